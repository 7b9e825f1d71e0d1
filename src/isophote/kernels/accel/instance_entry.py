"""Instances as things in an accelerator over their boxes (things.py): what a ray meets of one.

The accelerator of the instance's object is asked by a ray of its own, which lies at the beginning of the scratch that
the ray through the boxes lies in: where accelerators are entries, no stack is there. A code is instance · 2³⁶ + slot.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.contract import (
    DEPTH,
    LIMIT,
    NODES,
    PRIMITIVES,
    WEIGHT1,
    WEIGHT2,
    add_counts,
    clear_counts,
    ray_at,
    ray_direction,
    ray_origin,
    set_ray,
)
from isophote.kernels.accel.geometry import GEOMETRY, RAY, SLOT_BITS, into_object
from isophote.kernels.accel.layout import BLOCK, LANES
from isophote.kernels.base.entry import call_entry, element_address, entry, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, store_float

__all__ = ["any_in_instance", "closest_in_instance"]

open_geometry = opener_at(GEOMETRY)

_NONE, _ONE, _WORD = np.int64(-1), np.int64(1), np.int64(4)


@device
def _ask_object(geometry, address, words, ray_address, instance):
    """What an entry of the accelerator of an instance's object answers; the words of the ray that asked it."""
    inner_address = ray_address - _WORD * RAY
    inner = ray_at(inner_address)
    origin, direction = into_object(geometry, instance, ray_origin(words), ray_direction(words))
    set_ray(inner, origin, direction, load_float(words, LIMIT))
    clear_counts(inner)
    blocks = element_address(geometry.blocks, geometry.first_blocks[instance] * BLOCK)
    found = call_entry(address, (geometry.objects[instance], blocks, inner_address))
    # Tests are counted of triangles, not of the instances that hold them.
    add_counts(words, load_int(inner, NODES), np.int64(load_int(inner, PRIMITIVES)) - _ONE, load_int(inner, DEPTH))
    return found, inner


@entry
def closest_in_instance(geometry_address, ray_address, instance):
    """The code of the nearest triangle of an instance before the ray's limit, or −1."""
    geometry, words = open_geometry(geometry_address), ray_at(ray_address)
    slot, inner = _ask_object(geometry, geometry.closest, words, ray_address, instance)
    if slot < 0:
        return _NONE
    for word in (LIMIT, WEIGHT1, WEIGHT2):
        store_float(words, word, load_float(inner, word))
    return (instance << SLOT_BITS) + geometry.first_blocks[instance] * LANES + slot


@entry
def any_in_instance(geometry_address, ray_address, instance):
    """0 where the ray meets a triangle of an instance before its limit, else −1."""
    geometry, words = open_geometry(geometry_address), ray_at(ray_address)
    blocked, _ = _ask_object(geometry, geometry.any, words, ray_address, instance)
    return blocked - _ONE
