"""Sixteen rays against primitives: those that stand alone all rays at once, those in the tree ray by ray."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import call_entry, element_address, entry, opener_at
from isophote.kernels.base.jit import device, exact_inline
from isophote.kernels.base.simd_double16 import (
    chosen_doubles16,
    load_doubles16,
    splat_doubles16,
    store_doubles16,
)
from isophote.kernels.base.vec import vec3
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, HIGH, LANES, PART, T, U, V, W, X, Y, Z
from isophote.kernels.primitive.layout import PRIMITIVES
from isophote.kernels.primitive.trace import first_in_boxes

__all__ = ["trace_primitive_lanes"]

_NOTHING, _ONE, _NONE, _PARTS = 0.0, 1.0, -1.0, 16.0
_ZERO, _WORD, _LANES = np.int64(0), np.int64(4), np.int64(LANES)

open_primitives_at = opener_at(PRIMITIVES)


@exact_inline
def _turned(m, k, first, x, y, z):
    """A row of affine matrix number `k`, from its element `first` on, but its last element, times sixteen vectors."""
    a, b, c = splat_doubles16(m[k, first]), splat_doubles16(m[k, first + 1]), splat_doubles16(m[k, first + 2])
    return a * x + b * y + c * z


@exact_inline
def _bring(m, k, rays, block):
    """Rays by affine matrix number `k`, and their limits, into another block."""
    x, y, z = load_doubles16(rays, X), load_doubles16(rays, Y), load_doubles16(rays, Z)
    u, v, w = load_doubles16(rays, U), load_doubles16(rays, V), load_doubles16(rays, W)
    store_doubles16(block, X, _turned(m, k, 0, x, y, z) + splat_doubles16(m[k, 3]))
    store_doubles16(block, Y, _turned(m, k, 4, x, y, z) + splat_doubles16(m[k, 7]))
    store_doubles16(block, Z, _turned(m, k, 8, x, y, z) + splat_doubles16(m[k, 11]))
    store_doubles16(block, U, _turned(m, k, 0, u, v, w))
    store_doubles16(block, V, _turned(m, k, 4, u, v, w))
    store_doubles16(block, W, _turned(m, k, 8, u, v, w))
    store_doubles16(block, HIGH, load_doubles16(rays, T))


@device
def _meet_one_by_one(meet, own, block, line):
    """What a kind's entry for sixteen rays does, for kinds that have none."""
    line[layout.LOW], line[layout.MOST] = _NOTHING, _ONE
    for i in range(LANES):
        for row in range(6):
            line[row] = block[LANES * row + i]
        line[layout.HIGH] = block[HIGH + i]
        met = call_entry(meet, (own, element_address(line, _ZERO))) > 0
        block[T + i] = line[layout.FOUND] if met else np.inf
        block[PART + i] = line[layout.FOUND + 1]


@exact_inline
def _keep(rays, block, code):
    """What is nearer than what the rays have met so far."""
    t, before = load_doubles16(block, T), load_doubles16(rays, T)
    nearer, part = t < before, splat_doubles16(code) + load_doubles16(block, PART)
    store_doubles16(rays, T, chosen_doubles16(nearer, t, before))
    store_doubles16(rays, PART, chosen_doubles16(nearer, part, load_doubles16(rays, PART)))


@device
def _meet_alone(primitives, number, rays, block, line):
    _bring(primitives.to_object, number, rays, block)
    own = element_address(primitives.values, np.int64(primitives.numbers[number, layout.FIRST]))
    meet = primitives.entries[number, layout.MEET_LANES]
    if meet != 0:
        call_entry(meet, (own, element_address(block, _ZERO), _LANES))
    else:
        _meet_one_by_one(primitives.entries[number, layout.MEET], own, block, line)
    _keep(rays, block, _PARTS * np.float64(number))


@entry
def trace_primitive_lanes(primitives_address, scratch_address):
    """The first primitives that sixteen rays meet before their limits in row T, which become t; the codes of
    trace_primitive, in doubles, go to row PART. The rays' block lies at RAYS_AT of the scratch."""
    primitives = open_primitives_at(primitives_address)
    line = doubles_at(scratch_address + _WORD * layout.LINE_AT, np.int64(layout.WORDS))
    rays = doubles_at(scratch_address + _WORD * layout.RAYS_AT, BLOCK_DOUBLES)
    block = doubles_at(scratch_address + _WORD * layout.OWN_AT, BLOCK_DOUBLES)
    for i in range(LANES):
        rays[PART + i] = _NONE
    for i in range(primitives.alone.rows):
        _meet_alone(primitives, np.int64(primitives.alone[i]), rays, block, line)
    if primitives.top_nodes.rows > 0 or primitives.boxes.things != 0:
        for i in range(LANES):
            if rays[T + i] > _NOTHING:
                origin, direction = (
                    vec3(rays[X + i], rays[Y + i], rays[Z + i]),
                    vec3(rays[U + i], rays[V + i], rays[W + i]),
                )
                limit, code = np.float32(rays[T + i]), np.int64(rays[PART + i])
                t, code = first_in_boxes(primitives, origin, direction, limit, code, False, scratch_address)
                rays[T + i], rays[PART + i] = t, np.float64(code)
    return np.int64(0)
