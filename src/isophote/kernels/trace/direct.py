"""All that rays meet besides triangles: fields and primitives, by entries that are called where a scene has any."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.field_chain import closest_field, surface_of_field
from isophote.kernels.accel.field_layout import FIELD
from isophote.kernels.accel.field_layout import SURFACE as ROW_OF_FIELD
from isophote.kernels.accel.surface import surface_at
from isophote.kernels.base.jit import device
from isophote.kernels.primitive.chain import closest_primitive, surface_of_primitive
from isophote.kernels.primitive.layout import SLOT
from isophote.kernels.primitive.layout import SURFACE as ROW_OF_PRIMITIVE

__all__ = ["closest_direct", "direct_item", "direct_part", "has_direct", "is_surface", "surface_of"]

_FIELD, _PRIMITIVE = np.int64(FIELD), np.int64(SLOT)


@device
def has_direct(scene):
    """Whether anything but triangles and lamps is there."""
    return scene.fields.numbers.rows + scene.primitives.numbers.rows > 0


@device
def is_surface(slot):
    """Whether a hit's slot is that of an item's surface, and not that of nothing or of a lamp."""
    return slot >= 0 or slot <= _PRIMITIVE


@device
def closest_direct(scene, origin, direction, best, scratch):
    """`best`, or the nearer `Hit` on a primitive or a field."""
    best = closest_primitive(scene.primitives, origin, direction, best, scratch)
    return closest_field(scene.fields, origin, direction, best, scratch)


@device
def direct_item(scene, hit):
    """Row of the item in `Surfaces` that a `Hit` on a primitive or a field lies on."""
    if hit.slot > _FIELD:
        return np.int64(scene.primitives.numbers[hit.instance, ROW_OF_PRIMITIVE])
    return np.int64(scene.fields.numbers[hit.instance, ROW_OF_FIELD])


@device
def direct_part(hit):
    """Number of the part of a primitive's surface that a `Hit` lies on; 0 of fields."""
    return _PRIMITIVE - hit.slot if hit.slot > _FIELD else np.int64(0)


@device
def surface_of(scene, origin, direction, hit, scratch):
    """The `Surface` of a `Hit` on a triangle, a primitive or a field."""
    if hit.slot >= 0:
        return surface_at(scene.geometry, scene.surfaces, hit)
    if hit.slot > _FIELD:
        return surface_of_primitive(scene.primitives, origin, direction, hit, scratch)
    return surface_of_field(scene.fields, origin, direction, hit, scratch)
