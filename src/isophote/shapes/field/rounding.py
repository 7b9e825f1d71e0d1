"""How far single precision takes the values of an expression from the exact ones.

An error in an argument grows by the operator's slope, which its Lipschitz rule tells: given bounds on the arguments'
errors in place of their Lipschitz constants, it yields one on the error of the value. Each row adds its own rounding.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.shapes.field.expression import Graph
from isophote.shapes.field.operators import OPERATORS

__all__ = ["roundings"]

# Exact too. Which whole number, or which arm, is taken where rounding decides does not count: a Lipschitz constant beyond
# such a row is a claim that values meet there, and a point a few roundings away takes the same side exactly.
_CHOICES = ("FLOOR", "ROUND", "SELECT")

# More than any one operator of the interpreters is off by, in parts of its value, and those that are never off.
_ULPS = 4 * 2.0**-24
_EXACT = ("COPY", "NEGATE", "ABSOLUTE", "MINIMUM", "MAXIMUM", "MINIMUM_CONSTANT", "MAXIMUM_CONSTANT", *_CHOICES)


def roundings(graph: Graph, constants: list[float]) -> list[float]:
    """For each node of a graph, how far value(p) − value(q), as computed, can be beyond its Lipschitz constant.

    `constants` are the graph's Lipschitz constants over its region. Constants of the expression count as they are in
    single precision. Infinite where nothing is known.
    """
    errors: list[float] = []
    slack: list[float] = []
    reach = float(np.abs(graph.region).max())
    for number, (name, arguments, constant) in enumerate(graph.nodes):
        known = 0.0 if name in ("INPUT", "PARAMETER", "CONSTANT") else math.inf
        if known:
            low, high = graph.interval(number)
            passed = [errors[a] for a in arguments]
            with np.errstate(all="ignore"):
                if name in _CHOICES:
                    known = max([*passed[1:], 0.0])
                else:
                    intervals = [graph.interval(a) for a in arguments]
                    known = float(OPERATORS[name].lipschitz(passed, intervals, constant))
                if name == "SQUARE_ROOT":
                    # Its slope has no bound, but roots of numbers that differ by e differ by no more than √e.
                    known = np.fmin(known, math.sqrt(passed[0]))
            known += 0.0 if name in _EXACT else _ULPS * float(max(abs(low), abs(high)))
        errors.append(math.inf if math.isnan(known) else float(known))
        both = 2 * errors[-1] + _ULPS * constants[number] * reach
        slack.append(math.inf if math.isnan(both) else both)
    return slack
