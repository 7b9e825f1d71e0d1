"""Whether rays slip out of closed meshes: none may.

    python bench/watertight.py [--rays 10000000] [--threads 2]

Rays start at random points inside closed meshes (bumpy spheres, some of them far from the origin, tiny or huge; a
torus; a tetrahedron; a needle) and go in random directions, and, a quarter as many each, exactly at vertices and at
midpoints of edges. Blocks of rays are asked for by single rays and by packets, for the closest hit and for any, in
turn. Half of the rays at vertices lie together, as packets are meant for: runs of 64 from one point to vertices of
successive numbers. What meets nothing has escaped.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

import isophote as iso
from common import Array, Floats, Ints, Rays, bumpy_sphere, geodesic_sphere, print_machine, print_table

_BLOCK = 1 << 19
_QUERIES = ("closest, single", "closest, packets", "any, single", "any, packets")


class Closed(NamedTuple):
    """A closed mesh, and for each vertex the point of its core that it sees: all between the two lies inside."""

    vertices: Floats
    triangles: Ints
    core: Array


def _star(vertices: Array, triangles: Ints, scale: float = 1.0, centre: float = 0.0) -> Closed:
    """A mesh of which the origin sees all, scaled and moved along all axes."""
    placed = np.asarray(vertices, np.float64) * scale + centre
    return Closed(placed.astype(np.float32), triangles, np.full(placed.shape, centre))


def _torus(around: int, across: int) -> Closed:
    i, j = (grid.reshape(-1) for grid in np.mgrid[0:around, 0:across])
    a, b = 2 * np.pi * i / around, 2 * np.pi * j / across
    core = np.stack([np.cos(a), 0 * a, np.sin(a)], axis=1)
    tube = 0.4 * np.stack([np.cos(a) * np.cos(b), np.sin(b), np.sin(a) * np.cos(b)], axis=1)
    k = [((i + di) % around) * across + (j + dj) % across for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
    triangles = np.concatenate([np.stack([k[0], k[1], k[2]], axis=1), np.stack([k[0], k[2], k[3]], axis=1)])
    return Closed((core + tube).astype(np.float32), triangles.astype(np.int32), core)


def meshes(largest: int) -> dict[str, Callable[[], Closed]]:
    """The closed meshes by name; the largest sphere has this frequency."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], np.float64)
    faces = np.array([(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)], np.int32)
    medium, large = max(largest // 4, 1), largest
    return {
        "tetrahedron": lambda: _star(corners, faces),
        "needle (1 : 1000)": lambda: _star(geodesic_sphere(8)[0] * (1000, 1, 1), geodesic_sphere(8)[1]),
        "torus": lambda: _torus(4 * medium, 2 * medium),
        f"bumpy sphere, frequency {medium}": lambda: _star(*bumpy_sphere(medium)),
        f"bumpy sphere, frequency {medium}, at (100, 100, 100)": lambda: _star(*bumpy_sphere(medium), 1, 100),
        f"bumpy sphere, frequency {medium}, 1e-4 wide": lambda: _star(*bumpy_sphere(medium), 0.5e-4),
        f"bumpy sphere, frequency {medium}, 1e5 wide": lambda: _star(*bumpy_sphere(medium), 0.5e5),
        f"bumpy sphere, frequency {large}": lambda: _star(*bumpy_sphere(large)),
    }


def points_inside(mesh: Closed, count: int, rng: np.random.Generator) -> Array:
    """(count, 3) random points inside, most of them near the surface, none within a thousandth of it."""
    weights = rng.dirichlet((1, 1, 1), count)[:, :, None]
    corners = mesh.triangles[rng.integers(0, len(mesh.triangles), count)]
    out = rng.uniform(0, 0.999, (count, 1)) ** (1 / 3)
    surface, core = ((weights * rows[corners]).sum(axis=1) for rows in (mesh.vertices, mesh.core))
    return core + (surface - core) * np.minimum(out, 0.999)


def random_rays(mesh: Closed, count: int, rng: np.random.Generator) -> Rays:
    """From inside in random directions."""
    return _towards(points_inside(mesh, count, rng), rng.normal(size=(count, 3)))


def rays_at_vertices(mesh: Closed, count: int, rng: np.random.Generator) -> Rays:
    """From inside at vertices; the first half in runs of 64 from one point at vertices of successive numbers."""
    starts = points_inside(mesh, count, rng)
    targets = rng.integers(0, len(mesh.vertices), count)
    runs = np.arange(count // 2) // 64 * 64
    starts[: count // 2] = starts[runs]
    targets[: count // 2] = (targets[runs] + np.arange(count // 2) % 64) % len(mesh.vertices)
    return _towards(starts, mesh.vertices[targets] - starts.astype(np.float32))


def rays_at_edges(mesh: Closed, count: int, rng: np.random.Generator) -> Rays:
    """From inside at midpoints of edges."""
    starts = points_inside(mesh, count, rng)
    edges = np.roll(mesh.triangles[rng.integers(0, len(mesh.triangles), count)], 1, axis=1)[:, :2]
    return _towards(starts, mesh.vertices[edges].mean(axis=1) - starts.astype(np.float32))


def _towards(starts: Array, directions: Array) -> Rays:
    return Rays(np.ascontiguousarray(starts, np.float32), np.ascontiguousarray(directions, np.float32))


KINDS = (("random directions", random_rays, 4), ("at vertices", rays_at_vertices, 1), ("at edges", rays_at_edges, 1))


def escapes(tracer: iso.Tracer, query: str, rays: Rays) -> int:
    """How many of `rays` meet nothing."""
    what, how = query.split(", ")
    coherent = how == "packets"
    met = (
        tracer.closest(*rays, coherent=coherent).hit if what == "closest" else tracer.occluded(*rays, coherent=coherent)
    )
    return int((~met).sum())


def blocks(count: int, mesh_count: int) -> Iterator[int]:
    """Sizes of the blocks that one mesh's share of `count` rays is asked in, four at least: one for each query."""
    share = -(-count // mesh_count)
    parts = max(len(_QUERIES), -(-share // _BLOCK))
    yield from (share // parts + (k < share % parts) for k in range(parts))


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rays", type=int, default=10_000_000, help="rays in random directions")
    parser.add_argument("--threads", type=int, default=None)
    parser.add_argument("--frequency", type=int, default=224, help="of the largest mesh")
    options = parser.parse_args(arguments)
    print_machine()
    rng, began, tracing = np.random.default_rng(7), time.perf_counter(), 0.0
    rows, totals = [], dict.fromkeys(_QUERIES, 0)
    choices = meshes(options.frequency)
    for name, make in choices.items():
        mesh = make()
        tracer = iso.Tracer(iso.Mesh(mesh.vertices, mesh.triangles), threads=options.threads)
        counts = []
        for _, rays_of, parts in KINDS:
            lost = asked = 0
            for block, size in enumerate(blocks(options.rays * parts // 4, len(choices))):
                rays, query = rays_of(mesh, size, rng), _QUERIES[block % len(_QUERIES)]
                start = time.perf_counter()
                lost += escapes(tracer, query, rays)
                tracing += time.perf_counter() - start
                asked += size
                totals[query] += size
            counts += [f"{lost} of {asked:,}"]
        rows.append([name, f"{len(mesh.triangles):,}", *counts])
        print(f"{name}: {', '.join(counts)}", file=sys.stderr, flush=True)
    print_table(("mesh", "triangles", *(f"escaped, {kind}" for kind, _, _ in KINDS)), rows)
    asked_by = ", ".join(f"{count:,} by {query}" for query, count in totals.items())
    print(f"Asked {asked_by}; {time.perf_counter() - began:.0f} s, {tracing:.0f} s of them tracing.")
    escaped = sum(int(cell.split(" of ")[0]) for row in rows for cell in row[2:])
    print(f"Escaped in all: {escaped}")
    sys.exit(escaped > 0)


if __name__ == "__main__":
    main()
