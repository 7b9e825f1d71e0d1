"""Rays against primitives: those that stand alone one by one, the others through the tree over their boxes."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.contract import LIMIT, ray_at, ray_direction, ray_origin
from isophote.kernels.accel.geometry import RAY, push_boxes
from isophote.kernels.accel.layout import STACK
from isophote.kernels.accel.things import ask_boxes
from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import call_entry, element_address, entry, floats_at, opener_at, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, store_float
from isophote.kernels.base.vec import dot, vec3
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.layout import PRIMITIVES
from isophote.kernels.primitive.line import placed

__all__ = ["first_in_boxes", "test_primitive", "trace_primitive"]

_ZERO = np.float32(0)
_NOTHING, _ONE = 0.0, 1.0
_NONE, _WORD, _PART_BITS = np.int64(-1), np.int64(4), np.int64(4)
_BALL_SLACK = np.float32(1 - 2.0**-18)
# The stack's words end where a row of distances begins.
_STACK = np.int64(STACK)

open_primitives_at = opener_at(PRIMITIVES)


@device
def passes_by(primitives, k, origin, direction):
    """Whether a ray certainly misses the ball around primitive `k`."""
    reach = primitives.reach
    to_ball = vec3(reach[k, 0] - origin.x, reach[k, 1] - origin.y, reach[k, 2] - origin.z)
    radius, distance2 = reach[k, 3], dot(to_ball, to_ball)
    # More than the rounding of what is compared.
    outside = distance2 * _BALL_SLACK - radius * radius
    along = dot(to_ball, direction)
    return outside > _ZERO and (along <= _ZERO or along * along < outside * dot(direction, direction))


@device
def meet_primitive(primitives, k, origin, direction, t_max, line):
    """(t, part) where a ray first meets primitive `k` at 0 < t < t_max; part −1 for nowhere. `line` has WORDS."""
    m = primitives.to_object
    line[0], line[1], line[2] = placed(m, k, np.float64(origin.x), np.float64(origin.y), np.float64(origin.z), _ONE)
    line[3], line[4], line[5] = placed(
        m, k, np.float64(direction.x), np.float64(direction.y), np.float64(direction.z), _NOTHING
    )
    line[layout.LOW], line[layout.HIGH], line[layout.MOST] = _NOTHING, np.float64(t_max), _ONE
    own = element_address(primitives.values, np.int64(primitives.numbers[k, layout.FIRST]))
    if call_entry(primitives.entries[k, layout.MEET], (own, element_address(line, np.int64(0)))) == 0:
        return t_max, _NONE
    return np.float32(line[layout.FOUND]), np.int64(line[layout.FOUND + 1])


@device
def _first_alone(primitives, origin, direction, t_max, any_hit, line):
    """(t, code) of what a ray meets first among the primitives that stand alone; see trace_primitive."""
    found = _NONE
    for i in range(primitives.alone.rows):
        k = np.int64(primitives.alone[i])
        if not passes_by(primitives, k, origin, direction):
            t, part = meet_primitive(primitives, k, origin, direction, t_max, line)
            if part >= 0:
                t_max, found = t, (k << _PART_BITS) + part
                if any_hit:
                    break
    return t_max, found


@device
def _first_in_tree(primitives, origin, direction, t_max, found, any_hit, stack, line):
    # As closest_hit goes through instances.
    top, node = np.int64(0), np.int32(0)
    while True:
        if node >= 0:
            top = push_boxes(primitives.top_nodes, node, origin, direction, t_max, stack, top, _STACK)
        else:
            code = np.int64(-1) - np.int64(node)
            first = code >> 3
            for at in range(first, first + (code & 7)):
                k = np.int64(primitives.top_items[at])
                t, part = meet_primitive(primitives, k, origin, direction, t_max, line)
                if part >= 0:
                    t_max, found = t, (k << _PART_BITS) + part
                    if any_hit:
                        return t_max, found
        while True:
            if top == 0:
                return t_max, found
            top -= 2
            if load_float(stack, top) < t_max:
                node = load_int(stack, top + 1)
                break


@device
def first_in_boxes(primitives, origin, direction, t_max, found, any_hit, scratch_address):
    """(t, code) of what a ray meets first of the primitives with boxes, or what was found before."""
    if primitives.boxes.things != 0:
        ray, any_will_do = scratch_address + _WORD * RAY, np.int64(any_hit)
        t, code = ask_boxes(primitives.boxes, table_address(primitives), origin, direction, t_max, any_will_do, ray)
        return (t, code) if code >= 0 else (t_max, found)
    if primitives.top_nodes.rows == 0:
        return t_max, found
    line = doubles_at(scratch_address + _WORD * layout.LINE_AT, np.int64(layout.WORDS))
    stack = floats_at(scratch_address + _WORD * layout.STACK_AT, np.int64(layout.STACK_WORDS))
    return _first_in_tree(primitives, origin, direction, t_max, found, any_hit, stack, line)


@entry
def test_primitive(primitives_address, ray_address, box):
    """What a ray for an accelerator meets of the primitive in a box (accel/things.py); codes as of trace_primitive.

    The ray's words lie where they do in a scratch."""
    primitives, words = open_primitives_at(primitives_address), ray_at(ray_address)
    line = doubles_at(ray_address + _WORD * (layout.LINE_AT - RAY), np.int64(layout.WORDS))
    k, origin, direction = np.int64(primitives.boxed[box]), ray_origin(words), ray_direction(words)
    if passes_by(primitives, k, origin, direction):
        return _NONE
    t, part = meet_primitive(primitives, k, origin, direction, load_float(words, LIMIT), line)
    if part < 0:
        return _NONE
    store_float(words, LIMIT, t)
    return (k << _PART_BITS) + part


@entry
def trace_primitive(primitives_address, scratch_address):
    """The first primitive that a ray meets before its limit, as a code: primitive · 2⁴ + part of its surface, or −1.

    The ray's words stand at the start of the scratch; its limit becomes t.
    """
    primitives = open_primitives_at(primitives_address)
    ray = floats_at(scratch_address, np.int64(layout.RAY_WORDS))
    line = doubles_at(scratch_address + _WORD * layout.LINE_AT, np.int64(layout.WORDS))
    origin, direction = vec3(ray[0], ray[1], ray[2]), vec3(ray[3], ray[4], ray[5])
    any_hit = ray[7] != _ZERO
    t, found = _first_alone(primitives, origin, direction, ray[6], any_hit, line)
    if found < 0 or not any_hit:
        t, found = first_in_boxes(primitives, origin, direction, t, found, any_hit, scratch_address)
    ray[6] = t
    return found
