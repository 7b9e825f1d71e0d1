"""Patterns of sample points: two numbers in [0, 1) for each (pixel, sample, dimension).

The samples of one pixel and one dimension make a point set over the unit square; sets of different dimensions are
padded, that is, shuffled against each other.

    INDEPENDENT   every point by itself
    JITTERED      one point in each cell of a grid of about √n × √n cells
    REGULAR       the middles of those cells
    SOBOL         Owen-scrambled Sobol points: any 2^k consecutive ones fill the square evenly at every scale
                  (Burley: "Practical Hash-based Owen Scrambling", JCGT 10(4), 2020)
    BLUE_NOISE    one Owen-scrambled Sobol sequence for all pixels, dealt out along a shuffled Morton curve: pixels
                  side by side share out a well-spread set, so that their errors cancel from near, and noise is blue
                  (Ahmed, Wonka: "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical
                  Ordering of Pixels", SIGGRAPH Asia 2020)
    ANTITHETIC    on the film one point in each cell of a grid, at places that are mirrored from cell to cell: of two
                  neighbours that an edge or a slope goes through, one has too much and one too little (Haber: "A
                  Modified Monte-Carlo Quadrature II", Math. Comp. 21, 1967; Kensler: "Correlated Multi-Jittered
                  Sampling", Pixar 13-01, 2013); in all other dimensions as BLUE_NOISE

Pixels are numbered by `pixel_number`, so that pixels of near numbers are near. Loops are over plain arrays, and what
they call is inlined however long it is, so that the compiler does eight at a time.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, exact_inline
from isophote.kernels.base.random import combine, mix, owen, permute, reverse_bits, sobol_1, unit_float

__all__ = [
    "ANTITHETIC",
    "BLUE_NOISE",
    "INDEPENDENT",
    "JITTERED",
    "REGULAR",
    "SOBOL",
    "draw_pairs",
    "pair",
    "pixel_number",
]

INDEPENDENT = 0
JITTERED = 1
SOBOL = 2
REGULAR = 3
BLUE_NOISE = 4
ANTITHETIC = 5

_U = np.uint32
_HALF = np.float32(0.5)
_ONE_BELOW = np.float32(1 - 2.0**-24)
_EVEN_BITS = _U(0x55555555)
_FILM = 0
# Beyond so many, which nobody plans but those who wait for a noise or a time, cells would be too small to be filled.
_MOST_CELLS = 4096


@device
def _independent_pair(key, sample):
    a = mix(_U(key ^ _U(sample * _U(0x9E3779B1))))
    return unit_float(a), unit_float(mix(_U(a ^ _U(0x68BC21EB))))


@device
def _spread(a):
    """The low 16 bits of `a` with a zero above each."""
    a = _U(a & _U(0xFFFF))
    a = _U((a | (a << _U(8))) & _U(0x00FF00FF))
    a = _U((a | (a << _U(4))) & _U(0x0F0F0F0F))
    a = _U((a | (a << _U(2))) & _U(0x33333333))
    return _U((a | (a << _U(1))) & _EVEN_BITS)


@device
def pixel_number(x, y):
    """Number of a pixel along Morton's curve, in 32 bits: beyond 65,536 pixels patterns come again."""
    return _U(_spread(_U(x)) | (_spread(_U(y)) << _U(1)))


@exact_inline
def _sobol_point(index, key):
    """Point of an Owen-scrambled Sobol sequence, whose order is shuffled too; `index` has its bits in reverse order."""
    index = reverse_bits(owen(index, key))
    u = reverse_bits(owen(index, mix(_U(key ^ _U(0xA511E9B3)))))
    v = reverse_bits(owen(sobol_1(index), mix(_U(key ^ _U(0x63D83595)))))
    return unit_float(u), unit_float(v)


@device
def _sobol_pair(key, sample):
    return _sobol_point(reverse_bits(sample), key)


@exact_inline
def _turned(number, key):
    """A pixel's number by another curve: at every scale rows, columns or diagonals of four squares come together.

    With the flips of Owen's scramble, which follows, all 24 orders of the four are possible.
    """
    a, b = mix(_U(key ^ _U(0x1B56C4E9))), mix(_U(key ^ _U(0x3C6EF372)))
    swaps = _U(a & _U(b | (b >> _U(1))) & _EVEN_BITS)
    x, y = _U(number & _EVEN_BITS), _U((number >> _U(1)) & _EVEN_BITS)
    y = _U(y ^ (x & (a >> _U(1))))
    changes = _U((x ^ y) & swaps)
    return _U(_U((y ^ changes) << _U(1)) | _U(x ^ changes))


@device
def _power_above(count):
    """The least power of two that is not below `count`."""
    power = np.int64(1)
    while power < np.int64(count):
        power *= 2
    return _U(power)


@exact_inline
def _blue_noise_pair(key, pixel, sample, block):
    """Each pixel takes `block` points in a row, a power of two. The 32 bits of a place in the sequence are enough for a
    square of 2^32 / `block` pixels; other squares, and samples beyond a block, have sequences of their own."""
    within = _U(block - _U(1))
    # Products instead of shifts, so that the compiler does eight at a time.
    square = _U((np.uint64(pixel) * np.uint64(block)) >> np.uint64(32))
    key = _U(key ^ mix(_U(square ^ _U(_U(sample & _U(~within)) * _U(0x9E3779B1)))))
    index = _U(_U(_turned(pixel, key) * block) | _U(sample & within))
    return _sobol_point(reverse_bits(index), key)


@device
def _within(cell, offset, cells):
    return min((np.float32(np.int32(cell)) + offset) / np.float32(np.int32(cells)), _ONE_BELOW)


@exact_inline
def _packed(a):
    """The even bits of `a` side by side."""
    a = _U(a & _EVEN_BITS)
    a = _U((a | (a >> _U(1))) & _U(0x33333333))
    a = _U((a | (a >> _U(2))) & _U(0x0F0F0F0F))
    a = _U((a | (a >> _U(4))) & _U(0x00FF00FF))
    return _U((a | (a >> _U(8))) & _U(0xFFFF))


@exact_inline
def _mirrored(u, odd):
    return _ONE_BELOW - u if odd & _U(1) else u


@device
def _takes_grid(pattern, count, dimension):
    return pattern == ANTITHETIC and dimension == _FILM and count <= _MOST_CELLS


@device
def _grid(block):
    """(columns, rows, places) of the grid of `block` cells, a power of two, and the places that a pixel takes: one for
    two columns and two rows."""
    columns = _U(1)
    while _U(columns * columns) < block:
        columns = _U(columns * _U(2))
    return columns, _U(block // columns), _U(max(columns >> _U(1), _U(1)))


@exact_inline
def _antithetic_pair(key, pixel, sample, block, columns, rows, places):
    """All cells of a row have one place across them, and all of a column one along them; the next row's or column's is
    its mirror image. A pixel takes the few places that this needs from one sequence for all, as blue noise does."""
    square = _U((np.uint64(pixel) * np.uint64(places)) >> np.uint64(32))
    key = _U(key ^ mix(_U(square ^ _U(_U(sample & _U(~_U(block - _U(1)))) * _U(0x9E3779B1)))))
    # Any 4^k samples in a row from a multiple of it on lie in as many squares of cells.
    order = owen(reverse_bits(sample), mix(_U(key ^ mix(_U(pixel ^ _U(0x7D2A4F1B))))))
    cell = _U((np.uint64(order) * np.uint64(block)) >> np.uint64(32))
    column, row = _packed(cell), _packed(_U(cell >> _U(1)))
    first = _U(_turned(pixel, key) * places)
    u = _sobol_point(reverse_bits(_U(first | (row >> _U(1)))), key)[0]
    v = _sobol_point(reverse_bits(_U(first | (column >> _U(1)))), key)[1]
    return _within(column, _mirrored(u, row), columns), _within(row, _mirrored(v, column), rows)


@device
def _cell(key, sample, count):
    """(column, row, columns, rows): cell `permute(sample)` of a grid with columns · rows ≥ count."""
    columns = _U(np.ceil(np.sqrt(np.float64(count))))
    rows = _U((count + columns - _U(1)) // columns)
    block = _U(columns * rows)
    turn = _U(sample // block)
    cell = permute(_U(sample % block), block, combine(key, turn))
    return _U(cell % columns), _U(cell // columns), columns, rows


@device
def _jittered_pair(key, sample, count):
    column, row, columns, rows = _cell(key, sample, count)
    u, v = _independent_pair(_U(key ^ _U(0x02E5BE93)), sample)
    return _within(column, u, columns), _within(row, v, rows)


@device
def _regular_pair(key, sample, count):
    column, row, columns, rows = _cell(key, sample, count)
    return _within(column, _HALF, columns), _within(row, _HALF, rows)


@device
def _key(seed, pixel, dimension):
    return combine(combine(seed, pixel), dimension)


@device
def pair(pattern, seed, pixel, sample, count, dimension):
    """The two numbers of one (pixel, sample, dimension); `count` is the number of samples planned for a pixel."""
    seed, pixel, sample, dimension = _U(seed), _U(pixel), _U(sample), _U(dimension)
    if _takes_grid(pattern, count, dimension):
        block = _power_above(count)
        columns, rows, places = _grid(block)
        return _antithetic_pair(combine(seed, dimension), pixel, sample, block, columns, rows, places)
    if pattern in (BLUE_NOISE, ANTITHETIC):
        return _blue_noise_pair(combine(seed, dimension), pixel, sample, _power_above(count))
    key = _key(seed, pixel, dimension)
    if pattern == SOBOL:
        return _sobol_pair(key, sample)
    if pattern == JITTERED:
        return _jittered_pair(key, sample, _U(count))
    if pattern == REGULAR:
        return _regular_pair(key, sample, _U(count))
    return _independent_pair(key, sample)


@device
def draw_pairs(pattern, seed, pixels, samples, count, dimension, n, out_u, out_v):
    """`pair` for the first `n` of the (pixel, sample) given, into `out_u` and `out_v`."""
    seed, dimension, count = _U(seed), _U(dimension), _U(count)
    key, block = combine(seed, dimension), _power_above(count)
    if _takes_grid(pattern, count, dimension):
        columns, rows, places = _grid(block)
        for i in range(n):
            out_u[i], out_v[i] = _antithetic_pair(key, pixels[i], samples[i], block, columns, rows, places)
    elif pattern in (BLUE_NOISE, ANTITHETIC):
        for i in range(n):
            out_u[i], out_v[i] = _blue_noise_pair(key, pixels[i], samples[i], block)
    elif pattern == SOBOL:
        for i in range(n):
            out_u[i], out_v[i] = _sobol_pair(_key(seed, pixels[i], dimension), samples[i])
    elif pattern == JITTERED:
        for i in range(n):
            out_u[i], out_v[i] = _jittered_pair(_key(seed, pixels[i], dimension), samples[i], count)
    elif pattern == REGULAR:
        for i in range(n):
            out_u[i], out_v[i] = _regular_pair(_key(seed, pixels[i], dimension), samples[i], count)
    else:
        for i in range(n):
            out_u[i], out_v[i] = _independent_pair(_key(seed, pixels[i], dimension), samples[i])
