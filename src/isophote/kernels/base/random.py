"""Random numbers that are counted, not drawn: pure functions of (seed, pixel, sample, dimension).

Nothing has a state, so tiles, threads and machines cannot change a picture. Numba promotes the product of two
uint32 to uint64, hence the casts after every step.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device

__all__ = ["combine", "mix", "owen", "permute", "reverse_bits", "sobol_1", "unit_float"]

_U = np.uint32
_TO_UNIT = np.float32(2.0**-24)


@device
def mix(x):
    """A bijection of the 32-bit integers in which every bit of `x` stirs all others (Wellons: "lowbias32", 2018)."""
    x = _U(x ^ (x >> _U(16)))
    x = _U(x * _U(0x7FEB352D))
    x = _U(x ^ (x >> _U(15)))
    x = _U(x * _U(0x846CA68B))
    return _U(x ^ (x >> _U(16)))


@device
def combine(a, b):
    """One 32-bit key made from two."""
    return mix(_U(_U(a * _U(0x9E3779B1)) ^ _U(b + _U(0x7F4A7C15))))


@device
def unit_float(x):
    """The upper 24 bits as a float in [0, 1)."""
    return np.float32(np.int32(x >> _U(8))) * _TO_UNIT


@device
def reverse_bits(x):
    """The 32 bits in the opposite order."""
    x = _U(((x >> _U(1)) & _U(0x55555555)) | ((x & _U(0x55555555)) << _U(1)))
    x = _U(((x >> _U(2)) & _U(0x33333333)) | ((x & _U(0x33333333)) << _U(2)))
    x = _U(((x >> _U(4)) & _U(0x0F0F0F0F)) | ((x & _U(0x0F0F0F0F)) << _U(4)))
    x = _U(((x >> _U(8)) & _U(0x00FF00FF)) | ((x & _U(0x00FF00FF)) << _U(8)))
    return _U((x >> _U(16)) | (x << _U(16)))


@device
def owen(x, key):
    """Owen's scramble of a number whose bits are in reverse order: each bit is flipped by what lies below it.

    Burley: "Practical Hash-based Owen Scrambling", JCGT 10(4), 2020, with Vegdahl's improved constants.
    """
    x = _U(x ^ _U(x * _U(0x3D20ADEA)))
    x = _U(x + key)
    x = _U(x * _U((key >> _U(16)) | _U(1)))
    x = _U(x ^ _U(x * _U(0x05526C56)))
    return _U(x ^ _U(x * _U(0x53A22864)))


@device
def sobol_1(index):
    """Second dimension of Sobol's sequence at `index`, with its bits in reverse order.

    Its generator matrix is Pascal's triangle modulo 2, which five masked shifts apply at once.
    """
    x = _U(index ^ ((index & _U(0xAAAAAAAA)) >> _U(1)))
    x = _U(x ^ ((x & _U(0xCCCCCCCC)) >> _U(2)))
    x = _U(x ^ ((x & _U(0xF0F0F0F0)) >> _U(4)))
    x = _U(x ^ ((x & _U(0xFF00FF00)) >> _U(8)))
    return _U(x ^ (x >> _U(16)))


@device
def permute(index, count, key):
    """Place of `index` in a permutation of 0 … count − 1 told by `key` (Kensler: "Correlated Multi-Jittered
    Sampling", Pixar 13-01, 2013)."""
    w = _U(count - _U(1))
    w = _U(w | (w >> _U(1)))
    w = _U(w | (w >> _U(2)))
    w = _U(w | (w >> _U(4)))
    w = _U(w | (w >> _U(8)))
    w = _U(w | (w >> _U(16)))
    i = index
    while True:
        i = _U(i ^ key)
        i = _U(i * _U(0xE170893D))
        i = _U(i ^ (key >> _U(16)))
        i = _U(i ^ ((i & w) >> _U(4)))
        i = _U(i ^ (key >> _U(8)))
        i = _U(i * _U(0x0929EB3F))
        i = _U(i ^ (key >> _U(23)))
        i = _U(i ^ ((i & w) >> _U(1)))
        i = _U(i * _U(_U(1) | (key >> _U(27))))
        i = _U(i * _U(0x6935FA69))
        i = _U(i ^ ((i & w) >> _U(11)))
        i = _U(i * _U(0x74DCB303))
        i = _U(i ^ ((i & w) >> _U(2)))
        i = _U(i * _U(0x9E501CC3))
        i = _U(i ^ ((i & w) >> _U(2)))
        i = _U(i * _U(0xC860A3DF))
        i = _U(i & w)
        i = _U(i ^ (i >> _U(5)))
        if i < count:
            return _U((i + key) % count)
