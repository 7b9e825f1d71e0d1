"""Grids of grids: what empty cells say of their neighbours, boxes of blocks, shared lists, grids within grids."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from accelerator_rays import check_against_brute_force, distant_rays, rays_at
from isophote.accel import grid_lists
from isophote.accel.accelerator import Built, build_accelerator
from isophote.kernels.accel.grid_empty import measure_empty
from isophote.kernels.accel.grid_layout import MAILED, NO_ROW, NOTHING, ROW, SIZE
from isophote.kernels.accel.layout import BLOCK, LANES, NUMBER, UPPER, WIDTH
from scenes import box, icosphere
from trees import GEOMETRIES, Geometry, random_soup, sphere


def _stadium() -> Geometry:
    """A ball of 14,160 triangles in the middle of a shell a thousand times as wide."""
    ball, shell = sphere(60, 0.05), sphere(30)
    points = np.concatenate([ball[0] * 1e-3, shell[0]])
    return points.astype(np.float32), np.concatenate([ball[1], shell[1] + len(ball[0])])


def _room() -> Geometry:
    """A ball between six walls of two triangles each, all turned."""
    ball, walls = icosphere(5, 0.5), iso.triangulate(box(6.0))
    c, s = np.cos(0.4), np.sin(0.4)
    turned = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    points = np.concatenate([ball.vertices, box(6.0).vertices]) @ turned.T
    return points.astype(np.float32), np.concatenate([ball.faces, walls.triangles + len(ball.vertices)])


CASES = {**GEOMETRIES, "stadium": _stadium(), "room": _room(), "small": random_soup(3_000, 0.02)}


def _build(case: str) -> tuple[Geometry, Built]:
    return CASES[case], build_accelerator("grid", *CASES[case])


def _cells_of(built: Built, grid: int) -> np.ndarray:
    """The codes of a grid's cells, by x, y, z."""
    nx, ny, nz, first = built.tables.arrays["shapes"][grid]
    return built.tables.arrays["cells"][first : first + nx * ny * nz].reshape(nz, ny, nx).transpose(2, 1, 0)


@pytest.mark.parametrize("filled", [0.0, 0.01, 0.1, 0.5])
def test_empty_cells_tell_the_largest_empty_cube_toward_each_octant(filled):
    rng = np.random.default_rng(1)
    shapes = np.array([[12, 9, 10, 0], [3, 1, 14, 1080], [1, 1, 1, 1122]])
    cells = np.where(rng.random(1123) < filled, rng.integers(0, 99, 1123), NOTHING).astype(np.int32)
    measure_empty(cells, shapes, 0, len(shapes))
    for nx, ny, nz, first in shapes:
        codes = cells[first : first + nx * ny * nz].reshape(nz, ny, nx).transpose(2, 1, 0)
        for x, y, z in np.argwhere(codes < 0)[::7]:
            for octant in range(8):
                told = (int(codes[x, y, z]) >> (3 * octant)) & 7
                assert told == _empty_toward(codes, (x, y, z), octant), (x, y, z, octant)


def _empty_toward(codes: np.ndarray, cell: tuple[int, ...], octant: int) -> int:
    """How many more cells on each axis toward an octant the largest empty cube has, up to seven."""
    for more in range(1, 8):
        low = [max(c - more, 0) if octant >> axis & 1 else c for axis, c in enumerate(cell)]
        high = [c + 1 if octant >> axis & 1 else c + more + 1 for axis, c in enumerate(cell)]
        if (codes[tuple(slice(*ends) for ends in zip(low, high, strict=True))] >= 0).any():
            return more - 1
    return 7


@pytest.mark.parametrize("case", CASES)
def test_boxes_of_blocks_hold_what_lies_in_the_cell(case):
    """Points of a block's triangles that are in its list's cell are in its box; every list has all its triangles."""
    (points, triangles), built = _build(case)
    arrays, rng = built.tables.arrays, np.random.default_rng(2)
    numbers = built.blocks.view(np.int32).reshape(-1, BLOCK)[:, NUMBER:]
    rows = arrays["rows"].reshape(-1, ROW)
    within = 0
    for grid, (frame, shape) in enumerate(zip(arrays["frames"], arrays["shapes"], strict=True)):
        codes = _cells_of(built, grid)
        listed = np.argwhere((codes >= 0) & (codes & 1 == 0))
        for x, y, z in rng.permutation(listed)[:20]:
            block, count, row = arrays["lists"][codes[x, y, z] >> 1]
            own = numbers[block : block - (-count // LANES)].reshape(-1)
            assert (own[:count] >= 0).all()
            assert (own[count:] == -1).all()
            if row < 0:
                assert count <= LANES
                continue
            low = frame[:3] + np.array([x, y, z]) * frame[SIZE : SIZE + 3]
            weights = rng.dirichlet([0.7] * 3, (count, 40))
            places = np.einsum("tkc,tcx->tkx", weights, points[triangles[own[:count]]].astype(np.float64))
            inside = ((places > low) & (places < low + frame[SIZE : SIZE + 3])).all(axis=2)
            lane = np.arange(count) // LANES
            boxes = rows[row + lane // WIDTH]
            lower = boxes[np.arange(count)[:, None], np.arange(3) * WIDTH + (lane % WIDTH)[:, None]]
            upper = boxes[np.arange(count)[:, None], UPPER + np.arange(3) * WIDTH + (lane % WIDTH)[:, None]]
            rounding = 1e-14 * np.abs(places).max()
            held = ((places >= lower[:, None] - rounding) & (places <= upper[:, None] + rounding)).all(axis=2)
            assert held[inside].all()
            within += int(inside.sum())
        assert shape[:3].prod() == codes.size
    assert within > 0 or len(rows) == 0 or case in ("unequal", "chain", "huge")


def test_a_ray_comes_once_by_lists_that_cells_share(monkeypatch):
    """Along a wall, cells hold the same two triangles; without the mailbox a ray tests them in each."""
    mesh = iso.Mesh(*_room())
    lists = build_accelerator("grid", *_room()).tables.arrays["lists"]
    assert (lists[:, 2] == MAILED).sum() > 4
    assert (lists[lists[:, 2] == MAILED, 1] <= LANES).all()
    rays = rays_at(mesh, 2_000)
    once = iso.Tracer(mesh, accelerator="grid")
    monkeypatch.setattr(grid_lists, "MAILED", NO_ROW)
    always = iso.Tracer(mesh, accelerator="grid")
    assert np.array_equal(once.closest(*rays).distance, always.closest(*rays).distance)
    first, second = once.count(*rays), always.count(*rays)
    assert np.array_equal(first.nodes, second.nodes)
    assert (first.primitives <= second.primitives).all()
    assert first.primitives.mean() < 0.9 * second.primitives.mean()


def test_a_small_thing_in_a_large_scene_is_one_grid_around_it():
    """The grid within fits the ball, not the cell of the stadium; rays from anywhere there are near to it."""
    points, triangles = _stadium()
    arrays = build_accelerator("grid", points, triangles).tables.arrays
    extents = arrays["frames"][:, SIZE : SIZE + 3] * arrays["shapes"][:, :3]
    small = np.flatnonzero(extents.max(axis=1) < 3e-3)
    assert 0 < len(small) < len(arrays["shapes"])
    assert arrays["shapes"][small, :3].prod(axis=1).sum() > 100
    counts = iso.Tracer(iso.Mesh(points, triangles), accelerator="grid").count(
        np.tile([0.5, 0.3, 0.4], (500, 1)), np.random.default_rng(3).normal(0, 5e-4, (500, 3)) - [0.5, 0.3, 0.4]
    )
    assert counts.depth.max() >= 1
    assert counts.nodes.mean() < 25


@pytest.mark.parametrize("case", ["stadium", "room"])
def test_grids_within_grids_find_what_brute_force_finds(case):
    mesh = iso.Mesh(*CASES[case])
    check_against_brute_force(mesh, rays_at(mesh, 600), ("grid",))
    check_against_brute_force(mesh, distant_rays(mesh, 200), ("grid",))
    # From the wide part to the small one and back.
    rng = np.random.default_rng(4)
    ends = rng.normal(size=(2, 400, 3)) * np.array([6e-4, 0.4])[:, None, None]
    for a, b in (ends, ends[::-1]):
        hits = check_against_brute_force(mesh, (a.astype(np.float32), (b - a).astype(np.float32)), ("grid",))
        assert hits.hit.any()
