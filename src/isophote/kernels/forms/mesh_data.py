"""Signed distances to triangle meshes: exact, inside by the winding number, within the mesh's box only."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, store_float
from isophote.kernels.base.table import DOUBLE_BOXES, Packed, Table
from isophote.kernels.forms.field_data import DataTable
from isophote.kernels.forms.table_slots import ANY, LANES, reach_of, store_around, store_gradient
from isophote.kernels.forms.tape_interval import REGION_MIDDLE
from isophote.kernels.measure.closest import closest_slot, nearest_on_slot
from isophote.kernels.measure.mesh_distance import MESH_DISTANCE, STACK_WORDS
from isophote.kernels.measure.winding import winding_of

__all__ = ["mesh_table"]

# `box` (2, 3): the least and the greatest corner of the mesh, in its own units.
_MESH = Table("SignedMesh", mesh=MESH_DISTANCE, box=DOUBLE_BOXES)
_open_signed = opener_at(_MESH)

_NAN = np.float32(np.nan)
_HALF = np.float64(0.5)
# What single precision takes from a distance, as a part of it and of coordinates.
_ERROR = np.float64(2.0**-22)


class Place(NamedTuple):
    """A signed distance, and the slot of the triangle nearest to the point; −1 for points that are not finite."""

    value: float
    slot: int


@device
def _beyond(box, x, y, z):
    """How far a point is from the mesh's box."""
    total = 0.0
    for axis in range(3):
        c = (x, y, z)[axis]
        out = max(box[0, axis] - c, c - box[1, axis], 0.0)
        total += out * out
    return math.sqrt(total)


@device
def _place(signed, x, y, z, stack):
    """The signed distance of a point in the mesh's units."""
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        return Place(np.nan, np.int64(-1))
    mesh = signed.mesh
    scale = mesh.frame[0, 3]
    square, slot = closest_slot(mesh, x * scale, y * scale, z * scale, np.inf, stack)
    distance = math.sqrt(square) / scale
    if _beyond(signed.box, x, y, z) > 0.0:
        return Place(distance, slot)
    inside = abs(winding_of(mesh, x * scale, y * scale, z * scale, stack)[0]) > _HALF
    return Place(-distance if inside else distance, slot)


@device
def _direction(signed, place, x, y, z):
    """The gradient: away from the nearest point of the mesh, inside toward it; on it the triangle's normal."""
    if place.slot < 0:
        return _NAN, _NAN, _NAN
    corners, scale = signed.mesh.corners, signed.mesh.frame[0, 3]
    near = nearest_on_slot(corners, place.slot, x * scale, y * scale, z * scale)
    sign = -1.0 if place.value < 0.0 else 1.0
    dx, dy, dz = sign * (x * scale - near.x), sign * (y * scale - near.y), sign * (z * scale - near.z)
    if dx == 0.0 and dy == 0.0 and dz == 0.0:
        c = corners[place.slot]
        ux, uy, uz, vx, vy, vz = c[3] - c[0], c[4] - c[1], c[5] - c[2], c[6] - c[0], c[7] - c[1], c[8] - c[2]
        dx, dy, dz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = math.sqrt(dx * dx + dy * dy + dz * dz)
    size = size if size > 0.0 else 1.0
    return np.float32(dx / size), np.float32(dy / size), np.float32(dz / size)


@device
def _point(slots, a, b, c, i):
    x, y, z = load_float(slots, a + i), load_float(slots, b + i), load_float(slots, c + i)
    return np.float64(x), np.float64(y), np.float64(z)


@entry
def _values(words, slots_at, out, a, b, c, width):
    """Values at `width` · 16 points."""
    signed, slots, stack = _open_signed(words), floats_at(slots_at, ANY), np.empty(STACK_WORDS, np.float32)
    for i in range(LANES * width):
        x, y, z = _point(slots, a, b, c, i)
        store_float(slots, out + i, np.float32(_place(signed, x, y, z, stack).value))
    return 0


@entry
def _intervals(words, slots_at, out, a, b, c, width):
    """Bounds in sixteen regions; of both signs within the box of a mesh with holes, where signs turn between them."""
    signed, slots, stack = _open_signed(words), floats_at(slots_at, ANY), np.empty(STACK_WORDS, np.float32)
    for i in range(LANES):
        x, y, z = _point(slots, a + REGION_MIDDLE, b + REGION_MIDDLE, c + REGION_MIDDLE, i)
        value = _place(signed, x, y, z, stack).value
        dx, dy, dz = reach_of(slots, a, i), reach_of(slots, b, i), reach_of(slots, c, i)
        radius = math.sqrt(np.float64(dx * dx) + np.float64(dy * dy) + np.float64(dz * dz))
        spread = radius + _ERROR * (abs(value) + radius + abs(x) + abs(y) + abs(z))
        if signed.mesh.closed == 0 and not _beyond(signed.box, x, y, z) > spread:
            spread += 2.0 * abs(value)
        store_around(slots, out, i, np.float32(value), np.float32(spread))
    return 0


@entry
def _gradients(words, slots_at, out, a, b, c, width):
    """Values and gradients at sixteen points."""
    signed, slots, stack = _open_signed(words), floats_at(slots_at, ANY), np.empty(STACK_WORDS, np.float32)
    for i in range(LANES):
        x, y, z = _point(slots, a, b, c, i)
        place = _place(signed, x, y, z, stack)
        store_gradient(slots, out, i, np.float32(place.value), (a, b, c), _direction(signed, place, x, y, z))
    return 0


def mesh_table(mesh: Packed, box: Any) -> DataTable:
    """A packed MESH_DISTANCE and the mesh's box, (2, 3) float64, with the functions that interpreters call."""
    packed = _MESH.pack(mesh=mesh, box=np.ascontiguousarray(box, np.float64))
    return DataTable(packed, (_values, _intervals, _gradients))
