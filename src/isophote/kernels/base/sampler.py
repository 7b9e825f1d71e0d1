"""Patterns of sample points: two numbers in [0, 1) for each (pixel, sample, dimension).

The samples of one pixel and one dimension make a point set over the unit square; sets of different dimensions are
padded, that is, shuffled against each other.

    INDEPENDENT   every point by itself
    JITTERED      one point in each cell of a grid of about √n × √n cells
    SOBOL         Owen-scrambled Sobol points: any 2^k consecutive ones fill the square evenly at every scale
                  (Burley: "Practical Hash-based Owen Scrambling", JCGT 10(4), 2020)

The loops are over plain arrays, so that the compiler does eight at a time.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.random import combine, mix, owen, permute, reverse_bits, sobol_1, unit_float

__all__ = ["INDEPENDENT", "JITTERED", "SOBOL", "draw_pairs", "pair"]

INDEPENDENT = 0
JITTERED = 1
SOBOL = 2

_U = np.uint32
_ONE_BELOW = np.float32(1 - 2.0**-24)


@device
def _independent_pair(key, sample):
    a = mix(_U(key ^ _U(sample * _U(0x9E3779B1))))
    return unit_float(a), unit_float(mix(_U(a ^ _U(0x68BC21EB))))


@device
def _sobol_pair(key, sample):
    index = reverse_bits(owen(reverse_bits(sample), key))
    u = reverse_bits(owen(index, mix(_U(key ^ _U(0xA511E9B3)))))
    v = reverse_bits(owen(sobol_1(index), mix(_U(key ^ _U(0x63D83595)))))
    return unit_float(u), unit_float(v)


@device
def _jittered_pair(key, sample, count):
    """Cell `permute(sample)` of a columns × rows grid with columns · rows ≥ count, jittered inside."""
    columns = _U(np.ceil(np.sqrt(np.float64(count))))
    rows = _U((count + columns - _U(1)) // columns)
    block = _U(columns * rows)
    turn = _U(sample // block)
    cell = permute(_U(sample % block), block, combine(key, turn))
    u, v = _independent_pair(_U(key ^ _U(0x02E5BE93)), sample)
    x = (np.float32(np.int32(_U(cell % columns))) + u) / np.float32(np.int32(columns))
    y = (np.float32(np.int32(_U(cell // columns))) + v) / np.float32(np.int32(rows))
    return min(x, _ONE_BELOW), min(y, _ONE_BELOW)


@device
def pair(pattern, seed, pixel, sample, count, dimension):
    """The two numbers of one (pixel, sample, dimension); `count` is the number of samples planned for a pixel."""
    key = combine(combine(_U(seed), _U(pixel)), _U(dimension))
    if pattern == SOBOL:
        return _sobol_pair(key, _U(sample))
    if pattern == JITTERED:
        return _jittered_pair(key, _U(sample), _U(count))
    return _independent_pair(key, _U(sample))


@device
def draw_pairs(pattern, seed, pixels, samples, count, dimension, n, out_u, out_v):
    """`pair` for the first `n` of the (pixel, sample) given, into `out_u` and `out_v`."""
    seed, dimension, count = _U(seed), _U(dimension), _U(count)
    if pattern == SOBOL:
        for i in range(n):
            key = combine(combine(seed, pixels[i]), dimension)
            out_u[i], out_v[i] = _sobol_pair(key, samples[i])
    elif pattern == JITTERED:
        for i in range(n):
            key = combine(combine(seed, pixels[i]), dimension)
            out_u[i], out_v[i] = _jittered_pair(key, samples[i], count)
    else:
        for i in range(n):
            key = combine(combine(seed, pixels[i]), dimension)
            out_u[i], out_v[i] = _independent_pair(key, samples[i])
