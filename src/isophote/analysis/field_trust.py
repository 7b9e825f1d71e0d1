"""How far a field can be trusted: what it claims, and what is measured."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field.field import Field
from isophote.shapes.field.field2 import Field2
from isophote.shapes.field.form import Exactness
from isophote.shapes.field.tape import numpy_values, written

__all__ = ["FieldReport", "field_report"]

Floats: TypeAlias = npt.NDArray[np.float64]
Box: TypeAlias = npt.NDArray[np.float64]

# How far round the bounds values are looked at, in parts of their diagonal.
_AROUND = 0.25
# Lengths in parts of the diagonal: steps of differences, the shortest step in search of a jump, and the distance below
# which a value is too small to be compared with it.
_NEAR, _SHORTEST, _CLEAR = 1e-6, 1e-7, 1e-2
# What rounding may hide of a value, and of the diagonal.
_PART, _LEAST = 1e-3, 1e-6
_HALVINGS, _STEPS, _TRIES = 30, 12, 6
# Pairs whose slope is followed to where it is steepest, and points that a table shows.
_FOLLOWED, _SHOWN = 256, 10


@attrs.frozen(eq=False, repr=False)
class FieldReport:
    """What `field_report` found. `str()` is a table.

    `claimed_exactness` and `claimed_lipschitz` are what the field says of itself; `measured_lipschitz` is the steepest
    slope between neighbouring points, and `steepest` (2, d) the two. `exactness` is what the samples allow: `EXACT`
    where no value is off the distance to the surface by more than a thousandth, `BOUND` where |value| / claimed
    Lipschitz constant never reached beyond the surface, else `SIGN`. `least_ratio` and `greatest_ratio` are the least
    and the greatest |value| / distance. `too_near` (k, d) are points, the worst first, whose value promises more free
    space than there is: they contradict the claim, and tracing may miss the surface. `samples` is how many points were
    looked at, within `box` (2, d).
    """

    claimed_exactness: Exactness
    claimed_lipschitz: float
    measured_lipschitz: float
    steepest: Floats
    exactness: Exactness
    least_ratio: float
    greatest_ratio: float
    too_near: Floats
    samples: int
    box: Box

    @property
    def holds(self) -> bool:
        """Whether nothing contradicts what the field claims."""
        slope = self.measured_lipschitz <= self.claimed_lipschitz * (1 + _PART)
        return slope and self.exactness >= self.claimed_exactness and len(self.too_near) == 0

    def __str__(self) -> str:
        rows = [
            ("", "claimed", "measured"),
            ("values are", _NAMES[self.claimed_exactness], _NAMES[self.exactness]),
            ("Lipschitz constant", f"{self.claimed_lipschitz:.6g}", f"{self.measured_lipschitz:.6g}"),
            ("|value| / distance", "", f"{self.least_ratio:.4g} to {self.greatest_ratio:.4g}"),
            ("points that fail", "0", str(len(self.too_near))),
        ]
        widths = [max(len(row[k]) for row in rows) for k in range(3)]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
        lines.append(f"{self.samples:,} points in {_spelled(self.box[0])} to {_spelled(self.box[1])}")
        lines.append(f"steepest between {_spelled(self.steepest[0])} and {_spelled(self.steepest[1])}")
        for point in self.too_near[:_SHOWN]:
            lines.append(f"promises too much at {_spelled(point)}")
        return "\n".join(lines)

    __repr__ = __str__


_NAMES = {
    Exactness.EXACT: "exact distances",
    Exactness.BOUND: "bounds",
    Exactness.SIGN: "signs alone",
}


def _spelled(point: Floats) -> str:
    return "(" + ", ".join(f"{c:.6g}" for c in point) + ")"


def field_report(
    shape: Field | Field2, bounds: npt.ArrayLike | None = None, *, samples: int = 5000, seed: int = 0
) -> FieldReport:
    """Measure how far a field can be trusted, against what it claims.

    Random points in the bounds and a quarter of their diagonal around are compared in pairs, near and far, and slopes
    followed to where they are steepest, so that jumps are found. Distances are measured to points of the surface that
    bisections find, and to where steps against the gradient end. All in double precision, by NumPy. What is measured
    is evidence: a report can refute a claim, not prove it.

    `bounds` (2, d) are looked at instead of the field's own, which they must be for endless fields. Raises
    `GeometryError` for those without, and where no surface is found.
    """
    if not isinstance(shape, Field | Field2):
        raise GeometryError(
            f"field_report takes a field, not {type(shape).__name__}; distance_field makes one of a mesh"
        )
    if isinstance(samples, bool) or not isinstance(samples, int | np.integer) or not 100 <= samples <= 10_000_000:
        raise GeometryError(f"field_report: samples must be a whole number from 100 to 10 000 000, not {samples!r}")
    return _Measured(shape, _box(shape, bounds), int(samples), seed).report()


def _box(shape: Field | Field2, bounds: npt.ArrayLike | None) -> Box:
    box = np.asarray(shape.bounds if bounds is None else bounds, np.float64)
    if box.shape != (2, shape.dimension) or not np.isfinite(box).all():
        raise GeometryError(
            f"field_report: the bounds are {box.tolist()}; give bounds=, finite, (2, {shape.dimension}), to look at"
        )
    if not (box[0] <= box[1]).all() or not (box[0] < box[1]).any():
        raise GeometryError(
            f"field_report: there is nothing to look at between {_spelled(box[0])} and {_spelled(box[1])}"
        )
    if bounds is not None:
        return box
    around = _AROUND * float(np.linalg.norm(box[1] - box[0]))
    return np.stack([box[0] - around, box[1] + around])


class _Measured:
    """Samples of a field in a box, and what they tell."""

    def __init__(self, shape: Field | Field2, box: Box, samples: int, seed: int) -> None:
        self.shape, self.box = shape, box
        self.size = float(np.linalg.norm(box[1] - box[0]))
        self.random = np.random.default_rng(seed)
        self.points = self.random.uniform(box[0], box[1], (samples, len(box[0])))
        self.values = self.at(self.points)
        self.pairs = self._across()

    def at(self, points: Floats) -> Floats:
        values = numpy_values(self.shape.form, points)
        if not np.isfinite(values).all():
            bad = int(np.argmin(np.isfinite(values)))
            raise GeometryError(f"field_report: the field is {values[bad]} at {_spelled(points[bad])}")
        return values

    def report(self) -> FieldReport:
        graph, result = written(self.shape.form, self.box)
        claimed = graph.lipschitz()[result]
        slope, steepest = self.steepest()
        distances = self.distances()
        clear = distances > _CLEAR * self.size
        ratios = np.abs(self.values[clear]) / distances[clear]
        least, greatest = (float(ratios.min()), float(ratios.max())) if clear.any() else (np.nan, np.nan)
        excess = np.abs(self.values) / claimed - distances * (1 + _PART) - _LEAST * self.size
        failing = np.flatnonzero(excess > 0)
        failing = failing[np.argsort(-excess[failing])]
        if least >= 1 - _PART and greatest <= 1 + _PART:
            exactness = Exactness.EXACT
        else:
            bound = np.isfinite(claimed) and len(failing) == 0 and slope <= claimed * (1 + _PART)
            exactness = Exactness.BOUND if bound else Exactness.SIGN
        return FieldReport(
            claimed_exactness=self.shape.exactness,
            claimed_lipschitz=claimed,
            measured_lipschitz=slope,
            steepest=steepest,
            exactness=exactness,
            least_ratio=least,
            greatest_ratio=greatest,
            too_near=self.points[failing],
            samples=len(self.points),
            box=self.box,
        )

    def steepest(self) -> tuple[float, Floats]:
        """The steepest slope between two points, and these."""
        near = self.points + self.random.normal(size=self.points.shape) * _NEAR * self.size
        far = self.random.permutation(len(self.points))
        first = np.concatenate([self.points, self.points])
        second = np.concatenate([near, self.points[far]])
        at_first = np.concatenate([self.values, self.values])
        at_second = np.concatenate([self.at(near), self.values[far]])
        order = np.argsort(-_slopes(first, second, at_first, at_second))[:_FOLLOWED]
        # Some of the far pairs are followed too, however flat: a jump between them shows when they are close.
        jumps = len(self.points) + np.arange(min(_FOLLOWED, len(self.points)))
        chosen = np.concatenate([order, jumps])
        slope, pair = self._followed(first[chosen], second[chosen], at_first[chosen], at_second[chosen])
        a, b = self.pairs
        across = _slopes(a, b, self.at(a), self.at(b))
        worst = int(across.argmax())
        return (slope, pair) if slope >= across[worst] else (float(across[worst]), np.stack([a[worst], b[worst]]))

    def _followed(self, a: Floats, b: Floats, at_a: Floats, at_b: Floats) -> tuple[float, Floats]:
        """Pairs halved again and again, the steeper half kept: its slope is no less than that of the whole."""
        for _ in range(_HALVINGS):
            long = np.linalg.norm(a - b, axis=1) > _SHORTEST * self.size
            if not long.any():
                break
            middle = (a + b) / 2
            at_middle = self.at(middle)
            lower = _slopes(a, middle, at_a, at_middle) >= _slopes(middle, b, at_middle, at_b)
            a, at_a = np.where((long & ~lower)[:, None], middle, a), np.where(long & ~lower, at_middle, at_a)
            b, at_b = np.where((long & lower)[:, None], middle, b), np.where(long & lower, at_middle, at_b)
        slopes = _slopes(a, b, at_a, at_b)
        worst = int(slopes.argmax())
        return float(slopes[worst]), np.stack([a[worst], b[worst]])

    def distances(self) -> Floats:
        """Upper bounds on the distances of all points to the surface, tight where steps down the gradient reach it."""
        from scipy.spatial import cKDTree

        distances: Floats = cKDTree(self.pairs[0]).query(self.points)[0]
        distances = np.minimum(distances, self._stepped(self.points, self.points))
        for _ in range(_TRIES):
            # On a medial axis differences mix the slopes of both sides; points beside it have one of them.
            off = np.abs(self.values) < distances * (1 - _PART / 2)
            if not off.any():
                break
            near = self.points[off] + self.random.normal(size=self.points[off].shape) * 3 * _NEAR * self.size
            distances[off] = np.minimum(distances[off], self._stepped(self.points[off], near))
        return distances

    def _stepped(self, points: Floats, starts: Floats) -> Floats:
        """How far from `points` Newton's steps from `starts` reach the surface; infinite where they do not."""
        at, values = starts, self.at(starts)
        for _ in range(_STEPS):
            slopes = self._gradients(at)
            steepness = np.maximum((slopes**2).sum(axis=1), 1e-12)
            step = slopes * (values / steepness)[:, None]
            length = np.linalg.norm(step, axis=1)
            at = at - step * np.minimum(1.0, self.size / np.maximum(length, 1e-300))[:, None]
            values = self.at(at)
            if (np.abs(values) <= _LEAST * self.size).all():
                break
        reached = np.abs(values) <= _LEAST * self.size
        result: Floats = np.where(reached, np.linalg.norm(points - at, axis=1), np.inf)
        return result

    def _gradients(self, points: Floats) -> Floats:
        step = _NEAR * self.size
        slopes = []
        for axis in range(points.shape[1]):
            offset = step * (np.arange(points.shape[1]) == axis)
            slopes.append((self.at(points + offset) - self.at(points - offset)) / (2 * step))
        return np.stack(slopes, axis=1)

    def _across(self) -> tuple[Floats, Floats]:
        """Pairs of points close together, one inside and one outside: where the surface is, or the sign jumps."""
        inside, outside = self.points[self.values <= 0], self.points[self.values > 0]
        if len(inside) == 0 or len(outside) == 0:
            where = "inside" if len(outside) == 0 else "outside"
            box = f"{_spelled(self.box[0])} to {_spelled(self.box[1])}"
            raise GeometryError(
                f"field_report: all of {len(self.points):,} points in {box} lie {where}, so there is no surface to "
                "measure to; give other bounds=, or more samples="
            )
        count = len(self.points)
        a = inside[self.random.integers(len(inside), size=count)]
        b = outside[self.random.integers(len(outside), size=count)]
        for _ in range(_HALVINGS):
            middle = (a + b) / 2
            is_in = (self.at(middle) <= 0)[:, None]
            a, b = np.where(is_in, middle, a), np.where(is_in, b, middle)
        return a, b


def _slopes(a: Floats, b: Floats, at_a: Floats, at_b: Floats) -> Floats:
    apart = np.linalg.norm(a - b, axis=1)
    slopes: Floats = np.abs(at_a - at_b) / np.where(apart == 0, np.inf, apart)
    return slopes
