"""Fields at points and in pictures.

    python bench/fields.py [--rounds 9] [--side 1024]

The tape is that of a ball in a box less three poles, 45 operations with its three coordinates. The picture is a page
of letters drawn with strokes, one expression of more than 6,000 operations; NumPy evaluates it at every pixel of every
sixteenth row, and its time is taken as sixteen times that.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence

import attrs
import numpy as np
import numpy.typing as npt

import isophote as iso
from common import print_machine, print_table, verdict
from isophote.convert.mask import pixel_centres
from isophote.shapes.field import evaluate
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Form
from isophote.shapes.field.functions import maximum, minimum, sqrt
from isophote.shapes.field.tape import numpy_values, tape_of
from lettering import PAGE, lettering

# Points that fit the cache, so that it is the tape that is measured.
_POINTS = 1 << 16
# Points that NumPy looks at in one step, for it holds the values of all operators; and every how many rows of a picture
# it is measured on.
_PIECE, _ROWS = 1 << 12, 16

_GOAL_NANOSECONDS, _GOAL_MILLISECONDS, _GOAL_TIMES, _GOAL_GROWTH = 4.5, 30, 500, 4


@attrs.frozen(eq=False)
class Part(Form):
    """A ball in a box, less three poles; squares of coordinates are taken once."""

    pole: float = 0.5

    def expression(self, p: Point) -> Value:
        x, y, z = (c * c for c in (p.x, p.y, p.z))
        sides = [abs(c) - 0.75 for c in (p.x, p.y, p.z)]
        beyond = [maximum(side, 0.0) for side in sides]
        outside = sqrt(beyond[0] * beyond[0] + beyond[1] * beyond[1] + beyond[2] * beyond[2])
        box = outside + minimum(maximum(maximum(sides[0], sides[1]), sides[2]), 0.0)
        value = maximum(sqrt(x + y + z) - 1.0, box)
        for a, b in ((x, y), (y, z), (x, z)):
            value = maximum(value, -(sqrt(a + b) - self.pole))
        return value


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--side", type=int, default=1024, help="pixels along a side of the smaller picture")
    options = parser.parse_args(arguments)
    print_machine()
    _evaluation(options.rounds)
    _pictures(options.rounds, options.side)


def _evaluation(rounds: int) -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (_POINTS, 3)).astype(np.float32)
    part = Part()
    evaluate.values(part, points), evaluate.gradients(part, points)
    fresh = min(_seconds(lambda k=k: evaluate.values(Part(0.4 + k / 100), points[:1])) for k in range(rounds))
    table: list[list[object]] = []
    for name, run in (("values", evaluate.values), ("gradients", evaluate.gradients)):
        spent = np.array([_seconds(lambda run=run: run(part, points), time.thread_time) for _ in range(20 * rounds)])
        each = spent / _POINTS * 1e9
        goal = verdict(each.min(), _GOAL_NANOSECONDS, at_most=True) if name == "values" else ""
        table.append([name, len(tape_of(part).rows) + 3, each.min(), np.median(each), goal])
    theirs = _seconds(lambda: _numpy(part, points))
    table.append(["values, NumPy", "", theirs / _POINTS * 1e9, "", ""])
    print_table(["tape", "operations", "ns a point and core", "median", "goal"], table)
    print(f"A new shape, from its form to its first value: {fresh * 1e3:.2f} ms; nothing is compiled for it.\n")


def _pictures(rounds: int, side: int) -> None:
    page = lettering(PAGE)
    low, high = page.bounds
    middle, half = (low + high) / 2, 0.55 * (high - low).max()
    bounds = np.stack([middle - half, middle + half])
    operations = len(tape_of(page.form, bounds).rows)
    spent = {}
    for size in (side, 4 * side):
        iso.mask(page, (size, size), bounds)
        spent[size] = (
            np.array([_seconds(lambda s=size: iso.mask(page, (s, s), bounds)) for _ in range(4 * rounds)]) * 1e3
        )
    first = min(_seconds(lambda: iso.mask(lettering(PAGE), (side, side), bounds)) for _ in range(3)) * 1e3
    xs, ys = pixel_centres(bounds, (side, side))
    columns, rows = np.meshgrid(xs, ys[::_ROWS])
    begin = time.perf_counter()
    values = _numpy(page.form, np.column_stack([columns.reshape(-1), rows.reshape(-1)]))
    theirs = (time.perf_counter() - begin) * 1e3 * side / len(rows)
    wrong = (values.reshape(rows.shape) < 0) != iso.mask(page, (side, side), bounds)[::_ROWS]
    best, large = spent[side].min(), spent[4 * side].min()
    growth = verdict(large / best, _GOAL_GROWTH, at_most=True)
    table: list[list[object]] = [
        [f"{side}²", best, np.median(spent[side]), "", verdict(best, _GOAL_MILLISECONDS, at_most=True)],
        [f"{4 * side}²", large, np.median(spent[4 * side]), large / best, growth],
        [f"{side}², new page: tape and picture", first, "", first / best, ""],
        [f"{side}², NumPy", theirs, "", theirs / best, verdict(theirs / best, _GOAL_TIMES)],
    ]
    print_table([f"picture of {operations:,} operations", "ms", "median", "times the first", "goal"], table)
    print(f"Pixels that differ from NumPy's in double precision: {wrong.sum()} of {wrong.size:,}.")


def _numpy(form: Form, points: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
    pieces = [numpy_values(form, points[first : first + _PIECE]) for first in range(0, len(points), _PIECE)]
    return np.concatenate(pieces)


def _seconds(side: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    begin = clock()
    side()
    return clock() - begin


if __name__ == "__main__":
    main()
