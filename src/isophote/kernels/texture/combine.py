"""Textures made of others: constants, mixtures, colour ramps, and other places.

Where another space is looked at, the whole record is moved there and put back afterwards.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import load_vec3, store_vec3, vec3
from isophote.kernels.texture.contract import (
    AXIS_A,
    AXIS_B,
    CHILD_A,
    CHILD_B,
    CHILD_C,
    DATA,
    OWN,
    OWN_A,
    OWN_B,
    WORLD,
    WORLD_A,
    WORLD_B,
    U,
    V,
    answer,
    look_up,
    open_place,
)
from isophote.kernels.texture.lattice import datum

__all__ = [
    "CONSTANT",
    "LINEAR",
    "OF_OWN",
    "OF_UV",
    "OF_WORLD",
    "SMOOTH",
    "blend",
    "child",
    "constant",
    "placed",
    "ramp",
    "ramp_colour",
]

# Spaces that a place is taken from, and what lies between the stops of a ramp.
OF_OWN, OF_UV, OF_WORLD = 0, 1, 2
LINEAR, SMOOTH, CONSTANT = 0, 1, 2

_START = np.int64(0)
_ZERO, _ONE, _TWO, _THREE = np.float32(0), np.float32(1), np.float32(2), np.float32(3)


@device
def child(place, column):
    """(colour, alpha) of a node that the place's node is made from, in the same place."""
    return look_up(place.textures, np.int64(place.textures.nodes[place.node, column]), place.record, _START)


@entry
def constant(textures, node, record):
    """Data: red, green, blue."""
    place = open_place(textures, node, record)
    first = np.int64(place.textures.nodes[node, DATA])
    return answer(place, load_vec3(place.textures.data, first), _ONE)


@entry
def blend(textures, node, record):
    """So far from the first child to the second as the red channel of the third says."""
    place = open_place(textures, node, record)
    part, _ = child(place, CHILD_C)
    share = min(max(part.x, _ZERO), _ONE)
    if share == _ZERO:
        colour, alpha = child(place, CHILD_A)
        return answer(place, colour, alpha)
    if share == _ONE:
        colour, alpha = child(place, CHILD_B)
        return answer(place, colour, alpha)
    colour, alpha = child(place, CHILD_A)
    other, other_alpha = child(place, CHILD_B)
    return answer(place, colour * (_ONE - share) + other * share, alpha * (_ONE - share) + other_alpha * share)


@device
def _stop(data, at):
    return load_vec3(data, at + 1)


@device
def ramp_colour(data, at, t):
    """Colour of the ramp whose numbers begin at `data[at]`: how many stops, what lies between them, and of each one its
    position and colour."""
    count, between = np.int64(data[at]), np.int64(data[at + 1])
    at += 2
    if not t > data[at]:
        return _stop(data, at)
    # Halving: the last stop that is not beyond.
    low, left = np.int64(0), count
    while left > 1:
        half = left >> 1
        low += half if data[at + 4 * (low + half)] <= t else 0
        left -= half
    here = at + 4 * low
    if low == count - 1 or between == CONSTANT:
        return _stop(data, here)
    share = (t - data[here]) / (data[here + 4] - data[here])
    if between == SMOOTH:
        share = share * share * (_THREE - _TWO * share)
    return _stop(data, here) * (_ONE - share) + _stop(data, here + 4) * share


@entry
def ramp(textures, node, record):
    """The colour of a ramp at the red channel of the child. Data: the ramp."""
    place = open_place(textures, node, record)
    number, alpha = child(place, CHILD_A)
    first = np.int64(place.textures.nodes[node, DATA])
    return answer(place, ramp_colour(place.textures.data, first, number.x), alpha)


@device
def _moved(place, v):
    """A vector by the matrix in the node's data."""
    return vec3(
        datum(place, 1) * v.x + datum(place, 2) * v.y + datum(place, 3) * v.z,
        datum(place, 5) * v.x + datum(place, 6) * v.y + datum(place, 7) * v.z,
        datum(place, 9) * v.x + datum(place, 10) * v.y + datum(place, 11) * v.z,
    )


@device
def _write_place(record, p, a, b, flat_p, flat_a, flat_b):
    store_vec3(record, OWN, p)
    store_vec3(record, OWN_A, a)
    store_vec3(record, OWN_B, b)
    record[U], record[V] = flat_p.x, flat_p.y
    record[AXIS_A], record[AXIS_A + 1] = flat_a.x, flat_a.y
    record[AXIS_B], record[AXIS_B + 1] = flat_b.x, flat_b.y


@entry
def placed(textures, node, record_address):
    """The child in a space of its own, of which x and y are its texture coordinates, too. Data: the space that is moved
    there, and the rows of an affine 3 × 4 matrix."""
    place = open_place(textures, node, record_address)
    record = place.record
    p, a, b = load_vec3(record, OWN), load_vec3(record, OWN_A), load_vec3(record, OWN_B)
    flat_p = vec3(record[U], record[V], _ZERO)
    flat_a = vec3(record[AXIS_A], record[AXIS_A + 1], _ZERO)
    flat_b = vec3(record[AXIS_B], record[AXIS_B + 1], _ZERO)
    space = datum(place, _START)
    if space == OF_OWN:
        q, qa, qb = p, a, b
    elif space == OF_UV:
        q, qa, qb = flat_p, flat_a, flat_b
    else:
        q, qa, qb = load_vec3(record, WORLD), load_vec3(record, WORLD_A), load_vec3(record, WORLD_B)
    q = _moved(place, q) + vec3(datum(place, 4), datum(place, 8), datum(place, 12))
    qa, qb = _moved(place, qa), _moved(place, qb)
    _write_place(record, q, qa, qb, q, qa, qb)
    colour, alpha = child(place, CHILD_A)
    _write_place(record, p, a, b, flat_p, flat_a, flat_b)
    return answer(place, colour, alpha)
