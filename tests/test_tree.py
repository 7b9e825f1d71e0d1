"""Trees: what they hold, how deep and good they are, and that no ray slips through them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

import isophote
from isophote.errors import GeometryError
from isophote.kernels.accel.bvh import any_triangle, closest_triangle
from isophote.kernels.accel.layout import (
    BLOCK,
    CHILD,
    LANES,
    LOWER,
    MAX_BLOCKS,
    MAX_DEPTH,
    NODE,
    NUMBER,
    SCRATCH,
    UPPER,
    WIDTH,
)
from isophote.kernels.base.vec import vec3
from isophote.lower.tree import BOXES, TRIANGLES, Tree, build_boxes, build_triangles
from isophote.lower.tree_statistics import tree_statistics

CLOSED_MODELS = Path(__file__).parents[1] / "../shared/models/closed"
Geometry = tuple[np.ndarray, np.ndarray]


# --- meshes ---------------------------------------------------------------------------------------


def sphere(rings: int, bump: float = 0.0) -> Geometry:
    """A closed sphere of 4 rings (rings - 1) triangles, in waves of height `bump`."""
    polar = np.pi * np.arange(1, rings)[:, None] / rings
    around = np.pi * np.arange(2 * rings)[None, :] / rings
    x, y = np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around)
    z = np.cos(polar) + 0 * around
    points = np.concatenate([np.stack([x, y, z], 2).reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    points *= 1 + bump * np.sin(9 * points[:, :1]) * np.sin(11 * points[:, 1:2]) * np.sin(7 * points[:, 2:])
    row, column = np.mgrid[0 : rings - 2, 0 : 2 * rings]
    here, right = row * 2 * rings + column, row * 2 * rings + (column + 1) % (2 * rings)
    below, across = here + 2 * rings, right + 2 * rings
    top, bottom = len(points) - 2, len(points) - 1
    first, last = np.arange(2 * rings), (rings - 2) * 2 * rings + np.arange(2 * rings)
    parts = [
        np.stack([here, below, across], 2).reshape(-1, 3),
        np.stack([here, across, right], 2).reshape(-1, 3),
        np.stack([np.full_like(first, top), first, np.roll(first, -1)], 1),
        np.stack([np.full_like(last, bottom), np.roll(last, -1), last], 1),
    ]
    return points.astype(np.float32), np.concatenate(parts).astype(np.int32)


def soup(corners: np.ndarray) -> Geometry:
    """Triangles that share nothing, from (m, 3, 3) corners."""
    points = np.ascontiguousarray(corners, np.float32).reshape(-1, 3)
    return points, np.arange(len(points), dtype=np.int32).reshape(-1, 3)


def random_soup(count: int, size: float = 0.2) -> Geometry:
    rng = np.random.default_rng(count)
    return soup(rng.uniform(-1, 1, (count, 1, 3)) + rng.normal(0, size, (count, 3, 3)))


def flat_soup(count: int) -> Geometry:
    points, triangles = random_soup(count)
    points[:, 2] = 0.25
    return points, triangles


def unequal_soup(count: int) -> Geometry:
    """Triangles whose sizes and places span two hundred octaves."""
    rng = np.random.default_rng(5)
    place = np.exp2(rng.uniform(-100, 100, (count, 1, 1))) * rng.choice([-1, 1], (count, 1, 3))
    return soup(place * (1 + rng.normal(0, 0.1, (count, 3, 3))))


def chain(count: int) -> Geometry:
    """Points, each twice as far as the last few: splits by area would take them off one by one."""
    x = np.exp2(np.linspace(-120, 126, count))
    return soup(np.repeat(np.stack([x, 0 * x, 0 * x], 1)[:, None], 3, axis=1))


def coincident(count: int) -> Geometry:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.5]], np.float32)
    return points, np.tile(np.arange(3, dtype=np.int32), (count, 1))


def huge(count: int) -> Geometry:
    """Corners near the end of single precision, where extents and areas are infinite."""
    return soup(np.random.default_rng(2).choice([-3.3e38, 3.3e38], (count, 3, 3)))


def slivers(count: int) -> Geometry:
    """Triangles without area (a point, a segment) among others."""
    points, triangles = random_soup(count)
    triangles[::3, 2] = triangles[::3, 1]
    triangles[::5] = triangles[::5, :1]
    return points, triangles


GEOMETRIES = {
    "one": random_soup(1),
    "two": random_soup(2),
    "five": random_soup(5),
    "soup": random_soup(3000),
    "needles": random_soup(2000, 3.0),
    "sphere": sphere(30, 0.05),
    "flat": flat_soup(1500),
    "unequal": unequal_soup(3000),
    "chain": chain(5000),
    "coincident": coincident(1000),
    "slivers": slivers(1500),
    "huge": huge(1000),
}


# --- oracles --------------------------------------------------------------------------------------


def leaves(tree: Tree) -> tuple[list[tuple[np.ndarray, np.ndarray, int, int]], int]:
    """Every leaf as (lower, upper, first, count), and the depth, having checked all that joins the nodes."""
    rows = tree.nodes.reshape(-1, NODE)
    codes = rows[:, CHILD : CHILD + WIDTH].copy().view(np.int32)
    visits = np.zeros(len(rows), int)
    found, deepest = [], 0
    pending = [(0, *tree.bounds, 1)]
    while pending:
        node, lower, upper, depth = pending.pop()
        visits[node] += 1
        deepest = max(deepest, depth)
        for k in range(WIDTH):
            low, high = rows[node, LOWER + k : UPPER : WIDTH], rows[node, UPPER + k : CHILD : WIDTH]
            if np.isposinf(low).all() and np.isneginf(high).all():
                continue
            assert (lower <= low).all()
            assert (low <= high).all()
            assert (high <= upper).all()
            code = int(codes[node, k])
            if code >= 0:
                pending.append((code, low, high, depth + 1))
            else:
                first, count = divmod(-1 - code, 8)
                assert 1 <= count <= MAX_BLOCKS
                found.append((low, high, first, count))
    assert (visits == 1).all()
    return found, deepest


def check_triangles(tree: Tree, geometry: Geometry) -> int:
    """Check all that a tree of triangles promises, and return its depth."""
    points, triangles = geometry
    blocks = tree.blocks.reshape(-1, BLOCK)
    numbers = blocks[:, NUMBER : NUMBER + LANES].copy().view(np.int32)
    corners = blocks[:, :NUMBER].reshape(-1, 3, 3, LANES).transpose(0, 3, 1, 2)
    assert np.array_equal(np.sort(numbers[numbers >= 0]), np.arange(len(triangles)))
    assert np.array_equal(corners[numbers >= 0], points[triangles[numbers[numbers >= 0]]])
    assert (numbers[numbers < 0] == -1).all()
    assert np.isnan(corners[numbers < 0]).all()
    used = np.zeros(len(blocks), int)
    found, depth = leaves(tree)
    for low, high, first, count in found:
        used[first : first + count] += 1
        inside = corners[first : first + count][numbers[first : first + count] >= 0].reshape(-1, 3)
        assert np.array_equal(inside.min(axis=0), low)
        assert np.array_equal(inside.max(axis=0), high)
    assert (used == 1).all()
    assert depth <= MAX_DEPTH
    return depth


def brute_force(geometry: Geometry, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance along each ray in double precision (inf: none), and whether a ray passes close to an edge."""
    corners = geometry[0].astype(np.float64)[geometry[1]]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    a, b, c = corners[area > 0].transpose(1, 0, 2)
    area = area[area > 0]
    distances, doubtful = [], []
    for origin, d in zip(origins.astype(np.float64), directions.astype(np.float64), strict=True):
        p = np.cross(d, c - a)
        scale = ((b - a) * p).sum(axis=1)
        edge_on = np.abs(scale) < 1e-4 * area * np.linalg.norm(d)
        scale[scale == 0] = 1e-300
        q = np.cross(origin - a, b - a)
        u = ((origin - a) * p).sum(axis=1) / scale
        v = (q @ d) / scale
        t = (q * (c - a)).sum(axis=1) / scale
        margin = np.minimum(np.minimum(u, v), 1 - u - v)
        distances.append(np.min(t, where=(margin >= 0) & (t > 0), initial=np.inf))
        doubtful.append(bool(((np.abs(margin) < 1e-4) | edge_on).any()))
    return np.array(distances), np.array(doubtful)


@njit
def closest(nodes, blocks, origins, directions, distances, slots):
    stack = np.empty(SCRATCH, np.float32)
    for i in range(len(origins)):
        o = vec3(origins[i, 0], origins[i, 1], origins[i, 2])
        d = vec3(directions[i, 0], directions[i, 1], directions[i, 2])
        distances[i], _, _, slots[i] = closest_triangle(nodes, blocks, 0, o, d, np.float32(np.inf), stack)


@njit
def occluded(nodes, blocks, origins, directions, found):
    stack = np.empty(SCRATCH, np.float32)
    for i in range(len(origins)):
        o = vec3(origins[i, 0], origins[i, 1], origins[i, 2])
        d = vec3(directions[i, 0], directions[i, 1], directions[i, 2])
        found[i] = any_triangle(nodes, blocks, 0, o, d, np.float32(np.inf), stack)


def shoot(tree: Tree, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(distances, slots, occluded) of rays."""
    origins, directions = (np.ascontiguousarray(a, np.float32) for a in (origins, directions))
    distances, slots = np.empty(len(origins), np.float32), np.empty(len(origins), np.int64)
    found = np.empty(len(origins), np.bool_)
    closest(tree.nodes, tree.blocks, origins, directions, distances, slots)
    occluded(tree.nodes, tree.blocks, origins, directions, found)
    return distances, slots, found


@njit
def swept_cost(lower, upper, lanes, most, leaf_cost, block_cost):
    """Surface area cost of the tree that tries every split of the sorted items on every axis, collapsed at best."""
    n = len(lower)
    order = np.arange(n)
    first, size, left = np.zeros(2 * n, np.int64), np.zeros(2 * n, np.int64), np.zeros(2 * n, np.int64)
    area = np.zeros(2 * n)
    right_cost = np.empty(n)
    size[0], free, node = n, 1, 0
    # Children are numbered after their parents, so one pass over the numbers splits all nodes.
    while node < free:
        begin, count = first[node], size[node]
        items = order[begin : begin + count].copy()
        best, best_count, best_order = np.inf, count // 2, items
        for axis in range(3):
            in_order = items[np.argsort(lower[items, axis] + upper[items, axis], kind="mergesort")]
            low, high = np.full(3, np.inf), np.full(3, -np.inf)
            for i in range(count - 1, -1, -1):
                for k in range(3):
                    low[k], high[k] = min(low[k], lower[in_order[i], k]), max(high[k], upper[in_order[i], k])
                x, y, z = high - low
                area[node] = x * y + y * z + z * x
                right_cost[i] = area[node] * ((count - i + lanes - 1) // lanes)
            low[:], high[:] = np.inf, -np.inf
            for i in range(1, count):
                for k in range(3):
                    low[k], high[k] = min(low[k], lower[in_order[i - 1], k]), max(high[k], upper[in_order[i - 1], k])
                x, y, z = high - low
                cost = (x * y + y * z + z * x) * ((i + lanes - 1) // lanes) + right_cost[i]
                if cost < best:
                    best, best_count, best_order = cost, i, in_order
        if count > lanes:
            order[begin : begin + count] = best_order
            left[node] = free
            first[free], size[free] = begin, best_count
            first[free + 1], size[free + 1] = begin + best_count, count - best_count
            free += 2
        node += 1
    costs = np.empty((free, 9))
    for node in range(free - 1, -1, -1):
        costs[node] = np.inf
        if size[node] <= most:
            costs[node] = area[node] * (leaf_cost + block_cost * ((size[node] + lanes - 1) // lanes))
        if left[node] > 0:
            shared = np.full(9, np.inf)
            for slots in range(2, 9):
                for k in range(1, slots):
                    shared[slots] = min(shared[slots], costs[left[node], k] + costs[left[node] + 1, slots - k])
            costs[node, 1:] = np.minimum(costs[node, 1:], area[node] + shared[8])
            for slots in range(2, 9):
                costs[node, slots] = min(costs[node, slots - 1], shared[slots])
            if node == 0:
                return 1 + shared[8] / area[0]
    return 1 + costs[0, 1] / area[0]


def is_closed(triangles: np.ndarray) -> bool:
    """Whether every edge has exactly two triangles, one each way."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    keys = edges[:, 0] << 32 | edges[:, 1]
    return len(np.unique(keys)) == len(keys) and set(keys.tolist()) == set((edges[:, 1] << 32 | edges[:, 0]).tolist())


def winding(geometry: Geometry, point: np.ndarray) -> float:
    """How often a closed mesh winds round a point (van Oosterom, Strackee 1983)."""
    a, b, c = (geometry[0].astype(np.float64)[geometry[1][:, k]] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    above = (a * np.cross(b, c)).sum(axis=1)
    below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return float(np.arctan2(above, below).sum() / (2 * np.pi))


# --- what trees hold ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GEOMETRIES)
def test_every_triangle_lies_in_one_lane_and_in_its_boxes(name):
    check_triangles(build_triangles(*GEOMETRIES[name]), GEOMETRIES[name])


@settings(max_examples=60, deadline=None)
@given(
    corners=st.lists(st.lists(st.integers(-3, 3), min_size=9, max_size=9), min_size=1, max_size=70),
    scale=st.sampled_from([1e-40, 1e-20, 1.0, 1e30]),
)
def test_any_triangles_make_a_sound_tree(corners, scale):
    geometry = soup(np.array(corners, np.float64).reshape(-1, 3, 3) * scale)
    check_triangles(build_triangles(*geometry), geometry)


def test_a_single_triangle_hangs_on_an_inner_root():
    tree = build_triangles(*random_soup(1))
    assert tree_statistics(tree)._replace(cost=0, bytes=0) == (1, 1, 1, 1, 1 / LANES, 0, 0)


def test_no_triangles_make_a_tree_that_nothing_meets():
    tree = build_triangles(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    assert not shoot(tree, np.zeros((1, 3)), np.ones((1, 3)))[2].any()
    assert tree_statistics(tree).leaves == 0


@pytest.mark.parametrize("make", [coincident, chain, unequal_soup])
def test_hundred_thousand_awkward_triangles(make):
    geometry = make(100_000)
    assert 1 < check_triangles(build_triangles(*geometry), geometry) <= MAX_DEPTH


@pytest.mark.parametrize("geometry", [sphere(200, 0.05), coincident(150_000), chain(150_000)])
def test_same_bits_for_any_number_of_threads(geometry):
    alone = build_triangles(*geometry, threads=1)
    for threads in (2, 3, 7, None):
        together = build_triangles(*geometry, threads=threads)
        assert all(a.tobytes() == b.tobytes() for a, b in zip(alone, together, strict=True))


def test_read_only_and_strided_input_is_taken_as_it_is():
    points, triangles = sphere(10)
    wide = np.zeros((len(points), 6))
    wide[:, ::2] = points
    wide.flags.writeable = False
    from_other = build_triangles(wide[:, ::2], triangles.astype(np.uint64))
    assert from_other.blocks.tobytes() == build_triangles(points, triangles).blocks.tobytes()


@pytest.mark.parametrize(
    ("points", "triangles", "reason"),
    [
        ([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]], "finite"),
        ([[0, 0, 0], [1, 0, 1e39], [0, 1, 0]], [[0, 1, 2]], "finite"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]], "outside 0 to 2"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, -1, 2]], "outside 0 to 2"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2**32]], "outside 0 to 2"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2.0]], "whole numbers"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2, 0]], "whole numbers"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], "shape"),
    ],
)
def test_bad_triangles_are_refused(points, triangles, reason):
    with pytest.raises(GeometryError, match=reason):
        build_triangles(np.array(points), np.array(triangles))


# --- trees of boxes -------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, 9, 1000, 30_000])
@pytest.mark.parametrize("spread", [0.0, 1.0])
def test_every_box_lies_in_one_leaf(count, spread):
    rng = np.random.default_rng(count)
    lower = (spread * rng.normal(size=(count, 3))).astype(np.float32)
    upper = (lower + 0.01 + 0.05 * spread * rng.random((count, 3))).astype(np.float32)
    tree = build_boxes(lower, upper)
    assert tree.blocks.dtype == np.int32
    assert np.array_equal(np.sort(tree.blocks), np.arange(count))
    used = np.zeros(count, int)
    found, depth = leaves(tree)
    for low, high, first, size in found:
        items = tree.blocks[first : first + size]
        used[items] += 1
        assert np.array_equal(lower[items].min(axis=0), low)
        assert np.array_equal(upper[items].max(axis=0), high)
    assert (used == 1).all()
    assert depth <= MAX_DEPTH
    if spread > 0:
        assert len(found) >= 0.99 * count


def test_bad_boxes_are_refused():
    for lower, upper in (([[0, 0, 0]], [[1, -1, 1]]), ([[0, 0, np.nan]], [[1, 1, 1]]), ([[0, 0, 0]], [[1, 1, np.inf]])):
        with pytest.raises(GeometryError):
            build_boxes(np.array(lower, np.float32), np.array(upper, np.float32))
    with pytest.raises(GeometryError):
        build_boxes(np.zeros((2, 3)), np.ones((3, 3)))


# --- how good they are ----------------------------------------------------------------------------


@pytest.mark.parametrize("geometry", [sphere(72, 0.05), random_soup(8000), random_soup(3000, 1.0)])
def test_cost_is_near_that_of_trying_every_split(geometry):
    corners = geometry[0].astype(np.float64)[geometry[1]]
    swept = swept_cost(corners.min(axis=1), corners.max(axis=1), *TRIANGLES.collapse)
    assert tree_statistics(build_triangles(*geometry)).cost <= 1.05 * swept


def test_cost_of_boxes_is_near_that_of_trying_every_split():
    lower = np.random.default_rng(1).uniform(-1, 1, (3000, 3)).astype(np.float32)
    upper = lower + np.float32(0.03)
    swept = swept_cost(lower.astype(np.float64), upper.astype(np.float64), *BOXES.collapse)
    assert tree_statistics(build_boxes(lower, upper)).cost <= 1.05 * swept


def test_cost_of_two_separate_boxes():
    lower = np.array([[0, 0, 0], [3, 0, 0]], np.float32)
    # Surfaces: root 4 x 1 x 1 has 18, each box 6; the root's test and, for each box, its block.
    expected = 1 + 2 * 6 / 18 * float(BOXES.leaf_cost + BOXES.block_cost)
    assert tree_statistics(build_boxes(lower, lower + 1)).cost == pytest.approx(expected)


def test_memory_of_a_mesh():
    geometry = sphere(72, 0.05)
    numbers = tree_statistics(build_triangles(*geometry))
    assert numbers.bytes == numbers.nodes * 4 * NODE + numbers.blocks * 4 * BLOCK
    assert numbers.bytes <= 75 * len(geometry[1])
    assert numbers.occupancy == pytest.approx(len(geometry[1]) / (LANES * numbers.blocks))


# --- what rays meet -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["one", "two", "five", "soup", "needles", "sphere", "flat", "coincident", "slivers"])
def test_same_hits_as_brute_force(name):
    geometry = GEOMETRIES[name]
    rng = np.random.default_rng(11)
    origins = rng.uniform(-1.5, 1.5, (600, 3)).astype(np.float32)
    targets = geometry[0][geometry[1][rng.integers(len(geometry[1]), size=600)]]
    weights = rng.dirichlet(np.ones(3), 600)[:, :, None]
    directions = ((targets * weights).sum(axis=1) - origins).astype(np.float32)
    directions[::3] = rng.normal(size=(200, 3))
    expected, doubtful = brute_force(geometry, origins, directions)
    distances, slots, found = shoot(build_triangles(*geometry), origins, directions)
    sure = ~doubtful
    assert sure.sum() > 200
    assert np.array_equal(np.isfinite(expected)[sure], (slots >= 0)[sure])
    assert np.array_equal(found, slots >= 0)
    hit = sure & (slots >= 0)
    assert hit.sum() > 60
    assert np.allclose(distances[hit], expected[hit], rtol=1e-4, atol=1e-5)


def test_rays_along_axes_and_in_the_planes_of_boxes():
    """Directions with zeros, origins on planes of boxes: no 0 times infinity loses a box."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    cells = np.arange(16, dtype=np.float32)
    grid = np.stack(np.meshgrid(cells, cells, [0], indexing="ij"), 3).reshape(-1, 1, 3)
    corners = (grid + points[None])[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    tree = build_triangles(*soup(corners))
    x, y = np.meshgrid(np.linspace(0, 16, 33), np.linspace(0, 16, 33))
    for sign in (1, -1):
        origins = np.stack([x, y, np.full_like(x, -2.0 * sign)], 2).reshape(-1, 3)
        distances, _, found = shoot(tree, origins, np.tile([0.0, -0.0, sign], (len(origins), 1)))
        assert (distances == 2).all()
        assert found.all()


def escapes(geometry: Geometry, origins: np.ndarray, count: int) -> int:
    """Rays out of a closed mesh, a third each in any direction, at vertices, and at midpoints of edges."""
    rng = np.random.default_rng(3)
    points, triangles = geometry
    corners = points[triangles[rng.integers(len(triangles), size=count)]]
    origins = origins[rng.integers(len(origins), size=count)].astype(np.float32)
    ends = corners[:, 0].copy()
    ends[1::3] = (corners[1::3, 0] + corners[1::3, 1]) / 2
    directions = ends - origins
    directions[2::3] = rng.normal(size=directions[2::3].shape)
    _, slots, found = shoot(build_triangles(*geometry), origins, directions)
    return int((slots < 0).sum() + (~found).sum())


@pytest.mark.parametrize("rings", [3, 24, 160])
def test_no_ray_escapes_from_a_sphere(rings):
    origins = np.concatenate([np.zeros((1, 3)), np.random.default_rng(4).uniform(-0.3, 0.3, (50, 3))])
    assert escapes(sphere(rings, 0.05), origins, 400_000) == 0


@pytest.mark.parametrize("offset", [1e-4, 1e5])
def test_no_ray_escapes_at_any_scale(offset):
    points, triangles = sphere(24, 0.05)
    origins = np.random.default_rng(4).uniform(-0.3, 0.3, (50, 3)) * offset
    assert escapes((points * np.float32(offset), triangles), origins, 60_000) == 0


@pytest.mark.parametrize("name", ["koala", "bunny", "goathead"])
def test_no_ray_escapes_from_a_model(name):
    path = CLOSED_MODELS / f"{name}.obj"
    if not path.exists():
        pytest.skip("the models are not here")
    mesh = isophote.load_mesh(path)
    fans = [face[[0, k, k + 1]] for face in mesh.faces for k in range(1, len(face) - 1)]
    geometry = mesh.vertices.astype(np.float32), np.array(fans, np.int32)
    if not is_closed(geometry[1]):
        pytest.skip("the model is not closed")
    rng = np.random.default_rng(8)
    guesses = rng.uniform(*mesh.bounds, (150, 3)).astype(np.float32)
    inside = np.array([g for g in guesses if abs(winding(geometry, g)) > 0.99])
    assert len(inside) > 5
    assert escapes(geometry, inside, 100_000) == 0
