"""Lipschitz constants of forms in their own space."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from isophote.shapes.field.expression import Graph, Point, Value
from isophote.shapes.field.form import Exactness, Form
from isophote.shapes.field.tape import numpy_values

__all__ = ["is_fixed", "largest_value", "most", "own_slope", "steady"]


def own_slope(form: Form, p: Point) -> float:
    """A Lipschitz constant of a form in its own space, where `p` may be; infinite where none is known."""
    if form.exactness is Exactness.EXACT:
        return 1.0
    # Forms are equal whose parameters have equal values, but their constants hold for all values of a slider.
    return _slope.__wrapped__(form, True, *_ends(p)) if p.graph.symbolic else _slope(form, False, *_ends(p))


def largest_value(form: Form, p: Point) -> float:
    """A bound on the magnitude of a form's value where `p` may be: that at the middle, and the slope to the corners."""
    low, high = np.reshape(_ends(p), (3, 2)).T
    if p.graph.symbolic or not np.isfinite([low, high]).all():
        return math.inf
    middle = numpy_values(form, [((low + high) / 2)[: form.dimension]])
    return abs(float(middle[0])) + own_slope(form, p) * float(np.linalg.norm(high - low)) / 2


def _ends(p: Point) -> tuple[float, ...]:
    return tuple(float(end) for interval in p.intervals() for end in interval)


@lru_cache(maxsize=4096)
def _slope(form: Form, symbolic: bool, *ends: float) -> float:
    graph = Graph(np.reshape(ends, (3, 2)).T, symbolic)
    value = form.expression(graph.point)
    return graph.lipschitz()[value.id]


def most(value: Value) -> float:
    """The largest magnitude of a value over its graph's region."""
    low, high = value.graph.interval(value.id)
    return max(abs(float(low)), abs(float(high)))


def is_fixed(value: Value) -> bool:
    """Whether a value of whole numbers is always the same in its graph's region."""
    low, high = value.graph.interval(value.id)
    return float(high) - float(low) < 0.5


def steady(value: Value) -> Value:
    """A value of whole numbers, known not to change where its interval holds but one."""
    if is_fixed(value):
        claims = value.graph.claims
        claims[value.id] = min(claims.get(value.id, math.inf), 0.0)
    return value
