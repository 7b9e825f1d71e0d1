"""Pairs of faces that meet, against an intersection of triangles in fractions, and counts that are known."""

from __future__ import annotations

import itertools
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote import analysis
from isophote.errors import GeometryError
from trees import sphere

MODELS = Path(__file__).parents[1] / "../shared/models"

Point = tuple[Fraction, ...]


# --- the oracle: cut one triangle by the half-spaces that make the other --------------------------


def minus(a: Point, b: Point) -> Point:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def dot(a: Point, b: Point) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def cross(a: Point, b: Point) -> Point:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def half_spaces(t: list[Point]) -> list[tuple[Point, Fraction]]:
    """(n, c) with n · x <= c for exactly the points x of a triangle, segment or point."""
    axes = [tuple(Fraction(int(i == k)) for i in range(3)) for k in range(3)]
    normal = cross(minus(t[1], t[0]), minus(t[2], t[0]))
    if any(normal):
        sides = [(cross(minus(b, a), normal), a) for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))]
        planes = [(normal, t[0]), (minus((0, 0, 0), normal), t[0]), *sides]
    else:
        low, high = min(t), max(t)
        along = minus(high, low)
        flat = [cross(along, axis) for axis in axes] if any(along) else axes
        planes = [(n, low) for n in flat] + [(minus((0, 0, 0), n), low) for n in flat]
        planes += [(along, high), (minus((0, 0, 0), along), low)]
    return [(n, dot(n, p)) for n, p in planes]


def cut(polygon: list[Point], normal: Point, limit: Fraction) -> list[Point]:
    kept = []
    for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        a, b = dot(normal, p) - limit, dot(normal, q) - limit
        if a <= 0:
            kept.append(p)
        if a * b < 0:
            kept.append(tuple(x + (y - x) * a / (a - b) for x, y in zip(p, q, strict=True)))
    return kept


def in_hull(p: Point, points: list[Point]) -> bool:
    """Whether a point lies on the point or segment of `points`."""
    if len(points) == 1:
        return p == points[0]
    a, d = points[0], minus(points[1], points[0])
    return not any(cross(minus(p, a), d)) and 0 <= dot(minus(p, a), d) <= dot(d, d)


def really_meet(t: np.ndarray, s: np.ndarray) -> bool:
    """Whether two triangles meet outside of the hull of their common vertices."""
    first, second = ([tuple(map(Fraction, p)) for p in triangle.tolist()] for triangle in (t, s))
    common = sorted(set(first) & set(second))
    polygon = first
    for normal, limit in half_spaces(second):
        polygon = cut(polygon, normal, limit)
    if len(common) == 3:
        a, b, c = common
        if any(cross(minus(b, a), minus(c, a))):
            return True
        common = [a, c]
    return bool(polygon) if not common else any(not in_hull(p, common) for p in polygon)


def expected_pairs(corners: np.ndarray) -> list[list[int]]:
    return [[i, j] for i, j in itertools.combinations(range(len(corners)), 2) if really_meet(corners[i], corners[j])]


def loose(corners: np.ndarray) -> iso.Mesh:
    return iso.Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


# --- against it -----------------------------------------------------------------------------------


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(2, 9))
def test_pairs_on_grids_are_exact(seed: int, size: int, count: int) -> None:
    """Small grids: shared vertices and edges, coplanar, touching, folded, repeated triangles, segments and points."""
    corners = np.random.default_rng(seed).integers(0, size + 1, (count, 3, 3)).astype(np.float64)
    assert analysis.self_intersections(loose(corners)).pairs.tolist() == expected_pairs(corners)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.integers(2, 9))
def test_pairs_in_a_tilted_plane_are_exact(seed: int, size: int, count: int) -> None:
    """Whole numbers of the plane x + y + z = 0 times 0.1, so that most are not in any plane any more, barely."""
    rng = np.random.default_rng(seed)
    flat = rng.integers(-size, size + 1, (count, 3, 2)).astype(np.float64)
    corners = np.concatenate([flat, -flat.sum(axis=2, keepdims=True)], axis=2)
    assert analysis.self_intersections(loose(corners)).pairs.tolist() == expected_pairs(corners)
    corners = corners * 0.1
    corners[:, :, 2] = -(corners[:, :, 0] + corners[:, :, 1])
    assert analysis.self_intersections(loose(corners)).pairs.tolist() == expected_pairs(corners)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_pairs_of_any_doubles_are_exact(data: st.DataObject) -> None:
    coordinate = st.one_of(st.floats(-1, 1), st.sampled_from([0.0, 1.0, 1e-200, 0.1, 1 / 3, 1e100, -0.0]))
    corners = np.array(data.draw(st.lists(st.tuples(*[coordinate] * 9), min_size=2, max_size=5))).reshape(-1, 3, 3)
    assert analysis.self_intersections(loose(corners)).pairs.tolist() == expected_pairs(corners)


def test_pairs_of_random_triangles_are_exact() -> None:
    rng = np.random.default_rng(0)
    corners = rng.normal(size=(60, 1, 3)) + rng.normal(size=(60, 3, 3))
    expected = expected_pairs(corners)
    assert len(expected) > 50
    assert analysis.self_intersections(loose(corners)).pairs.tolist() == expected


# --- named cases ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("faces", "meet"),
    [
        ([(0, 1, 2), (0, 2, 3)], False),
        ([(0, 1, 2), (0, 2, 1)], True),
        ([(0, 1, 2), (0, 1, 3)], True),
        ([(0, 1, 2), (0, 1, 6)], False),
        ([(0, 1, 3), (0, 4, 5)], True),
        ([(0, 1, 2), (0, 3, 6)], False),
        ([(0, 1, 4), (4, 2, 3)], False),
        ([(0, 1, 4), (4, 5, 6)], False),
        ([(0, 1, 2), (4, 5, 6)], True),
    ],
    ids=["edge", "repeated", "folded", "hinge", "fan over fan", "vertex", "tip to tip", "tip, upright", "tip in edge"],
)
def test_two_faces(faces: list[tuple[int, ...]], meet: bool) -> None:
    square = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 0), (3, 0.5, 0), (1, 1, 5)]
    found = analysis.self_intersections(iso.Mesh(square, faces))
    assert found.embedded == (not meet)
    assert found.pairs.tolist() == ([[0, 1]] if meet else [])


def test_a_t_junction_touches_where_it_has_no_vertex() -> None:
    faces = [(0, 2, 3), (1, 0, 4), (2, 1, 4)]
    vertices = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (1, 1, 0), (1, -1, 0)]
    assert analysis.self_intersections(iso.Mesh(vertices, faces)).pairs.tolist() == [[0, 1], [0, 2]]


def test_a_polygon_that_crosses_itself_meets_itself() -> None:
    folded = iso.Mesh([(0, 0, 0), (4, 0, 0), (4, 1, 0), (1, 1, 0), (1, -1, 0), (0, -1, 0)], [[0, 1, 2, 3, 4, 5]])
    plain = iso.Mesh([(0, 0, 0), (4, 0, 0), (4, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)], [[0, 1, 2, 3, 4, 5]])
    assert analysis.self_intersections(folded).pairs.tolist() == [[0, 0]]
    assert analysis.self_intersections(plain).embedded


@pytest.mark.parametrize(
    ("name", "pairs"),
    [
        ("closed/bunny.obj", 0),
        ("closed/goathead.obj", 0),
        ("broken/self_intersectA.obj", 338),
        ("broken/joined_tetrahedra.obj", 1),
        ("broken/platonic_shelf.obj", 0),
        ("boundary/suzanne.obj", 98),
    ],
)
def test_models_whose_pairs_are_known(name: str, pairs: int) -> None:
    """Counts of pairs of triangles, polygons cut into fans: from the notes beside the models, or by what they are."""
    path = MODELS / name
    if not path.exists():
        pytest.skip(f"{name} is not there")
    mesh = iso.load_mesh(path)
    fans = [(face[0], face[k], face[k + 1]) for face in mesh.faces for k in range(1, len(face) - 1)]
    assert len(analysis.self_intersections(iso.Mesh(mesh.vertices, fans)).pairs) == pairs


@pytest.mark.parametrize("name", ["broken/soup.stl", "broken/angle_block.STL", "broken/triple_vierbein.obj"])
def test_broken_models_are_exact(name: str) -> None:
    path = MODELS / name
    if not path.exists():
        pytest.skip(f"{name} is not there")
    mesh = iso.load_mesh(path)
    corners = mesh.vertices[mesh.faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    near = (low[:, None] <= high[None]).all(axis=2) & (low[None] <= high[:, None]).all(axis=2)
    shared = (corners[:, None, :, None] == corners[None, :, None, :]).all(axis=4).any(axis=3).sum(axis=2)
    candidates = [(i, j) for i, j in np.argwhere(near & (shared < 2)).tolist() if i < j]
    candidates = candidates[:: max(1, len(candidates) // 1000)]
    found = {tuple(pair) for pair in analysis.self_intersections(mesh).pairs.tolist()}
    assert all(really_meet(corners[i], corners[j]) == ((i, j) in found) for i, j in candidates)


def test_two_spheres_that_cross_are_found_at_any_size_and_place() -> None:
    positions, triangles = sphere(24)
    vertices = np.concatenate([positions, positions + np.float32(0.5)]).astype(np.float64)
    both = np.concatenate([triangles, triangles + len(positions)])
    pairs = analysis.self_intersections(iso.Mesh(vertices, both)).pairs
    assert len(pairs) > 50
    assert (pairs[:, 0] < len(triangles)).all()
    assert (pairs[:, 1] >= len(triangles)).all()
    for factor in (2.0**-900, 2.0**900):
        scaled = analysis.self_intersections(iso.Mesh(vertices * factor, both)).pairs
        np.testing.assert_array_equal(scaled, pairs)


def test_pairs_are_the_same_whatever_the_order_of_faces() -> None:
    positions, triangles = sphere(12, 0.9)
    pairs = analysis.self_intersections(iso.Mesh(positions, triangles)).pairs
    order = np.random.default_rng(1).permutation(len(triangles))
    mixed = analysis.self_intersections(iso.Mesh(positions, triangles[order])).pairs
    np.testing.assert_array_equal(np.unique(np.sort(order[mixed], axis=1), axis=0), pairs)


def test_too_many_pairs_are_refused() -> None:
    triangle = np.random.default_rng(2).normal(size=(3, 3))
    with pytest.raises(GeometryError, match="faces repeated"):
        analysis.self_intersections(iso.Mesh(triangle, np.tile([0, 1, 2], (20_000, 1))))
