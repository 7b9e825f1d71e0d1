"""Copies of a form in rows and grids: the point is brought into its cell, and neighbours are looked at too."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from itertools import product
from typing import Any, NamedTuple

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.alter import Finished
from isophote.shapes.field.expression import Number, Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, grown, number_spelled
from isophote.shapes.field.functions import absolute, clip, maximum, minimum, rint, select
from isophote.shapes.field.intervals import tight_bounds
from isophote.shapes.field.joins import largest, least
from isophote.shapes.field.numbers import Vector, lowest, not_negative_vector
from isophote.shapes.field.place import Placed
from isophote.shapes.field.slope import is_fixed, own_slope, steady

__all__ = ["FEW", "MOST_NEAR", "ROUNDING", "Copies", "Copy", "Guards", "Repeat", "near", "out_of_box"]

# More copies near a point than this make an expression that nobody wants to wait for.
MOST_NEAR = 512
# So few copies in all are written out one by one: of such expressions only what matters is left in a region.
FEW = 32
# Parts of a spacing: forms that fill their cells exactly fit.
ROUNDING = 1e-9


def near(reach: float, exact: bool) -> range:
    """Steps to the copies that may be nearest to a point, counted toward the side of its cell that it is on.

    `reach` is half the form's extent over the spacing; cells are centred on the forms. A copy is no nearer than the
    next one towards the point, which is the same moved, unless it reaches within half a spacing of the point. So only
    steps m with −1/2 − reach < m < 1 + reach count, which are 0 and 1 where forms fit their cells. Where values are
    not `exact`, one more ahead may be taken, so that what is left out is no nearer ahead than behind.
    """
    back = max(math.ceil(reach + 0.5 - ROUNDING) - 1, 0)
    return range(-back, (max(math.ceil(reach - ROUNDING), 1) if exact else back + 1) + 1)


class Copy(NamedTuple):
    """The point in the space of one copy, and a bound on the distance to a region that holds it."""

    point: Point
    held: Value | None


class Guards(NamedTuple):
    """Bounds on the distances to all copies that are left out, and to all copies."""

    others: list[Value]
    all: list[Value]


@attrs.frozen(repr=False)
class Copies(Placed):
    """Union of copies of one form.

    Where the form is a distance, the least value of the copies near the point is the least of all copies' (`near`).
    Otherwise the value of a copy is max(f, b), with b a bound on the distance to a region that holds it, and the whole
    is held to at most D, a bound on the distance to the regions of the copies left out. That is the least over all
    copies of min(D, max(f, b)), whichever were looked at, and so it is as continuous as these are.
    """

    is_tight = False
    is_square = False
    is_smooth = False

    def near_copies(self, p: Point) -> tuple[list[Copy], Guards]:
        """The copies near the point, and what guards the value where the form is not a distance."""
        raise NotImplementedError

    def _united(self, p: Point, form: Form, ask: Callable[[Form, Point], Value]) -> Value:
        copies, guards = self.near_copies(p)
        arms = [ask(self.form, copy.point) for copy in copies]
        arms = [arm if copy.held is None else maximum(arm, copy.held) for arm, copy in zip(arms, copies, strict=True)]
        value = largest([least([*arms, *guards.others]), *guards.all])
        slopes = {own_slope(form, copy.point) for copy in copies}
        return p.bounded(value, max(slopes | ({1.0} if guards.all else set())))

    def expression(self, p: Point) -> Value:
        return self._united(p, self.form, lambda form, q: form.expression(q))

    def finished(self, p: Point, style: str, size: Value) -> Value:
        high = float(p.graph.interval(size.id)[1])
        return self._united(p, Finished(self.form, high, style), lambda form, q: form.finished(q, style, size))

    def faces(self, p: Point) -> list[Value]:
        return Form.faces(self, p)

    @cached_property
    def _is_distance(self) -> bool:
        return self.form.exactness is Exactness.EXACT

    @cached_property
    def _box(self) -> Box:
        """The tighter the box, the fewer copies are near a point."""
        return tight_bounds(self.form)


class _Row(NamedTuple):
    """One coordinate of the copies near a point, whether each is always the same copy, and the place in its cell."""

    places: list[tuple[Value, bool]]
    local: Value | None


def _counts(value: Any) -> Any:
    if value is None:
        return None
    return tuple(int(n) if isinstance(n, int | np.integer) and not isinstance(n, bool) else n for n in value)


@attrs.frozen(repr=False)
class Repeat(Copies):
    """Copies of a form, `spacing` apart along each axis; 0 leaves an axis alone.

    `count` copies along each axis, about the place of the form, or None for endlessly many.
    """

    spacing: Vector = not_negative_vector()
    count: tuple[int | None, ...] | None = attrs.field(default=None, converter=_counts)

    title = "repeat"

    def __attrs_post_init__(self) -> None:
        if not any(self.spacing):
            raise GeometryError("repeat: spacing is 0 along every axis; give one above 0")
        self._check_counts()
        box = self._box
        for axis, spacing in enumerate(self.spacing):
            if spacing > 0 and lowest(spacing) <= 0:
                raise GeometryError(f"repeat: a spacing must stay above 0, but is {spacing!r}")
            if spacing > 0 and not np.isfinite(box[:, axis]).all():
                raise GeometryError(
                    f"repeat: the form is endless along {'xyz'[axis]}; intersect it with a box first, or give spacing 0"
                )
        if math.prod(len(self._steps(axis)) for axis in self._rows()) > MOST_NEAR:
            raise GeometryError(
                f"repeat: spacing {self.spacing!r} is so small that more than {MOST_NEAR} copies of the form, whose "
                f"size is {np.diff(box, axis=0)[0].tolist()}, overlap at a point; give a larger spacing"
            )

    def _check_counts(self) -> None:
        if self.count is None:
            return
        fits = len(self.count) == self.dimension and all(
            n is None or (isinstance(n, int) and 1 <= n <= 1_000_000) for n in self.count
        )
        if not fits:
            raise GeometryError(
                f"repeat: count must be {self.dimension} whole numbers from 1 to 1000000, or None for endless, "
                f"but is {self.count!r}"
            )

    def _count(self, axis: int) -> int | None:
        if self.spacing[axis] == 0:
            return 1
        return None if self.count is None else self.count[axis]

    def _rows(self) -> list[int]:
        """The axes with more than one copy."""
        return [axis for axis in range(self.dimension) if self._count(axis) != 1]

    def _steps(self, axis: int) -> range:
        low, high = self._box[:, axis]
        return near(float(high - low) / 2 / lowest(self.spacing[axis]), self._is_distance)

    def _is_listed(self, axis: int) -> bool:
        """Whether the copies along an axis are few enough to be looked at all."""
        count = self._count(axis)
        counts = [self._count(row) for row in self._rows()]
        few = None not in counts and math.prod(counts) <= FEW  # type: ignore[arg-type]
        return count is not None and (few or count <= len(self._steps(axis)))

    def _row(self, p: Point, axis: int) -> _Row:
        x, spacing, count = p.coordinates[axis], p.number(self.spacing[axis]), self._count(axis)
        if count is not None and self._is_listed(axis):
            return _Row([(x - spacing * (k - (count - 1) / 2), True) for k in range(count)], None)
        middle, half = float(self._box[:, axis].mean()), spacing * 0.5
        if count is None:
            t = x - middle
            cell = steady(rint(t / spacing))
            local = clip(t - cell * spacing, -half, half)
        else:
            t, last = x - middle + half * (count - 1), float(count - 1)
            end = half + spacing * last
            cell = steady(clip(rint(t / spacing), 0.0, last))
            # t − spacing · cell, written so that intervals stay narrow: what is beyond the row, and what is within.
            within = clip(clip(t, -half, end) - cell * spacing, -half, half)
            local = within + (maximum(t - end, 0.0) + minimum(t + half, 0.0))
        side = steady(select(local, -1.0, 1.0))
        places = []
        for step in self._steps(axis):
            move: Number = side * float(step)
            if count is not None and step != 0:
                move = minimum(maximum(move, -cell), last - cell)
            places.append((local - move * spacing + middle, is_fixed(cell) and (step == 0 or is_fixed(side))))
        return _Row(places, local)

    def near_copies(self, p: Point) -> tuple[list[Copy], Guards]:
        rows = {axis: self._row(p, axis) for axis in self._rows()}
        folded = [axis for axis, row in rows.items() if row.local is not None and not self._is_distance]
        copies = []
        for places in product(*(row.places for row in rows.values())):
            parts = p.coordinates
            for axis, (place, _) in zip(rows, places, strict=True):
                parts[axis] = place
            q = p.moved(parts[0], parts[1], parts[2], 1.0 if all(fixed for _, fixed in places) else math.inf)
            copies.append(Copy(q, _beyond(q, self._box, folded) if folded else None))
        if not folded:
            return copies, Guards([], [])
        others = []
        for axis in folded:
            local, steps = rows[axis].local, self._steps(axis)
            assert local is not None
            low, high = self._box[:, axis]
            others.append(absolute(local) + (p.number(self.spacing[axis]) * (1.0 - steps[0]) - float(high - low) / 2))
        return copies, Guards(others, out_of_box(p, self.bounds))

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        """Exact where copies are apart; otherwise surfaces may be within others."""
        sizes = np.diff(self._box, axis=0)[0]
        apart = all(float(sizes[axis]) < lowest(self.spacing[axis]) for axis in self._rows())
        return self.form.exactness if apart else min(self.form.exactness, Exactness.BOUND)

    def bounds_at(self, level: float) -> Box:
        listed = all(self._is_listed(axis) for axis in self._rows())
        whole = listed or self._is_distance
        box = self.form.bounds_at(level).copy() if whole and level > 0 else self._box.copy()
        for axis in self._rows():
            count = self._count(axis)
            reach = math.inf if count is None else (count - 1) / 2 * float(self.spacing[axis])
            box[:, axis] += (-reach, reach)
        return box if whole else grown(box, max(level, 0.0))

    def spelled(self) -> str:
        count = "" if self.count is None else f", count={number_spelled(self.count)}"
        return f"{self.form.spelled()}.repeat({number_spelled(self.spacing)}{count})"


def _beyond(p: Point, box: Box, axes: list[int]) -> Value:
    """How far the point is beyond a box's sides across some axes, which is a bound on its distance."""
    ends = [(axis, *box[:, axis].tolist()) for axis in axes]
    sides = [absolute(p.coordinates[axis] - (low + high) / 2) - (high - low) / 2 for axis, low, high in ends]
    return p.bounded(largest(sides), 1.0)


def out_of_box(p: Point, box: Box) -> list[Value]:
    """How far the point is beyond a box's finite sides, or nothing."""
    finite = [axis for axis in range(box.shape[1]) if np.isfinite(box[:, axis]).all()]
    return [_beyond(p, box, finite)] if finite else []
