"""A page of letters written with strokes: bars, slanted lines and bows, put together as one expression.

A letter stands on a grid 4 wide and 6 tall. Its lines are written as the points that they pass, two digits each; its
bows as the middle and radius of a circle and where on it they begin and end, in eighths of a turn from the right.
"""

from __future__ import annotations

import itertools
import math

import isophote as iso
from isophote.shapes.field.field2 import Field2, arc, rectangle, segment

__all__ = ["PAGE", "lettering"]

Bow = tuple[float, float, float, float, float]

_ROUND: tuple[Bow, ...] = ((2, 4, 2, 0, 4), (2, 2, 2, 4, 8))
_OPEN: tuple[Bow, ...] = ((2, 4, 2, 1, 4), (2, 2, 2, 4, 7))
_UPPER: Bow = (2, 4.5, 1.5, -2, 2)

_LETTERS: dict[str, tuple[str, tuple[Bow, ...]]] = {
    "A": ("00-26-40 12-32", ()),
    "B": ("00-06 06-26 03-23 00-20", (_UPPER, (2, 1.5, 1.5, -2, 2))),
    "C": ("04-02", _OPEN),
    "D": ("00-06 06-16 00-10", ((1, 3, 3, -2, 2),)),
    "E": ("00-06 06-46 03-33 00-40", ()),
    "F": ("00-06 06-46 03-33", ()),
    "G": ("04-02 23-43 42-43", _OPEN),
    "H": ("00-06 40-46 03-43", ()),
    "I": ("20-26 10-30 16-36", ()),
    "J": ("46-42", ((2, 2, 2, 4, 8),)),
    "K": ("00-06 03-46 13-40", ()),
    "L": ("06-00 00-40", ()),
    "M": ("00-06-23-46-40", ()),
    "N": ("00-06-40-46", ()),
    "O": ("04-02 44-42", _ROUND),
    "P": ("00-06 06-26 03-23", (_UPPER,)),
    "Q": ("04-02 44-42 22-40", _ROUND),
    "R": ("00-06 06-26 03-23 23-40", (_UPPER,)),
    "S": ("", ((2, 4.5, 1.5, 1, 6), (2, 1.5, 1.5, -3, 2))),
    "T": ("20-26 06-46", ()),
    "U": ("06-02 46-42", ((2, 2, 2, 4, 8),)),
    "V": ("06-20-46", ()),
    "W": ("06-10-24-30-46", ()),
    "X": ("00-46 06-40", ()),
    "Y": ("06-23-46 23-20", ()),
    "Z": ("06-46-00-40", ()),
    ".": ("20-21", ()),
    ",": ("10-21", ()),
    " ": ("", ()),
}

PAGE = """\
A FIELD TELLS HOW FAR
IT IS TO WHAT IT DRAWS.
WHERE THE LEAST OF IT
IS ABOVE ZERO, THERE IS
NOTHING TO LOOK AT, AND
WHERE THE MOST IS BELOW,
ALL OF IT IS INK. ONLY
THE EDGES OF LETTERS
ASK FOR A CLOSER LOOK,
AND THERE, MOST OF THE
PAGE IS TOO FAR AWAY
TO MATTER. A TAPE GETS
SHORTER WITH EACH CUT,
TILL ONE STROKE IS LEFT."""

_WEIGHT, _ACROSS, _DOWN = 0.4, 5.6, 9.0


def lettering(text: str) -> Field2:
    """Lines of capitals, the first at the top."""
    strokes = []
    for row, line in enumerate(text.splitlines()):
        for column, letter in enumerate(line):
            lines, bows = _LETTERS[letter]
            x, y = column * _ACROSS, -row * _DOWN
            for path in lines.split():
                points = [(x + int(point[0]), y + int(point[1])) for point in path.split("-")]
                strokes += [_line(a, b) for a, b in itertools.pairwise(points)]
            strokes += [_bow(x, y, bow) for bow in bows]
    return iso.union(*strokes)


def _line(a: tuple[float, float], b: tuple[float, float]) -> Field2:
    """A bar where the line is upright or level, else a line with round ends."""
    size = abs(b[0] - a[0]), abs(b[1] - a[1])
    if 0 in size:
        middle = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
        return rectangle((size[0] + 2 * _WEIGHT, size[1] + 2 * _WEIGHT)).translate(middle)
    return segment(a, b, _WEIGHT)


def _bow(x: float, y: float, bow: Bow) -> Field2:
    turn = math.tau / 8
    ring = arc(bow[2], 2 * _WEIGHT, bow[3] * turn, bow[4] * turn)
    return ring.translate((x + bow[0], y + bow[1]))
