"""Rays: every accelerator against all triangles in double precision, and closed meshes that let nothing through."""

from __future__ import annotations

from functools import cache, partial
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import ACCELERATORS
from isophote.checks.check import Check, Effort, Measured
from isophote.checks.scenes import sphere_mesh
from isophote.rendering.tracer import Tracer

__all__ = ["CHECKS", "brute_force"]

_SAME = "rays: those that meet something else than by trying all triangles"
_FAR = "rays: largest difference of distances to those, in parts of them"
_CLOSED = "rays: from within a closed mesh, those that meet nothing"

Floats: TypeAlias = npt.NDArray[np.float64]

_RAYS, _ESCAPES = 2000, 200_000
# Rays this close to an edge, in parts of the triangle, may meet its neighbour in single precision.
_CLOSE = 1e-4


class Nearest(NamedTuple):
    """What n rays meet: distances, inf for nothing, and whether a ray passes close to an edge of any triangle."""

    distance: Floats
    doubtful: npt.NDArray[np.bool_]


def brute_force(triangles: npt.ArrayLike, origins: npt.ArrayLike, directions: npt.ArrayLike) -> Nearest:
    """The nearest of all triangles (m, 3, 3) for each ray, tried one by one in double precision (Möller, Trumbore,
    "Fast, minimum storage ray-triangle intersection", JGT 2(1), 1997)."""
    corners, starts, ways = (np.asarray(values, np.float64) for values in (triangles, origins, directions))
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    a, b, c = corners[area > 0].transpose(1, 0, 2)
    area = area[area > 0]
    distances, doubtful = np.full(len(starts), np.inf), np.zeros(len(starts), bool)
    for i, (origin, d) in enumerate(zip(starts, ways, strict=True)):
        p = np.cross(d, c - a)
        scale = ((b - a) * p).sum(axis=1)
        edge_on = np.abs(scale) < _CLOSE * area * np.linalg.norm(d)
        scale[scale == 0] = 1e-300
        q = np.cross(origin - a, b - a)
        u = ((origin - a) * p).sum(axis=1) / scale
        v = (q @ d) / scale
        t = (q * (c - a)).sum(axis=1) / scale
        margin = np.minimum(np.minimum(u, v), 1 - u - v)
        distances[i] = np.min(t, where=(margin >= 0) & (t > 0), initial=np.inf)
        doubtful[i] = bool(((np.abs(margin) < _CLOSE) | edge_on).any())
    return Nearest(distances, doubtful)


_MESH = sphere_mesh(20, 0.2)


@cache
def _known(effort: Effort) -> tuple[Floats, Floats, Nearest]:
    """Rays from around the mesh towards points within its box, and what they meet."""
    generator = effort.generator()
    origins = generator.uniform(-2, 2, (effort.samples(_RAYS), 3)).astype(np.float32).astype(np.float64)
    directions = (generator.uniform(-1, 1, origins.shape) - origins).astype(np.float32).astype(np.float64)
    corners = _MESH.vertices.astype(np.float32)[np.asarray(_MESH.faces)]
    return origins, directions, brute_force(corners, origins, directions)


def _same(name: str, effort: Effort) -> Measured:
    origins, directions, known = _known(effort)
    found = Tracer(_MESH, accelerator=name, threads=effort.threads).closest(origins, directions).distance
    sure = ~known.doubtful
    met = np.isfinite(known.distance)
    other = (np.isfinite(found) != met) | (met & (np.abs(found - np.where(met, known.distance, 0)) > 1e-3))
    return Measured(float((other & sure).sum()), 0, 0)


def _as_far(name: str, effort: Effort) -> Measured:
    origins, directions, known = _known(effort)
    found = Tracer(_MESH, accelerator=name, threads=effort.threads).closest(origins, directions).distance
    both = np.isfinite(found) & np.isfinite(known.distance) & ~known.doubtful
    gap = np.abs(found[both] - known.distance[both]) / known.distance[both]
    return Measured(float(gap.max()), 0, 1e-4, at_most=True)


def _escapes(name: str, effort: Effort) -> Measured:
    generator = effort.generator()
    directions = generator.normal(size=(effort.samples(_ESCAPES), 3))
    origins = generator.uniform(-0.3, 0.3, directions.shape)
    blocked = Tracer(_MESH, accelerator=name, threads=effort.threads).occluded(origins, directions)
    return Measured(float((~blocked).sum()), 0, 0)


CHECKS = [
    *(Check(_SAME, name, partial(_same, name)) for name in ACCELERATORS),
    *(Check(_FAR, name, partial(_as_far, name)) for name in ACCELERATORS),
    *(Check(_CLOSED, name, partial(_escapes, name)) for name in ACCELERATORS),
]
