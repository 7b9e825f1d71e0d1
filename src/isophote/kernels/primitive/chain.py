"""Primitives as the kernels of rendering methods know them: entries that are called where a scene has any."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import Hit
from isophote.kernels.accel.surface import Surface
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import store_int
from isophote.kernels.base.vec import vec3
from isophote.kernels.primitive.layout import SLOT, SURFACE

__all__ = ["closest_primitive", "primitive_occludes", "surface_of_primitive"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_SLOT, _PART_BITS, _PART = np.int64(SLOT), np.int64(4), np.int64(15)
_FIRST = np.int64(0)


@device
def _load_ray(scratch, origin, direction, t_max):
    scratch[0], scratch[1], scratch[2] = origin.x, origin.y, origin.z
    scratch[3], scratch[4], scratch[5] = direction.x, direction.y, direction.z
    scratch[6] = t_max


@device
def closest_primitive(primitives, origin, direction, best, scratch):
    """`best`, or the nearer `Hit` on a primitive: its slot is SLOT − the part's number, its instance the primitive's
    number."""
    if primitives.numbers.rows == 0:
        return best
    _load_ray(scratch, origin, direction, best.t)
    scratch[7] = _ZERO
    met = call_entry(primitives.trace, (table_address(primitives), element_address(scratch, _FIRST)))
    if met < 0:
        return best
    return Hit(scratch[6], _ZERO, _ZERO, _SLOT - (met & _PART), met >> _PART_BITS)


@device
def primitive_occludes(primitives, origin, direction, t_max, scratch):
    """Whether any primitive lies at 0 < t < t_max."""
    if primitives.numbers.rows == 0:
        return False
    _load_ray(scratch, origin, direction, t_max)
    scratch[7] = _ONE
    return call_entry(primitives.trace, (table_address(primitives), element_address(scratch, _FIRST))) >= 0


@device
def surface_of_primitive(primitives, origin, direction, hit, scratch):
    """The `Surface` of a `Hit` on a primitive."""
    _load_ray(scratch, origin, direction, hit.t)
    store_int(scratch, np.int64(7), np.int32(hit.instance))
    store_int(scratch, np.int64(8), np.int32(_SLOT - hit.slot))
    call_entry(primitives.surface, (table_address(primitives), element_address(scratch, _FIRST)))
    place, normal = vec3(scratch[0], scratch[1], scratch[2]), vec3(scratch[3], scratch[4], scratch[5])
    item = np.int64(primitives.numbers[hit.instance, SURFACE])
    return Surface(place, normal, normal, scratch[6], scratch[7], scratch[8], item, _SLOT - hit.slot)
