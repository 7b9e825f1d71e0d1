"""Soft shadows and occlusion out of the values of a field.

On its way to a light a ray passes an obstacle at the distance h after the length t. A light that is seen under the half
angle atan w is whole as long as h / t ≥ w everywhere; what is left of it is told by the least h / (w t) (Quílez, "soft
shadows"). Between two steps s apart the nearest approach is found where both spheres meet, at y = (s² + h² − h'²) / 2 s
before the second: d = √(h² − y²), after the length t − y (after Aaltonen, 2018). Where w → 0, the shadow is the hard
one.

Occlusion compares the field's values at a few points along the normal with their distances, which are equal where
nothing is around.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.accel import field_layout as layout
from isophote.kernels.accel.field_march import affine_doubles, tape_at
from isophote.kernels.accel.surface import MATERIAL
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, lowest_bit, store_float, store_int
from isophote.kernels.base.vec import dot, vec3
from isophote.kernels.trace.sphere_march import DX, DY, DZ, END, GROWTH, NEAR, OX, OY, OZ, RADIUS, SCALE, STEP, T
from isophote.kernels.trace.sphere_packet import LANES, TAPE, VALUE, X, Y, Z, evaluate_lanes, region_at
from isophote.kernels.trace.sphere_pixels import NEARBY, NORMAL, OPEN, PLACE, lane_vec3

__all__ = ["LIGHT", "is_cut_field", "load_shadow_ray", "may_dim", "occlude_packet", "shade_packet"]

_ZERO, _HALF, _ONE, _TWO = np.float32(0), np.float32(0.5), np.float32(1), np.float32(2)
_FAR, _LEAST_SLOPE = np.float32(np.inf), np.float32(1e-6)
_BIT, _NONE = np.int32(1), np.int32(0)
_NOTHING, _DOUBLE_ONE = 0.0, 1.0
# Below this nothing of a light is left.
_DARK = np.float32(1e-3)
# Steps are at least so long in parts of the way so far: soft shadows need no more.
_LEAST_STEP = np.float32(0.01)
# The first step off the surface, in parts of the details' size, and how far a light without a place is.
_FIRST_STEP, _BEYOND = np.float32(2.0**-8), np.float32(4)
# Rows in place of those that only the first ray needs: how wide the light is seen, and what is left of it.
WIDTH, LIGHT = NEAR, GROWTH
_TAPS = np.int64(5)


@device
def is_cut_field(scene, k):
    """Whether field `k` has holes, of which its values know nothing: then its shadow is hard, and it hides no sky."""
    row = np.int64(scene.fields.numbers[k, layout.SURFACE])
    return scene.materials.cuts[np.int64(scene.surfaces.items[row, MATERIAL])] >= 0


@device
def distance_to_field(fields, k, x, y, z):
    """Distance in the field's space from a point to the box that holds it."""
    cubes, low, high = fields.cubes, layout.LOW, layout.HIGH
    dx = max(max(cubes[k, low] - x, x - cubes[k, high]), _ZERO)
    dy = max(max(cubes[k, low + 1] - y, y - cubes[k, high + 1]), _ZERO)
    dz = max(max(cubes[k, low + 2] - z, z - cubes[k, high + 2]), _ZERO)
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@device
def _place(fields, k, lanes, lane, x, y, z):
    """Put a lane's point at a place, with a tape that holds there."""
    store_float(lanes, X + lane, x)
    store_float(lanes, Y + lane, y)
    store_float(lanes, Z + lane, z)
    if distance_to_field(fields, k, x, y, z) > _ZERO:
        tape = np.int64(fields.numbers[k, layout.ROOT_TAPE])
    else:
        _, tape, _, _, _, _ = region_at(fields, k, x, y, z)
    store_int(lanes, TAPE + lane, np.int32(tape))


@device
def may_dim(fields, k, start, direction, width):
    """Whether any of field `k`'s ball is seen from a place within the half angle atan `width` of a unit direction."""
    cubes, at = fields.cubes, layout.BALL
    to_ball = vec3(cubes[k, at] - start.x, cubes[k, at + 1] - start.y, cubes[k, at + 2] - start.z)
    radius, distance2 = cubes[k, at + 3], dot(to_ball, to_ball)
    if distance2 <= radius * radius:
        return True
    # cos(α + β) for sin α = radius / distance, tan β = width.
    inverse = _ONE / math.sqrt(distance2)
    sine, cosine = radius * inverse, math.sqrt(_ONE - radius * radius / distance2)
    hypotenuse = math.sqrt(_ONE + width * width)
    return dot(to_ball, direction) * inverse * hypotenuse >= cosine - sine * width


@device
def load_shadow_ray(fields, k, lanes, lane, start, direction, distance, width):
    """Load a lane with a ray to a light, unit `direction`, at a `distance` (inf: beyond all), seen under `width`."""
    m, cubes = fields.to_object, fields.cubes
    x, y, z = affine_doubles(m, k, np.float64(start.x), np.float64(start.y), np.float64(start.z), _DOUBLE_ONE)
    a, b, c = affine_doubles(m, k, np.float64(direction.x), np.float64(direction.y), np.float64(direction.z), _NOTHING)
    speed = math.sqrt(a * a + b * b + c * c)
    for row, o, d in ((0, x, a), (1, y, b), (2, z, c)):
        store_float(lanes, OX + row * LANES + lane, np.float32(o))
        store_float(lanes, DX + row * LANES + lane, np.float32(d / speed))
    side = cubes[k, layout.SIDE]
    # Farther away than this all of the field lies behind.
    beyond = _BEYOND * (side + distance_to_field(fields, k, np.float32(x), np.float32(y), np.float32(z)))
    store_float(lanes, END + lane, min(distance * np.float32(speed), beyond))
    store_float(lanes, T + lane, cubes[k, layout.DETAIL] * _FIRST_STEP)
    store_float(lanes, RADIUS + lane, _FAR)
    store_float(lanes, SCALE + lane, np.float32(speed))
    store_float(lanes, WIDTH + lane, width)
    store_float(lanes, LIGHT + lane, _ONE)


@device
def _to_next(fields, k, lanes, lane):
    """Bring a lane to the next place where the field may dim the light. Returns whether there is one."""
    ox, oy, oz = load_float(lanes, OX + lane), load_float(lanes, OY + lane), load_float(lanes, OZ + lane)
    dx, dy, dz = load_float(lanes, DX + lane), load_float(lanes, DY + lane), load_float(lanes, DZ + lane)
    end, dimming = load_float(lanes, END + lane), load_float(lanes, WIDTH + lane) * load_float(lanes, LIGHT + lane)
    while True:
        t = load_float(lanes, T + lane)
        if t >= end:
            return False
        x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
        away = distance_to_field(fields, k, x, y, z)
        if away == _ZERO or away < dimming * t:
            _place(fields, k, lanes, lane, x, y, z)
            return True
        store_float(lanes, T + lane, t + max(away, t * _LEAST_STEP))
        # The last sphere is not the one before the next.
        store_float(lanes, RADIUS + lane, _FAR)


@device
def _dim(fields, k, lanes, lane):
    """Take the value at a lane's place into account, and step on. Returns whether any light is left."""
    root = np.int64(fields.numbers[k, layout.ROOT_TAPE])
    # The constant of the whole field, not of the region: places of steps are seen in penumbras, and must not jump.
    slope = tape_at(fields, root, root).lipschitz
    if not slope < _FAR:
        slope = max(tape_at(fields, root, np.int64(load_int(lanes, TAPE + lane))).lipschitz, _LEAST_SLOPE)
    t, light = load_float(lanes, T + lane), load_float(lanes, LIGHT + lane)
    # The value itself is the best guess of the distance; only steps must be proven.
    h, before = load_float(lanes, VALUE + lane), load_float(lanes, RADIUS + lane)
    if h <= _ZERO:
        light = _ZERO
    else:
        # The nearest approach lies behind, where the last sphere and this one meet; where the field rises that was told
        # by the last step.
        last = load_float(lanes, STEP + lane)
        y = _ZERO
        if h < before and before < _FAR:
            y = min(max((last * last + (h * h - before * before)) / (last + last), _ZERO), min(h, last))
        near = math.sqrt(max(h * h - y * y, _ZERO))
        light = min(light, near / (load_float(lanes, WIDTH + lane) * (t - y)))
    light = light if light > _DARK else _ZERO
    store_float(lanes, LIGHT + lane, light)
    store_float(lanes, RADIUS + lane, h)
    # Where the light may be dimmed more, rays go slower, or shadows show their steps as bands.
    whole = h > min(before, _TWO * load_float(lanes, WIDTH + lane) * t)
    step = h / max(slope, _ONE)
    step = max(step if whole else step * _HALF, t * _LEAST_STEP)
    store_float(lanes, STEP + lane, step)
    store_float(lanes, T + lane, t + step)
    return light > _ZERO


@device
def shade_packet(fields, k, lanes, active, most, slots):
    """What field `k` leaves of the light of each lane, 0 to 1, into the row LIGHT."""
    for _ in range(most):
        todo, ready = active, _NONE
        while todo != _NONE:
            bit = todo & -todo
            lane = np.int64(lowest_bit(todo))
            todo &= todo - _BIT
            if _to_next(fields, k, lanes, lane):
                ready |= bit
        if ready == _NONE:
            return
        evaluate_lanes(fields, k, lanes, ready, slots)
        active = ready
        while ready != _NONE:
            bit = ready & -ready
            lane = np.int64(lowest_bit(ready))
            ready &= ready - _BIT
            if not _dim(fields, k, lanes, lane):
                active &= ~bit


@device
def occlude_packet(scene, lanes, active, pixels, reach, slots):
    """How open the surroundings of each lane's surface are, 0 to 1, into the row OPEN of `pixels`.

    1 − Σ wᵢ max(hᵢ − v(p + hᵢ n), 0) / hᵢ / Σ wᵢ for distances hᵢ = i reach / 5, and weights wᵢ = 2⁻ⁱ.
    """
    for lane in range(LANES):
        store_float(pixels, OPEN + lane, _ONE)
    weight, total = _ONE, _ONE - np.float32(2.0**-5)
    for tap in range(1, _TAPS + 1):
        height = reach * np.float32(tap) / np.float32(_TAPS)
        weight *= _HALF
        _values_above(scene, lanes, active, pixels, height, slots)
        for lane in range(LANES):
            missing = max(height - load_float(pixels, NEARBY + lane), _ZERO) / height
            store_float(pixels, OPEN + lane, load_float(pixels, OPEN + lane) - weight / total * min(missing, _ONE))


@device
def _values_above(scene, lanes, active, pixels, height, slots):
    """The least value of all fields `height` above each lane's surface, in the world's units, into the row NEARBY."""
    for lane in range(LANES):
        store_float(pixels, NEARBY + lane, height)
    fields = scene.fields
    m = fields.to_object
    for k in range(fields.numbers.rows):
        if is_cut_field(scene, k):
            continue
        todo, ready = active, _NONE
        stretch = fields.cubes[k, layout.STRETCH]
        while todo != _NONE:
            bit = todo & -todo
            lane = np.int64(lowest_bit(todo))
            todo &= todo - _BIT
            p = lane_vec3(pixels, PLACE, lane) + height * lane_vec3(pixels, NORMAL, lane)
            x, y, z = affine_doubles(m, k, np.float64(p.x), np.float64(p.y), np.float64(p.z), _DOUBLE_ONE)
            a, b, c = np.float32(x), np.float32(y), np.float32(z)
            if distance_to_field(fields, k, a, b, c) * stretch < height:
                _place(fields, k, lanes, lane, a, b, c)
                ready |= bit
        if ready != _NONE:
            evaluate_lanes(fields, k, lanes, ready, slots)
        while ready != _NONE:
            lane = np.int64(lowest_bit(ready))
            ready &= ready - _BIT
            value = load_float(lanes, VALUE + lane) * stretch
            store_float(pixels, NEARBY + lane, min(load_float(pixels, NEARBY + lane), value))
