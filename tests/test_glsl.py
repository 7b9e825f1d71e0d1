"""Fields as GLSL: the same values as NumPy, for every operator and for whole shapes."""

from __future__ import annotations

import re

import attrs
import numpy as np
import pytest

import isophote as iso
from isophote.shapes.field.data import GridData, OutlineData
from isophote.shapes.field.expression import Parameter, Point, Value
from isophote.shapes.field.field import Field
from isophote.shapes.field.form import Form
from isophote.shapes.field.operators import OPERATORS
from isophote.shapes.field.rounds import cylinder
from isophote.shapes.field.solids import box, sphere
from isophote.shapes.field.tape import numpy_values
from isophote.shapes.field.vary import with_values
from shaders import values

RANDOM = np.random.default_rng(5)
POINTS = RANDOM.uniform(-2, 2, (4000, 3)).astype(np.float32)
# Operators whose constant is a table of data.
TABLES = {"OUTLINE", "GRID2", "GRID3", "MESH"}


@attrs.frozen
class OneOperator(Form):
    """The value of one operator of the point's coordinates."""

    name: str

    def expression(self, p: Point) -> Value:
        arguments = (p.x, p.y, p.z)[: OPERATORS[self.name].arity]
        if not arguments:
            return p.graph.number(0.375)
        if self.name in ("LOGARITHM", "SQUARE_ROOT"):
            arguments = (p.x * p.x + 0.25,)
        if self.name in ("DIVIDE",):
            arguments = (p.x, p.y * p.y + 0.5)
        if self.name == "CONSTANT_OVER":
            arguments = (p.x * p.x + 0.5,)
        return p.graph.apply(self.name, *arguments, constant=0.75)

    @property
    def bounds(self) -> np.ndarray:
        return np.array([[-2.0] * 3, [2.0] * 3])


@attrs.frozen
class Sampled(Form):
    """A table of data over x and y, less a half."""

    data: GridData | OutlineData

    def expression(self, p: Point) -> Value:
        name = "GRID2" if isinstance(self.data, GridData) else "OUTLINE"
        return p.graph.apply(name, p.x, p.y, constant=self.data) - 0.5

    @property
    def bounds(self) -> np.ndarray:
        return np.array([[-2.0] * 3, [2.0] * 3])


@pytest.mark.parametrize("name", sorted(OPERATORS.keys() - TABLES))
def test_every_operator_has_the_value_of_numpy(name: str) -> None:
    form = OneOperator(name)
    glsl = iso.to_glsl(Field(form))
    expected = numpy_values(form, POINTS)
    found = values(str(glsl), "field", POINTS)
    # GLSL's inverse sine and cosine are only good to 2^-11 or so where the slope is steep.
    tolerance = 2e-3 if name.startswith("ARC") else 2e-6
    if name in ("FLOOR", "ROUND"):
        assert (found == expected).mean() > 0.999
    else:
        np.testing.assert_allclose(found, expected, atol=tolerance, rtol=tolerance)


def _part() -> Field:
    hole = cylinder(0.5)
    return (sphere(1) & box(1.5)) - hole - cylinder(0.3).translate((0.2, 0, 0.4))


def test_a_part_has_the_values_of_numpy() -> None:
    part = _part().union(sphere(0.4).translate((0, 0.9, 0)), blend=0.3)
    found = values(str(iso.to_glsl(part, "part")), "part", POINTS)
    np.testing.assert_allclose(found, numpy_values(part.form, POINTS), atol=2e-6)


def test_parameters_are_uniforms() -> None:
    ball = sphere(Parameter("outer radius", 1.0, 0.5, 2.0))
    glsl = iso.to_glsl(ball)
    assert glsl.uniforms == ("u_outer_radius",)
    for radius in (0.5, 1.0, 1.75):
        found = values(glsl.source, "field", POINTS, u_outer_radius=radius)
        np.testing.assert_allclose(found, np.linalg.norm(POINTS, axis=1) - radius, atol=1e-6)


def test_the_slope_that_is_told_bounds_the_values() -> None:
    glsl = iso.to_glsl(_part())
    a, b = POINTS[:2000], POINTS[2000:]
    difference = values(glsl.source, "field", a) - values(glsl.source, "field", b)
    assert (np.abs(difference) <= glsl.lipschitz * np.linalg.norm(a - b, axis=1) + 1e-5).all()


def test_what_is_used_twice_is_worked_out_once() -> None:
    source = iso.to_glsl(box(1)).source
    assert len(re.findall(r"abs\(p\.x\)", source)) == 1


@pytest.mark.parametrize("name", ["", "2d", "a b", "gl_field", "field;"])
def test_names_that_glsl_does_not_take(name: str) -> None:
    with pytest.raises(iso.GeometryError, match="GLSL"):
        iso.to_glsl(sphere(1), name)


def test_tables_of_data_become_textures() -> None:
    samples = np.add.outer(np.arange(3.0), np.arange(4.0)).astype(np.float32)
    grid = GridData(samples, (-1.0, -1.0), 0.5)
    glsl = iso.to_glsl(Field(Sampled(grid)))
    assert [g.name for g in glsl.grids] == ["grid0"]
    found = values(glsl.source, "field", POINTS, grids=glsl.grids)
    np.testing.assert_allclose(found, grid.value(POINTS[:, 0], POINTS[:, 1]) - 0.5, atol=1e-5)


def test_outlines_are_sampled() -> None:
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32)
    ends = np.roll(corners, -1, axis=0)
    square = OutlineData(np.hstack([corners, (corners + ends) / 2, ends]), np.ones(4, np.int8))
    glsl = iso.to_glsl(Field(Sampled(square)))
    points = POINTS * 0.5
    found = values(glsl.source, "field", points, grids=glsl.grids)
    exact = square.value(points[:, 0], points[:, 1]) - 0.5
    near = np.abs(exact + 0.5) < 0.04
    np.testing.assert_allclose(found[near], exact[near], atol=2e-3)


def test_parameters_take_other_values() -> None:
    ball = sphere(Parameter("r", 1.0, 0.5, 2.0)).translate((Parameter("x", 0.0, -1.0, 1.0), 0, 0)) | box(1)
    assert Field(with_values(ball.form, {"r": 2.0, "other": 9.0})).bounds[1, 0] == pytest.approx(2.0, abs=0.05)
    moved = with_values(ball.form, {"x": 1.0})
    np.testing.assert_allclose(Field(moved)([(1.0, 0, 0)]), -1.0)
    assert with_values(ball.form, {}) == ball.form
