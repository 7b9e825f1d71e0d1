"""Arithmetic whose errors are known: sums and products with their rounding errors, pairs of doubles, and the sign of a
determinant in whole numbers.

A pair (h, l) stands for h + l with |l| <= ulp(h) / 2, some 106 bits. Sums and products of pairs err by less than
2^-102 of the result, if nothing overflows or underflows (Joldes, Muller, Popescu, "Tight and rigorous error bounds for
basic building blocks of double-word arithmetic", 2017, algorithms 6 and 12).
"""

from __future__ import annotations

import math

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.jit import exact_apart, exact_device

__all__ = [
    "determinant_sign",
    "fused",
    "lowest_place",
    "pair_add",
    "pair_multiply",
    "pair_subtract",
    "two_difference",
    "two_product",
    "two_sum",
]

_F64 = ir.DoubleType()

# The accumulator of `determinant_sign`: 28 bits a limb, from 5 * -1126 to 5 * 1024 binary places and a few more.
_RADIX_BITS = np.int64(28)
_RADIX_MASK = np.int64((1 << 28) - 1)
_LEAST_EXPONENT = np.int64(1126)
_LIMBS = 400
_PRODUCT_LIMBS = 12
_MOST_ROWS = 5
_MANTISSA = 9007199254740992.0

_EXPONENT_MASK = np.int64(2047)
_LEADING_BIT = np.int64(1 << 52)
_FRACTION_MASK = np.int64((1 << 52) - 1)
_NO_PLACE = np.int64(1100)


@intrinsic
def fused(typingctx, a, b, c):
    """a * b + c, rounded once."""

    def codegen(context, builder, signature, args):
        kind = ir.FunctionType(_F64, [_F64] * 3)
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.fma.f64"), args)

    return types.float64(types.float64, types.float64, types.float64), codegen


@intrinsic
def _bits_of(typingctx, x):
    """The bits of a double as an int64."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), codegen


@intrinsic
def _zeros_below(typingctx, x):
    """The number of zero bits below the lowest set one of an int64; 64 for none."""

    def codegen(context, builder, signature, args):
        return builder.cttz(args[0], ir.IntType(1)(0))

    return types.int64(types.int64), codegen


@exact_device
def two_sum(a, b):
    """(s, e): s = fl(a + b), s + e = a + b."""
    s = a + b
    from_b = s - a
    return s, (a - (s - from_b)) + (b - from_b)


@exact_device
def two_difference(a, b):
    """(s, e): s = fl(a - b), s + e = a - b."""
    s = a - b
    from_b = a - s
    return s, (a - (s + from_b)) + (from_b - b)


@exact_device
def two_product(a, b):
    """(p, e): p = fl(a b), p + e = a b unless e underflows."""
    p = a * b
    return p, fused(a, b, -p)


@exact_device
def _normal(h, l):
    s = h + l
    return s, l - (s - h)


@exact_device
def pair_add(a, b):
    """The sum of two pairs."""
    h, e = two_sum(a[0], b[0])
    l, f = two_sum(a[1], b[1])
    h, e = _normal(h, e + l)
    return _normal(h, f + e)


@exact_device
def pair_subtract(a, b):
    """The difference of two pairs."""
    return pair_add(a, (-b[0], -b[1]))


@exact_device
def pair_multiply(a, b):
    """The product of two pairs."""
    h, e = two_product(a[0], b[0])
    return _normal(h, e + (fused(a[0], b[1], a[1] * b[0]) + a[1] * b[1]))


@exact_device
def lowest_place(x):
    """The k for which 2^k is the lowest set bit of a finite double; 1100 for 0."""
    bits = _bits_of(x)
    exponent = (bits >> 52) & _EXPONENT_MASK
    mantissa = bits & _FRACTION_MASK
    if exponent != 0:
        return exponent - 1075 + _zeros_below(mantissa | _LEADING_BIT)
    if mantissa != 0:
        return _zeros_below(mantissa) - 1074
    return _NO_PLACE


@exact_device
def _multiply_limbs(product, count, factor):
    """Multiply a number of `count` limbs by |factor| < 2^56."""
    magnitude = abs(factor)
    low = magnitude & _RADIX_MASK
    high = magnitude >> _RADIX_BITS
    carry = np.int64(0)
    before = np.int64(0)
    for k in range(count + 2):
        limb = product[k]
        carry += limb * low + before * high
        product[k] = carry & _RADIX_MASK
        carry >>= _RADIX_BITS
        before = limb


@exact_device
def _accumulate(total, product, count, exponent, negative):
    """Add a number of `count` limbs times 2^exponent, exponent >= 0, to the total, whose limbs may exceed the radix."""
    first = exponent // _RADIX_BITS
    shift = exponent - first * _RADIX_BITS
    for k in range(count):
        limb = product[k] << shift
        if negative:
            total[first + k] -= limb & _RADIX_MASK
            total[first + k + 1] -= limb >> _RADIX_BITS
        else:
            total[first + k] += limb & _RADIX_MASK
            total[first + k + 1] += limb >> _RADIX_BITS


@exact_device
def _add_product(total, product, mantissas, exponents, factors, count, negative):
    """Add a product of `count` of the numbers to the total."""
    product[:] = 0
    product[0] = 1
    exponent = np.int64(0)
    limbs = 1
    for k in range(count):
        mantissa = mantissas[factors[k]]
        if mantissa == 0:
            return
        negative ^= mantissa < 0
        _multiply_limbs(product, limbs, mantissa)
        limbs += 2
        exponent += exponents[factors[k]] + _LEAST_EXPONENT
    _accumulate(total, product, limbs, exponent, negative)


@exact_device
def _total_sign(total):
    carry = np.int64(0)
    any_set = np.int64(0)
    for k in range(len(total)):
        carry += total[k]
        any_set |= carry & _RADIX_MASK
        carry >>= _RADIX_BITS
    if carry < 0:
        return np.int64(-1)
    return np.int64(1) if (any_set | carry) != 0 else np.int64(0)


@exact_device
def _arrange(number, order, rows):
    """Write the permutation of this number, of the first `rows` numbers; returns whether it is odd."""
    for i in range(rows):
        order[i] = i
    odd = False
    for i in range(rows - 1, 0, -1):
        j = number % (i + 1)
        number //= i + 1
        if i != j:
            order[i], order[j] = order[j], order[i]
            odd = not odd
    return odd


@exact_device
def determinant_sign(points, dimension, lifted):
    """The sign of a determinant, in whole numbers: right for all finite doubles.

    `points` is a tuple of coordinates, `dimension` for each point. The columns of the matrix are the coordinates, the
    sum of their squares if `lifted`, and ones if there are more points than these; it has 5 rows at most. Expands the
    determinant into products and adds them up in fixed point: microseconds, for what filters could not decide.
    """
    coordinates = np.empty(len(points))
    for i in range(len(points)):
        coordinates[i] = points[i]
    return _array_sign(coordinates, dimension, lifted)


@exact_apart
def _array_sign(points, dimension, lifted):
    rows = len(points) // dimension
    total = np.zeros(_LIMBS, np.int64)
    product = np.empty(_PRODUCT_LIMBS, np.int64)
    mantissas = np.empty(rows * dimension, np.int64)
    exponents = np.empty(rows * dimension, np.int64)
    order = np.empty(_MOST_ROWS, np.int64)
    factors = np.empty(_MOST_ROWS, np.int64)
    for i in range(rows * dimension):
        fraction, exponent = math.frexp(points[i])
        mantissas[i] = np.int64(fraction * _MANTISSA)
        exponents[i] = exponent - 53
    permutations = 1
    for i in range(2, rows + 1):
        permutations *= i
    for number in range(permutations):
        odd = _arrange(number, order, rows)
        for axis in range(dimension):
            factors[axis] = order[axis] * dimension + axis
        if not lifted:
            _add_product(total, product, mantissas, exponents, factors, dimension, odd)
            continue
        for axis in range(dimension):
            factors[dimension] = factors[dimension + 1] = order[dimension] * dimension + axis
            _add_product(total, product, mantissas, exponents, factors, dimension + 2, odd)
    return _total_sign(total)
