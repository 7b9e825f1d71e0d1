"""Regions of fields: cells that are passed by hold nothing, rays along faces and edges of cells miss nothing, and
crossings are where the field is zero."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import isophote as iso
from isophote.accel import field_tree
from isophote.accel.field_tree import FieldTree, build_field_tree
from isophote.kernels.accel.field_layout import CHILDREN, EMPTY, INSIDE, NODE
from isophote.lower import scene as lower_scene
from isophote.lower.latest import LatestScene
from isophote.shapes.field.evaluate import packed_data
from isophote.shapes.field.tape import numpy_values, tape_of

RNG = np.random.default_rng(7)


def blobs(count: int = 60) -> iso.Field:
    rng = np.random.default_rng(5)
    parts = zip(rng.uniform(-1, 1, (count, 3)).tolist(), rng.uniform(0.05, 0.15, count).tolist(), strict=True)
    return iso.union(*(iso.sphere(radius).translate(place) for place, radius in parts), blend=0.05)


SHAPES = {
    "pierced": (iso.sphere(0.9) & iso.box(1.4)) - iso.cylinder(0.4) - iso.cylinder(0.4).along("x"),
    "twisted": iso.box((0.6, 1.6, 0.4)).twist(1.5) | iso.sphere(0.2).translate((0.7, 0, 0)),
    "blobs": blobs(),
    "shell": iso.sphere(0.8) - iso.sphere(0.8 - 1e-4) - iso.box((3, 0.5, 0.5)),
    "short": iso.torus(0.7, 0.25).offset(0),
}


def tree_of(field: iso.Field) -> tuple[FieldTree, np.ndarray, float]:
    """The tree over a cube around a field, the cube's least corner and its side."""
    low, high = np.asarray(field.bounds)
    side = float((high - low).max()) * 1.1
    corner = ((low + high) / 2 - side / 2).astype(np.float32)
    tape = tape_of(field.form, np.stack([corner - 0.01, corner + side + 0.01]))
    return build_field_tree(tape.rows, packed_data(tape).words, corner, side), corner, side


def cells_of(field: iso.Field) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n, 3) least corners and (n,) widths of the 64 cells of all regions, and (n,) whether they are passed by."""
    tree, corner, side = tree_of(field)
    nodes, finer = tree.nodes.reshape(-1, NODE)[:, :CHILDREN], tree.finer.reshape(-1, CHILDREN)
    steps = np.arange(CHILDREN)
    offset = np.stack([steps & 3, (steps >> 2) & 3, steps >> 4], axis=1)
    corners, widths, passed = [], [], []
    waiting = [(tree.root, finer[0, 0], corner.astype(float), side)]
    while waiting:
        code, cells, at, width = waiting.pop()
        open_cells = (int(cells) >> steps) & 1 == 1
        corners.append(at + offset * width / 4)
        widths.append(np.full(CHILDREN, width / 4))
        passed.append(~open_cells)
        if code > 0:
            assert ((nodes[code] != EMPTY) == open_cells).all()
            below = [k for k in steps if nodes[code, k] not in (EMPTY, INSIDE)]
            waiting += [(nodes[code, k], finer[code, k], corners[-1][k], width / 4) for k in below]
    return np.concatenate(corners), np.concatenate(widths), np.concatenate(passed)


@pytest.mark.parametrize("name", SHAPES)
def test_cells_that_are_passed_by_hold_no_surface(name: str) -> None:
    corners, widths, passed = cells_of(SHAPES[name])
    # Most of space is empty, and cells are not passed by for nothing.
    assert passed.mean() > 0.2
    corners, widths = corners[passed], widths[passed]
    if len(corners) > 40_000:
        some = RNG.choice(len(corners), 40_000, replace=False)
        corners, widths = corners[some], widths[some]
    for _ in range(4):
        points = corners + RNG.uniform(0, 1, corners.shape) * widths[:, None]
        assert (numpy_values(SHAPES[name].form, points) > 0).all()


@pytest.mark.parametrize("name", SHAPES)
def test_all_that_is_inside_lies_in_cells_that_are_looked_at(name: str) -> None:
    """The other way round: points inside, and the regions on the way to them."""
    field = SHAPES[name]
    tree, corner, side = tree_of(field)
    nodes, finer = tree.nodes.reshape(-1, NODE), tree.finer.reshape(-1, CHILDREN)
    low, high = np.asarray(field.bounds)
    points = RNG.uniform(low, high, (400_000 if name == "shell" else 20_000, 3))
    points = points[numpy_values(field.form, points) < 0][:2000]
    assert len(points) > 20
    for point in points:
        code, cells, place = tree.root, int(finer[0, 0]), (point - corner) / side
        while code != INSIDE:
            place = place * 4
            i, j, k = np.minimum(place.astype(int), 3)
            number = i + 4 * j + 16 * k
            assert (cells >> number) & 1
            if code < 0:
                break
            node, place = code, place - [i, j, k]
            code, cells = nodes[node, number], int(finer[node, number])


def test_rays_along_faces_and_through_corners_of_cells_miss_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """All 26 directions, from places on a lattice that regions share, against the whole tape."""
    shape = blobs() | iso.box(0.25) | iso.box(0.0625).translate((0.5, 0.5, 0.5))
    steps = np.array([d for d in itertools.product((-1, 0, 1), repeat=3) if any(d)], float)
    places = np.stack(np.meshgrid(*[np.linspace(-1, 1, 9)] * 3), axis=-1).reshape(-1, 3)
    origins = (places[:, None] - 4 * steps).reshape(-1, 3)
    directions = np.broadcast_to(steps, (len(places), *steps.shape)).reshape(-1, 3)
    # Directions that all but run along an axis.
    tilted = directions + RNG.choice([0, 1e-7, -1e-20, 1e-38], directions.shape)
    found = [iso.Tracer(shape).closest(origins, d) for d in (directions, tilted)]
    monkeypatch.setattr(field_tree, "_SHORT", 10**9)
    monkeypatch.setattr(field_tree, "_FINE_ROWS", 0)
    monkeypatch.setattr(lower_scene, "_latest", LatestScene())
    whole = [iso.Tracer(shape).closest(origins, d) for d in (directions, tilted)]
    for a, b in zip(found, whole, strict=True):
        assert a.hit.sum() > 1000
        # Rays that touch a face may go either way.
        assert (a.hit != b.hit).sum() <= 4
        both = a.hit & b.hit
        assert np.abs(a.distance[both] - b.distance[both]).max() < 1e-4


@pytest.mark.parametrize("name", SHAPES)
def test_crossings_are_where_the_field_is_zero(name: str) -> None:
    """However flat a ray meets the surface; only where it is thinner than positions can tell there is none."""
    field = SHAPES[name]
    origins = RNG.normal(size=(6000, 3))
    origins *= 3 / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = RNG.uniform(-1, 1, (6000, 3)) - origins
    hits = iso.Tracer(field).closest(origins, directions)
    at = origins[hits.hit].astype(np.float32).astype(float)
    at += hits.distance[hits.hit, None] * directions[hits.hit].astype(np.float32).astype(float)
    values = np.abs(numpy_values(field.form, at))
    assert np.quantile(values, 0.95) < 3e-7
    assert values.max() < 1e-6


@pytest.mark.parametrize("gap", [3e-7, 1e-6, 1e-4])
def test_rays_that_only_come_near_go_by(gap: float) -> None:
    """Rays past a ball, nearer than what a hit may be off, but farther than what single precision can tell: they meet
    the wall behind, and those that come as much too near meet the ball."""
    ball = iso.sphere(0.05).translate((0.1, 0, 0))
    field = iso.union(ball, iso.sphere(0.04).translate((0.1, 0.5, 0)), blend=0.05) | iso.box((2, 2, 0.1)).translate(
        (0, 0, -1)
    )
    angle = np.linspace(0, 2 * np.pi, 512, endpoint=False)
    for side in (1, -1):
        distance = 0.05 + side * gap
        origins = np.stack([0.1 + distance * np.cos(angle), distance * np.sin(angle), np.full(512, 0.8)], axis=1)
        hits = iso.Tracer(field).closest(origins, (0, 0, -1))
        # Single precision moves origins themselves.
        apart = np.linalg.norm(origins.astype(np.float32).astype(float)[:, :2] - [0.1, 0], axis=1) - 0.05
        sure = apart * side > gap / 2
        assert sure.mean() > 0.9
        assert (np.abs(hits.distance[sure] - (1.75 if side > 0 else 0.8)) < 0.05).all()


def test_normals_point_outward_where_a_value_changes_its_sign_by_a_switch() -> None:
    # A cone's value is a root times a sign: next to the surface, rounding may take the wrong one.
    shape = iso.union(iso.cone(0.6, 1.3), iso.sphere(0.1).translate((9, 0, 0)))
    random = np.random.default_rng(1)
    directions = random.normal(size=(20_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins = -3 * directions + random.uniform(-0.5, 0.5, (20_000, 3))
    hits = iso.Tracer(shape).closest(origins, directions)
    along = (hits.normal[hits.hit] * directions[hits.hit]).sum(axis=1)
    assert hits.hit.sum() > 10_000
    assert (along < 1e-3).all()
