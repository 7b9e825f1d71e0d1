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
from isophote.shapes.field.form import Box, Exactness, Form, grown, number_spelled
from isophote.shapes.field.functions import absolute, length, maximum, minimum
from isophote.shapes.field.joins import least
from isophote.shapes.field.numbers import Vector
from isophote.shapes.field.slope import own_slope

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
        count = len(self.path) - 1
        return np.stack([[self._on_plane(k, k + end, self.form.bounds, 0.0) for end in (0, 1)] for k in range(count)])

    def _on_plane(self, k: int, plane: int, box: Box, height: float) -> Floats:
        """(4, 3): where the corners of a box of piece k are, drawn out to a height above a plane."""
        frame, (low, high) = self._frame, box
        flat = np.array([(low[0], low[1]), (low[0], high[1]), (high[0], low[1]), (high[0], high[1])])
        across = flat @ np.stack([frame.x[k], frame.y[k]])
        normal = frame.planes[plane]
        along: Floats = (height - across @ normal) / (frame.along[k] @ normal)
        corners: Floats = np.array(self.path[plane]) + across + along[:, None] * frame.along[k]
        return corners

    @cached_property
    def _spans(self) -> Floats:
        """(n, 2): from where to where along each piece its corners lie, measured from its start."""
        along = np.einsum("neci,ni->nec", self._corners - self._frame.start[:, None, None], self._frame.along)
        return np.stack([along.min(axis=(1, 2)), along.max(axis=(1, 2))], axis=1)

    @cached_property
    def _bends(self) -> dict[int, tuple[float, float]]:
        """By the number of a plane between two pieces: how far from it the prisms of both are clear of their other
        planes, and the sine of half the turn; without planes that leave no room."""
        frame, bends = self._frame, {}
        for k in range(0 if self.path[0] == self.path[-1] else 1, len(self.path) - 1):
            plane, point = frame.planes[k], frame.start[k]
            before, after = (self._corners[k - 1, 0] - point) @ plane, (self._corners[k, 1] - point) @ plane
            room = float(min(-before.max(), after.min()))
            if room > 0:
                bends[k] = room, float(np.linalg.norm(np.cross(frame.along[k], plane)))
        return bends

    def expression(self, p: Point) -> Value:
        frame, path = self._frame, np.array(self.path)
        count = len(path) - 1
        heights = [_height(p, path[k], frame.planes[k]) for k in range(count + 1)]
        prisms, slopes = zip(*(self._prism(p, k) for k in range(count)), strict=True)
        pieces = [
            maximum(self._piece(p, k, prisms[k], slopes[k]), maximum(-heights[k], heights[k + 1])) for k in range(count)
        ]
        for k, (room, sine) in self._bends.items():
            both, beyond = maximum(prisms[k - 1], prisms[k]), absolute(heights[k]) - room
            pieces.append(_bend(p, both, beyond, sine, max(slopes[k - 1], slopes[k])))
        return least(pieces)

    def _prism(self, p: Point, k: int) -> tuple[Value, float]:
        """The form's value on piece k, drawn out endlessly both ways, and a Lipschitz constant, 1 or more."""
        frame = self._frame
        x, y = (_height(p, frame.start[k], axis[k]) for axis in (frame.x, frame.y))
        q = p.moved(x, y, 0.0)
        return self.form.expression(q), max(own_slope(self.form, q), 1.0)

    def _piece(self, p: Point, k: int, prism: Value, slope: float) -> Value:
        """Piece k between upright ends that leave room for its slanting ones: farther off a better bound than they."""
        start, along, (low, high) = self._frame.start[k], self._frame.along[k], self._spans[k]
        beyond = absolute(_height(p, start + (low + high) / 2 * along, along)) - float(high - low) / 2
        return p.bounded(_both(prism, beyond), slope)

    @property
    def bounds(self) -> Box:
        return _box_of(self._corners)

    def bounds_at(self, level: float) -> Box:
        if level <= 0 or self.form.exactness is not Exactness.EXACT:
            return super().bounds_at(level)
        frame, (low, high) = self._frame, self.form.bounds
        flat = np.array([(low[0], low[1]), (low[0], high[1]), (high[0], low[1]), (high[0], high[1])])
        across = flat[:, 0, None] * frame.x[:, None] + flat[:, 1, None] * frame.y[:, None]
        upright = (frame.start[:, None] + self._spans[..., None] * frame.along[:, None])[:, :, None] + across[:, None]
        boxes = [grown(_box_of(upright), level)]
        for k, (room, sine) in self._bends.items():
            reach = level * np.sqrt(1 + sine)
            box = grown(self.form.bounds, reach)
            both = [
                _box_of(np.stack([self._on_plane(piece, k, box, height) for height in (-room - reach, room + reach)]))
                for piece in (k - 1, k)
            ]
            boxes.append(np.stack([np.maximum(both[0][0], both[1][0]), np.minimum(both[0][1], both[1][1])]))
        return _box_of(np.stack(boxes))

    def spelled(self) -> str:
        return f"{self.form.spelled()}.sweep({number_spelled(self.path)})"


def _height(p: Point, origin: Floats, normal: Floats) -> Value:
    """(p − origin) · normal, for a unit normal."""
    nx, ny, nz = map(float, normal)
    return p.bounded(p.x * nx + p.y * ny + p.z * nz - float(origin @ normal), 1.0)


def _both(a: Value, b: Value, part: float = 1.0) -> Value:
    """What is below zero where both are; outside their length, times `part`."""
    return length(maximum(a, 0.0), maximum(b, 0.0)) * float(part) + minimum(maximum(a, b), 0.0)


def _bend(p: Point, both: Value, beyond: Value, sine: float, slope: float) -> Value:
    """What is in the prisms before and after a plane, and near it.

    The slopes a of the prisms and b of the height above the plane meet at a cosine of no more than the sine of half the
    turn, s; so the length of the two has the slope √(a² + b² + 2abs) ≤ √(1 + s), which is divided out.
    """
    return p.bounded(_both(both, beyond, 1 / np.sqrt(1 + sine)), slope)


def _box_of(points: Floats) -> Box:
    flat = points.reshape(-1, 3)
    return np.stack([flat.min(axis=0), flat.max(axis=0)])
