"""Forms that stand elsewhere: the inverse of the transform goes on the point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Number, Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.functions import cos, sin
from isophote.shapes.field.numbers import (
    Axis,
    Vector,
    any_number,
    any_vector,
    axis_of,
    lowest,
    scale_factor,
    unit_axis,
)

__all__ = ["Affine", "Along", "Mirror", "Placed", "Rotate", "Scale", "Translate", "Turn", "turned_box"]

Matrix: TypeAlias = npt.NDArray[np.float64]

# Matrices that flatten space by so much, or shrink it so far, have no inverse in floating point.
_FLAT = 1e-14
_TINY = 1e-300
# Singular values that differ by less are one scale.
_ALIKE = 1e-12


@attrs.frozen(repr=False)
class Placed(Form):
    """One form in another place."""

    form: Form

    def inside(self, p: Point) -> Point:
        """The point brought into the form's space."""
        raise NotImplementedError

    def unit(self, p: Point) -> Number:
        """What lengths in the form's space count here, at least."""
        return 1.0

    def affine_map(self) -> Matrix | None:
        """(4, 4): the map from the form's space to this one, where it is affine."""
        return None

    @property
    def dimension(self) -> int:  # type: ignore[override]
        return self.form.dimension

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        return self.form.exactness

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return self.form.is_tight

    @property
    def is_square(self) -> bool:  # type: ignore[override]
        return self.form.is_square

    @property
    def is_edgeless(self) -> bool:  # type: ignore[override]
        return self.form.is_edgeless

    @property
    def is_smooth(self) -> bool:  # type: ignore[override]
        return self.form.is_smooth

    def expression(self, p: Point) -> Value:
        return self.form.expression(self.inside(p)) * self.unit(p)

    def faces(self, p: Point) -> list[Value]:
        return [face * self.unit(p) for face in self.form.faces(self.inside(p))]

    def finished(self, p: Point, style: str, size: Value) -> Value:
        return self.form.finished(self.inside(p), style, size / self.unit(p)) * self.unit(p)

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)


def _in_space(linear: npt.ArrayLike, offset: npt.ArrayLike = 0.0) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, offset
    return matrix


def _applied(rows: Sequence[Sequence[Number]], parts: Sequence[Value]) -> list[Value]:
    """A matrix on a vector; rows may hold numbers and values."""
    return [sum((c * entry for c, entry in zip(parts[1:], row[1:], strict=True)), parts[0] * row[0]) for row in rows]


def _moved(p: Point, parts: Sequence[Value], stretch: float = 1.0) -> Point:
    return p.moved(parts[0], parts[1], parts[2] if len(parts) == 3 else p.z, stretch)


def turned_box(matrix: Matrix, box: Box) -> Box:
    """The least box about a box that a matrix is applied to; endless only along axes that endless sides lean to."""
    with np.errstate(invalid="ignore"):
        reach = np.where(np.abs(matrix)[..., None] > 1e-12, matrix[..., None] * box.T[None], 0.0)
    finite = np.isfinite(box).all(axis=0)
    reach[:, finite] = matrix[:, finite, None] * box.T[None, finite]
    return np.stack([reach.min(axis=2).sum(axis=1), reach.max(axis=2).sum(axis=1)])


@attrs.frozen(repr=False)
class Translate(Placed):
    """A form moved by `offset`: f(p − offset)."""

    offset: Vector = any_vector()

    def inside(self, p: Point) -> Point:
        return _moved(p, [c - p.number(o) for c, o in zip(p.coordinates, self.offset, strict=False)])

    def affine_map(self) -> Matrix | None:
        return _in_space(np.eye(3), self.offset) if self.dimension == 3 else None

    def bounds_at(self, level: float) -> Box:
        box: Box = self.form.bounds_at(level) + np.array(self.offset)
        return box

    def spelled(self) -> str:
        return f"{self.form.spelled()}.translate({number_spelled(self.offset)})"


@attrs.frozen(repr=False)
class Rotate(Placed):
    """A form turned about an axis through the origin, by Rodrigues' formula; anticlockwise for who looks down it."""

    axis: Axis = axis_of()
    angle: float = any_number()

    title = "rotate"

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return False

    def _rows(self, c: Any, s: Any) -> list[list[Any]]:
        """The rotation with the given cosine and sine, of numbers or of values."""
        x, y, z = unit_axis(self.axis)
        cross = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
        outer = [[a * b for b in (x, y, z)] for a in (x, y, z)]
        return [[c * (float(i == j) - outer[i][j]) + s * cross[i][j] + outer[i][j] for j in range(3)] for i in range(3)]

    def inside(self, p: Point) -> Point:
        angle = p.number(self.angle)
        return _moved(p, _applied(self._rows(cos(angle), -sin(angle)), p.coordinates))

    def affine_map(self) -> Matrix | None:
        return _in_space(self._rows(math.cos(self.angle), math.sin(self.angle)))

    def bounds_at(self, level: float) -> Box:
        return turned_box(np.array(self._rows(math.cos(self.angle), math.sin(self.angle))), self.form.bounds_at(level))

    def spelled(self) -> str:
        axis = repr(self.axis) if isinstance(self.axis, str) else number_spelled(self.axis)
        return f"{self.form.spelled()}.rotate({axis}, {number_spelled(self.angle)})"


@attrs.frozen(repr=False)
class Turn(Placed):
    """A form of the plane turned about the origin, anticlockwise."""

    angle: float = any_number()

    title = "rotate"

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return False

    def inside(self, p: Point) -> Point:
        c, s = cos(p.number(self.angle)), sin(p.number(self.angle))
        return _moved(p, _applied([[c, s], [-s, c]], p[:2]))

    def bounds_at(self, level: float) -> Box:
        c, s = math.cos(self.angle), math.sin(self.angle)
        return turned_box(np.array([[c, -s], [s, c]]), self.form.bounds_at(level))

    def spelled(self) -> str:
        return f"{self.form.spelled()}.rotate({number_spelled(self.angle)})"


@attrs.frozen(repr=False)
class Along(Placed):
    """A form that stands along +y, laid along another axis, by the least turn; letters only swap coordinates."""

    axis: Axis = axis_of()

    title = "along"

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return isinstance(self.axis, str) and self.form.is_tight

    def _matrix(self) -> Matrix:
        """Letters go round, x → z → y → x, so that the form's y becomes the axis."""
        if isinstance(self.axis, str):
            return np.roll(np.eye(3), "yzx".index(self.axis), axis=0)
        x, y, z = unit_axis(self.axis)
        if y < -1 + _ALIKE:
            return np.diag([1.0, -1.0, -1.0])
        # The turn from +y to the axis n: 1 + [v] + [v]² / (1 + n_y), with v = y × n.
        cross = np.array([[0, x, 0], [-x, 0, -z], [0, z, 0]])
        return np.asarray(np.eye(3) + cross + cross @ cross / (1 + y))

    def inside(self, p: Point) -> Point:
        return _moved(p, _applied(self._matrix().T.tolist(), p.coordinates))

    def affine_map(self) -> Matrix | None:
        return _in_space(self._matrix())

    def bounds_at(self, level: float) -> Box:
        return turned_box(self._matrix(), self.form.bounds_at(level))

    def spelled(self) -> str:
        axis = repr(self.axis) if isinstance(self.axis, str) else number_spelled(self.axis)
        return f"{self.form.spelled()}.along({axis})"


@attrs.frozen(repr=False)
class Mirror(Placed):
    """A form mirrored in the plane (in 2D: the line) through the origin that an axis is normal to."""

    axis: Axis = axis_of()

    title = "mirror"

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return isinstance(self.axis, str) and self.form.is_tight

    def _matrix(self) -> Matrix:
        """Householder's reflection, its own inverse."""
        normal = np.array(unit_axis(self.axis, self.dimension))
        return np.asarray(np.eye(self.dimension) - 2 * np.outer(normal, normal))

    def inside(self, p: Point) -> Point:
        return _moved(p, _applied(self._matrix().tolist(), p.coordinates[: self.dimension]))

    def affine_map(self) -> Matrix | None:
        return _in_space(self._matrix()) if self.dimension == 3 else None

    def bounds_at(self, level: float) -> Box:
        return turned_box(self._matrix(), self.form.bounds_at(level))

    def spelled(self) -> str:
        axis = repr(self.axis) if isinstance(self.axis, str) else number_spelled(self.axis)
        return f"{self.form.spelled()}.mirror({axis})"


@attrs.frozen(repr=False)
class Scale(Placed):
    """A form scaled about the origin: f(p / s) · min s.

    With one factor the distance stays a distance. With several it is a bound: p / s moves at most 1 / min s times as
    fast as p, so the value has no larger Lipschitz constant than f.
    """

    factor: float | Vector = scale_factor()

    title = "scale"

    def _factors(self) -> Vector:
        return self.factor if isinstance(self.factor, tuple) else (self.factor,) * self.dimension

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        alike = len(set(self._factors())) == 1
        return self.form.exactness if alike else min(self.form.exactness, Exactness.BOUND)

    @property
    def is_square(self) -> bool:  # type: ignore[override]
        return self.form.is_square and len(set(self._factors())) == 1

    def inside(self, p: Point) -> Point:
        parts = [c / p.number(f) for c, f in zip(p.coordinates, self._factors(), strict=False)]
        return _moved(p, parts, 1 / min(map(lowest, self._factors())))

    def unit(self, p: Point) -> Number:
        return p.number(min(self._factors(), key=lowest))

    def affine_map(self) -> Matrix | None:
        return _in_space(np.diag(self._factors())) if self.dimension == 3 else None

    def bounds_at(self, level: float) -> Box:
        factors = np.array(self._factors())
        box: Box = self.form.bounds_at(level / float(factors.min())) * factors
        return box

    def spelled(self) -> str:
        return f"{self.form.spelled()}.scale({number_spelled(self.factor)})"


def _matrix(value: Any) -> Any:
    try:
        return tuple(tuple(row) for row in np.array(value, np.float64).tolist())
    except (TypeError, ValueError):
        return value


@attrs.frozen(repr=False)
class Affine(Placed):
    """A form under an affine map p ↦ M p: f(M⁻¹ p) · σ, with σ the least singular value of M's linear part.

    M⁻¹ moves points at most 1 / σ times as fast, so the value has no larger Lipschitz constant than f. It is the
    distance where f is and M scales all directions alike.
    """

    matrix: tuple[Vector, ...] = attrs.field(converter=_matrix)

    title = "affine"

    def __attrs_post_init__(self) -> None:
        size = self.dimension + 1
        matrix = np.array(self.matrix) if isinstance(self.matrix, tuple) else np.empty(0)
        if matrix.shape != (size, size) or not np.isfinite(matrix).all():
            raise GeometryError(f"affine: matrix must be {size} by {size} finite numbers, but is {self.matrix!r}")
        if matrix[-1].tolist() != [0.0] * self.dimension + [1.0]:
            raise GeometryError(f"affine: the last row of matrix must be 0, …, 0, 1, but is {self.matrix[-1]!r}")
        values = np.linalg.svd(matrix[:-1, :-1], compute_uv=False)
        if values[-1] <= max(_FLAT * values[0], _TINY):
            raise GeometryError(
                f"affine: matrix must not flatten space, but is singular: {self.matrix!r}; use a small scale, not 0"
            )

    def _singular_values(self) -> npt.NDArray[np.float64]:
        values: npt.NDArray[np.float64] = np.linalg.svd(np.array(self.matrix)[:-1, :-1], compute_uv=False)
        return values

    def _is_similar(self) -> bool:
        values = self._singular_values()
        return bool(values[-1] >= values[0] * (1 - _ALIKE))

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        return self.form.exactness if self._is_similar() else min(self.form.exactness, Exactness.BOUND)

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return False

    @property
    def is_square(self) -> bool:  # type: ignore[override]
        return self.form.is_square and self._is_similar()

    def inside(self, p: Point) -> Point:
        inverse = np.linalg.inv(np.array(self.matrix))
        parts = _applied(inverse[:-1, :-1].tolist(), p.coordinates[: self.dimension])
        offset = inverse[:-1, -1].tolist()
        return _moved(p, [c + o for c, o in zip(parts, offset, strict=True)], 1 / self._singular_values()[-1])

    def unit(self, p: Point) -> Number:
        return float(self._singular_values()[-1])

    def affine_map(self) -> Matrix | None:
        return np.array(self.matrix) if self.dimension == 3 else None

    def bounds_at(self, level: float) -> Box:
        matrix = np.array(self.matrix)
        inner = self.form.bounds_at(level / float(self._singular_values()[-1]))
        box: Box = turned_box(matrix[:-1, :-1], inner) + matrix[:-1, -1]
        return box

    def spelled(self) -> str:
        return f"{self.form.spelled()}.affine({number_spelled(self.matrix)})"
