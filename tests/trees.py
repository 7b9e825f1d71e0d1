"""Meshes for tests of trees, easy and awkward, and the oracles that trees are held against."""

from __future__ import annotations

import numpy as np
from numba import njit

from isophote.accel.tree import Tree
from isophote.checks.rays import brute_force as nearest_of_all
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
    return nearest_of_all(geometry[0][geometry[1]], origins, directions)


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
