"""Intervals of sixteen regions at once: the rules that the interval interpreter applies.

A rule takes the low and high ends of its arguments as vectors, and gives those of its value, rounded outward. NaN at
an end means that nothing is known there.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import absolute, maximum, minimum, select, splat16, square_root

__all__ = [
    "absolute_interval",
    "downward",
    "length_interval",
    "multiply_interval",
    "reciprocal_interval",
    "upward",
]

# Outward steps, relative and absolute: more than the rounding of the few operations within a rule, contracted or not,
# and than the smallest normal number.
_STEP, _TINY = np.float32(2.0**-21), np.float32(1e-37)
_ZERO, _ONE, _INFINITY = np.float32(0), np.float32(1), np.float32(np.inf)


@device
def downward(v):
    """A number below all that round to `v`."""
    return v - (absolute(v) * splat16(_STEP) + splat16(_TINY))


@device
def upward(v):
    """A number above all that round to `v`."""
    return v + (absolute(v) * splat16(_STEP) + splat16(_TINY))


@device
def absolute_interval(low, high):
    """Ends of |a|; exact."""
    zero = splat16(_ZERO)
    p, q = absolute(low), absolute(high)
    return select((low <= zero) & (high >= zero), zero, minimum(p, q)), maximum(p, q)


@device
def _product(p, q):
    """p · q with 0 · ∞ = 0: a factor that is always zero."""
    product = p * q
    return select(product == product, product, splat16(_ZERO))


@device
def multiply_interval(a_low, a_high, b_low, b_high):
    """Ends of a · b."""
    p, q = _product(a_low, b_low), _product(a_low, b_high)
    r, s = _product(a_high, b_low), _product(a_high, b_high)
    return downward(minimum(minimum(p, q), minimum(r, s))), upward(maximum(maximum(p, q), maximum(r, s)))


@device
def reciprocal_interval(low, high):
    """Ends of 1 / b: everything where b may be zero."""
    zero, one, infinity = splat16(_ZERO), splat16(_ONE), splat16(_INFINITY)
    # Where one end's reciprocal overflows, its outward step is NaN, which the comparisons put aside.
    holds_zero = (low <= zero) & (high >= zero)
    least = maximum(downward(one / high), splat16(-_INFINITY))
    most = minimum(upward(one / low), infinity)
    return select(holds_zero, splat16(-_INFINITY), least), select(holds_zero, infinity, most)


@device
def length_interval(a_low, a_high, b_low, b_high, c_low, c_high):
    """Ends of √(a² + b² + c²)."""
    p, q = absolute_interval(a_low, a_high)
    r, s = absolute_interval(b_low, b_high)
    t, u = absolute_interval(c_low, c_high)
    return downward(square_root(p * p + r * r + t * t)), upward(square_root(q * q + s * s + u * u))
