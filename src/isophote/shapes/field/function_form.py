"""Fields from functions of the user's."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field.data import GridData
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.field import Field
from isophote.shapes.field.field2 import Field2
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.functions import maximum
from isophote.shapes.field.joins import largest
from isophote.shapes.field.numbers import Vector
from isophote.shapes.field.symbols import Columns
from isophote.shapes.field.tape import numpy_values

__all__ = ["FunctionData", "FunctionForm", "SampledFunction", "WrittenFunction", "field", "field2"]

Floats: TypeAlias = npt.NDArray[np.float64]
Function: TypeAlias = Callable[[Any], Any]

_MOST_SAMPLES = 1 << 26
_STEP = 1 << 18
# Points at which a function is tried, and how near its expression must come to it there.
_TRIED, _SAME = 2000, 1e-9
# How far endless bounds are looked at.
_FAR = 10.0
_RESOLUTION = 64


def called(function: Function, points: Floats) -> Floats:
    """What a user's function says at points (n, dimension); refused where that is not one finite number for each."""
    try:
        result = np.asarray(function(points.copy()))
    except Exception as error:
        raise GeometryError(
            f"field: the function failed on an array of points {points.shape}: {type(error).__name__}: {error}"
        ) from error
    if result.shape != (len(points),) or result.dtype.kind not in "biuf":
        raise GeometryError(
            f"field: the function must give one number for each point, ({len(points)},) for {points.shape}, "
            f"but it gave {result.dtype} {result.shape}"
        )
    values = result.astype(np.float64)
    finite = np.isfinite(values)
    if not finite.all():
        bad = int(np.argmin(finite))
        raise GeometryError(
            f"field: the function is {values[bad]} at the point {points[bad].tolist()}; fields are finite everywhere "
            "within their bounds"
        )
    return values


def _refuse_steeper(points: Floats, values: Floats, others: Floats, at_others: Floats, slope: float) -> None:
    """Refuse a stated constant that two points contradict."""
    apart = np.linalg.norm(points - others, axis=1)
    excess = np.abs(values - at_others) - slope * apart * (1 + 1e-6) - 1e-9 * (np.abs(values) + np.abs(at_others))
    if len(excess) and excess.max() > 0:
        worst = int(excess.argmax())
        steep = abs(values[worst] - at_others[worst]) / apart[worst]
        raise GeometryError(
            f"field: lipschitz={slope:g} does not hold: between {points[worst].tolist()} and {others[worst].tolist()} "
            f"the function has the slope {steep:g}; state more than that"
        )


@attrs.frozen(eq=False)
class FunctionData(GridData):
    """A function, and its samples on a grid. NumPy asks the function itself, at the nearest point within the grid;
    kernels take the samples."""

    high: tuple[float, ...]
    function: Function
    stated: float

    @property
    def error(self) -> float:
        """How far values between samples can be off: a point is within half the diagonal of a cell from all that it is
        mixed of, in the mean."""
        return self.stated * self.step * float(np.sqrt(self.dimension)) / 2

    @cached_property
    def slope(self) -> float:
        """A Lipschitz constant of the function as of its samples, beyond the grid too."""
        return max(float(np.hypot(self.stated, 1.0)), self._slope_of_samples())

    def _held(self, cells: npt.NDArray[np.int64], weights: Floats, along: int | None = None) -> Floats:
        if along is not None:
            return super()._held(cells, weights, along)
        points = np.array(self.low)[:, None] + (cells + weights) * self.step
        return called(self.function, np.minimum(points, np.array(self.high)[:, None]).T)


def sampled(function: Function, box: Box, slope: float, resolution: int) -> FunctionData:
    """A function's samples: `resolution` cells along the longest side of a box."""
    step = float((box[1] - box[0]).max()) / resolution
    counts = np.ceil((box[1] - box[0]) / step - 1e-9).astype(np.int64) + 1
    counts = np.maximum(counts, 2)
    if counts.prod() > _MOST_SAMPLES:
        raise GeometryError(f"field: {int(counts.prod()):,} samples are more than {_MOST_SAMPLES:,}; lower resolution=")
    values = np.empty(int(counts.prod()))
    for first in range(0, len(values), _STEP):
        numbers = np.arange(first, min(first + _STEP, len(values)))
        index = np.stack(np.unravel_index(numbers, counts[::-1])[::-1], axis=1)
        # The outermost samples may lie beyond the box by part of a cell; the function is asked on its border.
        values[first : first + _STEP] = called(function, np.minimum(box[0] + index * step, box[1]))
    grid = values.reshape(counts[::-1])
    _check_grid(grid, box[0], step, slope)
    return FunctionData(grid, tuple(box[0].tolist()), step, tuple(box[1].tolist()), function, slope)


def _check_grid(grid: Floats, low: Floats, step: float, slope: float) -> None:
    for axis in range(grid.ndim):
        rises = np.abs(np.diff(grid, axis=axis))
        worst = np.array(np.unravel_index(int(rises.argmax()), rises.shape))
        after = worst + (np.arange(grid.ndim) == axis)
        points = low + worst[::-1] * step, low + after[::-1] * step
        values = grid[tuple(worst)], grid[tuple(after)]
        _refuse_steeper(points[0][None], values[0][None], points[1][None], values[1][None], slope)


@attrs.frozen(repr=False, slots=False)
class FunctionForm(Form):
    """What a function of points (n, dimension) says, between the corners `low` and `high`.

    `slope` is its Lipschitz constant, if one was stated. `is_cut`: the function is not positive somewhere on the
    border of its bounds, so that the bounds cut the shape.
    """

    function: Function
    low: Vector
    high: Vector
    slope: float | None
    is_cut: bool
    resolution: int
    exactness = Exactness.BOUND
    is_tight = False
    title = "field"

    @property
    def dimension(self) -> int:  # type: ignore[override]
        return len(self.low)

    @property
    def bounds(self) -> Box:
        return np.array([self.low, self.high])

    def expression(self, p: Point) -> Value:
        value = self.within(p)
        if self.slope is not None:
            value = p.bounded(value, self.slope)
        return maximum(value, self._outside_box(p)) if self.is_cut else value

    def within(self, p: Point) -> Value:
        """The function at p."""
        raise NotImplementedError

    def _outside_box(self, p: Point) -> Value:
        """The distance to the bounds."""
        sides: list[Value] = []
        for c, low, high in zip(p[:3], self.low, self.high, strict=False):
            sides += [low - c] if np.isfinite(low) else []
            sides += [c - high] if np.isfinite(high) else []
        return largest(sides)

    def spelled(self) -> str:
        name = getattr(self.function, "__qualname__", repr(self.function))
        parts = [name]
        if np.isfinite(self.bounds).any():
            corners = f"({number_spelled(self.low)}, {number_spelled(self.high)})"
            parts.append(corners.replace("inf", "float('inf')"))
        if self.slope is not None:
            parts.append(f"lipschitz={number_spelled(self.slope)}")
        if self.resolution != _RESOLUTION:
            parts.append(f"resolution={self.resolution}")
        return f"{'field' if self.dimension == 3 else 'field2'}({', '.join(parts)})"


@attrs.frozen(repr=False, slots=False)
class WrittenFunction(FunctionForm):
    """A function that can be written as an expression: it is asked for it whenever one is needed."""

    def within(self, p: Point) -> Value:
        result = self.function(Columns(p[: self.dimension], False))
        if not isinstance(result, Columns) or not result.is_flat:
            raise TypeError("the function does not give one number for each point")
        part = result.parts[0]
        return part if isinstance(part, Value) else p.number(part)


@attrs.frozen(repr=False, slots=False)
class SampledFunction(FunctionForm):
    """A function that is sampled: `resolution` cells along the longest side of its bounds."""

    is_opaque = True

    def __attrs_post_init__(self) -> None:
        _ = self.data

    @cached_property
    def data(self) -> FunctionData:
        """The function and its samples."""
        return sampled(self.function, self.bounds, float(self.slope or 0), self.resolution)

    def within(self, p: Point) -> Value:
        name = "GRID2" if self.dimension == 2 else "GRID3"
        value = p.graph.apply(name, *p[: self.dimension], constant=self.data)
        return p.bounded(value, self.data.slope)

    def expression(self, p: Point) -> Value:
        # Samples may be steeper than the function.
        value = self.within(p)
        return maximum(value, self._outside_box(p)) if self.is_cut else value


def function_form(
    function: Function, bounds: npt.ArrayLike | None, lipschitz: float | None, resolution: int, dimension: int
) -> FunctionForm:
    """The form of a user's function, written or sampled."""
    if not callable(function):
        raise GeometryError(f"field: it takes a function of points (n, {dimension}), but not {function!r}")
    box = _checked_bounds(bounds, dimension)
    slope = None if lipschitz is None else _checked_slope(lipschitz)
    if isinstance(resolution, bool) or not isinstance(resolution, int | np.integer) or not 2 <= resolution <= 4096:
        raise GeometryError(f"field: resolution must be a whole number from 2 to 4096, but is {resolution!r}")
    points, values = _tried(function, box, slope)
    given = (function, tuple(box[0].tolist()), tuple(box[1].tolist()), slope, _is_cut(function, box, points))
    form = WrittenFunction(*given, int(resolution))
    if _is_same(attrs.evolve(form, is_cut=False), points, values):
        return form
    if slope is None:
        raise GeometryError(
            "field: the function uses more than NumPy's arithmetic on columns, so it is sampled; that needs "
            "lipschitz=, a number that no slope of it exceeds: 1 for a distance"
        )
    if not np.isfinite(box).all():
        raise GeometryError("field: the function is sampled, and that needs finite bounds=")
    return SampledFunction(*given, int(resolution))


def _checked_bounds(bounds: npt.ArrayLike | None, dimension: int) -> Box:
    if bounds is None:
        return np.array([[-np.inf] * dimension, [np.inf] * dimension])
    try:
        box = np.array(bounds, np.float64)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"field: bounds must be (2, {dimension}) numbers: {error}") from error
    if box.shape != (2, dimension) or not (box[0] < box[1]).all():
        raise GeometryError(f"field: bounds must be a lower and an upper corner, (2, {dimension}), not {bounds!r}")
    return box


def _checked_slope(lipschitz: Any) -> float:
    try:
        slope = float(lipschitz)
    except (TypeError, ValueError):
        slope = np.nan
    if not (np.isfinite(slope) and slope > 0):
        raise GeometryError(f"field: lipschitz must be a finite number above 0, or None, but is {lipschitz!r}")
    return slope


def _tried(function: Function, box: Box, slope: float | None) -> tuple[Floats, Floats]:
    """Random points within the bounds and the function there; refused where it breaks what is stated."""
    low, high = np.maximum(box[0], -_FAR), np.minimum(box[1], _FAR)
    low, high = np.where(low < high, low, box[0]), np.where(low < high, high, box[1])
    low, high = np.where(np.isfinite(low), low, high - _FAR), np.where(np.isfinite(high), high, low + _FAR)
    random = np.random.default_rng(0)
    points = random.uniform(low, high, (_TRIED, len(low)))
    values = called(function, points)
    if slope is not None:
        near = np.clip(points + random.normal(size=points.shape) * 1e-4 * (high - low), low, high)
        _refuse_steeper(points, values, near, called(function, near), slope)
    return points, values


def _is_cut(function: Function, box: Box, points: Floats) -> bool:
    """Whether the function is not positive on the border of its bounds, as far as it is seen there."""
    for end in (0, 1):
        for axis in np.flatnonzero(np.isfinite(box[end])):
            border = points.copy()
            border[:, axis] = box[end, axis]
            if (called(function, border) <= 0).any():
                return True
    return False


def _is_same(form: WrittenFunction, points: Floats, values: Floats) -> bool:
    """Whether the function has an expression, with the same values as itself."""
    try:
        written = numpy_values(form, points)
    except Exception:  # noqa: BLE001
        # Whatever a function does with what only looks like an array: it is then taken as it is.
        return False
    return bool((np.abs(written - values) <= _SAME * (1 + np.abs(values))).all())


def field(
    function: Function,
    bounds: npt.ArrayLike | None = None,
    *,
    lipschitz: float | None = None,
    resolution: int = _RESOLUTION,
) -> Field:
    """The field of a NumPy function: it takes points (n, 3) float64 and gives (n,) numbers, negative inside.

    `bounds` (2, 3) are the least and greatest corner of a box around the shape; a shape that reaches beyond is cut
    there. `lipschitz` states a number that no slope of the function exceeds (1 for a distance), wherever it is asked.

    What is made of NumPy's arithmetic, functions of elements, `norm`, `where` and reductions of columns becomes an
    expression, as if it had been built of Isophote's own shapes; then `bounds` may be left out for an endless shape,
    and `lipschitz` where the constant that follows from the expression will do. Any other function is asked by NumPy
    itself where the field is called; for rendering and meshing it is sampled, with `resolution` cells along the longest
    side, and off by half a cell's diagonal times `lipschitz` at most. Both are then needed.

    Raises `GeometryError` where the function fails, gives other shapes, infinities or NaN, saying where, and where two
    points show that `lipschitz` does not hold.
    """
    return Field(function_form(function, bounds, lipschitz, resolution, 3))


def field2(
    function: Function,
    bounds: npt.ArrayLike | None = None,
    *,
    lipschitz: float | None = None,
    resolution: int = _RESOLUTION,
) -> Field2:
    """The field in the plane of a NumPy function of points (n, 2); all else as for `field`, with `bounds` (2, 2)."""
    return Field2(function_form(function, bounds, lipschitz, resolution, 2))
