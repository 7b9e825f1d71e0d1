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
from isophote.kernels.accel.contract import LIMIT, RAY_WORDS, ray_at, ray_direction, ray_origin
from isophote.kernels.accel.field_cells import cells_met, mirrored
from isophote.kernels.accel.field_layout import CHILDREN, FIELDS, FIRST_TAPE, INSIDE, NODE
from isophote.kernels.accel.field_march import Line, affine_doubles, first_crossing, slots_at, tape_at
from isophote.kernels.accel.geometry import push_boxes
from isophote.kernels.accel.layout import STACK
from isophote.kernels.accel.things import ask_boxes
from isophote.kernels.base.entry import entry, floats_at, ints_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.long_words import highest_bit, load_long, lowest_bit, store_long
from isophote.kernels.base.simd import load_float, load_int, store_float, store_int
from isophote.kernels.base.vec import dot, vec3
from isophote.kernels.forms.field_data import open_field_data

__all__ = ["test_field", "trace_field"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_NOTHING, _DOUBLE_ONE = 0.0, 1.0
_QUARTER, _FOUR = np.float32(0.25), np.float32(4)
# Rays that move less than this along an axis stay where they are on it.
_TINY = np.float32(1e-30)
# Axes as `mirrored` knows them.
_NO_AXIS, _X, _Y, _Z = np.int64(0), np.int64(3), np.int64(12), np.int64(48)
# Words of a level: its cells, and behind them the node.
_LEAVES, _KEPT, _LEVEL_WORDS = (np.int64(n) for n in (layout.LEAVES_AT, layout.KEPT_AT, layout.LEVEL_WORDS))
_BALL_SLACK = np.float32(1 - 2.0**-18)
_NONE, _WORD, _FIELD_BITS = np.int64(-1), np.int64(4), np.int64(32)

open_fields_at = opener_at(FIELDS)


class Walk(NamedTuple):
    """A ray as it goes through a field: its `Line` from where it enters; where that is in units of the finest regions'
    width, mirrored so that the ray goes up, and the reciprocals of how it moves in these units; how numbers of
    children are mirrored; t where it enters, and t a length; the length to where it leaves."""

    line: object
    x: float
    y: float
    z: float
    ix: float
    iy: float
    iz: float
    mirror: int
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
def _upward(place, move, size):
    """(place, reciprocal of the movement) along one axis, mirrored between 0 and `size` if the ray goes down."""
    return (size - place if move < _ZERO else place), _ONE / max(abs(move), _TINY)


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
    size = np.float32(1 << (2 * fields.numbers[k, layout.LEVELS]))
    cells = size / cubes[k, layout.SIDE]
    wx, ix = _upward((x - cubes[k, layout.CELLS]) * cells, ux * cells, size)
    wy, iy = _upward((y - cubes[k, layout.CELLS + 1]) * cells, uy * cells, size)
    wz, iz = _upward((z - cubes[k, layout.CELLS + 2]) * cells, uz * cells, size)
    mirror = (_X if ux < _ZERO else _NO_AXIS) | (_Y if uy < _ZERO else _NO_AXIS) | (_Z if uz < _ZERO else _NO_AXIS)
    return Walk(
        Line(x, y, z, ux, uy, uz, cubes[k, layout.SHORTEST], cubes[k, layout.DETAIL]),
        wx,
        wy,
        wz,
        ix,
        iy,
        iz,
        mirror,
        near,
        _DOUBLE_ONE / speed,
        np.float32((far - near) * speed),
    )


@device
def _keep(cells, level, node, left, x, y, z):
    """Keep a node, its corner, and which of its children are still to be looked at."""
    at = level * _LEVEL_WORDS + _KEPT
    store_long(cells, at, left)
    store_int(cells, at + 2, np.int32(node))
    store_float(cells, at + 3, x)
    store_float(cells, at + 4, y)
    store_float(cells, at + 5, z)


@device
def _kept(cells, level):
    """(node, left, x, y, z) as they were kept."""
    at = level * _LEVEL_WORDS + _KEPT
    place = load_float(cells, at + 3), load_float(cells, at + 4), load_float(cells, at + 5)
    return np.int64(load_int(cells, at + 2)), load_long(cells, at), place[0], place[1], place[2]


@device
def _through_field(fields, k, origin, direction, t_max, any_hit, slots, places, choices, cells):
    """(t, number of the tape) where a ray first meets the surface of field `k` before `t_max`; −1 for nowhere."""
    w = _enter(fields, k, origin, direction, t_max)
    if not w.end > _ZERO:
        return t_max, _NONE
    data = open_field_data(fields.data[k])
    root_tape = np.int64(fields.numbers[k, layout.ROOT_TAPE])
    sign, leaves = _ZERO, w.enter == _NOTHING
    # Stretches that share a tape are gone through together: that from `since` to `until` waits for its end.
    waiting, since, until = _NONE, _ZERO, _ZERO
    # A node with its corner, the width of its children, and those of them that are still to be looked at; the first is
    # the one above the root.
    level, node, left = np.int64(0), np.int64(fields.numbers[k, layout.ABOVE]), np.int64(0)
    nx, ny, nz, width = _ZERO, _ZERO, _ZERO, np.float32(1 << (2 * fields.numbers[k, layout.LEVELS]))
    # The child at hand.
    child, code, x, y, z, near, far = (
        np.int64(0),
        np.int64(fields.numbers[k, layout.ROOT_CODE]),
        nx,
        ny,
        nz,
        _ZERO,
        w.end,
    )
    while True:
        within = np.int64(0)
        if code != INSIDE:
            base = (level + 1) * _LEVEL_WORDS
            met = cells_met(w, x, y, z, width * _QUARTER, cells, base)
            within = met & mirrored(fields.finer[node * CHILDREN + child], w.mirror)
            if within != 0 and code <= FIRST_TAPE:
                near = load_float(cells, base + lowest_bit(within))
                far = load_float(cells, base + _LEAVES + highest_bit(within))
        if code < 0 and (within != 0 or code == INSIDE):
            tape = FIRST_TAPE - code
            if waiting >= 0 and (tape != waiting or near > until):
                sign, found, place = first_crossing(
                    fields, data, tape_at(fields, root_tape, waiting), w.line, since, until, sign, leaves, any_hit,
                    slots, places, choices
                )  # fmt: skip
                if found:
                    return np.float32(w.enter + np.float64(place) * w.scale), waiting
                waiting, leaves = _NONE, False
            if near > until:
                # What lies between is proven empty.
                sign, leaves = _ONE, False
            if code == INSIDE:
                if sign > _ZERO:
                    return np.float32(w.enter + np.float64(near) * w.scale), root_tape
                sign, leaves = -_ONE, False
            elif waiting < 0:
                waiting, since = tape, near
            until = far
        elif within != 0:
            _keep(cells, level, node, left, nx, ny, nz)
            level, node, left, width, nx, ny, nz = level + 1, code, within, width * _QUARTER, x, y, z
        while left == 0 and level > 0:
            level, width = level - 1, width * _FOUR
            node, left, nx, ny, nz = _kept(cells, level)
        if left == 0:
            break
        number = lowest_bit(left)
        left &= left - 1
        child = number ^ w.mirror
        code = np.int64(fields.nodes[node * NODE + child])
        x = nx + np.float32(number & 3) * width
        y = ny + np.float32((number >> 2) & 3) * width
        z = nz + np.float32(number >> 4) * width
        at = level * _LEVEL_WORDS + number
        near, far = load_float(cells, at), load_float(cells, at + _LEAVES)
    if waiting >= 0:
        sign, found, place = first_crossing(
            fields, data, tape_at(fields, root_tape, waiting), w.line, since, until, sign, leaves, any_hit, slots,
            places, choices
        )  # fmt: skip
        if found:
            return np.float32(w.enter + np.float64(place) * w.scale), waiting
    return t_max, _NONE


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
def _meet_field(fields, k, origin, direction, t_max, any_hit, scratch):
    """(t, number of the tape) where a ray first meets field `k`; −1 for nowhere. `scratch` is its address."""
    if _passes_by(fields, k, origin, direction):
        return t_max, _NONE
    places = floats_at(scratch + _WORD * layout.PLACES_AT, np.int64(layout.PLACES_WORDS))
    cells = floats_at(scratch + _WORD * layout.CELLS_AT, np.int64(layout.CELLS_WORDS))
    choices = ints_at(scratch + _WORD * layout.CHOICES_AT, fields.longest)
    slots = slots_at(fields, scratch)
    return _through_field(fields, k, origin, direction, t_max, any_hit, slots, places, choices, cells)


@device
def _first_in_tree(fields, origin, direction, t_max, any_hit, scratch):
    """(t, field, number of the tape) of what a ray meets first; tape −1 for nothing."""
    stack = floats_at(scratch + _WORD * layout.STACK_AT, np.int64(layout.STACK_WORDS))
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
                t, met = _meet_field(fields, k, origin, direction, t_max, any_hit, scratch)
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
    origin, direction, any_hit = vec3(ray[0], ray[1], ray[2]), vec3(ray[3], ray[4], ray[5]), ray[7] != _ZERO
    if fields.boxes.things != 0:
        # The words of a ray for accelerators are the last before the entry's.
        words = scratch_address - _WORD * RAY_WORDS
        t, code = ask_boxes(fields.boxes, fields_address, origin, direction, ray[6], np.int64(any_hit), words)
        ray[6] = t
        return code
    t, field, tape = _first_in_tree(fields, origin, direction, ray[6], any_hit, scratch_address)
    ray[6] = t
    return (field << _FIELD_BITS) + tape if tape >= 0 else _NONE


@entry
def test_field(fields_address, ray_address, field):
    """What a ray for an accelerator meets of a field (things.py); codes as of trace_field.

    The ray's words lie where they do in a scratch."""
    fields, words = open_fields_at(fields_address), ray_at(ray_address)
    scratch = ray_address + _WORD * RAY_WORDS
    limit, any_hit = load_float(words, LIMIT), floats_at(scratch, np.int64(layout.RAY_WORDS))[7] != _ZERO
    t, tape = _meet_field(fields, field, ray_origin(words), ray_direction(words), limit, any_hit, scratch)
    if tape < 0:
        return _NONE
    store_float(words, LIMIT, t)
    return (field << _FIELD_BITS) + tape
