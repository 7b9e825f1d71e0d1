"""Placements over time, and what lies between them."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.fields import VectorLike
from isophote.scene.interpolation import between, taken_apart
from isophote.scene.transform import Axis, Transform

__all__ = ["Motion"]

Matrix: TypeAlias = npt.NDArray[np.float64]
Placements: TypeAlias = Mapping[float, Transform] | Iterable[tuple[float, Transform]]

# Rotations whose quaternions are this near to perpendicular are half a turn apart: either way round is as short.
_HALF_TURN = 1e-6
# A turn is kept as placements at most a quarter of a turn apart.
_STEP = math.pi / 2
_MOST_STEPS = 100_000


def _is_time(value: Any) -> bool:
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    return number and math.isfinite(value)


def _as_placements(given: Placements) -> tuple[tuple[float, Transform], ...]:
    try:
        pairs = list(given.items() if isinstance(given, Mapping) else given)
        named = [(time, transform) for time, transform in pairs]
    except (TypeError, ValueError):
        raise SceneError(
            f"Motion takes placements by their times, {{0.0: Transform, 1.0: Transform}}, not {given!r}"
        ) from None
    for time, transform in named:
        if not _is_time(time):
            raise SceneError(f"Motion: times must be finite numbers of seconds, but one is {time!r}")
        if not isinstance(transform, Transform):
            raise SceneError(f"Motion: the placement at {time} must be a Transform, but is {transform!r}")
    placed = sorted(((float(time), transform) for time, transform in named), key=lambda pair: pair[0])
    times = [time for time, _ in placed]
    if len(placed) < 2 or len(set(times)) < len(times):
        raise SceneError(f"Motion needs placements at two different times or more, but was given {times}")
    return tuple(placed)


@attrs.frozen(repr=False)
class Motion:
    """Where something stands over time: `Motion({0.0: a, 1.0: b})` goes from Transform `a` to `b` within a second.

    `placements` are (time in seconds, Transform) in order of time. Each is taken apart as T R S, a translation, a
    rotation and a stretch, M = R S by polar decomposition; between two of them T and S go in a straight line and R
    along the shortest arc (spherical linear interpolation of quaternions), so that what turns keeps its shape. Before
    the first and after the last time it stands still.

    Raises `SceneError` for fewer than two times, and for neighbours between which there is no way that is told by
    them: half a turn apart, or one of them mirrored. Source: Shoemake, Duff, "Matrix Animation and Polar
    Decomposition", Graphics Interface 1992.
    """

    placements: tuple[tuple[float, Transform], ...] = attrs.field(converter=_as_placements)

    def __attrs_post_init__(self) -> None:
        for (start, before), (end, after) in pairwise(self.placements):
            a, b = taken_apart([before]), taken_apart([after])
            if a.mirrored[0] != b.mirrored[0]:
                raise SceneError(f"Motion: the placements at {start} and {end} are mirror images; nothing lies between")
            if abs(float(a.turns[0] @ b.turns[0])) < _HALF_TURN:
                raise SceneError(
                    f"Motion: the placements at {start} and {end} are half a turn apart, which does not tell which way "
                    "it turns; give one between, or use Motion.turn"
                )

    @classmethod
    def turn(
        cls,
        axis: Axis,
        angle: float,
        times: tuple[float, float] = (0.0, 1.0),
        start: Transform | None = None,
    ) -> Motion:
        """Turns about its own origin, evenly from the first of `times` to the second, by `angle` radians of any size
        about `axis` in its own space; `start` is where it stands at first."""
        if not _is_time(angle):
            raise SceneError(f"angle must be a finite number of radians, but is {angle!r}")
        steps = max(1, math.ceil(abs(angle) / _STEP))
        if steps > _MOST_STEPS:
            raise SceneError(f"angle is {angle}, more than {_MOST_STEPS // 4:,} turns, in one Motion")
        if not (isinstance(times, tuple | list) and len(times) == 2 and all(map(_is_time, times))):
            raise SceneError(f"times must be two finite numbers of seconds, (first, last), but are {times!r}")
        placed = Transform.identity() if start is None else start
        first, last = times
        parts = [k / steps for k in range(steps + 1)]
        return cls(
            (first + part * (last - first), placed @ Transform.identity().rotate(axis, part * angle)) for part in parts
        )

    @property
    def times(self) -> tuple[float, ...]:
        """The times of the placements, in seconds."""
        return tuple(time for time, _ in self.placements)

    @property
    def matrix(self) -> Matrix:
        """(4, 4): the first placement's matrix, for what knows of no time."""
        return self.placements[0][1].matrix

    def at(self, time: float) -> Transform:
        """Where it stands at a time."""
        times = self.times
        if time <= times[0]:
            return self.placements[0][1]
        if time >= times[-1]:
            return self.placements[-1][1]
        k = bisect_right(times, time) - 1
        (start, before), (end, after) = self.placements[k : k + 2]
        if before == after or time == start:
            return before
        parts = np.array([(time - start) / (end - start)])
        return Transform(between(taken_apart([before]), taken_apart([after]), parts)[0])

    def moves(self, first: float, last: float) -> bool:
        """Whether it stands elsewhere at some time between two times than at the first."""
        at_first = self.at(first)
        within = [time for time in self.times if first < time < last]
        return any(self.at(time) != at_first for time in (*within, last))

    def then(self, other: Transform) -> Motion:
        """Each placement, and after it `other`."""
        return Motion((time, transform.then(other)) for time, transform in self.placements)

    def translate(self, offset: VectorLike) -> Motion:
        """All of it moved by `offset`."""
        return self.then(Transform.identity().translate(offset))

    def rotate(self, axis: Axis, angle: float) -> Motion:
        """All of it turned about the world's origin; see `Transform.rotate`."""
        return self.then(Transform.identity().rotate(axis, angle))

    def scale(self, factor: float | VectorLike) -> Motion:
        """All of it scaled about the world's origin; see `Transform.scale`."""
        return self.then(Transform.identity().scale(factor))

    def __repr__(self) -> str:
        inside = ", ".join(f"{time!r}: {transform!r}" for time, transform in self.placements)
        return f"Motion({{{inside}}})"
