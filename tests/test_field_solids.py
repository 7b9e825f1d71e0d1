"""Solid primitives: values against exact distances found by other ways, inside and out; slopes; bounds."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from field_shapes import EXACT, to_cloud
from isophote.shapes.field.tape import numpy_gradients, numpy_values

RANDOM = np.random.default_rng(3)
POINTS = RANDOM.uniform(-1.4, 1.4, (2000, 3))


@pytest.mark.parametrize("name", EXACT)
def test_values_are_the_distance(name: str) -> None:
    field, distance = EXACT[name]
    assert field.exactness is iso.Exactness.EXACT
    # Half of the points about the form, half within its bounds.
    low, high = np.clip(field.bounds, -1, 1)
    points = np.concatenate([POINTS, RANDOM.uniform(low, high, (2000, 3))])
    expected = distance(points)
    assert (expected < 0).sum() > 200
    np.testing.assert_allclose(numpy_values(field.form, points), expected, atol=1e-5, rtol=0)
    np.testing.assert_allclose(field(points), expected, atol=1.5e-5, rtol=0)


@pytest.mark.parametrize("name", EXACT)
def test_gradients_have_length_1(name: str) -> None:
    field, _ = EXACT[name]
    points = RANDOM.uniform(-1.4, 1.4, (100_000, 3))
    values, gradients = numpy_gradients(field.form, points)
    np.testing.assert_allclose(np.linalg.norm(gradients, axis=1), 1, atol=1e-9)
    # Down the gradient by the value lies the surface.
    np.testing.assert_allclose(numpy_values(field.form, points - gradients * values[:, None]), 0, atol=1e-9)


@pytest.mark.parametrize("name", [name for name in EXACT if np.isfinite(EXACT[name][0].bounds).all()])
def test_bounds_touch_the_surface_on_all_sides(name: str) -> None:
    field, _ = EXACT[name]
    size = field.bounds[1] - field.bounds[0]
    points = RANDOM.uniform(field.bounds[0] - 0.2 * size, field.bounds[1] + 0.2 * size, (100_000, 3))
    values, gradients = numpy_gradients(field.form, points)
    surface = points - gradients * values[:, None]
    np.testing.assert_allclose(surface.min(axis=0), field.bounds[0], atol=0.02)
    np.testing.assert_allclose(surface.max(axis=0), field.bounds[1], atol=0.02)
    assert (points[values <= 0] >= field.bounds[0]).all()
    assert (points[values <= 0] <= field.bounds[1]).all()


@pytest.mark.parametrize("radii", [(0.9, 0.4, 0.6), (0.5, 0.5, 0.5), (0.1, 1.2, 0.3)])
def test_an_ellipsoid_is_a_bound(radii: tuple[float, float, float]) -> None:
    field = iso.ellipsoid(radii)
    assert field.exactness is iso.Exactness.BOUND
    k = np.arange(400_000) + 0.5
    turn, height = k * (np.pi * (1 + 5**0.5)), 1 - k / 200_000
    ring = np.sqrt(1 - height**2)
    surface = np.column_stack([ring * np.cos(turn), height, ring * np.sin(turn)]) * radii
    values = numpy_values(field.form, POINTS)
    np.testing.assert_array_equal(values < 0, ((POINTS / radii) ** 2).sum(axis=1) < 1)
    assert (np.abs(values) <= to_cloud(POINTS, surface) + 1e-12).all()
    assert numpy_values(field.form, np.zeros((1, 3)))[0] == pytest.approx(-min(radii))
    np.testing.assert_allclose(numpy_values(field.form, np.diag(radii)), 0, atol=1e-15)


def test_overlapping_rings_are_bounds() -> None:
    assert iso.torus(0.2, 0.3).exactness is iso.Exactness.BOUND
    assert iso.capped_torus(0.6, 0.3, 6.0).exactness is iso.Exactness.BOUND
    assert iso.link(0.2, 0.3, 2).exactness is iso.Exactness.BOUND


def test_the_ground_is_solid_below() -> None:
    np.testing.assert_array_equal(iso.plane()([[5, -2, 1], [5, 0, 1], [5, 3, 1]]), [-2, 0, 3])
    np.testing.assert_array_equal(iso.plane().bounds, [[-np.inf] * 3, [np.inf, 0, np.inf]])
    np.testing.assert_array_equal(iso.plane("x", 0.5).bounds[1], [0.5, np.inf, np.inf])


def test_round_solids_stand_upright_and_sizes_are_full_lengths() -> None:
    for field, size in (
        (iso.box(1.5), (1.5, 1.5, 1.5)),
        (iso.cylinder(0.5, 3), (1, 3, 1)),
        (iso.capsule(0.5, 3), (1, 3, 1)),
        (iso.cone(0.5, 3), (1, 3, 1)),
        (iso.rounded_cone(0.5, 0.2, 3), (1, 3, 1)),
        (iso.torus(1, 0.25), (2.5, 0.5, 2.5)),
        (iso.link(0.5, 0.25, 4), (1.5, 4, 0.5)),
        (iso.pyramid(2, 3), (2, 3, 2)),
        (iso.prism(4, 1, 3), (2, 3, 2)),
    ):
        np.testing.assert_allclose(field.bounds[1] - field.bounds[0], size)
