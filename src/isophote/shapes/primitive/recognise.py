"""Fields that are one solid of a simple kind, moved and scaled: exact primitives instead."""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from isophote.shapes.field.combine import Difference, Intersection, Union
from isophote.shapes.field.form import Form
from isophote.shapes.field.numbers import unit_axis
from isophote.shapes.field.place import Placed
from isophote.shapes.field.rounds import Cone, Cylinder, Torus
from isophote.shapes.field.solids import BoxForm, Ellipsoid, Plane, Slab, Sphere
from isophote.shapes.primitive.primitive import Matrix, Primitive, upright

__all__ = ["primitive_of_form"]


def _primitive(kind: str, matrix: Matrix, *values: float) -> Primitive:
    return Primitive(kind, matrix, np.array(values, np.float64))


@singledispatch
def primitive_of_form(form: Form) -> Primitive | None:
    """The exact primitive with the same inside as a form, or None where there is none: booleans, blends and
    deformations stay fields."""
    return None


@primitive_of_form.register
def _(form: Placed) -> Primitive | None:
    matrix = form.affine_map()
    inner = None if matrix is None else primitive_of_form(form.form)
    return None if inner is None or matrix is None else inner.placed(matrix)


@primitive_of_form.register(Union)
@primitive_of_form.register(Intersection)
@primitive_of_form.register(Difference)
def _(form: Union | Intersection | Difference) -> Primitive | None:
    return primitive_of_form(form.parts[0]) if len(form.parts) == 1 else None


@primitive_of_form.register
def _(form: Sphere) -> Primitive:
    radius = float(form.radius)
    return _primitive("ball", np.diag([radius, radius, radius, 1.0]))


@primitive_of_form.register
def _(form: Ellipsoid) -> Primitive:
    return _primitive("ball", np.diag([*map(float, form.radii), 1.0]))


@primitive_of_form.register
def _(form: BoxForm) -> Primitive:
    return _primitive("block", np.diag([*(float(size) / 2 for size in form.size), 1.0]), 1.0, 1.0, 1.0)


@primitive_of_form.register
def _(form: Slab) -> Primitive:
    return _primitive("block", upright(1.0, float(form.thickness) / 2), np.inf, 1.0, np.inf)


@primitive_of_form.register
def _(form: Plane) -> Primitive:
    normal = np.array(unit_axis(form.normal))
    matrix = np.eye(4)
    matrix[:3, :3] = frame_on(normal)
    matrix[:3, 3] = normal * float(form.height)
    return _primitive("plane", matrix)


@primitive_of_form.register
def _(form: Cylinder) -> Primitive:
    radius = float(form.radius)
    if form.height is None:
        return _primitive("pipe", upright(radius, radius))
    return _primitive("tube", upright(radius, float(form.height) / 2))


@primitive_of_form.register
def _(form: Cone) -> Primitive:
    bottom, top = float(form.radius), float(form.top)
    widest = max(bottom, top)
    middle, lean = (bottom + top) / (2 * widest), (top - bottom) / (2 * widest)
    return _primitive("cone", upright(widest, float(form.height) / 2), middle, lean)


@primitive_of_form.register
def _(form: Torus) -> Primitive:
    radius = float(form.radius)
    return _primitive("ring", upright(radius, radius), float(form.tube) / radius)


def frame_on(normal: Matrix) -> Matrix:
    """(3, 3): the least turn from +y to a unit vector."""
    x, y, z = normal
    if y < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    # 1 + [v] + [v]² / (1 + n_y), with v = y × n.
    cross = np.array([[0, x, 0], [-x, 0, -z], [0, z, 0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1 + y))
