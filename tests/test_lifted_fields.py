"""Solids from forms in the plane, extruded, turned and swept, and fields of meshes: closed forms and brute force."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import isophote as iso
from isophote.shapes.field.form import Exactness
from isophote.shapes.field.tape import numpy_values

MODELS = Path(__file__).parents[1] / "../shared/models"
POINTS = np.random.default_rng(0).uniform(-2, 2, (4000, 3))


def at(field: Any, points: Any = POINTS) -> Any:
    return numpy_values(field.form, np.asarray(points, np.float64))


def box_at(low: Any, high: Any, points: Any = POINTS) -> Any:
    q = np.maximum(np.asarray(low) - points, points - np.asarray(high))
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


def steepest(field: Any, points: Any = POINTS) -> float:
    near = points + np.random.default_rng(1).normal(size=points.shape) * 1e-4
    return float((np.abs(at(field, points) - at(field, near)) / np.linalg.norm(points - near, axis=1)).max())


# --- extruded and turned --------------------------------------------------------------------------


def test_an_extruded_rectangle_is_a_box():
    field = iso.rectangle((2, 1)).extrude(0.6)
    assert at(field) == pytest.approx(box_at((-1, -0.5, -0.3), (1, 0.5, 0.3)))
    assert field.exactness is Exactness.EXACT
    assert field.lipschitz == 1.0
    assert field.bounds.tolist() == [[-1, -0.5, -0.3], [1, 0.5, 0.3]]
    assert at(field.round(0.1)) == pytest.approx(at(iso.box((2, 1, 0.6)).round(0.1)))


def test_an_extruded_disc_is_a_cylinder():
    assert at(iso.circle(0.7).extrude(1)) == pytest.approx(at(iso.cylinder(0.7, 1).along("z")))


def test_a_turned_disc_is_a_torus():
    field = iso.circle(0.4).revolve(1.1)
    expected = np.hypot(np.hypot(POINTS[:, 0], POINTS[:, 2]) - 1.1, POINTS[:, 1]) - 0.4
    assert at(field) == pytest.approx(expected)
    assert field.exactness is Exactness.EXACT
    assert field.lipschitz == 1.0


def test_a_turned_rectangle_across_the_axis_is_a_cylinder():
    """Its left half is as good as its right one; what is claimed is only a bound."""
    field = iso.rectangle((2, 1)).revolve()
    assert at(field) == pytest.approx(at(iso.cylinder(1.0, 1.0)))
    assert field.exactness is Exactness.BOUND


def test_what_lies_left_of_the_axis_is_left_out():
    field = iso.circle(0.5).revolve(-0.3)
    inside = np.hypot(np.hypot(POINTS[:, 0], POINTS[:, 2]) + 0.3, POINTS[:, 1]) < 0.5
    assert ((at(field) < 0) == inside).all()
    assert iso.analysis.field_report(field).holds


@pytest.mark.parametrize("name", ["extrude", "revolve", "sweep"])
def test_lifts_of_bounds_keep_their_slopes(name):
    """An image's field is steeper than 1; what is claimed of its lifts holds."""
    flat = iso.image([[True, False], [True, True]], pixel=0.5)
    field = {
        "extrude": lambda: flat.extrude(1),
        "revolve": lambda: flat.revolve(0.7),
        "sweep": lambda: flat.sweep([(-1, 0, 0), (0, 0, 1), (1, 0.5, 0)]),
    }[name]()
    assert field.exactness is Exactness.BOUND
    assert 1.05 < steepest(field) <= field.lipschitz
    assert field.lipschitz == pytest.approx(math.sqrt(2))


# --- swept ----------------------------------------------------------------------------------------


def test_a_straight_sweep_is_an_extrusion():
    swept, drawn = iso.star(5, 1, 0.4).sweep([(0, 0, -0.3), (0, 0, 0.3)]), iso.star(5, 1, 0.4).extrude(0.6)
    assert (np.sign(at(swept)) == np.sign(at(drawn))).all()
    assert at(swept) == pytest.approx(at(drawn))


def test_a_right_angle_is_mitred():
    """Two boxes that reach into the outer corner."""
    field = iso.rectangle((0.6, 0.4)).sweep([(0, 0, -1), (0, 0, 1), (1.5, 0, 1)])
    one = box_at((-0.3, -0.2, -1), (0.3, 0.2, 1.3))
    two = box_at((-0.3, -0.2, 0.7), (1.5, 0.2, 1.3))
    assert (np.sign(at(field)) == np.sign(np.minimum(one, two))).all()
    assert (np.abs(at(field)) <= np.abs(np.minimum(one, two)) + 1e-9)[np.minimum(one, two) > 0].all()
    assert field.bounds == pytest.approx(np.array([[-0.3, -0.2, -1], [1.5, 0.2, 1.3]]), abs=0.02)
    # At the bend, where the pieces meet, the inside is not felt to end.
    assert at(field, [(0, 0, 1)])[0] < -0.15
    assert at(field, [(0.1, 0, 1.1)])[0] < -0.15


def test_a_closed_path_makes_a_frame():
    path = [(-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1), (-1, 0, -1)]
    field = iso.rectangle((0.4, 0.4)).sweep(path)
    outer, inner = box_at((-1.2, -0.2, -1.2), (1.2, 0.2, 1.2)), box_at((-0.8, -9, -0.8), (0.8, 9, 0.8))
    assert (np.sign(at(field)) == np.sign(np.maximum(outer, -inner))).all()
    assert at(field, [(1, 0, -1), (-1, 0, -1), (0, 0, 1)]).max() < -0.15


def test_a_fine_ring_is_a_torus():
    field = iso.circle(0.4).sweep(
        lambda t: (1.1 * math.cos(t * math.tau), 0, 1.1 * math.sin(t * math.tau)), samples=128
    )
    expected = np.hypot(np.hypot(POINTS[:, 0], POINTS[:, 2]) - 1.1, POINTS[:, 1]) - 0.4
    clear = np.abs(expected) > 2e-3
    assert (np.sign(at(field)) == np.sign(expected))[clear].all()
    outside = expected > 0.01
    assert (at(field)[outside] <= expected[outside] + 2e-3).all()
    assert (at(field)[outside] >= 0.9 * expected[outside]).all()


def test_helices_hold_what_they_claim():
    def helix(t: float) -> Any:
        return math.cos(4 * t), 2 * t - 1, math.sin(4 * t)

    field = iso.rounded_rectangle((0.5, 0.3), 0.1).sweep(helix, samples=20)
    report = iso.analysis.field_report(field, samples=300)
    assert report.holds
    assert report.claimed_exactness is Exactness.BOUND
    assert field.lipschitz == 1.0
    middle = np.array([helix((k + 0.5) / 20) for k in range(20)])
    ends = np.array([helix(k / 20) for k in range(21)])
    assert at(field, (ends[1:] + ends[:-1]) / 2).max() < -0.05
    assert np.abs(field(middle) - at(field, middle)).max() < 1e-6


def test_frames_do_not_twist():
    """Along a curve in a plane the form's y stays upright."""
    field = iso.rectangle((0.1, 1.0)).sweep([(math.sin(a), 0, math.cos(a)) for a in np.linspace(0, 4, 30)])
    along = np.array([(math.sin(a), 0.45, math.cos(a)) for a in np.linspace(0.1, 3.9, 50)])
    assert (at(field, along) < 0).all()
    assert (at(field, along + np.array([0, 0.1, 0])) > 0).all()


@pytest.mark.parametrize("level", [0.0, 0.1, 0.5])
@pytest.mark.parametrize(
    "path",
    [
        [(0, 0, 0), (0, 0, 2), (2, 0, 2), (2, 1.5, 1)],
        [(0, 0, 0), (2, 0, 0), (2, 0, 2), (0, 0, 2), (0, 0, 0)],
        [(0, 0, 0), (1, 0, 0), (1.1, 0, 0.4), (0.2, 0.1, 0.3)],
    ],
)
def test_bounds_of_swept_forms_at_a_level(path, level):
    form = iso.rounded_rectangle((0.6, 0.3), 0.1).sweep(path).form
    low, high = form.bounds_at(level)
    points = np.random.default_rng(2).uniform(low - 1, high + 1, (20_000, 3))
    held = points[numpy_values(form, points) <= level]
    assert len(held) > 100
    assert ((held >= low) & (held <= high)).all()


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ([(0, 0, 0)], "from 2 to 2049 points"),
        ([(0, 0, 0), (0, 0, 0)], "points 0 and 1 of the path are the same"),
        ([(0, 0, 0), (0, 0, 1), (0, 0, 0.5)], "turns back at point 1"),
        ([(0, 0), (1, 1)], "point 0 is"),
        ([(0, 0, 0), (0, math.nan, 1)], "point 1 is"),
        (3, "is a function that gives one"),
        ("path", "has points"),
        (lambda t: (t, 0), "point 0 is"),
    ],
)
def test_paths_that_lead_nowhere_are_refused(path, message):
    with pytest.raises(iso.GeometryError, match=message):
        iso.circle(1).sweep(path)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: iso.circle(1).extrude(0), "height must be a finite number above 0"),
        (lambda: iso.circle(1).revolve(-2), "nothing of the form lies right of the axis"),
        (lambda: iso.circle(1).revolve(math.inf), "offset must be a finite number"),
        (lambda: iso.circle(1).sweep(lambda t: (t, 0, 0), samples=0), "samples must be"),
    ],
)
def test_lifts_that_cannot_be_are_refused(make, message):
    with pytest.raises(iso.GeometryError, match=message):
        make()


def test_they_paste_back():
    names = {name: getattr(iso, name) for name in ("circle", "rectangle")}
    for field in (iso.circle(1).extrude(2), iso.circle(1).revolve(2), iso.rectangle(1).sweep([(0, 0, 0), (0, 1, 0.5)])):
        assert eval(repr(field), names) == field


# --- meshes ---------------------------------------------------------------------------------------

CUBE = iso.Mesh(
    [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)],
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
)


def brute_distance(vertices: Any, triangles: Any, points: Any) -> Any:
    """Distance to triangles: to their planes where the projection is within, else to their edges."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    best = np.full(len(points), np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        d = q - p
        size = np.maximum((d * d).sum(axis=1), 1e-300)
        t = np.clip(((points[:, None] - p) * d).sum(axis=2) / size, 0, 1)
        best = np.minimum(best, np.linalg.norm(points[:, None] - p - t[..., None] * d, axis=2).min(axis=1))
    normal = np.cross(b - a, c - a)
    flat = (normal * normal).sum(axis=1)
    area = np.where(flat > 0, flat, np.inf)
    offset = points[:, None] - a
    v = (np.cross(offset, c - a) * normal).sum(axis=2) / area
    w = (np.cross(b - a, offset) * normal).sum(axis=2) / area
    height = np.abs((offset * normal).sum(axis=2)) / np.sqrt(area)
    height = np.where((flat > 0) & (v >= 0) & (w >= 0) & (v + w <= 1), height, np.inf)
    return np.minimum(best, height.min(axis=1))


def brute_winding(vertices: Any, triangles: Any, points: Any) -> Any:
    """Sum of solid angles over 4π (van Oosterom, Strackee 1983)."""
    a, b, c = (vertices[triangles[:, k]] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    top = (a * np.cross(b, c)).sum(axis=2)
    bottom = la * lb * lc + (a * b).sum(axis=2) * lc + (b * c).sum(axis=2) * la + (c * a).sum(axis=2) * lb
    return 2 * np.arctan2(top, bottom).sum(axis=1) / (4 * np.pi)


def test_a_mesh_of_a_cube():
    field = iso.distance_field(CUBE)
    assert at(field) == pytest.approx(box_at((0, 0, 0), (1, 1, 1)))
    assert field(POINTS) == pytest.approx(box_at((0, 0, 0), (1, 1, 1)), abs=1e-6)
    assert field.bounds.tolist() == [[0, 0, 0], [1, 1, 1]]
    assert field.lipschitz == 1.0
    assert eval(repr(field), {"distance_field": iso.distance_field, "Mesh": iso.Mesh}) == field
    inside_out = iso.distance_field(iso.Mesh(CUBE.vertices, [face[::-1] for face in CUBE.faces]))
    assert at(inside_out) == pytest.approx(box_at((0, 0, 0), (1, 1, 1)))


def test_a_mesh_with_a_hole_has_an_inside_and_claims_signs_alone():
    field = iso.distance_field(iso.Mesh(CUBE.vertices, CUBE.faces[:5]))
    deep = np.random.default_rng(3).uniform(0.1, 0.6, (500, 3))
    assert (at(field, deep) < 0).all()
    assert (at(field)[box_at((0, 0, 0), (1, 1, 1)) > 0] > 0).all()
    assert field.exactness is Exactness.SIGN
    assert field.lipschitz == math.inf


@pytest.mark.parametrize("name", ["broken", "closed", "genus"])
def test_mesh_files_against_brute_force(name):
    folder = MODELS / name
    if not folder.is_dir():
        pytest.skip("no model files")
    rng = np.random.default_rng(4)
    tried = 0
    for path in sorted(folder.iterdir()):
        if path.suffix not in (".obj", ".off", ".ply", ".stl") or path.stat().st_size > 300_000:
            continue
        try:
            mesh = iso.load_mesh(path)
        except iso.Error:
            continue
        triangles = iso.triangulate(mesh).triangles
        if len(triangles) > 4000:
            continue
        tried += 1
        low, high = mesh.bounds
        points = rng.uniform(low - 0.2 * (high - low), high + 0.2 * (high - low), (60, 3))
        found = at(iso.distance_field(mesh), points)
        size = float(np.linalg.norm(high - low))
        assert np.abs(np.abs(found) - brute_distance(mesh.vertices, triangles, points)).max() < 1e-9 * size, path
        winding = np.abs(brute_winding(mesh.vertices, triangles, points))
        winding[~((points >= low) & (points <= high)).all(axis=1)] = 0
        clear = np.abs(winding - 0.5) > 1e-6
        assert ((found < 0) == (winding > 0.5))[clear].all(), path
    assert tried >= 1


def test_what_is_no_mesh_is_refused():
    with pytest.raises(iso.GeometryError, match="takes a Mesh, but not Field"):
        iso.distance_field(iso.sphere(1))
