"""Rays against fields: through the tree over their boxes, then through the regions of each, front to back.

Regions that are proven empty or inside are passed by at once; in the others the ray is followed with the region's own
tape (field_march.py). The walk goes from a region to the one behind the face by which the ray leaves, so that none is
left out whatever the rounding; what was proven of a region holds a little beyond it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.accel import field_layout as layout
from isophote.kernels.accel.field_layout import EMPTY, FIELDS, INSIDE, NODE
from isophote.kernels.accel.field_march import Line, affine_doubles, first_crossing, slots_at, tape_at
from isophote.kernels.accel.geometry import push_boxes
from isophote.kernels.accel.layout import STACK
from isophote.kernels.base.entry import entry, floats_at, ints_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int
from isophote.kernels.base.vec import dot, vec3
from isophote.kernels.forms.field_data import open_field_data

__all__ = ["trace_field"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_NOTHING, _DOUBLE_ONE = 0.0, 1.0
_TINY = np.float32(1e-12)
_FAR = np.float32(np.inf)
_BALL_SLACK = np.float32(1 - 2.0**-18)
_NONE, _WORD = np.int64(-1), np.int64(4)

open_fields_at = opener_at(FIELDS)


class Walk(NamedTuple):
    """A ray as it goes through a field: its `Line` from where it enters; the least corner of the finest regions in
    units of their width and how the ray moves in these units, with its reciprocals; t where it enters, and t a
    length."""

    line: object
    x: float
    y: float
    z: float
    dx: float
    dy: float
    dz: float
    ix: float
    iy: float
    iz: float
    enter: float
    scale: float
    end: float


@device
def _clip(low, high, o, d, near, far):
    """The part of a stretch of t between two planes, in double precision."""
    if d == _NOTHING:
        inside = low <= o <= high
        return near, far if inside else near - _DOUBLE_ONE
    inverse = _DOUBLE_ONE / d
    a, b = (low - o) * inverse, (high - o) * inverse
    return max(near, min(a, b)), min(far, max(a, b))


@device
def _reciprocal(d):
    """1/d, or 0 for rays that run along the faces."""
    return _ONE / d if abs(d) > _TINY else _ZERO


@device
def _enter(fields, k, origin, direction, t_max):
    """The `Walk` of a ray through field `k`; its end is below zero where it passes by."""
    m, cubes = fields.to_object, fields.cubes
    ox, oy, oz = affine_doubles(m, k, np.float64(origin.x), np.float64(origin.y), np.float64(origin.z), _DOUBLE_ONE)
    dx, dy, dz = affine_doubles(
        m, k, np.float64(direction.x), np.float64(direction.y), np.float64(direction.z), _NOTHING
    )
    near, far = _NOTHING, np.float64(t_max)
    low, high = layout.LOW, layout.HIGH
    near, far = _clip(np.float64(cubes[k, low]), np.float64(cubes[k, high]), ox, dx, near, far)
    near, far = _clip(np.float64(cubes[k, low + 1]), np.float64(cubes[k, high + 1]), oy, dy, near, far)
    near, far = _clip(np.float64(cubes[k, low + 2]), np.float64(cubes[k, high + 2]), oz, dz, near, far)
    speed = math.sqrt(dx * dx + dy * dy + dz * dz)
    # From where the ray enters, positions are as precise as the field's own coordinates, however far it came.
    x, y, z = np.float32(ox + near * dx), np.float32(oy + near * dy), np.float32(oz + near * dz)
    ux, uy, uz = np.float32(dx / speed), np.float32(dy / speed), np.float32(dz / speed)
    side = cubes[k, layout.SIDE]
    cells = np.float32(1 << (2 * fields.numbers[k, layout.LEVELS])) / side
    vx, vy, vz = ux * cells, uy * cells, uz * cells
    return Walk(
        Line(x, y, z, ux, uy, uz, cubes[k, layout.SHORTEST], cubes[k, layout.DETAIL]),
        (x - cubes[k, layout.CELLS]) * cells,
        (y - cubes[k, layout.CELLS + 1]) * cells,
        (z - cubes[k, layout.CELLS + 2]) * cells,
        vx,
        vy,
        vz,
        _reciprocal(vx),
        _reciprocal(vy),
        _reciprocal(vz),
        near,
        _DOUBLE_ONE / speed,
        np.float32((far - near) * speed),
    )


@device
def _cell(place, first, count):
    """The number of the cell that a place lies in, between `first` and `first` + `count` − 1."""
    return min(max(np.int64(math.floor(place)), first), first + count - 1)


@device
def _leave(first, count, place, inverse):
    """How far it is to the face by which a ray leaves cells `first` … `first` + `count` − 1 of one axis."""
    if inverse == _ZERO:
        return _FAR
    return (np.float32(first + count if inverse > _ZERO else first) - place) * inverse


@device
def _past(first, count, direction):
    return first + count if direction > _ZERO else first - 1


@device
def _child(cx, cy, cz, shift):
    return ((cx >> shift) & 3) + 4 * ((cy >> shift) & 3) + 16 * ((cz >> shift) & 3)


@device
def _region(fields, k, cx, cy, cz, node, shift):
    """(code, binary logarithm of the width in cells, node) of the region that a cell lies in.

    `node`, whose children are 2^`shift` wide, holds the cell; the root's code and width will do.
    """
    code = node
    while code > 0:
        node = code
        code = np.int64(fields.nodes[node * NODE + _child(cx, cy, cz, shift)])
        shift -= 2
    return code, shift + 2, node


@device
def _through_field(fields, k, origin, direction, t_max, any_hit, slots, places, choices):
    """(t, number of the tape) where a ray first meets the surface of field `k` before `t_max`; −1 for nowhere."""
    w = _enter(fields, k, origin, direction, t_max)
    if not w.end > _ZERO:
        return t_max, _NONE
    data = open_field_data(fields.data[k])
    size = np.int64(1) << np.int64(2 * fields.numbers[k, layout.LEVELS])
    root_tape = np.int64(fields.numbers[k, layout.ROOT_TAPE])
    cx, cy, cz = _cell(w.x, 0, size), _cell(w.y, 0, size), _cell(w.z, 0, size)
    s, sign, leaves = _ZERO, _ZERO, w.enter == _NOTHING
    # Neighbours that share a tape are gone through together: the stretch from `since` on waits for its end.
    waiting, since = _NONE, _ZERO
    root, top = np.int64(fields.numbers[k, layout.ROOT_CODE]), np.int64(2 * fields.numbers[k, layout.LEVELS] - 2)
    node, shift, inside = root, top, True
    while True:
        code, shift, node = _region(fields, k, cx, cy, cz, node, shift)
        tape = layout.FIRST_TAPE - code
        if waiting >= 0 and (waiting != tape or not inside):
            sign, found, place = first_crossing(
                fields, data, tape_at(fields, root_tape, waiting), w.line, since, s, sign, leaves, any_hit, slots,
                places, choices
            )  # fmt: skip
            if found:
                return np.float32(w.enter + np.float64(place) * w.scale), waiting
            waiting, leaves = _NONE, False
        if not inside:
            return t_max, _NONE
        width = np.int64(1) << shift
        x0, y0, z0 = (cx >> shift) << shift, (cy >> shift) << shift, (cz >> shift) << shift
        sx, sy, sz = _leave(x0, width, w.x, w.ix), _leave(y0, width, w.y, w.iy), _leave(z0, width, w.z, w.iz)
        leave = min(sx, min(sy, sz))
        end = min(max(leave, s), w.end)
        if code >= INSIDE:
            here = _ONE if code == EMPTY else -_ONE
            if here * sign < _ZERO:
                return np.float32(w.enter + np.float64(s) * w.scale), root_tape
            sign, leaves = here, False
        elif waiting < 0 and end > s:
            waiting, since = tape, s
        s = end
        px, py, pz = cx, cy, cz
        if sx == leave:
            cx = _past(x0, width, w.dx)
            cy, cz = _cell(w.y + s * w.dy, y0, width), _cell(w.z + s * w.dz, z0, width)
        elif sy == leave:
            cy = _past(y0, width, w.dy)
            cx, cz = _cell(w.x + s * w.dx, x0, width), _cell(w.z + s * w.dz, z0, width)
        else:
            cz = _past(z0, width, w.dz)
            cx, cy = _cell(w.x + s * w.dx, x0, width), _cell(w.y + s * w.dy, y0, width)
        inside = leave < w.end and min(cx, min(cy, cz)) >= 0 and max(cx, max(cy, cz)) < size
        if not inside:
            # Somewhere within, so that what waits is looked at.
            cx, cy, cz = px, py, pz
        elif ((cx ^ px) | (cy ^ py) | (cz ^ pz)) >> (shift + 2) != 0:
            # Out of the node: from the root again.
            node, shift = root, top


@device
def _passes_by(fields, k, origin, direction):
    """Whether a ray certainly misses the ball around field `k`: found sooner than that it misses its box."""
    cubes, at = fields.cubes, layout.BALL
    to_ball = vec3(cubes[k, at] - origin.x, cubes[k, at + 1] - origin.y, cubes[k, at + 2] - origin.z)
    radius, distance2 = cubes[k, at + 3], dot(to_ball, to_ball)
    # More than the rounding of what is compared.
    outside = distance2 * _BALL_SLACK - radius * radius
    if outside <= _ZERO:
        return False
    along = dot(to_ball, direction)
    return along <= _ZERO or along * along < outside * dot(direction, direction)


@device
def _first_field(fields, origin, direction, t_max, any_hit, stack, slots, places, choices):
    """(t, field, number of the tape) of what a ray meets first; tape −1 for nothing."""
    field, tape = np.int64(0), _NONE
    many = fields.top_nodes.rows > 0
    # As closest_hit goes through instances.
    top = np.int64(0)
    node = np.int32(0) if many else np.int32(-2)
    while True:
        if node >= 0:
            top = push_boxes(fields.top_nodes, node, origin, direction, t_max, stack, top, np.int64(STACK))
        else:
            code = np.int64(-1) - np.int64(node)
            first = code >> 3
            for at in range(first, first + (code & 7)):
                k = np.int64(fields.top_items[at]) if many else np.int64(0)
                if _passes_by(fields, k, origin, direction):
                    continue
                t, met = _through_field(fields, k, origin, direction, t_max, any_hit, slots, places, choices)
                if met >= 0:
                    t_max, field, tape = t, k, met
                    if any_hit:
                        return t_max, field, tape
        while True:
            if top == 0:
                return t_max, field, tape
            top -= 2
            if load_float(stack, top) < t_max:
                node = load_int(stack, top + 1)
                break


@entry
def trace_field(fields_address, scratch_address):
    """The first field that a ray meets before its limit: field · 2³² + number of the tape, or −1.

    The ray's words stand at the start of the scratch; its limit becomes t.
    """
    fields = open_fields_at(fields_address)
    ray = floats_at(scratch_address, np.int64(layout.RAY_WORDS))
    stack = floats_at(scratch_address + _WORD * layout.STACK_AT, np.int64(layout.STACK_WORDS))
    places = floats_at(scratch_address + _WORD * layout.PLACES_AT, np.int64(layout.PLACES_WORDS))
    choices = ints_at(scratch_address + _WORD * layout.CHOICES_AT, fields.longest)
    slots = slots_at(fields, scratch_address)
    origin, direction = vec3(ray[0], ray[1], ray[2]), vec3(ray[3], ray[4], ray[5])
    t, field, tape = _first_field(fields, origin, direction, ray[6], ray[7] != _ZERO, stack, slots, places, choices)
    ray[6] = t
    return (field << np.int64(32)) + tape if tape >= 0 else _NONE
