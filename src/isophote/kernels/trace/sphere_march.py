"""Sphere tracing of one field by sixteen rays together.

A point with value v is at least |v| / L from the surface, for L is the field's Lipschitz constant, so that a ray may go
that far (Hart: "Sphere Tracing", 1996). Steps are taken longer than that by a factor; where the next sphere does not
overlap the last one, the ray goes back and on without the factor (Keinert et al.: "Enhanced Sphere Tracing", 2014). A
ray has arrived where the surface is nearer than a part of its pixel's width. Empty regions are passed by at once, and
no step leaves the region whose constant it relies on.

The other marcher goes on by the same length always, and sees the surface where the field is below zero at a step's end:
what is thinner than a step may be missed.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.accel import field_layout as layout
from isophote.kernels.accel.field_layout import EMPTY
from isophote.kernels.accel.field_march import affine_doubles, tape_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, lowest_bit, store_float, store_int
from isophote.kernels.trace.sphere_packet import LANES, ROWS, TAPE, VALUE, X, evaluate_lanes, region_at

__all__ = [
    "EXIT",
    "GROWTH",
    "MARCH_ROWS",
    "NEAR",
    "SCALE",
    "START",
    "STEP",
    "STEPS",
    "T",
    "enter_field",
    "march_packet",
]

# Rows behind those of the evaluator. Of a ray: origin where it enters, unit direction, place and end along it, where
# the region ends and its Lipschitz constant; of the last step: radius, and its length where it has yet to be judged;
# the ray's t where it enters, lengths per t, the pixel's footprint where it enters and how that grows; steps through
# all fields, and through this one.
(OX, OY, OZ, DX, DY, DZ, T, END, EXIT, SLOPE, RADIUS, STEP, START, SCALE, NEAR, GROWTH, STEPS, COUNT) = (
    np.int64(16 * (ROWS + row)) for row in range(18)
)
MARCH_ROWS = ROWS + 18

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_FAR = np.float32(np.inf)
_BIT, _NONE = np.int32(1), np.int32(0)
_NOTHING, _DOUBLE_ONE = 0.0, 1.0
_TINY, _LEAST_SLOPE = np.float32(1e-12), np.float32(1e-6)


@device
def _clip(low, high, o, d, near, far):
    if d == _NOTHING:
        return near, far if low <= o <= high else near - _DOUBLE_ONE
    a, b = (low - o) / d, (high - o) / d
    return max(near, min(a, b)), min(far, max(a, b))


@device
def enter_field(fields, k, lanes, lane, origin, direction, near, far):
    """Load a lane with the part of a ray at `near` < t < `far` that lies in field `k`'s region.

    Returns whether there is one.
    """
    m, cubes = fields.to_object, fields.cubes
    ox, oy, oz = affine_doubles(m, k, np.float64(origin.x), np.float64(origin.y), np.float64(origin.z), _DOUBLE_ONE)
    dx, dy, dz = affine_doubles(
        m, k, np.float64(direction.x), np.float64(direction.y), np.float64(direction.z), _NOTHING
    )
    first, last = np.float64(near), np.float64(far)
    low, high = layout.LOW, layout.HIGH
    first, last = _clip(np.float64(cubes[k, low]), np.float64(cubes[k, high]), ox, dx, first, last)
    first, last = _clip(np.float64(cubes[k, low + 1]), np.float64(cubes[k, high + 1]), oy, dy, first, last)
    first, last = _clip(np.float64(cubes[k, low + 2]), np.float64(cubes[k, high + 2]), oz, dz, first, last)
    if not last > first:
        return False
    speed = math.sqrt(dx * dx + dy * dy + dz * dz)
    for row, o, d in ((0, ox, dx), (1, oy, dy), (2, oz, dz)):
        store_float(lanes, OX + row * LANES + lane, np.float32(o + first * d))
        store_float(lanes, DX + row * LANES + lane, np.float32(d / speed))
    store_float(lanes, START + lane, np.float32(first))
    store_float(lanes, SCALE + lane, np.float32(speed))
    store_float(lanes, T + lane, _ZERO)
    store_float(lanes, END + lane, np.float32((last - first) * speed))
    store_float(lanes, EXIT + lane, _ZERO)
    store_float(lanes, STEP + lane, _ZERO)
    store_float(lanes, COUNT + lane, _ZERO)
    return True


@device
def _leave(o, d, low, width):
    """Where a ray leaves an interval of one axis."""
    if abs(d) <= _TINY:
        return _FAR
    return ((low + width if d > _ZERO else low) - o) / d


@device
def _next_region(fields, k, lanes, lane, step):
    """Bring a lane to the next region that is not empty. Returns whether there is one before its end."""
    ox, oy, oz = load_float(lanes, OX + lane), load_float(lanes, OY + lane), load_float(lanes, OZ + lane)
    dx, dy, dz = load_float(lanes, DX + lane), load_float(lanes, DY + lane), load_float(lanes, DZ + lane)
    t, end = load_float(lanes, T + lane), load_float(lanes, END + lane)
    least = fields.cubes[k, layout.SHORTEST]
    while t < end:
        code, tape, x, y, z, width = region_at(fields, k, ox + t * dx, oy + t * dy, oz + t * dz)
        leave = min(_leave(ox, dx, x, width), min(_leave(oy, dy, y, width), _leave(oz, dz, z, width)))
        leave = max(leave, t) + least
        first = _on_step(lanes, lane, t, step) if step > _ZERO else t
        if code != EMPTY and first < min(leave, end):
            store_float(lanes, T + lane, first)
            store_float(lanes, EXIT + lane, min(leave, end))
            root = np.int64(fields.numbers[k, layout.ROOT_TAPE])
            store_float(lanes, SLOPE + lane, max(tape_at(fields, root, tape).lipschitz, _LEAST_SLOPE))
            store_int(lanes, TAPE + lane, np.int32(tape))
            store_float(lanes, RADIUS + lane, _ZERO)
            store_float(lanes, STEP + lane, _ZERO)
            return True
        t = leave
    return False


@device
def _move(lanes, lane):
    """The point of a lane to its place."""
    t = load_float(lanes, T + lane)
    for row in range(3):
        o, d = load_float(lanes, OX + row * LANES + lane), load_float(lanes, DX + row * LANES + lane)
        store_float(lanes, X + row * LANES + lane, o + t * d)


@device
def _sphere_step(lanes, lane, relaxation):
    """One step of a lane by the value at its place. Returns whether it has arrived, STEP then being how far ahead the
    surface must be, 0 where that is not known."""
    t, leave = load_float(lanes, T + lane), load_float(lanes, EXIT + lane)
    value = load_float(lanes, VALUE + lane)
    radius = abs(value) / load_float(lanes, SLOPE + lane)
    step = load_float(lanes, STEP + lane)
    before = load_float(lanes, RADIUS + lane)
    if step > before and (value < _ZERO or radius + before < step):
        # Through the surface, or the spheres do not overlap: back to where the last one ends. In the first case the
        # crossing lies between, within the rest of the step.
        store_float(lanes, T + lane, t - step + before)
        store_float(lanes, STEP + lane, step - before if value < _ZERO else _ZERO)
        store_float(lanes, RADIUS + lane, _ZERO)
        return value < _ZERO
    footprint = load_float(lanes, NEAR + lane) + t * load_float(lanes, GROWTH + lane)
    if value < _ZERO or radius < footprint:
        store_float(lanes, STEP + lane, _ZERO)
        return True
    if t + radius >= leave:
        # The sphere reaches the end of the region, beyond which another constant holds.
        store_float(lanes, T + lane, leave)
        store_float(lanes, STEP + lane, _ZERO)
        return False
    step = radius * relaxation
    step = step if t + step < leave else radius
    store_float(lanes, RADIUS + lane, radius)
    store_float(lanes, STEP + lane, step)
    store_float(lanes, T + lane, t + step)
    return False


@device
def _fixed_step(lanes, lane, step):
    """One step of the other marcher. Returns whether the field is below zero here."""
    if load_float(lanes, VALUE + lane) < _ZERO:
        return True
    start = load_float(lanes, START + lane) * load_float(lanes, SCALE + lane)
    number = np.float32(math.floor((start + load_float(lanes, T + lane)) / step + _HALF)) + _ONE
    store_float(lanes, T + lane, number * step - start)
    return False


@device
def _on_step(lanes, lane, t, step):
    """The first place from `t` on where a step ends; they are counted from the ray's origin, wherever it enters."""
    start = load_float(lanes, START + lane) * load_float(lanes, SCALE + lane)
    return max(t, np.float32(math.ceil((start + t) / step)) * step - start)


@device
def march_packet(fields, k, lanes, active, march, slots):
    """Follow the rays of the lanes `active` (bits) through field `k`; those that arrive are returned, as bits, with
    their places in T. Steps are counted in STEPS."""
    arrived = _NONE
    while active != _NONE:
        todo, ready = active, _NONE
        while todo != _NONE:
            bit = todo & -todo
            lane = np.int64(lowest_bit(todo))
            todo &= todo - _BIT
            step = march.step * load_float(lanes, SCALE + lane)
            left = load_float(lanes, T + lane) >= load_float(lanes, EXIT + lane)
            tired = load_float(lanes, COUNT + lane) >= march.max_steps
            if tired or (left and not _next_region(fields, k, lanes, lane, step)):
                active &= ~bit
                continue
            _move(lanes, lane)
            ready |= bit
        if ready == _NONE:
            break
        evaluate_lanes(fields, k, lanes, ready, slots)
        while ready != _NONE:
            bit = ready & -ready
            lane = np.int64(lowest_bit(ready))
            ready &= ready - _BIT
            store_float(lanes, STEPS + lane, load_float(lanes, STEPS + lane) + _ONE)
            store_float(lanes, COUNT + lane, load_float(lanes, COUNT + lane) + _ONE)
            if march.step > _ZERO:
                here = _fixed_step(lanes, lane, march.step * load_float(lanes, SCALE + lane))
            else:
                here = _sphere_step(lanes, lane, march.relaxation)
            if here:
                arrived |= bit
                active &= ~bit
    return arrived
