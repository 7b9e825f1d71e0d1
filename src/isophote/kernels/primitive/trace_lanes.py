"""Sixteen rays against primitives: those that stand alone all rays at once, those in the tree ray by ray."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import call_entry, element_address, entry, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, HIGH, LANES, PART, T, U, V, W, X, Y, Z, chosen
from isophote.kernels.primitive.layout import PRIMITIVES
from isophote.kernels.primitive.trace import first_in_boxes

__all__ = ["trace_primitive_lanes"]

_NOTHING, _ONE, _NONE, _PARTS = 0.0, 1.0, -1.0, 16.0
_ZERO, _WORD, _LANES = np.int64(0), np.int64(4), np.int64(LANES)

open_primitives_at = opener_at(PRIMITIVES)


@device
def _bring(m, k, rays, block, lanes):
    """Rays by affine matrix number `k`, and their limits, into another block."""
    a, b, c, d = m[k, 0], m[k, 1], m[k, 2], m[k, 3]
    e, f, g, h = m[k, 4], m[k, 5], m[k, 6], m[k, 7]
    p, q, r, s = m[k, 8], m[k, 9], m[k, 10], m[k, 11]
    for i in range(lanes):
        x, y, z, u, v, w = rays[X + i], rays[Y + i], rays[Z + i], rays[U + i], rays[V + i], rays[W + i]
        block[X + i] = a * x + b * y + c * z + d
        block[Y + i] = e * x + f * y + g * z + h
        block[Z + i] = p * x + q * y + r * z + s
        block[U + i] = a * u + b * v + c * w
        block[V + i] = e * u + f * v + g * w
        block[W + i] = p * u + q * v + r * w
        block[HIGH + i] = rays[T + i]


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


@device
def _keep(rays, block, code, lanes):
    """What is nearer than what the rays have met so far."""
    for i in range(lanes):
        nearer = block[T + i] < rays[T + i]
        rays[T + i] = chosen(nearer, block[T + i], rays[T + i])
        rays[PART + i] = chosen(nearer, code + block[PART + i], rays[PART + i])


@device
def _meet_alone(primitives, number, rays, block, line):
    _bring(primitives.to_object, number, rays, block, _LANES)
    own = element_address(primitives.values, np.int64(primitives.numbers[number, layout.FIRST]))
    meet = primitives.entries[number, layout.MEET_LANES]
    if meet != 0:
        call_entry(meet, (own, element_address(block, _ZERO), _LANES))
    else:
        _meet_one_by_one(primitives.entries[number, layout.MEET], own, block, line)
    _keep(rays, block, _PARTS * np.float64(number), _LANES)


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
