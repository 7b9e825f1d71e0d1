"""The operators that every field is made of: what each means, five ways.

For each operator the table holds its meaning in NumPy (the oracle of every other evaluator), its rule for intervals,
its partial derivatives, its rule for Lipschitz constants, and its spelling in GLSL. `k` is the operator's constant.

Intervals are pairs (low, high) of float64 arrays; a rule gives an interval that holds every value that the operator
takes on the arguments' intervals, in exact arithmetic. Where several arms are possible, derivatives take one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.kernels.forms import opcodes

__all__ = ["OPERATORS", "Interval", "Operator"]

Array: TypeAlias = npt.NDArray[np.float64]
Interval: TypeAlias = tuple[Array, Array]
_Rule: TypeAlias = Callable[..., Any]

_TAU = 2 * np.pi


@attrs.frozen
class Operator:
    """One operator: `value(*arguments, k)`, `interval(*intervals, k)`, `partials(*arguments, value, k)` (one for each
    argument), `lipschitz(constants, intervals, k)`, and `glsl`, a format of `{a}`, `{b}`, `{c}`, `{k}`."""

    name: str
    code: int
    arity: int
    value: _Rule
    interval: _Rule
    partials: _Rule
    lipschitz: _Rule
    glsl: str
    commutes: bool = False


def _wide(interval: Interval) -> Array:
    """Largest magnitude in an interval."""
    return np.maximum(np.abs(interval[0]), np.abs(interval[1]))


def _product(p: Array, q: Array) -> Array:
    """p · q with 0 · ∞ = 0, as bounds need it: a factor that is always zero."""
    with np.errstate(invalid="ignore"):
        result: Array = np.where((p == 0) | (q == 0), 0.0, p * q)
    return result


def _multiply_interval(a: Interval, b: Interval, k: float = 0.0) -> Interval:
    products = [_product(p, q) for p in a for q in b]
    return np.minimum.reduce(products), np.maximum.reduce(products)


def _square_interval(a: Interval, k: float = 0.0) -> Interval:
    low, high = _absolute_interval(a)
    return low * low, high * high


def _absolute_interval(a: Interval, k: float = 0.0) -> Interval:
    inside = (a[0] <= 0) & (a[1] >= 0)
    return np.where(inside, 0.0, np.minimum(np.abs(a[0]), np.abs(a[1]))), _wide(a)


def _divide_interval(a: Interval, b: Interval, k: float = 0.0) -> Interval:
    low, high = _multiply_interval(a, _reciprocal(b))
    return low, high


def _reciprocal(b: Interval) -> Interval:
    """1 / b: everything where b may be zero."""
    holds_zero = (b[0] <= 0) & (b[1] >= 0)
    with np.errstate(divide="ignore"):
        return np.where(holds_zero, -np.inf, 1 / b[1]), np.where(holds_zero, np.inf, 1 / b[0])


def _wave_interval(a: Interval, peak: float) -> Interval:
    """Range of cos(t − peak) for t in a."""
    low, high = a[0] - peak, a[1] - peak
    endless = ~(np.isfinite(low) & np.isfinite(high))
    low, high = np.where(endless, 0.0, low), np.where(endless, _TAU, high)
    has_peak = np.floor(high / _TAU) * _TAU >= low
    has_trough = np.floor((high - np.pi) / _TAU) * _TAU + np.pi >= low
    first, last = np.cos(low), np.cos(high)
    return (
        np.where(has_trough, -1.0, np.minimum(first, last)),
        np.where(has_peak, 1.0, np.maximum(first, last)),
    )


def _length_interval(*parts: Any) -> Interval:
    *intervals, _ = parts
    squares = [_square_interval(a) for a in intervals]
    return np.sqrt(sum(s[0] for s in squares)), np.sqrt(sum(s[1] for s in squares))


def _arc_tangent_interval(y: Interval, x: Interval, k: float = 0.0) -> Interval:
    """Range of the angle of (x, y): everything where the box meets the cut or the origin."""
    corners = [np.arctan2(p, q) for p in y for q in x]
    cut = (x[0] <= 0) & (y[0] <= 0) & (y[1] >= 0)
    return (
        np.where(cut, -np.pi, np.minimum.reduce(corners)),
        np.where(cut, np.pi, np.maximum.reduce(corners)),
    )


def _select_interval(a: Interval, b: Interval, c: Interval, k: float = 0.0) -> Interval:
    low = np.where(a[1] < 0, b[0], np.where(a[0] >= 0, c[0], np.minimum(b[0], c[0])))
    high = np.where(a[1] < 0, b[1], np.where(a[0] >= 0, c[1], np.maximum(b[1], c[1])))
    return low, high


def _clamped(rule: Callable[[Array], Array], least: float, most: float) -> _Rule:
    """Interval rule of a rising function that is defined from `least` to `most`; arguments beyond are clamped."""

    def interval(a: Interval, k: float) -> Interval:
        return rule(np.clip(a[0], least, most)), rule(np.clip(a[1], least, most))

    return interval


def _smooth_minimum(a: Array, b: Array, k: float) -> Array:
    """Quadratic smooth minimum: min(a, b) − h² k / 4 with h = max(k − |a − b|, 0) / k.

    Source: Quílez, "smooth minimum", quadratic polynomial; equal to the minimum where |a − b| ≥ k.
    """
    h = np.maximum(k - np.abs(a - b), 0.0) / k
    return np.minimum(a, b) - h * h * (k / 4)


def _smooth_share(a: Array, b: Array, k: float) -> Array:
    """Derivative of the smooth minimum by its first argument."""
    return np.clip(0.5 - (a - b) / (2 * k), 0.0, 1.0)


def _smooth_maximum(a: Array, b: Array, k: float) -> Array:
    return -_smooth_minimum(-a, -b, k)


def _rising(rule: Callable[..., Array]) -> _Rule:
    """Interval rule of a function that rises, or stays, with each of its arguments."""

    def interval(*arguments: Any) -> Interval:
        *intervals, k = arguments
        # Equal infinities on both sides of a smooth minimum have no difference.
        with np.errstate(invalid="ignore"):
            low = rule(*(a[0] for a in intervals), k)
            high = rule(*(a[1] for a in intervals), k)
        return np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high)

    return interval


def _root(a: Array) -> Array:
    return np.asarray(np.sqrt(np.maximum(a, 0.0)))


def _safe_quotient(a: Array, b: Array) -> Array:
    """a / b, and 0 where b is 0: the derivative of a length at the point where it has none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        quotient: Array = np.where(b == 0, 0.0, a / b)
    return quotient


def _largest(constants: Any, intervals: Any, k: float) -> Array:
    largest: Array = np.maximum.reduce([np.asarray(c, float) for c in constants])
    return largest


def _total(constants: Any, intervals: Any, k: float) -> Array:
    return np.asarray(sum(constants), float)


def _joint(constants: Any, intervals: Any, k: float) -> Array:
    """Lipschitz constant of the length of a vector of such parts."""
    return np.asarray(np.sqrt(sum(np.square(c) for c in constants)))


def _unbounded(constants: Any, intervals: Any, k: float) -> Array:
    """No constant is known, but that of what does not change at all."""
    return np.where(_largest(constants, intervals, k) == 0, 0.0, np.inf)


def _scaled(factor: Any, constant: Any) -> Array:
    return _product(np.asarray(factor, float), np.asarray(constant, float))


def _divide_lipschitz(constants: Any, intervals: Any, k: float) -> Array:
    (p, q), (a, b) = constants, intervals
    inverse = _wide(_reciprocal(b))
    return _scaled(inverse, p) + _scaled(_scaled(_wide(a), _scaled(inverse, inverse)), q)


def _slope(rule: Callable[[Interval, float], Array]) -> _Rule:
    """Lipschitz rule of a function of one argument whose slope on an interval is at most `rule`."""

    def lipschitz(constants: Any, intervals: Any, k: float) -> Array:
        return _scaled(rule(intervals[0], k), constants[0])

    return lipschitz


def _root_slope(a: Interval, k: float) -> Array:
    with np.errstate(divide="ignore"):
        return np.asarray(0.5 / np.sqrt(np.maximum(a[0], 0.0)))


def _arc_slope(a: Interval, k: float) -> Array:
    with np.errstate(divide="ignore"):
        return np.asarray(1 / np.sqrt(np.maximum(1 - _wide(a) ** 2, 0.0)))


def _arc_tangent_lipschitz(constants: Any, intervals: Any, k: float) -> Array:
    with np.errstate(divide="ignore"):
        inverse = 1 / _length_interval(*intervals, k)[0]
    # Across the cut the angle jumps.
    y, x = intervals
    cut = (x[0] <= 0) & (y[0] <= 0) & (y[1] >= 0)
    return np.where(cut, _unbounded(constants, intervals, k), _scaled(inverse, _joint(constants, intervals, k)))


def _one(a: Interval, k: float) -> Array:
    return np.asarray(1.0)


OPERATORS: dict[str, Operator] = {}


def _add(name: str, arity: int, value: _Rule, interval: _Rule, partials: _Rule, lipschitz: _Rule, glsl: str) -> None:
    commutes = name in ("ADD", "MULTIPLY", "MINIMUM", "MAXIMUM", "LENGTH2", "SMOOTH_MINIMUM", "SMOOTH_MAXIMUM")
    code = getattr(opcodes, name)
    OPERATORS[name] = Operator(name, code, arity, value, interval, partials, lipschitz, glsl, commutes)


# Name, arguments, value, interval, partials, Lipschitz, GLSL. `v` is the value itself.
_add("CONSTANT", 0, lambda k: k, lambda k: (k, k), lambda v, k: (), lambda c, i, k: np.asarray(0.0), "{k}")
_add("COPY", 1, lambda a, k: a, lambda a, k: a, lambda a, v, k: (1.0,), _largest, "{a}")
_add("NEGATE", 1, lambda a, k: -a, lambda a, k: (-a[1], -a[0]), lambda a, v, k: (-1.0,), _largest, "-{a}")
_add(
    "ABSOLUTE", 1, lambda a, k: np.abs(a), _absolute_interval,
    lambda a, v, k: (np.where(a < 0, -1.0, 1.0),), _largest, "abs({a})",
)  # fmt: skip
_add(
    "SQUARE", 1, lambda a, k: a * a, _square_interval,
    lambda a, v, k: (2 * a,), _slope(lambda a, k: 2 * _wide(a)), "square({a})",
)  # fmt: skip
_add(
    "SQUARE_ROOT", 1, lambda a, k: _root(a), _rising(lambda a, k: _root(a)),
    lambda a, v, k: (_safe_quotient(np.asarray(0.5), v),), _slope(_root_slope), "sqrt(max({a}, 0.0))",
)  # fmt: skip
_add(
    "SINE", 1, lambda a, k: np.sin(a), lambda a, k: _wave_interval(a, np.pi / 2),
    lambda a, v, k: (np.cos(a),), _slope(_one), "sin({a})",
)  # fmt: skip
_add(
    "COSINE", 1, lambda a, k: np.cos(a), lambda a, k: _wave_interval(a, 0.0),
    lambda a, v, k: (-np.sin(a),), _slope(_one), "cos({a})",
)  # fmt: skip
_add(
    "ARC_SINE", 1, lambda a, k: np.arcsin(np.clip(a, -1, 1)), _clamped(np.arcsin, -1, 1),
    lambda a, v, k: (_safe_quotient(np.asarray(1.0), np.sqrt(np.maximum(1 - a * a, 0.0))),),
    _slope(_arc_slope), "asin(clamp({a}, -1.0, 1.0))",
)  # fmt: skip
_add(
    "ARC_COSINE", 1, lambda a, k: np.arccos(np.clip(a, -1, 1)),
    lambda a, k: (np.arccos(np.clip(a[1], -1, 1)), np.arccos(np.clip(a[0], -1, 1))),
    lambda a, v, k: (-_safe_quotient(np.asarray(1.0), np.sqrt(np.maximum(1 - a * a, 0.0))),),
    _slope(_arc_slope), "acos(clamp({a}, -1.0, 1.0))",
)  # fmt: skip
_add(
    "EXPONENTIAL", 1, lambda a, k: np.exp(a), _rising(lambda a, k: np.exp(a)),
    lambda a, v, k: (v,), _slope(lambda a, k: np.exp(a[1])), "exp({a})",
)  # fmt: skip
_add(
    "LOGARITHM", 1, lambda a, k: np.log(a), _rising(lambda a, k: np.log(np.maximum(a, 0.0))),
    lambda a, v, k: (1 / a,), _slope(lambda a, k: _wide(_reciprocal((np.maximum(a[0], 0.0), a[1])))), "log({a})",
)  # fmt: skip
_add(
    "FLOOR", 1, lambda a, k: np.floor(a), _rising(lambda a, k: np.floor(a)),
    lambda a, v, k: (np.zeros_like(a),), _unbounded, "floor({a})",
)  # fmt: skip
_add(
    "ROUND", 1, lambda a, k: np.rint(a), _rising(lambda a, k: np.rint(a)),
    lambda a, v, k: (np.zeros_like(a),), _unbounded, "roundEven({a})",
)  # fmt: skip
_add(
    "ADD", 2, lambda a, b, k: a + b, lambda a, b, k: (a[0] + b[0], a[1] + b[1]),
    lambda a, b, v, k: (1.0, 1.0), _total, "({a} + {b})",
)  # fmt: skip
_add(
    "SUBTRACT", 2, lambda a, b, k: a - b, lambda a, b, k: (a[0] - b[1], a[1] - b[0]),
    lambda a, b, v, k: (1.0, -1.0), _total, "({a} - {b})",
)  # fmt: skip
_add(
    "MULTIPLY", 2, lambda a, b, k: a * b, _multiply_interval,
    lambda a, b, v, k: (b, a), lambda c, i, k: _scaled(_wide(i[1]), c[0]) + _scaled(_wide(i[0]), c[1]), "({a} * {b})",
)  # fmt: skip
_add(
    "DIVIDE", 2, lambda a, b, k: a / b, _divide_interval,
    lambda a, b, v, k: (1 / b, -v / b), _divide_lipschitz, "({a} / {b})",
)  # fmt: skip
_add(
    "MINIMUM", 2, lambda a, b, k: np.minimum(a, b), _rising(lambda a, b, k: np.minimum(a, b)),
    lambda a, b, v, k: (np.where(a < b, 1.0, 0.0), np.where(a < b, 0.0, 1.0)), _largest, "min({a}, {b})",
)  # fmt: skip
_add(
    "MAXIMUM", 2, lambda a, b, k: np.maximum(a, b), _rising(lambda a, b, k: np.maximum(a, b)),
    lambda a, b, v, k: (np.where(a > b, 1.0, 0.0), np.where(a > b, 0.0, 1.0)), _largest, "max({a}, {b})",
)  # fmt: skip
_add(
    "LENGTH2", 2, lambda a, b, k: np.sqrt(a * a + b * b), _length_interval,
    lambda a, b, v, k: (_safe_quotient(a, v), _safe_quotient(b, v)), _joint, "length(vec2({a}, {b}))",
)  # fmt: skip
_add(
    "ARC_TANGENT", 2, lambda y, x, k: np.arctan2(y, x), _arc_tangent_interval,
    lambda y, x, v, k: (_safe_quotient(x, x * x + y * y), -_safe_quotient(y, x * x + y * y)),
    _arc_tangent_lipschitz, "atan({a}, {b})",
)  # fmt: skip
_add(
    "ADD_CONSTANT", 1, lambda a, k: a + k, lambda a, k: (a[0] + k, a[1] + k),
    lambda a, v, k: (1.0,), _largest, "({a} + {k})",
)  # fmt: skip
_add(
    "MULTIPLY_CONSTANT", 1, lambda a, k: a * k, lambda a, k: _multiply_interval(a, (np.asarray(k), np.asarray(k))),
    lambda a, v, k: (k,), _slope(lambda a, k: np.asarray(abs(k))), "({a} * {k})",
)  # fmt: skip
_add(
    "CONSTANT_MINUS", 1, lambda a, k: k - a, lambda a, k: (k - a[1], k - a[0]),
    lambda a, v, k: (-1.0,), _largest, "({k} - {a})",
)  # fmt: skip
_add(
    "CONSTANT_OVER", 1, lambda a, k: k / a, lambda a, k: _multiply_interval((np.asarray(k),) * 2, _reciprocal(a)),
    lambda a, v, k: (-v / a,), _slope(lambda a, k: abs(k) * _wide(_reciprocal(a)) ** 2), "({k} / {a})",
)  # fmt: skip
_add(
    "MINIMUM_CONSTANT", 1, lambda a, k: np.minimum(a, k), _rising(lambda a, k: np.minimum(a, k)),
    lambda a, v, k: (np.where(a < k, 1.0, 0.0),), _largest, "min({a}, {k})",
)  # fmt: skip
_add(
    "MAXIMUM_CONSTANT", 1, lambda a, k: np.maximum(a, k), _rising(lambda a, k: np.maximum(a, k)),
    lambda a, v, k: (np.where(a > k, 1.0, 0.0),), _largest, "max({a}, {k})",
)  # fmt: skip
_add(
    "SMOOTH_MINIMUM", 2, _smooth_minimum, _rising(_smooth_minimum),
    lambda a, b, v, k: (_smooth_share(a, b, k), 1 - _smooth_share(a, b, k)), _largest, "smoothMin({a}, {b}, {k})",
)  # fmt: skip
_add(
    "SMOOTH_MAXIMUM", 2, _smooth_maximum, _rising(_smooth_maximum),
    lambda a, b, v, k: (1 - _smooth_share(a, b, k), _smooth_share(a, b, k)), _largest, "smoothMax({a}, {b}, {k})",
)  # fmt: skip
_add(
    "LENGTH3", 3, lambda a, b, c, k: np.sqrt(a * a + b * b + c * c), _length_interval,
    lambda a, b, c, v, k: (_safe_quotient(a, v), _safe_quotient(b, v), _safe_quotient(c, v)),
    _joint, "length(vec3({a}, {b}, {c}))",
)  # fmt: skip
_add(
    "MULTIPLY_ADD", 3, lambda a, b, c, k: a * b + c,
    lambda a, b, c, k: tuple(p + q for p, q in zip(_multiply_interval(a, b), c, strict=True)),
    lambda a, b, c, v, k: (b, a, 1.0),
    lambda c, i, k: _scaled(_wide(i[1]), c[0]) + _scaled(_wide(i[0]), c[1]) + c[2], "({a} * {b} + {c})",
)  # fmt: skip
_add(
    "SELECT", 3, lambda a, b, c, k: np.where(a < 0, b, c), _select_interval,
    lambda a, b, c, v, k: (np.zeros_like(a), np.where(a < 0, 1.0, 0.0), np.where(a < 0, 0.0, 1.0)),
    # The arms need not meet where the choice turns; a shape that knows that they do says so.
    _unbounded, "({a} < 0.0 ? {b} : {c})",
)  # fmt: skip


def _table(name: str, arity: int) -> None:
    """An operator whose constant is a table of data, which knows all that is asked; GLSL has no spelling of tables."""
    _add(
        name, arity, lambda *a: a[-1].value(*a[:-1]), lambda *a: a[-1].interval(*a[:-1]),
        lambda *a: a[-1].partials(*a[:-2]), lambda c, i, k: _scaled(k.slope, _joint(c, i, k)), "",
    )  # fmt: skip


_table("OUTLINE", 2)
_table("GRID2", 2)
_table("GRID3", 3)
_table("MESH", 3)
