"""What noises have in common: cells of the integer lattice, a hash of them, and how noise fades out of view.

The hash is of 32-bit integers and has no period: coordinates go in one after another, each stirred by itself. What is
exact here and in the noises rounds each operation by itself, so that the same place has the same bits on any machine.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, exact_device
from isophote.kernels.base.random import mix, unit_float
from isophote.kernels.base.vec import vec3
from isophote.kernels.texture.contract import DATA, OWN, OWN_A, OWN_B, answer

__all__ = [
    "answer_number",
    "cell_of",
    "corner_key",
    "datum",
    "edge_vector",
    "fade",
    "faded",
    "footprint",
    "fraction",
    "own_place",
    "quintic",
    "row_key",
    "seed_of",
    "sheet_key",
    "unit_of",
]

_U = np.uint32
_ZERO, _ONE, _TWO = np.float32(0), np.float32(1), np.float32(2)
# Beyond, floats are whole numbers; cells stay within 32 bits.
_FAR = np.float32(2.0**30)
# A table: which vector it is cannot be guessed, and branches would be guessed wrong.
_EDGES = np.array(
    [
        *((x, y, 0) for y in (1, -1) for x in (1, -1)),
        *((x, 0, z) for z in (1, -1) for x in (1, -1)),
        *((0, y, z) for z in (1, -1) for y in (1, -1)),
        *((1, 1, 0), (0, -1, 1), (-1, 1, 0), (0, -1, -1)),
    ],
    np.float32,
).reshape(-1)
_X, _Y, _Z = _U(0x8DA6B343), _U(0xD8163841), _U(0xCB1AB31F)


@exact_device
def fraction(x):
    """x − ⌊x⌋; 0 where x is not finite."""
    rest = x - np.floor(x)
    return rest if rest >= _ZERO else _ZERO


@exact_device
def cell_of(x):
    """(the whole number below x, the rest from 0 to 1); whatever x is."""
    below = np.floor(x)
    return np.int32(min(max(below, -_FAR), _FAR)), fraction(x)


@device
def sheet_key(k, seed):
    """Key of all lattice points with z = k."""
    return mix(_U(_U(_U(k) * _Z) ^ seed))


@device
def row_key(j, sheet):
    """Key of all lattice points of a sheet with y = j."""
    return mix(_U(_U(_U(j) * _Y) ^ sheet))


@device
def corner_key(i, row):
    """Key of the lattice point of a row with x = i."""
    return mix(_U(_U(_U(i) * _X) ^ row))


@device
def unit_of(key):
    """The number of a lattice point, from 0, below 1."""
    return unit_float(key)


@exact_device
def quintic(t):
    """6 t⁵ − 15 t⁴ + 10 t³ and its derivative: from 0 to 1 with two derivatives that vanish at both ends."""
    a = t * t
    weight = (a * t) * (t * (t * np.float32(6) - np.float32(15)) + np.float32(10))
    rest = t - _ONE
    return weight, (a * np.float32(30)) * (rest * rest)


@device
def edge_vector(key):
    """One of the twelve vectors to the middles of a cube's edges, four of them twice (Perlin 2002)."""
    at = np.int64(key >> _U(28)) * 3
    return _EDGES[at], _EDGES[at + 1], _EDGES[at + 2]


@device
def datum(place, k):
    """Number `k` of the node's data."""
    return place.textures.data[np.int64(place.textures.nodes[place.node, DATA]) + k]


@device
def seed_of(place, k):
    """The seed that lies in the node's data, in two halves from number `k` on."""
    return _U(_U(datum(place, k)) | (_U(datum(place, k + 1)) << _U(16)))


@device
def own_place(place):
    """The place in the texture's space, three floats."""
    record = place.record
    return record[OWN], record[OWN + 1], record[OWN + 2]


@device
def footprint(place):
    """The longest diameter of the ellipse that is looked at, in the texture's space."""
    record = place.record
    a = record[OWN_A] * record[OWN_A] + record[OWN_A + 1] * record[OWN_A + 1] + record[OWN_A + 2] * record[OWN_A + 2]
    b = record[OWN_B] * record[OWN_B] + record[OWN_B + 1] * record[OWN_B + 1] + record[OWN_B + 2] * record[OWN_B + 2]
    return _TWO * np.sqrt(max(a, b))


@exact_device
def fade(width, reach):
    """What is left of noise in a mean over `width`, if nothing is over `reach`: 1 at 0, and smoothly down to 0."""
    t = max(_ONE - width / reach, _ZERO)
    return t * t * (np.float32(3) - _TWO * t)


@exact_device
def faded(value, mean, width, reach):
    """A value of noise with this mean, as far as it can still be seen."""
    return mean + (value - mean) * fade(width, reach) if width > _ZERO else value


@device
def answer_number(place, number):
    """Leave a number, as a grey."""
    return answer(place, vec3(number, number, number), _ONE)
