"""Copies of a form in a ring: the point is turned into its sector, and neighbours are looked at too."""

from __future__ import annotations

import math
from itertools import product

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Exactness, grown
from isophote.shapes.field.functions import absolute, length, select
from isophote.shapes.field.numbers import whole_number
from isophote.shapes.field.place import turned_box
from isophote.shapes.field.repeat import FEW, MOST_NEAR, ROUNDING, Copies, Copy, Guards, near, out_of_box
from isophote.shapes.field.slope import is_fixed, steady

__all__ = ["RepeatAround"]


@attrs.frozen
class _Sector:
    """What a form takes of a turn about the axis: the middle angle, half of the extent, and the distance to it."""

    middle: float
    half: float
    inner: float


@attrs.frozen(repr=False)
class RepeatAround(Copies):
    """`count` copies of a form about an axis through the origin, evenly round, the first where the form is."""

    axis: str = attrs.field()
    count: int = whole_number(1, 100_000)

    title = "repeat_around"

    def __attrs_post_init__(self) -> None:
        letters = "z" if self.dimension == 2 else "xyz"
        if not isinstance(self.axis, str) or self.axis not in tuple(letters):
            raise GeometryError(f"repeat_around: axis must be one of {', '.join(letters)}, but is {self.axis!r}")
        if self._is_listed() and self.count > MOST_NEAR:
            raise GeometryError(
                f"repeat_around: {self.count} copies overlap at a point, {MOST_NEAR} at most may; "
                "move the form away from the axis, or give a smaller count"
            )

    def _plane(self) -> tuple[int, int]:
        """The axes that a turn takes to each other, from the first to the second."""
        return {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[self.axis]

    def _sector(self) -> _Sector | None:
        """The form's sector; None where its bounds hold the axis."""
        box = self._box[:, list(self._plane())]
        if not np.isfinite(box).all() or ((box[0] <= 0) & (box[1] >= 0)).all():
            return None
        u, v = (np.array(list(product(*box.T))) - 0.0).T
        start = float(np.arctan2(*box.mean(axis=0)[::-1]))
        angles = np.mod(np.arctan2(v, u) - start + math.pi, math.tau) - math.pi
        inner = float(np.hypot(*np.maximum(np.maximum(box[0], -box[1]), 0.0)))
        return _Sector(start + float(angles.min() + angles.max()) / 2, float(np.ptp(angles)) / 2, inner)

    def _steps(self) -> range:
        sector = self._sector()
        if sector is None:
            return range(self.count)
        return near(sector.half * self.count / math.tau, self._is_distance)

    def _is_listed(self) -> bool:
        """Whether all copies are looked at."""
        return self.count <= max(len(self._steps()), FEW)

    def _moved(self, p: Point, u: Value, v: Value, stretch: float) -> Point:
        parts = p.coordinates
        first, second = self._plane()
        parts[first], parts[second] = u, v
        return p.moved(parts[0], parts[1], parts[2], stretch)

    def near_copies(self, p: Point) -> tuple[list[Copy], Guards]:
        u, v = (p.coordinates[axis] for axis in self._plane())
        turn, sector = math.tau / self.count, self._sector()
        if self._is_listed() or sector is None:
            turns = [(math.cos(turn * k), math.sin(turn * k)) for k in range(self.count)]
            return [Copy(self._moved(p, u * c + v * s, v * c - u * s, 1.0), None) for c, s in turns], Guards([], [])
        c, s = math.cos(sector.middle), math.sin(sector.middle)
        rho = p.bounded(length(u, v), 1.0)
        u, v, fixed = self._folded(p, u * c + v * s, v * c - u * s)
        side, w, copies = select(v, -1.0, 1.0), absolute(v), []
        for step in self._steps():
            along, across = _turned(u, w, step * turn)
            held = None if self._is_distance else _out_of(p, rho, along, absolute(across), sector.half)
            across = across * steady(side)
            rigid = fixed and (step == 0 or is_fixed(side))
            q = self._moved(p, along * c - across * s, along * s + across * c, 1.0 if rigid else math.inf)
            copies.append(Copy(q, held))
        if self._is_distance:
            return copies, Guards([], [])
        others = _out_of(p, rho, u, w, sector.half - turn * (1 - self._steps()[0]))
        return copies, Guards([others], [sector.inner - rho, *out_of_box(p, self.bounds)])

    def _folded(self, p: Point, u: Value, v: Value) -> tuple[Value, Value, bool]:
        """The point turned by the multiple of a turn that brings its angle nearest to 0; whether always by the same.

        Angles beyond half of a number of turns go back by that number, which leaves a third of them each time. There
        is no angle in this, which could not be told near the axis.
        """
        turn, reach, fixed = math.tau / self.count, self.count / 2, True
        while reach > 0.5 + ROUNDING:
            back = max(round(reach * 2 / 3), 1)
            w = absolute(v)
            _, beyond = _turned(u, w, back * turn / 2)
            along, across = _turned(u, w, back * turn)
            low, high = p.graph.interval(beyond.id)
            sides = p.graph.interval(v.id)
            fixed = fixed and bool(high < 0 or (low >= 0 and (sides[1] < 0 or sides[0] >= 0)))
            u, v = select(beyond, u, along), select(beyond, v, select(v, -across, across))
            for coordinate in (u, v) if fixed else ():
                p.bounded(coordinate, 1.0)
            reach = max(back / 2, reach - back)
        return u, v, fixed

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        """Exact where copies are apart."""
        sector = self._sector()
        apart = self.count == 1 or (sector is not None and sector.half < math.pi / self.count)
        return self.form.exactness if apart else min(self.form.exactness, Exactness.BOUND)

    def bounds_at(self, level: float) -> Box:
        whole = self._is_listed() or self._is_distance
        box = self.form.bounds_at(level) if whole and level > 0 else self._box
        first, second = self._plane()
        boxes = []
        for k in range(self.count):
            matrix = np.eye(self.dimension)
            c, s = math.cos(math.tau * k / self.count), math.sin(math.tau * k / self.count)
            matrix[[first, first, second, second], [first, second, first, second]] = c, -s, s, c
            boxes.append(turned_box(matrix, box))
        around = np.stack([np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)])
        return around if whole else grown(around, max(level, 0.0))

    def spelled(self) -> str:
        axis = "" if self.dimension == 2 else f"{self.axis!r}, "
        return f"{self.form.spelled()}.repeat_around({axis}{self.count})"


def _turned(u: Value, v: Value, angle: float) -> tuple[Value, Value]:
    """The vector (u, v) turned back by an angle."""
    c, s = math.cos(angle), math.sin(angle)
    return u * c + v * s, v * c - u * s


def _out_of(p: Point, rho: Value, u: Value, w: Value, half: float) -> Value:
    """The distance of (u, w), w ≥ 0, at ρ from the axis, to the sector |angle| ≤ half, or less: ρ sin(angle − half).

    Beyond a right angle it is ρ.
    """
    along, across = _turned(u, w, half)
    return p.bounded(select(along, rho, across), 1.0)
