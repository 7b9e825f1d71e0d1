"""Fields in the plane as pictures: inside and outside in two colours, and lines of equal value."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError, SceneError
from isophote.progress import Reporter
from isophote.rendering.image import Image
from isophote.rendering.method import Size
from isophote.scene.colour import WHITE, Colour, colour
from isophote.shapes.field.field2 import Field2

__all__ = ["FieldPlot"]

Values: TypeAlias = npt.NDArray[np.floating[Any]]

# What is left free on each side, in parts of the geometric mean of a field's width and height.
_MARGIN = 0.3
# About so many isolines lie between the least and the largest value.
_LINES = 16
# Widths of the outline and of the isolines in pixels of a picture 640 wide, and how dark the latter are.
_OUTLINE, _ISOLINE, _INK = 2.2, 1.2, 0.45
# Colours fade with the distance to the outline, down to this part of them.
_FADED = 0.55
_ORANGE, _BLUE = colour("#e8973a"), colour("#7fb0d6")
_PIXELS_A_STEP = 1 << 20


def _colour(value: Any) -> Colour:
    try:
        return colour(value)
    except SceneError as error:
        raise RenderError(f"FieldPlot: {error}") from error


def _bounds(value: Any) -> tuple[tuple[float, ...], ...] | None:
    if value is None:
        return None
    try:
        box = np.asarray(value, np.float64)
    except (TypeError, ValueError) as error:
        raise RenderError(f"FieldPlot: bounds must be (2, 2) numbers: {error}") from error
    if box.shape != (2, 2) or not np.isfinite(box).all() or not (box[0] < box[1]).all():
        raise RenderError(f"FieldPlot: bounds must be a lower and an upper corner, (2, 2), but are {value!r}")
    return tuple(tuple(corner) for corner in box.tolist())


def _spacing(instance: Any, attribute: Any, value: Any) -> None:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if value is not None and not (number and math.isfinite(value) and value >= 0):
        raise RenderError(f"FieldPlot: spacing must be a finite number, 0 for no isolines, or None, but is {value!r}")


@attrs.frozen
class FieldPlot:
    """How a field in the plane is drawn: `render(field, FieldPlot(...))`.

    `bounds` (2, 2) is what is seen at least, the shape with some room if None. `spacing` is the step of the field's
    value from one isoline to the next, 0 for none; None takes 1, 2 or 5 times a power of ten, for about sixteen of
    them. `inside`, `outside` and `outline` are colours.
    """

    bounds: tuple[tuple[float, ...], ...] | None = attrs.field(default=None, converter=_bounds)
    spacing: float | None = attrs.field(default=None, validator=_spacing)
    inside: Colour = attrs.field(default=_ORANGE, converter=_colour)
    outside: Colour = attrs.field(default=_BLUE, converter=_colour)
    outline: Colour = attrs.field(default=WHITE, converter=_colour)

    def plot(self, field: Field2, size: Size, report: Reporter) -> Image:
        """The picture, with the channel "value": the field at the middle of each pixel, (h, w) float32."""
        low, pixel = self._window(field, size)
        values = _sampled(field, low, pixel, size, report)
        spacing = _nice((float(values.max()) - float(values.min())) / _LINES) if self.spacing is None else self.spacing
        metadata = {
            "method": "FieldPlot",
            "units per pixel": f"{pixel:.9g}",
            "lower left corner": f"{low[0]:.9g}, {low[1]:.9g}",
            "isolines": f"every {spacing:g}" if spacing else "none",
        }
        picture = self._painted(values, float(spacing), size[0] / 640)
        return Image({"colour": picture, "value": values}, metadata)

    def _window(self, field: Field2, size: Size) -> tuple[npt.NDArray[np.float64], float]:
        """The lower left corner of the picture, and the side of a pixel."""
        box = np.asarray(field.bounds if self.bounds is None else self.bounds, np.float64)
        extent = box[1] - box[0]
        if not np.isfinite(box).all() or not extent.max() > 0:
            raise RenderError(
                f"the field has no finite bounds to be framed, {box.tolist()}; give FieldPlot(bounds=...)"
            )
        if self.bounds is None:
            extent = extent + 2 * _MARGIN * float(np.sqrt(extent.prod()) or extent.max())
        pixel = float((extent / size).max())
        return box.mean(axis=0) - np.array(size) * pixel / 2, pixel

    def _painted(self, values: Values, spacing: float, scale: float) -> npt.NDArray[np.float32]:
        slope = _steps(values)
        away = np.abs(values)
        inside = np.clip(0.5 - values / slope, 0.0, 1.0)[..., None]
        fade = _FADED + (1 - _FADED) * np.exp(-4 * away / max(float(away.max()), 1e-30))[..., None]
        picture = (inside * np.array(self.inside) + (1 - inside) * np.array(self.outside)) * fade
        width = max(scale, 0.6)
        if spacing > 0:
            turns = values / spacing
            line = _line(np.abs(turns - np.rint(turns)) * spacing / slope, _ISOLINE * width)
            # Where lines are closer than two pixels they run together.
            line = _INK * line * np.clip(spacing / slope - 1, 0, 1)[..., None]
            picture = picture * (1 - line)
        edge = _line(away / slope, _OUTLINE * width)
        result: npt.NDArray[np.float32] = (picture * (1 - edge) + np.array(self.outline) * edge).astype(np.float32)
        return result


def _sampled(field: Field2, low: Any, pixel: float, size: Size, report: Reporter) -> Values:
    width, height = size
    values = np.empty((height, width), np.float32)
    x = low[0] + (np.arange(width) + 0.5) * pixel
    rows = max(_PIXELS_A_STEP // width, 1)
    for first in range(0, height, rows):
        report("field", first / height)
        numbers = np.arange(first, min(first + rows, height))
        y = low[1] + (height - numbers - 0.5) * pixel
        points = np.stack(np.broadcast_arrays(x, y[:, None]), axis=-1).reshape(-1, 2)
        values[numbers] = field(points).reshape(-1, width)
    if not np.isfinite(values).all():
        row, column = np.argwhere(~np.isfinite(values))[0]
        raise RenderError(
            f"the field is {values[row, column]} at ({x[column]:g}, {low[1] + (height - row - 0.5) * pixel:g})"
        )
    report("field", 1.0)
    return values


def _steps(values: Values) -> Values:
    """How much the value changes from a pixel to the next, at least a little."""
    total = np.zeros_like(values)
    for axis in (0, 1):
        steps = np.abs(np.diff(values, axis=axis))
        before, after = np.zeros_like(values), np.zeros_like(values)
        inner = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
        outer = (slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))
        before[inner], after[outer] = steps, steps
        total += np.maximum(before, after) ** 2
    return np.maximum(np.sqrt(total), 1e-6 * max(float(np.abs(values).max()), 1e-30))


def _line(distance: Values, width: float) -> Values:
    """Coverage of a line, by the distance to its middle in pixels."""
    coverage: Values = np.clip(width / 2 + 0.5 - distance, 0.0, 1.0)[..., None]
    return coverage


def _nice(step: float) -> float:
    """1, 2 or 5 times a power of ten, at or above `step`; 0 for 0."""
    if not step > 0:
        return 0.0
    power = 10.0 ** math.floor(math.log10(step))
    return next(power * digit for digit in (1, 2, 5, 10) if power * digit >= step * (1 - 1e-9))
