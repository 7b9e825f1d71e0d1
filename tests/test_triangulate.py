"""Faces of any size and form become triangles that cover them exactly once."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from isophote import Mesh, load_mesh, triangulate

EARCUT = Path(__file__).parents[1] / "../shared/models/polygons/earcut"
COORDINATES = st.sampled_from([0.0, 1.0, 2.0, 3.0, -1.0, 0.5, 1e-9, 1e300, -1e300, 1e-300])


def face(points):
    points = np.asarray(points, float)
    if points.shape[1] == 2:
        points = np.c_[points, np.zeros(len(points))]
    return Mesh(points, [range(len(points))])


def area_vectors(mesh, triangles):
    a, b, c = (mesh.vertices[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


def polygon_area_vector(points):
    p = points - points[0]
    return np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0) / 2


def assert_covered_once(mesh, tolerance=1e-12):
    """All triangles turn as the face does, and their areas add up to the face's: no gap and no overlap."""
    cut = triangulate(mesh)
    assert cut.triangles.shape == (len(mesh.indices) - 2 * mesh.face_count, 3)
    whole = polygon_area_vector(mesh.vertices[mesh.indices])
    area = np.linalg.norm(whole)
    signed = area_vectors(mesh, cut.triangles) @ (whole / area)
    assert signed.min() > -tolerance * area
    assert np.abs(signed).sum() == pytest.approx(area, rel=tolerance)
    return cut


def assert_well_formed(mesh):
    cut = triangulate(mesh)
    counts = np.bincount(cut.face, minlength=mesh.face_count)
    assert (counts == mesh.face_sizes - 2).all()
    assert (cut.triangles == mesh.indices[cut.corners]).all()
    for number in range(mesh.face_count):
        assert_disk(cut.corners[cut.face == number], mesh.offsets[number], mesh.offsets[number + 1])


def assert_disk(corners, start, stop):
    """The triangles use every corner of the face, each side once in its direction, each inner edge both ways."""
    assert set(corners.ravel()) == set(range(start, stop))
    edges = {(int(t[k]), int(t[(k + 1) % 3])) for t in corners for k in range(3)}
    assert len(edges) == 3 * len(corners)
    ring = np.arange(start, stop)
    outline = {(int(a), int(b)) for a, b in zip(ring, np.roll(ring, -1), strict=True)}
    assert {(a, b) for a, b in edges if (b, a) not in edges} == outline


def star(count, seed, tilt=None):
    rng = np.random.default_rng(seed)
    angles = (np.arange(count) + 0.9 * rng.random(count)) * (2 * np.pi / count)
    radius = rng.uniform(0.1, 1, count)
    flat = np.c_[radius * np.cos(angles), radius * np.sin(angles), np.zeros(count)]
    return flat if tilt is None else flat @ np.linalg.qr(np.random.default_rng(tilt).normal(size=(3, 3)))[0].T


def spiral(turns, per_turn):
    s = np.linspace(0, 2 * np.pi * turns, turns * per_turn)
    inner, outer = s + 6, s + 9
    out = np.c_[inner * np.cos(s), inner * np.sin(s)]
    back = np.c_[outer * np.cos(s), outer * np.sin(s)][::-1]
    return np.r_[out, back]


def test_triangles_are_passed_on_without_copying():
    mesh = Mesh(np.eye(3), [(0, 1, 2), (2, 1, 0)])
    cut = triangulate(mesh)
    assert np.shares_memory(cut.triangles, mesh.indices)
    assert cut.triangles.tolist() == [[0, 1, 2], [2, 1, 0]]
    assert cut.face.tolist() == [0, 1]
    assert cut.corners.tolist() == [[0, 1, 2], [3, 4, 5]]
    assert (cut.triangles.dtype, cut.face.dtype, cut.corners.dtype) == (np.int32, np.int32, np.int64)


def test_triangles_and_quads_never_load_numba():
    program = (
        "import sys; from isophote import Mesh, studio, triangulate;"
        "m = Mesh([(0,0,0),(1,0,0),(1,1,0),(0,1,0)], [(0,1,2,3),(0,1,2)]);"
        "triangulate(m); studio(m); assert 'numba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_mixed_faces_keep_their_order_and_corners():
    mesh = Mesh(np.random.default_rng(1).random((9, 3)), [(0, 1, 2, 3), (4, 5, 6), (0, 2, 4, 6, 8), (8, 7, 6, 5)])
    cut = triangulate(mesh)
    assert cut.face.tolist() == [0, 0, 1, 2, 2, 2, 3, 3]
    assert_well_formed(mesh)


@pytest.mark.parametrize("turn", range(4))
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_concave_quad_is_cut_inside(turn, mirrored):
    arrow = np.array([(0, 0), (4, -1), (1, 0.2), (4, 2)], float)
    points = np.roll(arrow, turn, axis=0)
    assert_covered_once(face(points[::-1] if mirrored else points))


def test_a_quad_with_a_straight_corner_gives_no_triangle_without_area():
    for turn in range(4):
        mesh = face(np.roll([(0, 0), (1, 0), (2, 0), (0, 2)], turn, axis=0))
        assert np.linalg.norm(area_vectors(mesh, triangulate(mesh).triangles), axis=1).min() > 0.5


def test_a_convex_quad_is_cut_along_its_shorter_diagonal_and_a_square_from_its_first_corner():
    assert triangulate(face([(0, 0), (3, 0), (4, 1), (1, 1)])).triangles.tolist() == [[0, 1, 3], [1, 2, 3]]
    assert triangulate(face([(0, 0), (1, 0), (4, 1), (3, 1)])).triangles.tolist() == [[0, 1, 3], [1, 2, 3]]
    assert triangulate(face([(0, 0), (1, 0), (1, 1), (0, 1)])).triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize("scale", [1e-200, 1e-9, 1, 1e9, 1e200])
def test_quads_of_any_scale(scale):
    mesh = face(np.array([(0, 0), (4, -1), (1, 0.2), (4, 2)]) * scale)
    assert triangulate(mesh).triangles.tolist() == triangulate(face(mesh.vertices / scale)).triangles.tolist()


@pytest.mark.parametrize("count", [5, 6, 7, 20, 200])
@pytest.mark.parametrize("seed", range(5))
def test_star_shaped_polygons_in_any_plane(count, seed):
    assert_covered_once(face(star(count, seed)))
    assert_covered_once(face(star(count, seed)[::-1]))
    assert_covered_once(face(1e3 + star(count, seed, tilt=seed)), 1e-9)


@pytest.mark.parametrize("scale", [1e-200, 1e-4, 1e5, 1e200])
def test_polygons_of_any_scale(scale):
    expected = triangulate(face(star(30, 3))).triangles
    assert (triangulate(face(star(30, 3) * scale)).triangles == expected).all()


def test_spirals():
    assert_covered_once(face(spiral(4, 60)))


def test_a_long_spiral_takes_far_less_than_the_square_of_its_corners():
    triangulate(face(spiral(1, 9)))
    start = time.process_time()
    assert_covered_once(face(spiral(20, 250)), 1e-11)
    assert time.process_time() - start < 3


def test_straight_corners_give_no_triangle_without_area_where_none_is_needed():
    ring = [(0, 0), (1, 0), (2, 0), (3, 0), (3, 3), (2, 3), (1, 3), (0, 3), (0, 1)]
    mesh = face(ring)
    assert_covered_once(mesh)
    assert np.linalg.norm(area_vectors(mesh, triangulate(mesh).triangles), axis=1).min() > 0


@pytest.mark.parametrize(
    "ring",
    [
        [(0, 0), (0, 0), (1, 0), (1, 1), (1, 1), (0, 1), (0, 0)],
        [(0, 0), (2, 0), (2, 2), (1, 2), (1, 3), (1, 2), (0, 2)],
        [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 2), (2, 2), (2, 1), (1, 1)],
    ],
    ids=["repeated", "whisker", "hole on a bridge"],
)
def test_polygons_that_touch_themselves(ring):
    assert_covered_once(face(ring))
    assert_well_formed(face(ring))


@pytest.mark.parametrize("points", [np.zeros((7, 3)), np.outer(np.arange(6.0), (1, 2, 3))], ids=["point", "line"])
def test_faces_without_area_give_their_triangles_all_the_same(points):
    assert_well_formed(face(points))
    assert_well_formed(face(points[:4]))


@pytest.mark.skipif(not EARCUT.is_dir(), reason="the polygons are not here")
def test_known_hard_polygons():
    seen = 0
    for path in sorted(EARCUT.glob("*.json")):
        rings = json.loads(path.read_text())
        if isinstance(rings, list) and len(rings) == 1:
            assert_covered_once(face(rings[0]), 1e-12)
            seen += 1
    assert seen >= 3


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES), min_size=4, max_size=24))
def test_garbage_polygons(points):
    assert_well_formed(face(points))


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), min_size=4, max_size=40))
def test_crossing_polygons_keep_their_signed_area(points):
    mesh = face(points)
    assert_well_formed(mesh)
    total = area_vectors(mesh, triangulate(mesh).triangles).sum(axis=0)
    assert np.allclose(total, polygon_area_vector(mesh.vertices), atol=1e-9)


def test_a_million_quads_take_less_than_a_second():
    n = 1001
    number = np.arange(n * n).reshape(n, n)
    quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    mesh = Mesh(np.c_[x.ravel(), y.ravel(), np.sin(x + y).ravel()], quads)
    times = []
    for _ in range(3):
        start = time.process_time()
        cut = triangulate(mesh)
        times.append(time.process_time() - start)
    assert min(times) < 1
    assert len(cut.triangles) == 2_000_000


def test_a_large_polygon_that_crosses_itself_everywhere_does_not_take_long():
    start = time.process_time()
    assert_well_formed(face(np.random.default_rng(5).random((3000, 3))))
    assert time.process_time() - start < 20


# --- quads that share two edges -------------------------------------------------------------------

# A tent over the line from 0 to 2: all diagonals between these are shorter than the others.
TENT = [(0, -0.1, 0), (1, 0, 0), (0, 0.1, 0), (-1, 0, 0), (0, 0, 0.5)]


def most_at_an_edge(mesh):
    cut = triangulate(mesh)
    assert_well_formed(mesh)
    ends = np.sort(np.stack([cut.triangles, np.roll(cut.triangles, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    return np.unique(ends, axis=0, return_counts=True)[1].max()


@pytest.mark.parametrize(
    "faces",
    [
        [(0, 1, 2, 4), (0, 4, 2, 3)],
        [(4, 0, 1, 2), (3, 0, 4, 2)],
        [(0, 1, 2, 4), (0, 4, 2, 3), (0, 3, 2, 1)],
        [(0, 1, 2, 4), (0, 4, 2)],
        [(0, 4, 2), (1, 2, 4, 0)],
        [(0, 1, 2, 3), (0, 3, 2, 1)],
        [(0, 1, 2, 4), (4, 2, 1, 0)],
    ],
)
@pytest.mark.parametrize("copies", [1, 3])
def test_quads_that_share_two_edges_share_no_diagonal(faces, copies):
    vertices = np.concatenate([np.add(TENT, (5.0 * k, 0, 0)) for k in range(copies)])
    mesh = Mesh(vertices, [np.add(face, 5 * k) for k in range(copies) for face in faces])
    assert most_at_an_edge(mesh) == 2


def test_a_concave_quad_keeps_its_diagonal_and_its_twin_gives_way():
    """The upper quad has but one diagonal inside, the lower one may take either."""
    points = [(0, 0, 0), (-1, -1, 0), (3, 0, 0), (-1, 1, 0), (2, 1.5, -0.5)]
    upper, lower = (0, 1, 2, 3), (0, 4, 2, 1)
    assert {0, 2} <= set(triangulate(Mesh(points, [lower])).triangles[0].tolist())
    for faces in ([upper, lower], [lower, upper]):
        assert most_at_an_edge(Mesh(points, faces)) == 2
        found = {frozenset(t) for t in triangulate(Mesh(points, faces)).triangles.tolist()}
        assert {frozenset({0, 1, 2}), frozenset({0, 2, 3})} <= found


def test_suzanne_has_no_edge_with_more_than_two_triangles():
    """Two quads at the mouth share two edges."""
    path = Path(__file__).parents[1] / "../shared/models/boundary/suzanne.obj"
    if not path.exists():
        pytest.skip("the model is not there")
    assert most_at_an_edge(load_mesh(path)) == 2
