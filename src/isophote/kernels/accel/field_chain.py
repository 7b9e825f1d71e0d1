"""Fields as the kernels of rendering methods know them: entries that are called where a scene has any."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.field_layout import FIELD, SURFACE
from isophote.kernels.accel.geometry import SCRATCH_WORDS, Hit
from isophote.kernels.accel.surface import Surface
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import store_int
from isophote.kernels.base.vec import vec3

__all__ = ["closest_field", "field_occludes", "surface_of_field"]

_ZERO, _ONE = np.float32(0), np.float32(1)
# The entries' scratch lies behind that of the trees of triangles.
_AT, _LOW_WORD, _HIGH = np.int64(SCRATCH_WORDS), np.int64(0xFFFFFFFF), np.int64(32)
_FIELD = np.int64(FIELD)


@device
def _load_ray(scratch, origin, direction, t_max):
    scratch[_AT], scratch[_AT + 1], scratch[_AT + 2] = origin.x, origin.y, origin.z
    scratch[_AT + 3], scratch[_AT + 4], scratch[_AT + 5] = direction.x, direction.y, direction.z
    scratch[_AT + 6] = t_max


@device
def closest_field(fields, origin, direction, best, scratch):
    """`best`, or the nearer `Hit` on a field: its slot is FIELD − the tape's number, its instance the field's
    number."""
    if fields.numbers.rows == 0:
        return best
    _load_ray(scratch, origin, direction, best.t)
    scratch[_AT + 7] = _ZERO
    met = call_entry(fields.trace, (table_address(fields), element_address(scratch, _AT)))
    if met < 0:
        return best
    return Hit(scratch[_AT + 6], _ZERO, _ZERO, _FIELD - (met & _LOW_WORD), met >> _HIGH)


@device
def field_occludes(fields, origin, direction, t_max, scratch):
    """Whether any field lies at 0 < t < t_max."""
    if fields.numbers.rows == 0:
        return False
    _load_ray(scratch, origin, direction, t_max)
    scratch[_AT + 7] = _ONE
    return call_entry(fields.trace, (table_address(fields), element_address(scratch, _AT))) >= 0


@device
def surface_of_field(fields, origin, direction, hit, scratch):
    """The `Surface` of a `Hit` on a field."""
    _load_ray(scratch, origin, direction, hit.t)
    store_int(scratch, _AT + 7, np.int32(hit.instance))
    store_int(scratch, _AT + 8, np.int32(_FIELD - hit.slot))
    call_entry(fields.surface, (table_address(fields), element_address(scratch, _AT)))
    place = vec3(scratch[_AT], scratch[_AT + 1], scratch[_AT + 2])
    normal = vec3(scratch[_AT + 3], scratch[_AT + 4], scratch[_AT + 5])
    item = np.int64(fields.numbers[hit.instance, SURFACE])
    return Surface(place, normal, normal, scratch[_AT + 6], _ZERO, _ZERO, item, np.int64(0))
