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

_GIVEN = ("INPUT", "PARAMETER", "CONSTANT")

# Their slopes have no bound, but values at numbers that differ by e differ by no more than so many times √e.
_ROOTS = {"SQUARE_ROOT": 1.0, "ARC_SINE": 2.23, "ARC_COSINE": 2.23}

# Which whole number, or which arm, is taken where rounding decides does not count: a Lipschitz constant beyond such a
# row is a claim that values meet there, and a point a few roundings away takes the same side exactly.
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
    with np.errstate(all="ignore"):
        for node, (name, arguments, _) in enumerate(graph.nodes):
            known = 0.0
            if name not in _GIVEN:
                known = _passed_on(graph, node, [errors[a] for a in arguments])
                if name not in _EXACT:
                    low, high = graph.interval(node)
                    known += _ULPS * max(abs(float(low)), abs(float(high)))
            errors.append(math.inf if math.isnan(known) else known)
            both = 2 * errors[-1] + _ULPS * constants[node] * reach
            slack.append(math.inf if math.isnan(both) else both)
    return slack


def _passed_on(graph: Graph, node: int, errors: list[float]) -> float:
    """What errors of the arguments make of the value."""
    name, arguments, constant = graph.nodes[node]
    if name in _CHOICES:
        return max([*errors[1:], 0.0])
    passed = float(OPERATORS[name].lipschitz(errors, [graph.interval(a) for a in arguments], constant))
    return float(np.fmin(passed, _ROOTS[name] * math.sqrt(errors[0]))) if name in _ROOTS else passed
