"""Fields of NumPy functions: those that become expressions, those that stay opaque, and those that are refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import isophote as iso
from isophote.shapes.field.data import GridData
from isophote.shapes.field.form import Exactness
from isophote.shapes.field.function_form import SampledFunction, WrittenFunction
from isophote.shapes.field.tape import numpy_values, tape_of

BOX = ([-1.5] * 3, [1.5] * 3)
POINTS = np.random.default_rng(0).uniform(-1.5, 1.5, (2000, 3))
CENTRES = np.linspace(-1, 1, 4)


def sphere(p: Any) -> Any:
    return np.linalg.norm(p, axis=1) - 1


def torus(p: Any) -> Any:
    x, y, z = p.T
    return np.hypot(np.hypot(x, z) - 1, y) - 0.3


def box(p: Any) -> Any:
    d = np.abs(p) - np.array([0.5, 0.3, 0.7])
    return np.linalg.norm(np.maximum(d, 0), axis=-1) + np.minimum(d.max(axis=1), 0)


def twisted(p: Any) -> Any:
    c, s = np.cos(p[:, 1] * 0.5), np.sin(p[:, 1] * 0.5)
    return box(np.stack([c * p[:, 0] - s * p[:, 2], p[:, 1], s * p[:, 0] + c * p[:, 2]], axis=1))


def chosen(p: Any) -> Any:
    first = (p[:, 0] > 0) & (p[:, 1] < 0.2) | ~(p[..., 2] >= 0.4)
    return np.where(first, np.linalg.norm(p, axis=1), np.linalg.norm(p - [0.1, 0, 0], axis=1)) - 1.0


def powers(p: Any) -> Any:
    return ((p**2).sum(axis=1) ** 0.5 - 1) * (1 + 0 * p[:, 0] ** 3) + 0 * p[:, 1] ** -2


def sheared(p: Any) -> Any:
    return np.linalg.norm(p @ np.array([[1, 0.1, 0], [0, 1, 0], [0, 0, 1.0]]), axis=1, keepdims=True)[:, 0] - 1


def in_place(p: Any) -> Any:
    p = p.copy()
    p -= 0.1
    return np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2 + p[:, 2] ** 2) - 1


def joined(p: Any) -> Any:
    return np.minimum.reduce([np.linalg.norm(p - [c, 0, 0], axis=1) - 0.3 for c in CENTRES])


def summed(p: Any) -> Any:
    d: Any = 9.0
    for c in CENTRES:
        d = np.minimum(d, np.linalg.norm(p - [c, 0, 0], axis=1) - 0.3)
    return d


def waves(p: Any) -> Any:
    q = np.concatenate([p[:, :2], p[:, 2:]], axis=1)
    shaken = np.sin(3 * q).sum(axis=1) * 0.1 + np.arctan2(p[:, 1], 2.0) * 0.05 - np.exp(-p[:, 0]) * 0.01
    return np.clip(np.sqrt(np.square(q).sum(axis=-1)), 0, 5) - 0.8 + shaken - np.arctan(np.tan(p[:, 2] / 4)) * 0.01


def folded(p: Any) -> Any:
    r = np.abs(np.mod(p, 2.0) - 1.0) + np.floor(p) * 0 + np.sign(p) * 0
    return np.max(r, axis=1) + 0.2


WRITTEN = [sphere, torus, box, twisted, chosen, powers, sheared, in_place, summed, waves, folded]


def looked_up(p: Any) -> Any:
    """No arithmetic on columns: NumPy's searching and filling."""
    d = np.full(len(p), 9.0)
    for c in CENTRES:
        np.minimum(d, np.linalg.norm(p - [c, 0, 0], axis=1) - 0.3, out=d)
    return d


@pytest.mark.parametrize("function", WRITTEN, ids=lambda f: f.__name__)
def test_arithmetic_becomes_an_expression(function):
    field = iso.field(function, BOX)
    assert isinstance(field.form, WrittenFunction)
    inside = function(POINTS)
    assert numpy_values(field.form, POINTS) == pytest.approx(inside, abs=1e-9)
    assert np.abs(field(POINTS) - inside).max() < 1e-5
    near = POINTS + np.random.default_rng(1).normal(size=POINTS.shape) * 1e-5
    if math.isfinite(field.lipschitz):
        rises = np.abs(function(near) - inside) / np.linalg.norm(near - POINTS, axis=1)
        assert rises.max() <= field.lipschitz * (1 + 1e-6)


def test_what_is_written_is_as_good_as_what_is_built():
    """The same operators, point for point."""
    built = (iso.sphere(1) & iso.box((1, 0.6, 1.4))) - iso.torus(1, 0.3)

    def part(p: Any) -> Any:
        return np.maximum(np.maximum(sphere(p), box(p)), -torus(p))

    assert numpy_values(iso.field(part, BOX).form, POINTS) == pytest.approx(numpy_values(built.form, POINTS), abs=1e-12)
    assert len(tape_of(iso.field(part, BOX).form).rows) <= len(tape_of(built.form).rows) + 4


def test_a_stated_constant_is_claimed():
    assert iso.field(sphere, BOX).lipschitz > 1.5
    assert iso.field(sphere, BOX, lipschitz=1).lipschitz == 1.0
    assert iso.field(sphere, BOX, lipschitz=1).exactness is Exactness.BOUND


def test_bounds_cut_what_reaches_beyond():
    def endless(p: Any) -> Any:
        return np.hypot(p[:, 0], p[:, 2]) - 0.5

    field = iso.field(endless, ([-1, -1, -1], [1, 1, 1]))
    wide = np.random.default_rng(2).uniform(-3, 3, (4000, 3))
    inside = (endless(wide) < 0) & (np.abs(wide[:, 1]) < 1)
    assert ((numpy_values(field.form, wide) < 0) == inside).all()
    assert field.bounds == pytest.approx(np.array([[-0.5, -1, -0.5], [0.5, 1, 0.5]]), abs=0.1)
    whole = iso.field(endless)
    assert whole.bounds[:, 1].tolist() == [-math.inf, math.inf]
    assert numpy_values(whole.form, wide) == pytest.approx(endless(wide))
    # Where the shape lies within its bounds, values are the function's own everywhere.
    assert numpy_values(iso.field(sphere, BOX).form, wide) == pytest.approx(sphere(wide))


@pytest.mark.parametrize("function", [looked_up, joined])
def test_opaque_functions_are_asked_where_the_field_is_called(function):
    field = iso.field(function, BOX, lipschitz=1)
    assert isinstance(field.form, SampledFunction)
    assert field(POINTS) == pytest.approx(looked_up(POINTS), abs=1e-6)
    both = field | iso.sphere(0.4).translate((0, 1, 0))
    expected = np.minimum(looked_up(POINTS), np.linalg.norm(POINTS - [0, 1, 0], axis=1) - 0.4)
    assert both(POINTS) == pytest.approx(expected, abs=1e-6)
    assert np.isnan(field(np.array([[math.nan, 0, 0]]))).all()


@pytest.mark.parametrize("resolution", [8, 33, 64])
def test_samples_are_within_the_stated_error(resolution):
    low, high = np.array([-1.4, -0.4, -0.5]), np.array([1.4, 0.4, 0.5])
    data = iso.field(looked_up, (low, high), lipschitz=1, resolution=resolution).form.data
    assert data.error == pytest.approx(2.8 / resolution * math.sqrt(3) / 2)
    points = np.random.default_rng(3).uniform(low, high, (4000, 3))
    held = GridData(data.values, data.low, data.step).value(*points.T)
    assert np.abs(held - looked_up(points)).max() <= data.error
    assert np.abs(held - looked_up(points)).max() > 0


def test_two_dimensions():
    def disc(p: Any) -> Any:
        return np.hypot(p[:, 0], p[:, 1]) - 0.7

    field = iso.field2(disc, ([-1, -1], [1, 1]), lipschitz=1)
    points = np.random.default_rng(4).uniform(-1, 1, (500, 2))
    assert numpy_values(field.form, points) == pytest.approx(disc(points))
    assert isinstance(field, iso.Field2)
    lathe = field.revolve(1)
    assert numpy_values(lathe.form, POINTS) == pytest.approx(numpy_values(iso.circle(0.7).revolve(1).form, POINTS))

    def opaque(p: Any) -> Any:
        return np.array([math.hypot(x, y) - 0.7 for x, y in p])

    assert iso.field2(opaque, ([-1, -1], [1, 1]), lipschitz=1)(points) == pytest.approx(disc(points), abs=1e-6)


def test_it_is_named_after_the_function():
    field = iso.field(sphere, BOX, lipschitz=1)
    assert repr(field) == "field(sphere, ((-1.5, -1.5, -1.5), (1.5, 1.5, 1.5)), lipschitz=1)"
    assert eval(repr(field), {"field": iso.field, "sphere": sphere}) == field
    assert repr(iso.field(sphere)) == "field(sphere)"


def broken(message: str) -> Any:
    def function(p: Any) -> Any:
        raise ValueError(message)

    return function


@pytest.mark.parametrize(
    ("function", "bounds", "options", "message"),
    [
        (
            lambda p: p,
            BOX,
            {},
            r"one number for each point, \(2000,\) for \(2000, 3\), but it gave float64 \(2000, 3\)",
        ),
        (lambda p: 1.0, BOX, {}, "one number for each point"),
        (lambda p: np.log(p[:, 0]), BOX, {}, r"the function is nan at the point \[-"),
        (lambda p: 1 / np.floor(np.abs(p[:, 0])), BOX, {}, r"the function is inf at the point"),
        (broken("no such part"), BOX, {}, "the function failed .* ValueError: no such part"),
        (sphere, BOX, {"lipschitz": 0.5}, r"lipschitz=0.5 does not hold: between \["),
        (looked_up, BOX, {"lipschitz": 0.9}, r"lipschitz=0.9 does not hold: between \["),
        (looked_up, BOX, {}, "that needs lipschitz="),
        (looked_up, None, {"lipschitz": 1}, "that needs finite bounds="),
        (looked_up, BOX, {"lipschitz": 1, "resolution": 4096}, "samples are more than"),
        (sphere, ([1, 1, 1], [0, 0, 0]), {}, "a lower and an upper corner"),
        (sphere, ([1, 1], [2, 2]), {}, "a lower and an upper corner"),
        (sphere, "here", {}, "bounds must be"),
        (sphere, BOX, {"lipschitz": -1}, "lipschitz must be a finite number above 0"),
        (sphere, BOX, {"resolution": 1}, "resolution must be a whole number"),
        (3, BOX, {}, "it takes a function of points"),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_functions_that_are_no_fields_are_refused(function, bounds, options, message):
    with pytest.raises(iso.GeometryError, match=message):
        iso.field(function, bounds, **options)


def test_a_function_that_fails_later_says_where():
    late = []

    def fickle(p: Any) -> Any:
        d = np.array([float(np.linalg.norm(q)) - 1 for q in p])
        return np.where(bool(late), math.nan, d)

    field = iso.field(fickle, BOX, lipschitz=1, resolution=16)
    late.append(True)
    with pytest.raises(iso.GeometryError, match="the function is nan at the point"):
        field(POINTS)
