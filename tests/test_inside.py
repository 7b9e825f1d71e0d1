"""Distances, closest points and winding numbers of meshes, against brute force, closed forms and exact fractions."""

from __future__ import annotations

import gc
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote import analysis
from isophote.accel.mesh_distance import build_mesh_distance
from isophote.analysis import prepared as prepared_module
from isophote.errors import GeometryError
from isophote.kernels.measure.closest import closest_points
from isophote.kernels.measure.winding import winding_numbers
from trees import sphere

MODELS = Path(__file__).parents[1] / "../shared/models"

CUBE = iso.Mesh(
    [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)],
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]],
)


def load(name: str) -> iso.Mesh:
    path = MODELS / name
    if not path.exists():
        pytest.skip(f"{name} is not there")
    return iso.load_mesh(path)


def corners_of(mesh: iso.Mesh) -> np.ndarray:
    return mesh.vertices[iso.triangulate(mesh).triangles]


def around(mesh: iso.Mesh, count: int, seed: int = 0) -> np.ndarray:
    """Points in and around the box of a mesh."""
    low, high = mesh.bounds
    return np.random.default_rng(seed).uniform(low - 0.3 * (high - low), high + 0.3 * (high - low), (count, 3))


# --- oracles --------------------------------------------------------------------------------------


def segment_distance(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    d = b - a
    with np.errstate(invalid="ignore", divide="ignore"):
        t = np.clip(((p - a) * d).sum(-1) / (d * d).sum(-1), 0, 1)
    return np.linalg.norm(p - a - np.nan_to_num(t)[..., None] * d, axis=-1)


def brute_distance(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Least distance to the edges, and to the planes of the triangles that the point stands over."""
    out = np.empty(len(points))
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    for i, p in enumerate(points):
        best = min(segment_distance(p, *edge).min() for edge in ((a, b), (b, c), (c, a)))
        over = np.logical_and.reduce(
            [(np.cross(s - r, p - r) * normal).sum(1) >= 0 for r, s in ((a, b), (b, c), (c, a))]
        )
        over &= length > 0
        if over.any():
            best = min(best, (np.abs((normal * (p - a)).sum(1))[over] / length[over]).min())
        out[i] = best
    return out


def solid_angles(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The sum of the triangles' solid angles over 4π (van Oosterom, Strackee 1983)."""
    out = np.empty(len(points))
    for i, p in enumerate(points):
        a, b, c = corners.transpose(1, 0, 2) - p
        x, y, z = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        real = x * y * z + (a * b).sum(1) * z + (b * c).sum(1) * x + (c * a).sum(1) * y
        out[i] = np.arctan2((a * np.cross(b, c)).sum(1), real).sum() / (2 * np.pi)
    return out


def determinant(rows: list[list[Fraction]]) -> Fraction:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def on_triangle(p: list[Fraction], t: list[list[Fraction]]) -> bool:
    """Whether a point is a convex combination of three others, in fractions."""
    a, u, v, q = t[0], *([x - y for x, y in zip(w, t[0], strict=True)] for w in (t[1], t[2], p))
    normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    if any(normal):
        if sum(n * x for n, x in zip(normal, q, strict=True)) != 0:
            return False
        i, j = max(((1, 2), (2, 0), (0, 1)), key=lambda ij: abs(u[ij[0]] * v[ij[1]] - u[ij[1]] * v[ij[0]]))
        area = u[i] * v[j] - u[j] * v[i]
        s, r = (q[i] * v[j] - q[j] * v[i]) / area, (u[i] * q[j] - u[j] * q[i]) / area
        return s >= 0 and r >= 0 and s + r <= 1
    for w in (u, v, [y - x for x, y in zip(u, v, strict=True)]):
        start = a if w is not v and w is u else (a if w is v else t[1])
        offset = [x - y for x, y in zip(p, start, strict=True)]
        size = sum(x * x for x in w)
        k = sum(x * y for x, y in zip(w, offset, strict=True)) / size if size else Fraction(0)
        if 0 <= k <= 1 and all(o == k * x for o, x in zip(offset, w, strict=True)):
            return True
    return False


def far_winding(corners: np.ndarray, point: np.ndarray) -> int:
    """The winding number of a closed mesh round (x + ε, y + ε², z + ε³), ε a tiny fraction, by a ray in fractions."""
    tiny = Fraction(1, 10**30)
    p = [Fraction(x) + tiny ** (k + 1) for k, x in enumerate(point.tolist())]
    total = 0
    near = (corners.min(axis=1) <= point + 1e-9)[:, :2] & (corners.max(axis=1) >= point - 1e-9)[:, :2]
    for triangle in corners[near.all(axis=1)].tolist():
        a, b, c = ([Fraction(x) - q for x, q in zip(corner, p, strict=True)] for corner in triangle)
        sides = [s[0] * r[1] - s[1] * r[0] for s, r in ((a, b), (b, c), (c, a))]
        if all(s > 0 for s in sides) or all(s < 0 for s in sides):
            below = determinant([a, b, c])
            if (below > 0) == (sides[0] > 0):
                total += 1 if sides[0] > 0 else -1
    return total


# --- distances ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["closed/fox.ply", "genus/plate_holes.STL", "broken/soup.stl", "broken/deg_faces.obj"])
def test_distances_equal_brute_force(name: str) -> None:
    mesh = load(name)
    corners = corners_of(mesh)
    close = corners[np.arange(200) % len(corners)].mean(axis=1) * (1 + 1e-6)
    points = np.concatenate([around(mesh, 300), close, mesh.vertices[:100], 1e4 * around(mesh, 20)])
    found = analysis.closest_point(mesh, points)
    expected = brute_distance(corners, points)
    size = np.abs(mesh.bounds).max() + np.abs(points).max(axis=1)
    assert (np.abs(found.distance - expected) <= 1e-14 * size + 1e-9 * expected * (expected < 1e-6 * size)).all()
    np.testing.assert_array_equal(found.distance, analysis.distance(mesh, points))


@pytest.mark.parametrize("name", ["closed/fox.ply", "broken/soup.stl", "broken/platonic_shelf.obj"])
def test_closest_points_lie_where_their_weights_say(name: str) -> None:
    mesh = load(name)
    points = around(mesh, 500, 1)
    found = analysis.closest_point(mesh, points)
    size = np.abs(mesh.bounds).max()
    assert (found.barycentric >= 0).all()
    np.testing.assert_allclose(found.barycentric.sum(axis=1), 1, atol=1e-15)
    combined = (found.barycentric[:, :, None] * mesh.vertices[found.vertices]).sum(axis=1)
    np.testing.assert_allclose(combined, found.points, atol=1e-14 * size)
    np.testing.assert_allclose(np.linalg.norm(points - found.points, axis=1), found.distance, rtol=1e-14)
    faces = [set(mesh.indices[a:b].tolist()) for a, b in zip(mesh.offsets[:-1], mesh.offsets[1:], strict=True)]
    assert all(set(v.tolist()) <= faces[f] for v, f in zip(found.vertices, found.face, strict=True))


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_distances_of_slivers_and_points_on_grids(data: st.DataObject) -> None:
    coordinate = st.one_of(st.integers(-2, 2).map(float), st.floats(-2, 2), st.floats(-1e-6, 1e-6))
    corners = np.array(data.draw(st.lists(st.tuples(*[coordinate] * 9), min_size=1, max_size=6))).reshape(-1, 3, 3)
    points = np.array(data.draw(st.lists(st.tuples(*[coordinate] * 3), min_size=1, max_size=6)))
    mesh = iso.Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    # The oracle's own plane distances of slivers are too small by up to the sliver's width at worst.
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    thin = (areas > 0) & (areas < 1e-7 * lengths**2)
    found, expected = analysis.distance(mesh, points), brute_distance(corners, points)
    assert (np.abs(found - expected) <= (1e-6 if thin.any() else 1e-8)).all()


def test_of_equally_near_faces_the_first_is_named() -> None:
    for order in ([0, 1, 2, 3, 4, 5], [3, 5, 1, 0, 2, 4]):
        faces = [list(CUBE.faces[k]) for k in order]
        found = analysis.closest_point(iso.Mesh(CUBE.vertices, faces), [(2, 2, 2), (0.5, 0.5, 2)])
        corner = [k for k, face in enumerate(faces) if 7 in face]
        assert found.face.tolist() == [corner[0], order.index(1)]


def test_signed_distance_of_a_cube() -> None:
    points = np.random.default_rng(3).uniform(-1, 2, (500, 3))
    q = np.abs(points - 0.5) - 0.5
    expected = np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)
    np.testing.assert_allclose(analysis.signed_distance(CUBE, points), expected, atol=1e-15)
    inward = iso.Mesh(CUBE.vertices, CUBE.faces[:, ::-1])
    np.testing.assert_allclose(analysis.signed_distance(inward, points), expected, atol=1e-15)


def test_distances_do_not_depend_on_size_or_place() -> None:
    positions, triangles = sphere(12, 0.2)
    points = np.random.default_rng(4).normal(size=(200, 3))
    small = analysis.signed_distance(iso.Mesh(positions, triangles), points)
    for factor in (2.0**-600, 2.0**-30, 2.0**500):
        mesh = iso.Mesh(positions.astype(np.float64) * factor, triangles)
        np.testing.assert_array_equal(analysis.signed_distance(mesh, points * factor), small * factor)
    moved = iso.Mesh(positions + np.array([1e6, -3e6, 2e6]), triangles)
    far = analysis.signed_distance(moved, points + np.array([1e6, -3e6, 2e6]))
    np.testing.assert_allclose(far, small, atol=4e-9)


# --- winding numbers ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        "closed/fox.ply",
        "genus/plate_holes.STL",
        "boundary/suzanne.obj",
        "boundary/moebius.obj",
        "boundary/cat_head.obj",
        "broken/soup.stl",
        "broken/multibody.stl",
        "broken/triple_vierbein.obj",
        "broken/fan3.obj",
        "broken/angle_block.STL",
        "broken/deg_faces.obj",
    ],
)
def test_winding_numbers_equal_the_sum_of_solid_angles(name: str) -> None:
    mesh = load(name)
    points = around(mesh, 400, 5)
    np.testing.assert_allclose(
        analysis.winding_number(mesh, points), solid_angles(corners_of(mesh), points), atol=1e-13
    )


@pytest.mark.parametrize("name", ["closed/fox.ply", "broken/platonic_shelf.obj", "broken/hourglass_ico.obj"])
def test_winding_numbers_of_closed_meshes_are_whole_at_vertices_edges_and_faces(name: str) -> None:
    mesh = load(name)
    corners = corners_of(mesh)
    rng = np.random.default_rng(6)
    at = corners[rng.integers(0, len(corners), 25)]
    low = mesh.bounds[0] - 1
    on = np.concatenate([at[:, 0], (at[:, 0] + at[:, 1]) / 2, at.mean(axis=1)])
    # Below, beside and at vertices, edges and faces: rays through them.
    points = np.concatenate([on, [*on * (1, 1, 0) + low * (0, 0, 1)], [*on * (1, 0, 1) + low * (0, 1, 0)]])
    found = analysis.winding_number(mesh, points)
    assert found.tolist() == [far_winding(corners, p) for p in points]


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_winding_numbers_on_grids_are_those_of_the_moved_point(seed: int, size: int) -> None:
    """Closed meshes with corners on a small grid, full of degenerate, vertical and overlapping triangles."""
    rng = np.random.default_rng(seed)
    tetrahedra = rng.integers(0, size + 1, (rng.integers(1, 4), 4, 3)).astype(np.float64)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    mesh = iso.Mesh(tetrahedra.reshape(-1, 3), np.concatenate([faces + 4 * k for k in range(len(tetrahedra))]))
    points = rng.integers(0, 2 * size + 1, (12, 3)) / 2
    corners = corners_of(mesh)
    winding = [far_winding(corners, p) for p in points]
    assert analysis.winding_number(mesh, points).tolist() == winding
    on = [
        any(on_triangle([*map(Fraction, p)], [[*map(Fraction, c)] for c in t]) for t in corners.tolist())
        for p in points.tolist()
    ]
    assert analysis.contains(mesh, points).tolist() == [w != 0 or s for w, s in zip(winding, on, strict=True)]
    distances = analysis.distance(mesh, points)
    np.testing.assert_array_equal(distances[on] < 1e-15, True)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_rims_straight_above_and_below_points_are_closed_the_same_way(seed: int) -> None:
    """Cutting faces from a closed mesh on a grid leaves the rest's winding number: the whole's less theirs."""
    rng = np.random.default_rng(seed)
    corner = rng.permutation(3)
    faces = iso.triangulate(CUBE).triangles[rng.permutation(12)]
    cut = rng.integers(1, 12)
    vertices = CUBE.vertices[:, corner] * 2
    whole, rest, part = (iso.Mesh(vertices, f) for f in (faces, faces[:cut], faces[cut:]))
    points = rng.integers(-1, 4, (40, 3)).astype(np.float64)
    points = points[analysis.distance(whole, points) > 0]
    together = analysis.winding_number(rest, points) + analysis.winding_number(part, points)
    np.testing.assert_allclose(together, analysis.winding_number(whole, points), atol=1e-14)
    np.testing.assert_allclose(
        analysis.winding_number(rest, points), solid_angles(corners_of(rest), points), atol=1e-14
    )


def test_overlaps_count_twice_and_inward_faces_backward() -> None:
    two = iso.Mesh(
        np.concatenate([CUBE.vertices, CUBE.vertices + 0.5]), np.concatenate([CUBE.faces, np.add(CUBE.faces, 8)])
    )
    points = [(0.25, 0.25, 0.25), (0.75, 0.75, 0.75), (1.25, 1.25, 1.25), (1.4, 0.2, 0.2)]
    assert analysis.winding_number(two, points).tolist() == [1, 2, 1, 0]
    inward = iso.Mesh(CUBE.vertices, CUBE.faces[:, ::-1])
    assert analysis.winding_number(inward, points).tolist() == [-1, -1, 0, 0]
    assert analysis.contains(inward, points).tolist() == [True, True, False, False]


def test_a_mesh_of_loose_triangles_is_closed_where_its_corners_meet() -> None:
    corners = corners_of(CUBE).reshape(-1, 3)
    loose = iso.Mesh(corners, np.arange(len(corners)).reshape(-1, 3))
    points = np.random.default_rng(8).uniform(-1, 2, (100, 3))
    inside = ((points > 0) & (points < 1)).all(axis=1)
    assert analysis.winding_number(loose, points).tolist() == inside.astype(float).tolist()


@pytest.mark.parametrize("near", [1e-60, 1e-100, 1e-200, 1e-300])
def test_winding_numbers_hardly_away_from_a_rim_are_those_of_a_corner(near: float) -> None:
    """Seen from so near to a corner of an open mesh, only directions count."""
    octants = np.array([(x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)], float)
    mesh = iso.Mesh([(0, 0, 0), (1, 0, 0), (0.3, 1, 0.1), (-0.2, 0.4, 1)], [(0, 1, 2), (0, 2, 3)])
    directions = np.concatenate([octants, octants * (0.3, 0.9, 0.2), octants * (0.01, 0.2, 1)])
    expected = solid_angles(corners_of(mesh), directions * 1e-9)
    np.testing.assert_allclose(analysis.winding_number(mesh, directions * near), expected, atol=1e-8)


def test_winding_numbers_of_a_mesh_that_is_far_away_are_almost_none() -> None:
    cap = iso.Mesh(CUBE.vertices, CUBE.faces[:5])
    points = np.array([(x, y, z) for x in (1, -2) for y in (0, 1.5, -1) for z in (0, 3, -1)], float)
    for size in (1e9, 1e20, 1e40, 1e59):
        assert np.abs(analysis.winding_number(cap, points * size)).max() < max(2 / size**2, 1e-14)


def test_rims_of_many_loops_and_branches_are_whole() -> None:
    """Loose triangles, alone, side by side, twice the same, and in fans: their rims share edges and vertices."""
    rng = np.random.default_rng(10)
    for count in (1, 2, 3, 5, 8, 11, 30, 100):
        vertices = rng.random((max(4, count // 2), 3))
        faces = np.array([rng.permutation(len(vertices))[:3] for _ in range(count)])
        mesh = iso.Mesh(vertices, faces)
        points = rng.uniform(-0.5, 1.5, (50, 3))
        np.testing.assert_allclose(
            analysis.winding_number(mesh, points), solid_angles(corners_of(mesh), points), atol=1e-13
        )


def test_an_open_half_sphere_winds_by_its_solid_angle() -> None:
    """A cap seen from the centre of its sphere fills the part of the directions that it covers."""
    positions, triangles = sphere(40)
    upper = triangles[(positions[triangles][:, :, 2] > -1e-6).all(axis=1)]
    assert analysis.winding_number(iso.Mesh(positions, upper), [(0, 0, 0)])[0] == pytest.approx(0.5, abs=1e-9)


# --- all of it ------------------------------------------------------------------------------------


@pytest.mark.parametrize("question", ["closest_point", "distance", "signed_distance", "winding_number", "contains"])
def test_bad_points_are_refused(question: str) -> None:
    ask = getattr(analysis, question)
    for points, message in (
        ([[0, 0, np.nan]], "point 0 is not finite"),
        ([[0, 0, 0], [0, np.inf, 0]], "point 1 is not finite"),
        ([[0, 0, 1e200]], "too far"),
        ([[0, 0]], "shape"),
        ("far away", "numbers"),
    ):
        with pytest.raises(GeometryError, match=message):
            ask(CUBE, points)
    assert len(analysis.winding_number(CUBE, np.empty((0, 3)))) == 0
    assert analysis.contains(CUBE, (0.5, 0.5, 0.5)).tolist() == [True]


def test_results_do_not_depend_on_how_the_work_is_cut() -> None:
    positions, triangles = sphere(30, 0.1)
    table = build_mesh_distance(positions, triangles[:-7], 1).table
    points = np.random.default_rng(9).normal(size=(20_000, 3))
    mesh = iso.Mesh(positions, triangles[:-7])
    far, numbers, on = np.empty(20_000), np.empty(20_000), np.empty(20_000, np.int32)
    closest_points(table.words, points, 0, 20_000, np.empty((0, 3)), far, np.empty(0, np.int32), np.empty((0, 3)))
    winding_numbers(table.words, points, 0, 20_000, numbers, on)
    np.testing.assert_array_equal(analysis.distance(mesh, points), far)
    np.testing.assert_array_equal(analysis.winding_number(mesh, points), numbers)


def test_what_was_prepared_is_kept_until_its_mesh_goes() -> None:
    positions, triangles = sphere(8)
    mesh = iso.Mesh(positions, triangles)
    first = prepared_module.prepared(mesh)
    assert prepared_module.prepared(mesh) is first
    other = iso.Mesh(2 * positions, triangles)
    assert analysis.distance(other, [(0, 0, 4)])[0] == pytest.approx(2)
    assert analysis.distance(mesh, [(0, 0, 4)])[0] == pytest.approx(3)
    del mesh
    gc.collect()
    assert prepared_module._latest._kept is None
