"""Trees of planes in any direction: cells, what leaves hold, bounds of memory, and rays through turned boxes."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from scipy.spatial import ConvexHull, HalfspaceIntersection

import isophote as iso
from accelerator_rays import rays_at
from isophote.accel.accelerator import Built, build_accelerator
from isophote.accel.treelets import CHILDREN, PLANES, ROOT, leaf_lanes, parted, plane_lanes
from isophote.kernels.accel.bsp_cell import CELL, CELL_WORK, areas_of_cut, cell_area, cell_extent, cut_cell, start_cell
from isophote.kernels.accel.bsp_layout import CODES, PLACES, SLANTED, TOLERANCE, TREELET
from isophote.kernels.accel.bsp_polygon import Plane
from isophote.kernels.accel.layout import BLOCK, LANES, NUMBER
from trees import GEOMETRIES, Geometry, soup


def turned_boxes(count: int, degrees: float) -> Geometry:
    """count × count boxes of squares, 3 × 3 a side, all turned about a vertical and a slant."""
    rng = np.random.default_rng(4)
    u, v = (grid.reshape(-1) for grid in np.mgrid[0:3, 0:3] / 3)
    square = np.stack([u, v], 1)[:, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]]) / 3
    sides = []
    for axis in range(3):
        for place in (0.0, 1.0):
            sides.append(np.insert(square, axis, place, axis=2))
    box = np.concatenate(sides)
    corner = np.stack([*np.mgrid[0:count, 0:count].reshape(2, -1), np.zeros(count * count)], 1)
    size = np.concatenate([rng.uniform(0.5, 0.8, (count * count, 2)), rng.uniform(0.5, 3, (count * count, 1))], 1)
    points = (corner[:, None, None] + box * size[:, None, None]).reshape(-1, 3)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return soup((points @ turn.T).reshape(-1, 3, 3))


def needles_through_a_point(count: int) -> Geometry:
    """Long triangles that all pass close to one point: no plane parts them."""
    rng = np.random.default_rng(6)
    along = rng.normal(size=(count, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return soup(np.stack([along, -along + 1e-3 * rng.normal(size=(count, 3)), 1e-3 * rng.normal(size=(count, 3))], 1))


# --- cells ----------------------------------------------------------------------------------------


@njit
def cut_cube(planes):
    """The unit cube cut to what is below all planes but the last; its surface, and that of its parts below and above
    the last plane as they are foretold, and as they are."""
    work, cells, box = np.empty(CELL_WORK), np.empty(4 * CELL), np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    start_cell(cells, 0, box)
    at = 0
    for k in range(len(planes) - 1):
        x, y, z, place = planes[k]
        cut_cell(cells, at, Plane(x, y, z, place, np.int64(SLANTED)), 1.0, cells, CELL - at, work)
        at = CELL - at
    x, y, z, place = planes[-1]
    cell_extent(cells, at, Plane(x, y, z, 0.0, np.int64(SLANTED)), work)
    last = Plane(x, y, z, place, np.int64(SLANTED))
    below, above = areas_of_cut(cells, at, last, work)
    cut_cell(cells, at, last, 1.0, cells, 2 * CELL, work)
    cut_cell(cells, at, last, -1.0, cells, 3 * CELL, work)
    return cell_area(cells, at), below, above, cell_area(cells, 2 * CELL), cell_area(cells, 3 * CELL)


def hull_area(planes: np.ndarray) -> float:
    """The surface of what is below all planes, within the unit cube."""
    cube = np.concatenate([np.column_stack([-np.eye(3), np.zeros(3)]), np.column_stack([np.eye(3), -np.ones(3)])])
    halves = np.concatenate([cube, np.column_stack([planes[:, :3], -planes[:, 3]])])
    return float(ConvexHull(HalfspaceIntersection(halves, np.full(3, 0.5)).intersections).area)


def test_surfaces_of_cells_as_by_half_spaces():
    rng = np.random.default_rng(7)
    for count in (1, 2, 3, 5, 8):
        for _ in range(10):
            planes = rng.normal(size=(count, 3))
            planes /= np.linalg.norm(planes, axis=1, keepdims=True)
            # The middle of the cube stays within, a little below each plane.
            planes = np.column_stack([planes, planes @ np.full(3, 0.5) + rng.uniform(0.05, 0.6, count)])
            whole, below, above, lower, upper = cut_cube(planes)
            assert whole == pytest.approx(hull_area(planes[:-1]), rel=1e-9)
            assert below == pytest.approx(hull_area(planes), rel=1e-9)
            assert below == pytest.approx(lower, rel=1e-9)
            assert above == pytest.approx(upper, rel=1e-9, abs=1e-12)


# --- trees ----------------------------------------------------------------------------------------


def leaves_at(built: Built, point: np.ndarray, within: float) -> set[int]:
    """The triangles of all leaves that a point is in; on both sides of planes that it is not farther from."""
    words, codes = words_of(built)
    found: set[int] = set()
    pending = [ROOT]
    while pending:
        node = np.array([pending.pop()])
        [plane] = planes_at(words, node)
        if not np.isfinite(plane[3]):
            found.update(triangles_of(built, node)[0])
            continue
        height = plane[:3] @ point - plane[3]
        lower, upper = (int(side[0]) for side in parted(node, words[:, PLACES:CODES], codes))
        if height <= within:
            pending.append(lower)
        if height >= -within:
            pending.append(upper)
    return found


def words_of(built: Built) -> tuple[np.ndarray, np.ndarray]:
    """Words of the treelets, and codes of their children."""
    words = built.tables.arrays["nodes"].reshape(-1, TREELET)
    return words, words[:, CODES:].view(np.int32)


def planes_at(words: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Normals and places of the nodes' planes, (n, 4); the place of what is a leaf is infinite."""
    treelets, lanes = plane_lanes(nodes)
    planes = words[treelets, :CODES].reshape(-1, 4, CHILDREN)[np.arange(len(nodes)), :, lanes].astype(float)
    planes[lanes == PLANES, 3] = np.inf
    return planes


def triangles_of(built: Built, nodes: np.ndarray) -> list[list[int]]:
    """Numbers of the triangles of leaves."""
    _, codes = words_of(built)
    numbers = built.blocks.view(np.int32).reshape(-1, BLOCK)[:, NUMBER:].reshape(-1)
    leaves = built.tables.arrays["leaves"].reshape(-1, 2)
    found = []
    for code in codes[leaf_lanes(nodes)].tolist():
        first, count = divmod(-1 - code, 32) if code < 0 else (0, 0)
        if code < 0 and count == 0:
            first, count = leaves[first]
        found.append(numbers[first * LANES : first * LANES + count].tolist())
    return found


@pytest.mark.parametrize("geometry", ["soup", "needles", "sphere", "flat", "slivers", "turned"])
def test_leaves_hold_every_triangle_that_reaches_into_them(geometry):
    """A place on a triangle, which side of planes it is on decided exactly but for what lies within planes."""
    points, triangles = turned_boxes(4, 30) if geometry == "turned" else GEOMETRIES[geometry]
    built = build_accelerator("bsp", points, triangles)
    reach = float(np.abs(points).max())
    rng = np.random.default_rng(8)
    for triangle in rng.integers(0, len(triangles), 400):
        weights = rng.dirichlet((0.5, 0.5, 0.5))
        place = weights @ points[triangles[triangle]].astype(float)
        assert triangle in leaves_at(built, place, TOLERANCE * reach)


@pytest.mark.parametrize("geometry", [needles_through_a_point(3000), GEOMETRIES["needles"], GEOMETRIES["coincident"]])
def test_memory_and_depth_are_bounded(geometry):
    count = len(geometry[1])
    built = build_accelerator("bsp", *geometry)
    words, codes = words_of(built)
    nodes, references, made = np.array([ROOT]), 0, 0
    for _ in range(9 + int(1.3 * np.log2(count))):
        made += len(nodes)
        planes = planes_at(words, nodes)
        inner = np.isfinite(planes[:, 3])
        references += sum(map(len, triangles_of(built, nodes[~inner])))
        assert np.allclose(np.linalg.norm(planes[inner, :3], axis=1), 1, rtol=0, atol=2e-7)
        nodes = np.concatenate(parted(nodes[inner], words[:, PLACES:CODES], codes))
    assert len(nodes) == 0
    assert references <= 6 * count + LANES
    assert made <= 8 * count + 16


def test_turned_boxes_take_fewer_steps_than_in_a_kd_tree():
    mesh = iso.Mesh(*turned_boxes(12, 30))
    rays = rays_at(mesh, 3000)
    nodes = {name: iso.Tracer(mesh, accelerator=name).count(*rays).nodes.mean() for name in ("bsp", "kdtree")}
    assert nodes["bsp"] <= 0.6 * nodes["kdtree"]
