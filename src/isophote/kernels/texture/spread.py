"""Long footprints cut into shorter ones: what is seen at a grazing angle.

Most formulas know only how wide a footprint is. Asked over several pieces of a long one, each about as long as wide,
they lose no more detail across it than along, and the mean is one of colours, behind ramps and mixtures.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, load_vec3, store_vec3, vec3
from isophote.kernels.texture.combine import child
from isophote.kernels.texture.contract import (
    AXIS_A,
    AXIS_B,
    CHILD_A,
    OWN,
    OWN_A,
    OWN_B,
    WORLD,
    WORLD_A,
    WORLD_B,
    U,
    V,
    answer,
    open_place,
)

__all__ = ["spread"]

_MOST = np.int64(8)
_ZERO, _ONE = np.float32(0), np.float32(1)
# So much longer than wide, and a footprint is cut.
_LONG = np.float32(1.5)


@device
def _squares(record):
    """Squared lengths of both half-axes, in the shape's own space, or in texture coordinates if it is not known."""
    a, b = load_vec3(record, OWN_A), load_vec3(record, OWN_B)
    first, second = dot(a, a), dot(b, b)
    if first + second > _ZERO:
        return first, second
    first = record[AXIS_A] * record[AXIS_A] + record[AXIS_A + 1] * record[AXIS_A + 1]
    return first, record[AXIS_B] * record[AXIS_B] + record[AXIS_B + 1] * record[AXIS_B + 1]


@device
def _pieces(shorter, longer):
    """How many pieces a footprint with half-axes of these squared lengths is cut into."""
    if not longer > shorter * (_LONG * _LONG):
        return np.int64(1)
    ratio = np.sqrt(longer / shorter) if shorter > _ZERO else np.float32(_MOST)
    return np.int64(np.ceil(min(ratio, np.float32(_MOST))))


@entry
def spread(textures, node, record_address):
    """The mean of the child over the pieces of the footprint."""
    place = open_place(textures, node, record_address)
    record = place.record
    first, second = _squares(record)
    count = _pieces(min(first, second), max(first, second))
    if count == 1:
        colour, alpha = child(place, CHILD_A)
        return answer(place, colour, alpha)
    flat_at, own_at, world_at = (AXIS_A, OWN_A, WORLD_A) if first > second else (AXIS_B, OWN_B, WORLD_B)
    own, world = load_vec3(record, OWN), load_vec3(record, WORLD)
    own_axis, world_axis = load_vec3(record, own_at), load_vec3(record, world_at)
    u, v, along_u, along_v = record[U], record[V], record[flat_at], record[flat_at + 1]
    part = _ONE / np.float32(count)
    store_vec3(record, own_at, own_axis * part)
    store_vec3(record, world_at, world_axis * part)
    record[flat_at], record[flat_at + 1] = along_u * part, along_v * part
    total, opacity = vec3(_ZERO, _ZERO, _ZERO), _ZERO
    for k in range(count):
        t = np.float32(2 * k + 1) * part - _ONE
        store_vec3(record, OWN, own + own_axis * t)
        store_vec3(record, WORLD, world + world_axis * t)
        record[U], record[V] = u + along_u * t, v + along_v * t
        colour, alpha = child(place, CHILD_A)
        total, opacity = total + colour * part, opacity + alpha * part
    store_vec3(record, OWN, own)
    store_vec3(record, WORLD, world)
    store_vec3(record, own_at, own_axis)
    store_vec3(record, world_at, world_axis)
    record[U], record[V], record[flat_at], record[flat_at + 1] = u, v, along_u, along_v
    return answer(place, total, opacity)
