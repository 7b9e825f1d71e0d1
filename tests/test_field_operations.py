"""Operations on fields: logic of solids, edges, transforms, deformations."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso
from field_shapes import EXACT
from isophote.shapes.field.tape import numpy_gradients, numpy_values

Floats = npt.NDArray[np.float64]
RANDOM = np.random.default_rng(11)


def values(field: iso.Field, points: npt.ArrayLike) -> Floats:
    return numpy_values(field.form, points)


def test_boolean_logic() -> None:
    a, b, c = iso.box((1, 1.2, 0.8)), iso.sphere(0.7).translate((0.2, 0.1, 0)), iso.torus(0.5, 0.2)
    points = RANDOM.uniform(-1, 1, (1_000_000, 3))
    x, y, z = (field(points) < 0 for field in (a, b, c))
    for field, expected in (
        (a | b, x | y),
        (a & b, x & y),
        (a - b, x & ~y),
        (a | b | c, x | y | z),
        (a - b - c, x & ~y & ~z),
        ((a | b) & c, (x | y) & z),
        (a - (b - c), x & ~(y & ~z)),
        (iso.union(a, b, c), x | y | z),
        (iso.intersection(a, b, c), x & y & z),
        (iso.difference(a, b, c), x & ~y & ~z),
    ):
        np.testing.assert_array_equal(field(points) < 0, expected)


@pytest.mark.parametrize("style", ["blend", "round", "chamfer"])
def test_edges_are_sharp_beyond_their_size(style: str) -> None:
    a, b, size = iso.box(1), iso.sphere(0.6).translate((0.5, 0, 0)), 0.2
    points = RANDOM.uniform(-1.5, 1.5, (100_000, 3))
    x, y = values(a, points), values(b, points)
    far = np.abs(x - y) >= size if style == "blend" else np.minimum(np.abs(x), np.abs(y)) >= 3 * size
    assert far.sum() > 100
    for sharp, soft, sign in (
        (a | b, a.union(b, **{style: size}), -1),
        (a & b, a.intersection(b, **{style: size}), 1),
        (a - b, a.difference(b, **{style: size}), 1),
    ):
        difference = values(soft, points) - values(sharp, points)
        assert (sign * difference >= -1e-12).all()
        assert (sign * difference > 1e-3).sum() > 100
        near = far if style == "blend" else far & ((x < -size) != (y < -size)) & (values(sharp, points) < -3 * size)
        if style == "blend" and sharp == a - b:
            near = np.abs(x + y) >= size
        np.testing.assert_allclose(difference[near], 0, atol=1e-12)


def test_blends_have_continuous_slopes() -> None:
    soft = iso.box(1).union(iso.sphere(0.6).translate((0.8, 0, 0)), blend=0.25)
    p = np.column_stack([np.linspace(0.2, 0.9, 200_001), np.full(200_001, 0.55), np.full(200_001, 0.05)])
    _, slopes = numpy_gradients(soft.form, p)
    assert np.abs(np.diff(slopes, axis=0)).max() < 1e-4
    _, sharp = numpy_gradients((iso.box(1) | iso.sphere(0.6).translate((0.8, 0, 0))).form, p)
    assert np.abs(np.diff(sharp, axis=0)).max() > 0.1


def test_a_round_edge_is_a_quarter_of_a_circle_and_a_chamfer_a_flat() -> None:
    corner = iso.plane("x").intersection(iso.plane("y"), round=0.3)
    turn = np.linspace(0, math.pi / 2, 50)
    arc = np.column_stack([0.3 * np.cos(turn) - 0.3, 0.3 * np.sin(turn) - 0.3, turn])
    np.testing.assert_allclose(values(corner, arc), 0, atol=1e-12)
    flat = iso.plane("x").intersection(iso.plane("y"), chamfer=0.3)
    line = np.column_stack([-0.3 * np.linspace(0, 1, 50), -0.3 * np.linspace(1, 0, 50), turn])
    np.testing.assert_allclose(values(flat, line), 0, atol=1e-12)
    np.testing.assert_allclose(values(flat, line + np.array([0.1, 0.1, 0])), 0.1 * 2**0.5, atol=1e-12)


def rotation(axis: npt.ArrayLike, angle: float) -> Floats:
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross)


@pytest.mark.parametrize("name", ["box", "cone", "link", "pyramid"])
def test_rigid_transforms_keep_the_distance(name: str) -> None:
    field, distance = EXACT[name]
    turn = rotation((1, -2, 0.5), 0.8)
    mirror = np.eye(3) - 2 * np.outer((0.6, 0.8, 0), (0.6, 0.8, 0))
    for placed, matrix, scale in (
        (field.translate((0.1, -0.2, 0.3)), np.eye(3), 1.0),
        (field.rotate("x", 0.7), rotation((1, 0, 0), 0.7), 1.0),
        (field.rotate("y", 0.7), rotation((0, 1, 0), 0.7), 1.0),
        (field.rotate("z", 0.7), rotation((0, 0, 1), 0.7), 1.0),
        (field.rotate((1, -2, 0.5), 0.8), turn, 1.0),
        (field.mirror("x"), np.diag([-1, 1, 1]), 1.0),
        (field.mirror((0.6, 0.8, 0)), mirror, 1.0),
        (field.along("x"), np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]), 1.0),
        (field.along("z"), np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]), 1.0),
        (field.scale(1.7), np.eye(3), 1.7),
        (field.affine(np.block([[1.5 * turn, np.array([[0.1], [0.2], [0]])], [np.zeros((1, 3)), 1]])), turn, 1.5),
    ):
        offset = {"translate": (0.1, -0.2, 0.3), "affine": (0.1, 0.2, 0)}.get(str(placed).split(").")[-1].split("(")[0])
        points = RANDOM.uniform(-1, 1, (1500, 3))
        expected = distance(points) * scale
        there = points @ matrix.T * scale + (offset or 0)
        assert placed.exactness is iso.Exactness.EXACT
        np.testing.assert_allclose(values(placed, there), expected, atol=2e-5)
        np.testing.assert_allclose(numpy_gradients(placed.form, there)[0], values(placed, there))


def test_along_lays_what_is_upright_on_the_axis() -> None:
    cone = iso.cone(0.3, 2)
    for axis, unit in (("x", (1, 0, 0)), ("y", (0, 1, 0)), ("z", (0, 0, 1)), ((1, 2, -2), (1 / 3, 2 / 3, -2 / 3))):
        tip = cone.along(axis)
        np.testing.assert_allclose(values(tip, [np.array(unit) * 0.99]), values(cone, [(0, 0.99, 0)]), atol=1e-12)
    base, tip = values(cone.along((0, -1, 0)), [(0.2, 0.9, 0), (0.2, -0.9, 0)])
    assert base < 0 < tip


def test_uneven_scales_are_bounds_with_the_right_sign() -> None:
    field, distance = EXACT["cone"]
    factors = np.array([1, 0.4, 2.5])
    points = RANDOM.uniform(-1.2, 1.2, (4000, 3))
    for scaled in (field.scale(tuple(factors)), field.affine(np.diag([*factors, 1]))):
        assert scaled.exactness is iso.Exactness.BOUND
        found, inner = values(scaled, points * factors), distance(points)
        np.testing.assert_array_equal(found < 0, inner < 0)
        np.testing.assert_allclose(found, inner * 0.4, atol=1e-5)


def test_twist_and_bend_and_taper_take_points_where_they_should() -> None:
    points = RANDOM.uniform(-0.5, 0.5, (2000, 3)) * [0.6, 2, 0.6]
    field = iso.box((0.4, 1.6, 0.3)).translate((0.05, 0.1, 0))
    expected = values(field, points)
    x, y, z = points.T
    c, s = np.cos(1.3 * y), np.sin(1.3 * y)
    np.testing.assert_allclose(values(field.twist(1.3), np.column_stack([c * x + s * z, y, c * z - s * x])), expected)
    bent = np.column_stack([2 - (2 - x) * np.cos(y / 2), (2 - x) * np.sin(y / 2), z])
    np.testing.assert_array_equal(values(field.bend(0.5), bent) < 0, expected < 0)
    inside = expected < -0.01
    np.testing.assert_allclose(values(field.bend(0.5), bent)[inside], expected[inside], atol=0.01)
    scale = np.interp(y, [-0.5, 0.5], [1, 0.4])
    tapered = values(field.taper(0.4, -0.5, 0.5), np.column_stack([x * scale, y, z * scale]))
    np.testing.assert_allclose(tapered, expected * scale, atol=1e-12)


def test_displacement_moves_the_surface_outwards() -> None:
    bumps = iso.sphere(0.8).displace(iso.waves(0.5), 0.03)
    p = RANDOM.uniform(-1, 1, (10_000, 3))
    height = np.prod(np.sin(p * (2 * math.pi / 0.5)), axis=1)
    np.testing.assert_allclose(values(bumps, p), np.linalg.norm(p, axis=1) - 0.8 - 0.03 * height, atol=1e-12)
    # Held within ±1: the value of a large ball, −8 and less, counts as −1.
    strong = iso.sphere(0.8).displace(iso.sphere(9), 0.05)
    np.testing.assert_allclose(values(strong, p), np.linalg.norm(p, axis=1) - 0.75)


def test_shells_offsets_and_elongation() -> None:
    p = RANDOM.uniform(-1.5, 1.5, (5000, 3))
    inner = values(iso.box(1), p)
    np.testing.assert_allclose(values(iso.box(1).shell(0.2), p), np.abs(inner) - 0.1)
    np.testing.assert_allclose(values(iso.box(1).offset(0.2), p), inner - 0.2)
    # A ball that is pulled apart is a capsule.
    capsule = values(iso.capsule(0.4, 2), p)
    np.testing.assert_allclose(values(iso.sphere(0.4).elongate((0, 1.2, 0)), p), capsule, atol=1e-12)
