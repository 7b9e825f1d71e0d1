"""Functions of values, named as in NumPy where NumPy has them."""

from __future__ import annotations

from isophote.shapes.field.expression import Number, Value

__all__ = [
    "absolute",
    "arccos",
    "arcsin",
    "arctan2",
    "clip",
    "cos",
    "exp",
    "floor",
    "length",
    "log",
    "maximum",
    "minimum",
    "rint",
    "select",
    "sin",
    "smooth_maximum",
    "smooth_minimum",
    "sqrt",
]


def _value(*numbers: Number) -> Value:
    """The first of these that is a value."""
    return next(n for n in numbers if isinstance(n, Value))


def absolute(a: Value) -> Value:
    """|a|."""
    return abs(a)


def sqrt(a: Value) -> Value:
    """√a, 0 where a is negative."""
    return a.graph.apply("SQUARE_ROOT", a)


def sin(a: Value) -> Value:
    """sin a."""
    return a.graph.apply("SINE", a)


def cos(a: Value) -> Value:
    """cos a."""
    return a.graph.apply("COSINE", a)


def arcsin(a: Value) -> Value:
    """Angle in [−π/2, π/2] whose sine is a, clamped to [−1, 1]."""
    return a.graph.apply("ARC_SINE", a)


def arccos(a: Value) -> Value:
    """Angle in [0, π] whose cosine is a, clamped to [−1, 1]."""
    return a.graph.apply("ARC_COSINE", a)


def exp(a: Value) -> Value:
    """e to the a."""
    return a.graph.apply("EXPONENTIAL", a)


def log(a: Value) -> Value:
    """Natural logarithm."""
    return a.graph.apply("LOGARITHM", a)


def floor(a: Value) -> Value:
    """Largest whole number ≤ a."""
    return a.graph.apply("FLOOR", a)


def rint(a: Value) -> Value:
    """Nearest whole number, the even one of two."""
    return a.graph.apply("ROUND", a)


def arctan2(y: Number, x: Number) -> Value:
    """Angle of (x, y) in (−π, π]."""
    return _value(y, x).graph.apply("ARC_TANGENT", y, x)


def _bound(name: str, a: Number, b: Number) -> Value:
    value = _value(a, b)
    other = b if value is a else a
    k = other.constant if isinstance(other, Value) else float(other)
    if k is not None:
        return value.graph.apply(f"{name}_CONSTANT", value, constant=k)
    if value.constant is not None:
        return _bound(name, other, value.constant)
    return value if isinstance(other, Value) and other.id == value.id else value.graph.apply(name, value, other)


def minimum(a: Number, b: Number) -> Value:
    """The smaller of two."""
    return _bound("MINIMUM", a, b)


def maximum(a: Number, b: Number) -> Value:
    """The larger of two."""
    return _bound("MAXIMUM", a, b)


def clip(a: Value, low: Number, high: Number) -> Value:
    """a, brought between low and high."""
    return minimum(maximum(a, low), high)


def length(*parts: Value) -> Value:
    """Length of a vector with two or three parts."""
    return parts[0].graph.apply(f"LENGTH{len(parts)}", *parts)


def select(condition: Value, negative: Number, other: Number) -> Value:
    """`negative` where the condition is below 0, else `other`."""
    return condition.graph.apply("SELECT", condition, negative, other)


def smooth_minimum(a: Value, b: Value, k: Number) -> Value:
    """Quadratic smooth minimum, equal to the minimum where |a − b| ≥ k; k = 0 is the minimum itself."""
    constant = k.constant if isinstance(k, Value) else float(k)
    if constant is None:
        h = maximum(k - abs(a - b), 0.0) / k
        return minimum(a, b) - h * h * (k * 0.25)
    return minimum(a, b) if constant == 0 else a.graph.apply("SMOOTH_MINIMUM", a, b, constant=constant)


def smooth_maximum(a: Value, b: Value, k: Number) -> Value:
    """Quadratic smooth maximum, equal to the maximum where |a − b| ≥ k."""
    constant = k.constant if isinstance(k, Value) else float(k)
    if constant is None:
        return -smooth_minimum(-a, -b, k)
    return maximum(a, b) if constant == 0 else a.graph.apply("SMOOTH_MAXIMUM", a, b, constant=constant)
