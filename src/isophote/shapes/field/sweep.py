"""A form in the plane swept along a polyline, in frames that do not twist."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.functions import absolute, length, maximum, minimum
from isophote.shapes.field.lift import own_slope
from isophote.shapes.field.numbers import Vector

__all__ = ["Sweep", "sampled_path"]

Floats: TypeAlias = npt.NDArray[np.float64]

_MOST_POINTS = 2049
# Cosine of the sharpest turn: beyond it mitres grow longer than six times the form.
_SHARPEST = -0.95


class _Frames(NamedTuple):
    """For each piece of the path its start, its axes (the form's x and y, and the direction), (n, 3) each, and the
    normals of the planes that part pieces, (n + 1, 3), along the path."""

    start: Floats
    x: Floats
    y: Floats
    along: Floats
    planes: Floats


def sampled_path(path: npt.ArrayLike | Callable[[float], npt.ArrayLike], samples: int) -> tuple[Vector, ...]:
    """Points of a path: as given, or of a function of t at `samples` + 1 even steps from 0 to 1."""
    if callable(path):
        if isinstance(samples, bool) or not isinstance(samples, int | np.integer) or not 1 <= samples < _MOST_POINTS:
            raise GeometryError(f"sweep: samples must be a whole number from 1 to {_MOST_POINTS - 1}, not {samples!r}")
        given: Any = map(path, np.linspace(0, 1, samples + 1).tolist())
    else:
        given = path
    try:
        points = [np.asarray(point, np.float64) for point in given]
    except (TypeError, ValueError) as error:
        raise GeometryError(f"sweep: a path has points (n, 3), or is a function that gives one: {error}") from error
    for number, point in enumerate(points):
        if point.shape != (3,) or not np.isfinite(point).all():
            raise GeometryError(f"sweep: a path has points of three numbers, but point {number} is {point.tolist()}")
    return tuple(tuple(map(float, point)) for point in points)


def _checked_path(form: Any, attribute: Any, path: tuple[Vector, ...]) -> None:
    if not 2 <= len(path) <= _MOST_POINTS:
        raise GeometryError(f"sweep: a path has from 2 to {_MOST_POINTS} points, but this one has {len(path)}")
    points = np.array(path)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if (steps <= 1e-9 * np.abs(points).max(initial=1e-300)).any():
        raise GeometryError(
            f"sweep: points {int(steps.argmin())} and {int(steps.argmin()) + 1} of the path are the same"
        )
    along = np.diff(points, axis=0) / steps[:, None]
    if path[0] == path[-1]:
        along = np.concatenate([along, along[:1]])
    turns = (along[1:] * along[:-1]).sum(axis=1)
    if (turns < _SHARPEST).any():
        raise GeometryError(
            f"sweep: the path turns back at point {int(turns.argmin()) + 1}; round the bend with more points"
        )


def _turned(vectors: Floats, first: Floats, second: Floats) -> Floats:
    """Vectors (k, 3) turned by the least rotation that takes the unit vector `first` to `second`.

    Source: Rodrigues' formula, R v = v + c × v + c × (c × v) / (1 + first · second) with c = first × second.
    """
    axis = np.cross(first, second)
    once = np.cross(axis, vectors)
    turned: Floats = vectors + once + np.cross(axis, once) / (1 + first @ second)
    return turned


def _frames(path: Floats) -> _Frames:
    """Frames by parallel transport: from piece to piece by the least rotation; y starts as nearly up as can be.

    On a closed path the frames come back turned by some angle; it is taken out evenly along the path.
    """
    steps = np.diff(path, axis=0)
    along = steps / np.linalg.norm(steps, axis=1, keepdims=True)
    up = np.array([0.0, 1.0, 0.0]) if abs(along[0, 1]) < 0.999 else np.array([0.0, 0.0, -1.0])
    y = up - (up @ along[0]) * along[0]
    axes = np.empty((len(along), 2, 3))
    axes[0] = np.cross(y, along[0]), y
    axes[0] /= np.linalg.norm(axes[0], axis=1, keepdims=True)
    for k in range(1, len(along)):
        axes[k] = _turned(axes[k - 1], along[k - 1], along[k])
    closed = bool((path[0] == path[-1]).all())
    if closed:
        back = _turned(axes[-1], along[-1], along[0])
        angle = -np.arctan2(back[0] @ axes[0, 1], back[0] @ axes[0, 0]) * np.arange(len(along)) / len(along)
        c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
        axes = np.stack([c * axes[:, 0] + s * axes[:, 1], c * axes[:, 1] - s * axes[:, 0]], axis=1)
    ends = (along[-1:], along[:1]) if closed else (along[:1], along[-1:])
    planes = np.concatenate([ends[0], along]) + np.concatenate([along, ends[1]])
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    return _Frames(path[:-1], axes[:, 0], axes[:, 1], along, planes)


@attrs.frozen(repr=False)
class Sweep(Form):
    """A form in the plane, moved along a polyline and mitred where it bends; flat at its ends.

    Each piece of the path carries the form as an endless prism, between the two planes that halve the angles with its
    neighbours; there the prisms of both meet, for turning by the least rotation keeps the places on that plane. The
    value is the least of max(prism, planes) over all pieces, and over the bends of what both prisms hold near their
    plane, so that the planes are not felt inside. A prism's value is the form's at a projection of the point, which
    brings no points farther apart, so the slope is no more than the form's or 1. The sign is exact for the mitred
    solid; values are bounds.
    """

    form: Form
    path: tuple[Vector, ...] = attrs.field(validator=_checked_path)
    exactness = Exactness.BOUND

    def __attrs_post_init__(self) -> None:
        if not np.isfinite(self.form.bounds).all():
            raise GeometryError("sweep: the form is endless; intersect it with something first")

    @cached_property
    def _frame(self) -> _Frames:
        return _frames(np.array(self.path))

    @cached_property
    def _corners(self) -> Floats:
        """(n, 2, 4, 3): for each piece, at its start and its end, the corners of the form's box on the plane there."""
        frame, (low, high) = self._frame, self.form.bounds
        flat = np.array([(low[0], low[1]), (low[0], high[1]), (high[0], low[1]), (high[0], high[1])])
        ends = np.stack([frame.start, np.array(self.path[1:])], axis=1)
        planes = np.stack([frame.planes[:-1], frame.planes[1:]], axis=1)
        across = flat[:, 0, None] * frame.x[:, None] + flat[:, 1, None] * frame.y[:, None]
        slant = np.einsum("nci,nei->nec", across, planes) / np.einsum("ni,nei->ne", frame.along, planes)[..., None]
        corners: Floats = ends[:, :, None] + across[:, None] - slant[..., None] * frame.along[:, None, None]
        return corners

    def expression(self, p: Point) -> Value:
        frame, path = self._frame, np.array(self.path)
        count = len(path) - 1
        slope = max(own_slope(self.form, p.moved(p.x, p.y, 0.0)), 1.0)
        heights = [_height(p, path[k], frame.planes[k]) for k in range(count + 1)]
        prisms = [self._prism(p, k) for k in range(count)]
        pieces = [
            maximum(self._piece(p, k, prisms[k], slope), maximum(-heights[k], heights[k + 1])) for k in range(count)
        ]
        for k in range(0 if self.path[0] == self.path[-1] else 1, count):
            room = self._room(k)
            if room > 0:
                both = maximum(prisms[k - 1], prisms[k])
                pieces.append(self._bend(p, k, both, absolute(heights[k]) - room, slope))
        return _least(pieces)

    def _prism(self, p: Point, k: int) -> Value:
        """The form's value on piece k, drawn out endlessly both ways."""
        frame = self._frame
        x, y = (_height(p, frame.start[k], axis[k]) for axis in (frame.x, frame.y))
        return self.form.expression(p.moved(x, y, 0.0))

    def _piece(self, p: Point, k: int, prism: Value, slope: float) -> Value:
        """Piece k between upright ends that leave room for its slanting ones: farther off a better bound than they."""
        start, along = self._frame.start[k], self._frame.along[k]
        ends = (self._corners[k].reshape(-1, 3) - start) @ along
        middle, half = float(ends.max() + ends.min()) / 2, float(ends.max() - ends.min()) / 2
        beyond = absolute(_height(p, start + middle * along, along)) - half
        return p.bounded(_both(prism, beyond), slope)

    def _bend(self, p: Point, k: int, both: Value, beyond: Value, slope: float) -> Value:
        """What is in the prisms before and after plane k, near that plane.

        The slopes a of the prisms and b of the height above the plane meet at a cosine of c at most, the sine of half
        the turn; so the length of the two has the slope √(a² + b² + 2abc) ≤ √(1 + c), which is divided out.
        """
        frame = self._frame
        cosine = float(np.linalg.norm(np.cross(frame.along[k], frame.planes[k])))
        return p.bounded(_both(both, beyond, 1 / np.sqrt(1 + cosine)), slope)

    def _room(self, k: int) -> float:
        """How far from the plane before piece k the two prisms there are clear of their other planes."""
        before, after = self._corners[k - 1, 0], self._corners[k, 1]
        plane, point = self._frame.planes[k], self._frame.start[k]
        return float(min(-((before - point) @ plane).max(), ((after - point) @ plane).min()))

    @property
    def bounds(self) -> Box:
        corners = self._corners.reshape(-1, 3)
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def spelled(self) -> str:
        return f"{self.form.spelled()}.sweep({number_spelled(self.path)})"


def _least(values: list[Value]) -> Value:
    """The least of all, in pairs and pairs of pairs."""
    while len(values) > 1:
        pairs = [minimum(a, b) for a, b in zip(values[::2], values[1::2], strict=False)]
        values = pairs + values[len(pairs) * 2 :]
    return values[0]


def _height(p: Point, origin: Floats, normal: Floats) -> Value:
    """(p − origin) · normal, for a unit normal."""
    nx, ny, nz = map(float, normal)
    return p.bounded(p.x * nx + p.y * ny + p.z * nz - float(origin @ normal), 1.0)


def _both(a: Value, b: Value, part: float = 1.0) -> Value:
    """What is below zero where both are; outside their length, times `part`."""
    return length(maximum(a, 0.0), maximum(b, 0.0)) * float(part) + minimum(maximum(a, b), 0.0)
