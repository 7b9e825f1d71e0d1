"""Elementary functions of sixteen floats at once: sine, cosine, exponential, logarithm, arc functions.

Results are within two or three units in the last place; `sine` and `cosine` of any finite number, however large. NaN
yields NaN. Polynomials are minimax fits of ours to the functions named beside them.
"""

from __future__ import annotations

import math

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    bits,
    f32x16,
    floor,
    lane,
    maximum,
    minimum,
    round_even,
    select,
    splat16,
    square_root,
)

__all__ = ["arc_cosine", "arc_sine", "arc_tangent", "cosine", "exponential", "logarithm", "sine", "with_sign"]

_LANES = 16
_I32, _F64 = ir.IntType(32), ir.DoubleType()
_INTS, _DOUBLES = ir.VectorType(_I32, _LANES), ir.VectorType(_F64, _LANES)

_ZERO, _HALF, _ONE, _TWO, _FOUR = (np.float32(v) for v in (0, 0.5, 1, 2, 4))
_NAN, _INFINITY = np.float32(np.nan), np.float32(np.inf)
_QUARTER_TURN, _HALF_TURN = np.float32(np.pi / 2), np.float32(np.pi)

# (sin √z / √z − 1) / z, (cos √z − 1 + z / 2) / z², both for √z up to 0.855.
_SINE = tuple(np.float32(c) for c in (-0.16666667, 8.3333263e-3, -1.9838552e-4, 2.7113977e-6))
_COSINE = tuple(np.float32(c) for c in (0.041666668, -1.388888e-3, 2.4798683e-5, -2.7146075e-7))
# (arctan √z / √z − 1) / z for √z up to tan(π / 8), and (arcsin √z / √z − 1) / z for √z up to 1/2.
_ARC_TANGENT = tuple(np.float32(c) for c in (-0.33333316, 0.1999849, -0.14243838, 0.105959155, -0.060832232))
_ARC_SINE = tuple(np.float32(c) for c in (0.1666666, 0.075005114, 0.044515695, 0.031817835, 0.014401718, 0.03756651))
# (eʳ − 1 − r) / r² for |r| up to ln 2 / 2, and (artanh √z / √z − 1) / z for z up to 0.0295.
_EXPONENTIAL = tuple(np.float32(c) for c in (0.5, 0.16666518, 0.041666206, 8.3689084e-3, 1.3950524e-3))
_ARTANH = tuple(np.float32(c) for c in (0.3333333, 0.20000167, 0.1426864, 0.11791383))

_TWO_OVER_PI = np.float32(2 / np.pi)
# Beyond, the number of quarter turns has too many bits for the product with the first part of π / 2 to be exact.
_MOST_TURNS = np.float32(2.0**19)
_EIGHTH_TURN, _TANGENT = np.float32(np.pi / 4), np.float32(math.tan(math.pi / 8))
# Numbers of which the sum might overflow are made smaller first.
_LARGE, _QUARTER = np.float32(1e38), np.float32(0.25)
# ln 2 in two parts, of which the first has bits to spare.
_LN2, _LN2_REST, _LOG2_E = np.float32(0.693359375), np.float32(math.log(2) - 0.693359375), np.float32(1 / math.log(2))
_LEAST_POWER, _MOST_POWER = np.float32(-105), np.float32(89)
_LEAST_NORMAL, _LIFT, _LIFTED = np.float32(2.0**-126), np.float32(2.0**24), np.float32(24)


def _on_vectors(count: int):
    """Make an intrinsic of `count` vectors with one vector as its result from what builds its instructions."""

    def wrap(build):
        if count == 1:

            @intrinsic
            def function(typingctx, a):
                return f32x16(a), lambda context, builder, sig, args: build(builder, *args)
        else:

            @intrinsic
            def function(typingctx, a, b):
                return f32x16(a, b), lambda context, builder, sig, args: build(builder, *args)

        return function

    return wrap


def _ints(value: int) -> ir.Constant:
    return ir.Constant(_INTS, [value] * _LANES)


def _doubles(value: float) -> ir.Constant:
    return ir.Constant(_DOUBLES, [value] * _LANES)


@_on_vectors(2)
def _less_quarter_turns(builder, x, n):
    """x − n · π / 2 for whole |n| < 2²⁰: π / 2 in two parts of double precision, the first of 33 bits."""
    turns = builder.fpext(n, _DOUBLES)
    first = builder.fmul(turns, _doubles(float.fromhex("0x1.921fb544p+0")))
    second = builder.fmul(turns, _doubles(float.fromhex("0x1.0b4611a626331p-34")))
    rest = builder.fsub(builder.fsub(builder.fpext(x, _DOUBLES), first), second)
    return builder.fptrunc(rest, x.type)


@_on_vectors(2)
def _times_power(builder, x, n):
    """x · 2ⁿ for whole n from −126 to 127."""
    biased = builder.add(builder.fptosi(n, _INTS), _ints(127))
    return builder.fmul(x, builder.bitcast(builder.shl(biased, _ints(23)), x.type))


# The bits of √½: mantissas are counted from there to √2.
_ROOT_HALF = 0x3F3504F3


@_on_vectors(1)
def _exponent(builder, x):
    """The whole n for which x / 2ⁿ lies between √½ and √2; x is positive and normal."""
    number = builder.sub(builder.bitcast(x, _INTS), _ints(_ROOT_HALF))
    return builder.sitofp(builder.ashr(number, _ints(23)), x.type)


@_on_vectors(1)
def _mantissa(builder, x):
    """x / 2ⁿ, between √½ and √2."""
    number = builder.bitcast(x, _INTS)
    above = builder.and_(builder.sub(number, _ints(_ROOT_HALF)), _ints(0xFF800000 - (1 << 32)))
    return builder.bitcast(builder.sub(number, above), x.type)


@_on_vectors(2)
def with_sign(builder, x, sign):
    """|x| with the sign bit of `sign`."""
    kind = ir.FunctionType(x.type, [x.type, x.type])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.copysign.v16f32"), [x, sign])


@intrinsic
def _with_lane(typingctx, v, i, x):
    """`v` with lane `i` replaced by `x`."""

    def codegen(context, builder, signature, args):
        return builder.insert_element(args[0], args[2], args[1])

    return f32x16(v, types.int32, types.float32), codegen


@device
def _series4(c, z):
    return ((splat16(c[3]) * z + splat16(c[2])) * z + splat16(c[1])) * z + splat16(c[0])


@device
def _series5(c, z):
    rest = (splat16(c[4]) * z + splat16(c[3])) * z + splat16(c[2])
    return (rest * z + splat16(c[1])) * z + splat16(c[0])


@device
def _wave(x, quarter):
    """sin(x + quarter · π / 2)."""
    n = round_even(x * splat16(_TWO_OVER_PI))
    r = _less_quarter_turns(x, n)
    z = r * r
    rising = r + r * z * _series4(_SINE, z)
    falling = splat16(_ONE) - z * splat16(_HALF) + z * z * _series4(_COSINE, z)
    n = n + splat16(quarter)
    place = n - splat16(_FOUR) * floor(n / splat16(_FOUR))
    odd = place - splat16(_TWO) * floor(place * splat16(_HALF))
    value = select(odd > splat16(_ZERO), falling, rising)
    value = select(place >= splat16(_TWO), splat16(_ZERO) - value, value)
    # Rounding must not take a sine beyond 1.
    return maximum(splat16(-_ONE), minimum(splat16(_ONE), value))


@device
def _far(x):
    """Lanes, as bits, where numbers are too large for the vectors' way, or not finite."""
    return bits(absolute(x) * splat16(_TWO_OVER_PI) <= splat16(_MOST_TURNS)) ^ np.int32(0xFFFF)


@device
def sine(x):
    """sin x."""
    value = _wave(x, _ZERO)
    far = _far(x)
    for i in range(_LANES if far != 0 else 0):
        if (far >> i) & 1 != 0:
            value = _with_lane(value, np.int32(i), np.float32(math.sin(np.float64(lane(x, np.int32(i))))))
    return value


@device
def cosine(x):
    """cos x."""
    value = _wave(x, _ONE)
    far = _far(x)
    for i in range(_LANES if far != 0 else 0):
        if (far >> i) & 1 != 0:
            value = _with_lane(value, np.int32(i), np.float32(math.cos(np.float64(lane(x, np.int32(i))))))
    return value


@device
def exponential(x):
    """eˣ."""
    # A NaN in the second argument stays.
    x = maximum(splat16(_LEAST_POWER), minimum(splat16(_MOST_POWER), x))
    n = select(x == x, round_even(x * splat16(_LOG2_E)), splat16(_ZERO))
    r = x - n * splat16(_LN2) - n * splat16(_LN2_REST)
    value = splat16(_ONE) + (r + r * r * _series5(_EXPONENTIAL, r))
    # In two steps, since the power alone may be beyond what a float holds.
    half = floor(n * splat16(_HALF))
    return _times_power(_times_power(value, half), n - half)


@device
def logarithm(x):
    """Natural logarithm: −∞ at 0, NaN below."""
    zero = splat16(_ZERO)
    small = x < splat16(_LEAST_NORMAL)
    lifted = select(small, x * splat16(_LIFT), x)
    e = _exponent(lifted) - select(small, splat16(_LIFTED), zero)
    f = _mantissa(lifted) - splat16(_ONE)
    s = f / (splat16(_TWO) + f)
    z = s * s
    rest = s * z * _series4(_ARTANH, z) * splat16(_TWO) + e * splat16(_LN2_REST)
    # 2 s = f − s f, in which the first, exact part is the larger.
    value = e * splat16(_LN2) + (f - (s * f - rest))
    value = select(x < splat16(_INFINITY), value, x)
    return select(x > zero, value, select(x == zero, splat16(-_INFINITY), splat16(_NAN)))


@device
def arc_tangent(y, x):
    """Angle of (x, y) in [−π, π], with the signs of zeros as in NumPy's arctan2."""
    zero, one = splat16(_ZERO), splat16(_ONE)
    p, q = absolute(x), absolute(y)
    scale = select(maximum(p, q) > splat16(_LARGE), splat16(_QUARTER), one)
    least, most = minimum(p, q) * scale, maximum(p, q) * scale
    # Infinities as ones, so that their quotient is one; and 0 / 0 is 0.
    endless = most == splat16(_INFINITY)
    least = select(endless, select(least == most, one, zero), least)
    most = select(endless, one, select(most == zero, one, most))
    steep = least > most * splat16(_TANGENT)
    t = select(steep, least - most, least) / select(steep, least + most, most)
    z = t * t
    angle = t + t * z * _series5(_ARC_TANGENT, z)
    angle = select(steep, splat16(_EIGHTH_TURN) + angle, angle)
    angle = select(q > p, splat16(_QUARTER_TURN) - angle, angle)
    angle = select(with_sign(one, x) < zero, splat16(_HALF_TURN) - angle, angle)
    return select((x == x) & (y == y), with_sign(angle, y), x + y)


@device
def _arc_sine_part(t, z):
    """arcsin of t = √z ≤ 1/2."""
    series = _series5(_ARC_SINE, z) + splat16(_ARC_SINE[5]) * z * z * z * z * z
    return t + t * z * series


@device
def _arc_sine_near(a):
    """|a| ≤ 1 as (whether |a| > 1/2, arcsin |a| or, where it is, arcsin √((1 − |a|) / 2))."""
    size = minimum(splat16(_ONE), absolute(a))
    large = size > splat16(_HALF)
    z = select(large, (splat16(_ONE) - size) * splat16(_HALF), size * size)
    return large, _arc_sine_part(select(large, square_root(z), size), z)


@device
def arc_sine(a):
    """Angle in [−π/2, π/2] whose sine is a, clamped to [−1, 1]."""
    large, part = _arc_sine_near(a)
    return with_sign(select(large, splat16(_QUARTER_TURN) - splat16(_TWO) * part, part), a)


@device
def arc_cosine(a):
    """Angle in [0, π] whose cosine is a, clamped to [−1, 1]."""
    large, part = _arc_sine_near(a)
    twice = splat16(_TWO) * part
    negative = a < splat16(_ZERO)
    far = select(negative, splat16(_HALF_TURN) - twice, twice)
    return select(large, far, splat16(_QUARTER_TURN) - select(negative, splat16(_ZERO) - part, part))
