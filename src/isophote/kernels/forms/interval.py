"""Intervals of sixteen regions at once: the rules that the interval interpreter applies.

A rule takes the low and high ends of its arguments as vectors, and gives those of its value, rounded outward. NaN at
an end means that nothing is known there.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import absolute, floor, maximum, minimum, select, splat16, square_root
from isophote.kernels.base.simd_math import arc_cosine, arc_sine, arc_tangent, exponential, logarithm

__all__ = [
    "absolute_interval",
    "arc_cosine_interval",
    "arc_sine_interval",
    "arc_tangent_interval",
    "downward",
    "exponential_interval",
    "length_interval",
    "logarithm_interval",
    "multiply_interval",
    "reciprocal_interval",
    "upward",
    "wave_interval",
]

# Outward steps, relative and absolute: more than the rounding of the few operations within a rule, contracted or not,
# and than the smallest normal number.
_STEP, _TINY = np.float32(2.0**-21), np.float32(1e-37)
_ZERO, _ONE, _INFINITY = np.float32(0), np.float32(1), np.float32(np.inf)
_TURNS, _HALF, _HALF_TURN = np.float32(0.5 / np.pi), np.float32(0.5), np.float32(np.pi)


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
    # Squares of small numbers vanish.
    tiny = splat16(_TINY)
    low = square_root(maximum(p * p + r * r + t * t - tiny, splat16(_ZERO)))
    return downward(low), upward(square_root(q * q + s * s + u * u + tiny))


@device
def _below(v):
    """A number below what an elementary function gives where another of its results is `v`."""
    return downward(downward(v))


@device
def _above(v):
    return upward(upward(v))


@device
def wave_interval(low, high, first, last, shift):
    """Ends of sin t or cos t, which are `first` and `last` at the ends of t; the largest values are at t / 2π + `shift`
    whole.
    """
    # What rounding does to the number of turns, which for large numbers is more than one.
    least, most = low * splat16(_TURNS) + splat16(shift), high * splat16(_TURNS) + splat16(shift)
    least, most = _below(least) - splat16(_STEP), _above(most) + splat16(_STEP)
    half = splat16(_HALF)
    top, bottom = floor(most) >= least, floor(most - half) >= least - half
    one = splat16(_ONE)
    low_end, high_end = (
        maximum(_below(minimum(first, last)), splat16(-_ONE)),
        minimum(_above(maximum(first, last)), one),
    )
    endless = (splat16(-_INFINITY) >= low) | (high >= splat16(_INFINITY))
    return select(bottom | endless, splat16(-_ONE), low_end), select(top | endless, one, high_end)


@device
def arc_sine_interval(low, high):
    """Ends of arcsin a."""
    return _below(arc_sine(low)), _above(arc_sine(high))


@device
def arc_cosine_interval(low, high):
    """Ends of arccos a, which falls."""
    return _below(arc_cosine(high)), _above(arc_cosine(low))


@device
def exponential_interval(low, high):
    """Ends of eᵃ."""
    return _below(exponential(low)), _above(exponential(high))


@device
def logarithm_interval(low, high):
    """Ends of ln a."""
    zero = splat16(_ZERO)
    return _below(logarithm(maximum(low, zero))), _above(logarithm(maximum(high, zero)))


@device
def arc_tangent_interval(y_low, y_high, x_low, x_high):
    """Ends of the angle of (x, y): everything where the box meets the cut or the origin."""
    zero = splat16(_ZERO)
    # Where the box is first and last seen from the origin, going round it anticlockwise.
    x = select(y_low >= zero, x_high, x_low)
    low = arc_tangent(select(x >= zero, y_low, y_high), x)
    x = select(y_high <= zero, x_high, x_low)
    high = arc_tangent(select(x >= zero, y_high, y_low), x)
    cut = (x_low <= zero) & (y_low <= zero) & (y_high >= zero)
    turn = splat16(_HALF_TURN)
    return _below(select(cut, zero - turn, low)), _above(select(cut, turn, high))
