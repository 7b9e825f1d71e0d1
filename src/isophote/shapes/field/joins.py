"""How values of parts are joined: sharp, blended, rounded or chamfered.

A join takes values, negative inside, to the value of what is inside all of them; what is inside any of them comes of
the same with all signs turned. Each join is nowhere below the largest value, so it only ever takes material away.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import TypeAlias

import numpy as np

from isophote.shapes.field.expression import Value
from isophote.shapes.field.functions import length, maximum, minimum, smooth_maximum, smooth_minimum

__all__ = ["STYLES", "chamfered", "corner", "in_pairs", "joined", "largest", "least", "reach_of", "rounded", "united"]

_HALF_ROOT = float(np.sqrt(0.5))

Join: TypeAlias = Callable[[Value, Value], Value]


def in_pairs(values: Sequence[Value], join: Join) -> Value:
    """All values joined in pairs, then pairs of pairs, so that the expression is flat, not a long chain."""
    left = list(values)
    while len(left) > 1:
        pairs = [join(a, b) for a, b in zip(left[::2], left[1::2], strict=False)]
        left = pairs + left[len(pairs) * 2 :]
    return left[0]


def largest(values: Sequence[Value]) -> Value:
    """The largest value."""
    return in_pairs(values, maximum)


def least(values: Sequence[Value]) -> Value:
    """The least value."""
    return in_pairs(values, minimum)


def corner(faces: Sequence[Value]) -> Value:
    """|max(f, 0)| + min(max f, 0): the distance to where faces f meet at right angles, inside and out."""
    parts = [maximum(face, 0.0) for face in faces]
    outside = length(*parts) if len(parts) == 3 else in_pairs(parts, length)
    inside = minimum(largest(faces), 0.0)
    return outside.graph.one_of(outside + inside, outside, inside)


def rounded(faces: Sequence[Value], radius: Value) -> Value:
    """Faces that meet in an edge rounded by `radius`: the corner of faces moved inwards, and then offset."""
    return corner([face + radius for face in faces]) - radius


def chamfered(faces: Sequence[Value], leg: Value) -> Value:
    """Faces whose edges are cut off by planes that begin at `leg` from them: (f + g + leg) / √2 for each two."""
    cuts = [(f + g + leg) * _HALF_ROOT for f, g in combinations(faces, 2)]
    return largest([*faces, *cuts])


def _blended(faces: Sequence[Value], width: Value) -> Value:
    return in_pairs(faces, lambda a, b: smooth_maximum(a, b, width))


# By the name of the option that asks for it.
STYLES = {"blend": _blended, "round": rounded, "chamfer": chamfered}


def joined(values: Sequence[Value], style: str, size: Value) -> Value:
    """What is inside all of these, in pairs, with their edges in one of `STYLES`; size 0 is sharp."""
    if size.constant == 0:
        return largest(values)
    return in_pairs(values, lambda a, b: STYLES[style]([a, b], size))


def united(values: Sequence[Value], style: str, size: Value) -> Value:
    """What is inside any of these, in pairs, with their edges in one of `STYLES`; size 0 is sharp."""
    if size.constant == 0:
        return least(values)
    if style == "blend":
        return in_pairs(values, lambda a, b: smooth_minimum(a, b, size))
    return -joined([-value for value in values], style, size)


def reach_of(style: str, size: float, level: float) -> float:
    """The largest that the lesser of two values can be where their union's value is at most `level`.

    Blended, the union is at least min − size / 4. Chamfered, it is (a + b − size) / √2 or the minimum. Rounded, it is
    size − |max(size − a, 0), max(size − b, 0)|, whose length is at most √2 times its larger part.
    """
    if style == "blend":
        return level + size / 4
    if style == "chamfer":
        return max(level, size / 2 + level * _HALF_ROOT)
    return max(level, size - (size - level) * _HALF_ROOT)
