"""Fields are values: equal, hashed, pickled, and spelled so that Python makes them again; parameters; bad input."""

from __future__ import annotations

import copy
import pickle
from functools import reduce
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from field_shapes import EXACT, OPERATIONS
from isophote.shapes.field.expression import Graph
from isophote.shapes.field.tape import numpy_values

NAMES = {name: getattr(iso, name) for name in iso.__all__}
POINTS = np.random.default_rng(23).uniform(-1.5, 1.5, (50, 3))
NAMED = OPERATIONS | {name: field for name, (field, _) in EXACT.items()}

size = st.floats(0.05, 3) | st.builds(iso.Parameter, st.text(min_size=1), st.just(0.7), st.just(0.6), st.just(0.9))
number = st.floats(-3, 3, allow_subnormal=False)
vector = st.tuples(number, number, number)
axis = st.sampled_from("xyz") | vector.filter(lambda v: max(map(abs, v)) > 0.01)

primitives = st.one_of(
    st.builds(iso.sphere, size),
    st.builds(iso.ellipsoid, st.tuples(size, size, size)),
    st.builds(iso.box, size | st.tuples(size, size, size)),
    st.builds(lambda s, r: iso.rounded_box(s, r * s / 2), st.floats(0.1, 3), st.floats(0, 1)),
    st.builds(lambda s, t: iso.frame(s, t * s), st.floats(0.1, 3), st.floats(0.01, 0.49)),
    st.builds(iso.cylinder, size, st.none() | size),
    st.builds(lambda r, h: iso.capsule(r, 2 * r + h), st.floats(0.1, 2), st.floats(0, 3)),
    st.builds(iso.cone, size, size, st.just(0.0) | size),
    st.builds(lambda a, b, h: iso.rounded_cone(a, b, 2 * max(a, b) + h), st.floats(0.1, 2), st.floats(0.1, 2), size),
    st.builds(iso.torus, size, size),
    st.builds(iso.capped_torus, size, size, st.floats(0.1, 6.2)),
    st.builds(lambda r, t, h: iso.link(r, t, 2 * (r + t) + h), st.floats(0.1, 2), st.floats(0.1, 2), size),
    st.builds(iso.prism, st.integers(3, 12), size, st.none() | size),
    st.builds(iso.pyramid, size, size),
    st.builds(iso.octahedron, size),
    st.builds(iso.plane, axis, number),
    st.builds(iso.slab, size),
)


def edges() -> Any:
    return st.one_of(st.just({}), *(st.fixed_dictionaries({style: size}) for style in ("blend", "round", "chamfer")))


def _matrix(entries: list[float]) -> list[list[float]]:
    return [*(np.eye(3, 4) * 4 + np.reshape(entries, (3, 4))).tolist(), [0, 0, 0, 1]]


def extended(fields: Any) -> Any:
    several = st.lists(fields, min_size=1, max_size=3)
    return st.one_of(
        st.builds(lambda f, g: f | g, fields, fields),
        st.builds(lambda f, g: f & g, fields, fields),
        st.builds(lambda f, g: f - g, fields, fields),
        st.builds(lambda fs, e: iso.union(*fs, **e), several, edges()),
        st.builds(lambda fs, e: iso.intersection(*fs, **e), several, edges()),
        st.builds(lambda fs, e: iso.difference(*fs, **e), several, edges()),
        st.builds(iso.Field.translate, fields, vector),
        st.builds(iso.Field.rotate, fields, axis, number),
        st.builds(iso.Field.along, fields, axis),
        st.builds(iso.Field.mirror, fields, axis),
        st.builds(iso.Field.scale, fields, size | st.tuples(size, size, size)),
        st.builds(iso.Field.affine, fields, st.lists(st.floats(-1, 1), min_size=12, max_size=12).map(_matrix)),
        st.builds(iso.Field.offset, fields, number),
        st.builds(iso.Field.shell, fields, size),
        st.builds(iso.Field.elongate, fields, st.tuples(size, st.just(0.0), size)),
        st.builds(iso.Field.twist, fields, number),
        st.builds(lambda f, k: (f & iso.box(1)).bend(k), fields, st.floats(0.1, 0.9)),
        st.builds(lambda f, k: f.taper(k, -1, 0.5), fields, size),
        st.builds(lambda f, w, a: f.displace(iso.waves(w), a), fields, size | st.tuples(size, size, size), number),
        st.builds(lambda f, s: (f & iso.box(1)).repeat((s, 0, s)), fields, st.floats(0.5, 2)),
        st.builds(lambda f, s: (f & iso.box(1)).repeat((s, s, 0), (3, None, 1)), fields, st.floats(0.5, 2)),
        st.builds(lambda f, a, n: f.repeat_around(a, n), fields, st.sampled_from("xyz"), st.integers(1, 9)),
    )


trees = st.recursive(primitives, extended, max_leaves=6)


@settings(max_examples=150, deadline=None)
@given(trees)
def test_any_field_is_spelled_so_that_it_can_be_made_again(field: iso.Field) -> None:
    again = eval(repr(field), NAMES)
    assert again == field
    assert hash(again) == hash(field)
    assert repr(again) == repr(field)
    np.testing.assert_array_equal(numpy_values(again.form, POINTS), numpy_values(field.form, POINTS))


@pytest.mark.parametrize("name", NAMED)
def test_fields_are_pickled_and_copied(name: str) -> None:
    field = NAMED[name]
    for other in (pickle.loads(pickle.dumps(field)), copy.copy(field), copy.deepcopy(field), eval(repr(field), NAMES)):
        assert other == field
        assert hash(other) == hash(field)
        assert repr(other) == repr(field)
        np.testing.assert_array_equal(other.bounds, field.bounds)
        np.testing.assert_array_equal(other(POINTS), field(POINTS))
    assert field != iso.sphere(12)


def test_spelling_is_what_one_would_write() -> None:
    part = (iso.sphere(1) & iso.box(1.5)) - iso.cylinder(0.5) - iso.cylinder(0.5).along("x")
    assert repr(part) == "((sphere(1) & box(1.5)) - cylinder(0.5) - cylinder(0.5).along('x'))"
    blob = iso.sphere(1).union(iso.box((1, 2, 3)).translate((1, 0, 0)), blend=0.3).repeat((4, 0, 0), count=3)
    assert (
        repr(blob)
        == "union(sphere(1), box((1, 2, 3)).translate((1, 0, 0)), blend=0.3).repeat((4, 0, 0), count=(3, 1, 1))"
    )
    assert repr(iso.plane()) == "plane()"


def test_fields_cannot_be_changed() -> None:
    field = iso.sphere(1)
    with pytest.raises(AttributeError):
        field.form = iso.box(1).form  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        field.bounds[0, 0] = 5


def test_a_thousand_parts_one_by_one_and_at_once() -> None:
    balls = [iso.sphere(0.1).translate((k * 0.3, 0, 0)) for k in range(1000)]
    one_by_one = balls[0]
    for ball in balls[1:]:
        one_by_one = one_by_one | ball
    assert one_by_one == iso.union(*balls)
    assert hash(one_by_one) == hash(iso.union(*balls))
    assert one_by_one([[150, 0, 0], [150.15, 0, 0]]) == pytest.approx([-0.1, 0.05], abs=1e-4)


def test_nesting_has_an_end_that_is_told() -> None:
    balls = [iso.sphere(0.5).translate((k, 0, 0)) for k in range(400)]

    def chain(count: int) -> iso.Field:
        return reduce(lambda field, ball: field.union(ball, blend=0.1), balls[:count])

    field = chain(199)
    with pytest.raises(iso.GeometryError, match=r"nested 201 deep.*iso.union\(\*parts, blend=0.1\)"):
        chain(400)
    assert eval(repr(field), NAMES) == field
    assert pickle.loads(pickle.dumps(field)) == field
    assert np.isfinite(field(POINTS)).all()
    assert field.exactness is iso.Exactness.BOUND
    assert field.lipschitz == 1


def test_nested_repetition_stays_cheap() -> None:
    field = iso.ellipsoid((0.1, 0.2, 0.1))
    for _ in range(4):
        field = field.twist(0.5).repeat((1, 0, 0), count=2).translate((0.1, 0, 0))
    assert np.isfinite(field(POINTS)).all()
    assert np.isfinite(field.lipschitz)


def test_parameters_are_numbers_with_names() -> None:
    radius = iso.Parameter("radius", 1, 0.5, 2)
    assert radius == 1
    assert iso.sphere(radius) == iso.sphere(1)
    assert repr(iso.sphere(radius)) == "sphere(Parameter('radius', 1.0, 0.5, 2.0))"
    again = pickle.loads(pickle.dumps(radius))
    assert (again.name, float(again), again.low, again.high) == ("radius", 1, 0.5, 2)


def parameters_of(field: iso.Field) -> set[str]:
    graph = Graph(symbolic=True)
    result = field.form.expression(graph.point).id
    return {graph.nodes[n].constant.name for n in graph.used(result) if graph.nodes[n].name == "PARAMETER"}


@pytest.mark.parametrize(
    ("count", "make"),
    [
        (1, lambda p: iso.sphere(p())),
        (3, lambda p: iso.ellipsoid((p(), p(), p()))),
        (3, lambda p: iso.box((p(), p(), p()))),
        (2, lambda p: iso.rounded_box(3, p()).scale(p())),
        (1, lambda p: iso.frame(3, p())),
        (1, lambda p: iso.plane("y", p())),
        (1, lambda p: iso.slab(p())),
        (2, lambda p: iso.cylinder(p(), p())),
        (2, lambda p: iso.capsule(p(), p(5))),
        (3, lambda p: iso.cone(p(), p(), p())),
        (3, lambda p: iso.rounded_cone(p(), p(), p(5))),
        (2, lambda p: iso.torus(p(), p())),
        (3, lambda p: iso.capped_torus(p(), p(), p())),
        (3, lambda p: iso.link(p(), p(), p(6))),
        (2, lambda p: iso.prism(5, p(), p())),
        (2, lambda p: iso.pyramid(p(), p())),
        (1, lambda p: iso.octahedron(p())),
        (1, lambda p: iso.union(iso.sphere(1), iso.box(1.5), blend=p())),
        (1, lambda p: iso.union(iso.sphere(1), iso.box(1.5), round=p())),
        (1, lambda p: iso.difference(iso.sphere(1), iso.box(0.5), chamfer=p())),
        (3, lambda p: iso.sphere(1).translate((p(), p(), p()))),
        (1, lambda p: iso.box((1, 2, 3)).rotate("x", p())),
        (1, lambda p: iso.box((1, 2, 3)).rotate((1, 2, 3), p())),
        (3, lambda p: iso.sphere(1).scale((p(), p(), p(9)))),
        (2, lambda p: iso.sphere(1).offset(p()).shell(p())),
        (2, lambda p: iso.box(3).round(p()).union(iso.box(2).chamfer(p()))),
        (2, lambda p: iso.sphere(1).elongate((p(), 0, p()))),
        (1, lambda p: iso.box(1).twist(p())),
        (1, lambda p: iso.box(1).bend(p())),
        (2, lambda p: iso.box(1).taper(p(), -1, p())),
        (2, lambda p: iso.sphere(1).displace(iso.waves(p()), p())),
        (2, lambda p: iso.sphere(0.2).repeat((p(), 0, p()), count=(5, 1, 9))),
    ],
)
def test_every_number_may_be_a_parameter(count: int, make: Any) -> None:
    names: list[str] = []

    def parameter(value: float = 0.75) -> iso.Parameter:
        names.append(f"p{len(names)}")
        return iso.Parameter(names[-1], value, value * 0.9, value * 1.1)

    field = make(parameter)
    assert len(names) == count
    assert parameters_of(field) >= set(names)
    plain = make(lambda value=0.75: value)
    assert field == plain
    np.testing.assert_allclose(numpy_values(field.form, POINTS), numpy_values(plain.form, POINTS), atol=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: iso.sphere(-1), "sphere: radius must be a finite number above 0, but is -1.0"),
        (lambda: iso.sphere(float("nan")), "sphere: radius"),
        (lambda: iso.sphere("big"), "but is 'big'"),
        (lambda: iso.sphere(None), "sphere: radius"),
        (lambda: iso.sphere(iso.Parameter("r", 1, -1, 2)), "sphere: radius"),
        (lambda: iso.box((1, 2)), "box: size must be 3 finite numbers above 0, or one for all"),
        (lambda: iso.box((1, 2, float("inf"))), "box: size"),
        (lambda: iso.box(0), "box: size"),
        (lambda: iso.ellipsoid((1, 0, 1)), "ellipsoid: radii"),
        (lambda: iso.rounded_box(1, 0.6), "must not be above half of the shortest side"),
        (lambda: iso.frame(1, 0.5), "a box has no openings"),
        (lambda: iso.cylinder(1, -2), "None for endless"),
        (lambda: iso.capsule(1, 1), "full length, with both round ends"),
        (lambda: iso.cone(1, 1, -0.1), "cone: top"),
        (lambda: iso.rounded_cone(1, 0.2, 2), "full length"),
        (lambda: iso.capped_torus(1, 0.1, 7), "torus is the whole"),
        (lambda: iso.link(1, 0.1, 2), "link: height"),
        (lambda: iso.prism(2, 1), "prism: sides must be a whole number from 3"),
        (lambda: iso.prism(True, 1), "prism: sides"),
        (lambda: iso.plane((0, 0, 0)), "plane: normal must be 'x', 'y', 'z' or 3 finite numbers"),
        (lambda: iso.plane("w"), "plane: normal"),
        (lambda: iso.union(), "union: it has no parts"),
        (lambda: iso.union([iso.sphere(1)]), r"write union(*parts)"),
        (lambda: iso.sphere(1).union(3), "union: it takes fields"),
        (lambda: iso.union(iso.sphere(1), iso.box(1), blend=-1), "union: blend must be a finite number, 0 or above"),
        (lambda: iso.union(iso.sphere(1), blend=1, round=1), "exclude each other"),
        (lambda: iso.union(iso.sphere(1), iso.circle(1)), "extrude or revolve"),
        (lambda: iso.sphere(1).translate((1, 2)), "translate: offset must be 3 finite numbers"),
        (lambda: iso.circle(1).translate((1, 2, 3)), "translate: offset must be 2 finite numbers"),
        (lambda: iso.sphere(1).rotate("a", 1), "rotate: axis"),
        (lambda: iso.sphere(1).rotate("x", float("inf")), "rotate: angle"),
        (lambda: iso.sphere(1).scale(0), "scale: factor must be 3 finite numbers above 0, or one for all"),
        (lambda: iso.sphere(1).scale((1, 2)), "scale: factor"),
        (lambda: iso.sphere(1).affine(np.eye(3)), "affine: matrix must be 4 by 4"),
        (lambda: iso.sphere(1).affine(np.diag([1, 1, 0, 1])), "singular"),
        (lambda: iso.sphere(1).affine(np.full((4, 4), np.nan)), "finite"),
        (lambda: iso.sphere(1).affine(np.ones((4, 4))), "last row"),
        (lambda: iso.sphere(1).shell(0), "shell: thickness"),
        (lambda: iso.box(1).round(0.6), "must not be above half of the least extent, 0.5"),
        (lambda: iso.box(1).round(-0.1), "round: size"),
        (lambda: iso.box(1).twist(1).chamfer(0.1), "the edges of twist are not known"),
        (lambda: iso.sphere(1).elongate((0, 0, 0)), "0 along every axis"),
        (lambda: iso.sphere(1).bend(0), "leave the bend out"),
        (lambda: iso.box((1, 9, 1)).bend(1), "runs into itself; its curvature must be below 0.698"),
        (lambda: iso.cylinder(1).bend(0.1), "endless along x or y"),
        (lambda: iso.cylinder(1).taper(0.5), "give start and end"),
        (lambda: iso.sphere(1).taper(0.5, 1, 1), "end must be above start"),
        (lambda: iso.sphere(1).displace(lambda p: p, 1), "it takes a field, such as iso.waves(0.3)"),
        (lambda: iso.sphere(1).displace(iso.circle(1), 1), "must be alike"),
        (lambda: iso.Parameter("a", 3, 0, 1), "low ≤ value ≤ high"),
        (lambda: iso.Parameter("a", "x", 0, 1), "must be numbers"),
        (lambda: iso.Parameter("", 1, 0, 1), "name"),
        (lambda: iso.Field(3), "iso.sphere(1) is a field"),
        (lambda: iso.sphere(1)(np.zeros((4, 2))), "points must have shape (n, 3)"),
    ],
)
def test_bad_input_is_refused_with_what_is_wrong(make: Any, words: str) -> None:
    with pytest.raises(iso.GeometryError) as error:
        make()
    assert words in str(error.value)


def test_other_things_are_no_operands() -> None:
    with pytest.raises(TypeError):
        iso.sphere(1) | 3  # type: ignore[operator]


def test_slopes_of_fields_with_parameters_hold_for_all_their_values() -> None:
    rate = iso.Parameter("rate", 0.5, 0, 4)
    for field in (iso.box(1).twist(rate), iso.box(1).twist(rate).repeat((2, 0, 0), count=3)):
        region = np.array([[-0.5] * 3, [0.5] * 3])
        graph = Graph(region, symbolic=True)
        result = field.form.expression(graph.point).id
        steepest = eval(repr(field).replace(repr(rate), "4"), NAMES)
        fixed = Graph(region)
        most = steepest.form.expression(fixed.point).id
        assert graph.lipschitz()[result] >= fixed.lipschitz()[most] - 1e-9
        assert fixed.lipschitz()[most] > 2
