"""What a hit on a field says about the surface: place, normal, and how far off it the next ray must start.

The gradient is that of the tape, exactly differentiated; along it the hit is moved onto the surface by one step of
Newton's. How far rounding reaches is not guessed but looked at: of several distances to both sides of the place, the
least is taken at which the field has clearly the sign that it should have there, evaluated as the next ray will.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel import field_layout as layout
from isophote.kernels.accel.field_layout import FIELDS
from isophote.kernels.accel.field_march import affine_doubles, slots_at, tape_at
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import bits, load16, load_float, load_int, lowest_bit, store_float
from isophote.kernels.base.vec import dot, length, maximum_component, normalise, vec3
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import open_field_data
from isophote.kernels.forms.interpreters import gradients_on, values_on
from isophote.kernels.forms.tape_gradient import GRADIENT_SLOT

__all__ = ["field_surface"]

_ZERO, _ONE, _TWO, _QUARTER = np.float32(0), np.float32(1), np.float32(2), np.float32(0.25)
_FAR, _LEAST_SLOPE2 = np.float32(np.inf), np.float32(1e-12)
_NOTHING, _DOUBLE_ONE = 0.0, 1.0
_RESULT, _ONE_VECTOR = np.int64(op.INPUTS - 1), np.int64(1)
# The least distance off the surface in parts of the largest coordinate: a few units in its last place. Each of the
# following is twice the one before.
_LEAST_ERROR = np.float32(2.0**-22)
_TRIES, _LANES = np.int64(8), np.int64(16)
_TRY_MASK = np.int32(0xFF)
# Newton's step is at most so long in parts of the details' size.
_LONGEST_STEP = np.float32(2.0**-12)

open_fields_at = opener_at(FIELDS)


@device
def _reach(p):
    return maximum_component(vec3(abs(p.x), abs(p.y), abs(p.z)))


@device
def _gradient(fields, data, tape, p, back, slots):
    """(value, gradient) of a field at a point of its own space.

    Exactly on a surface where two arms of the expression meet, the gradient may vanish; then that of the first of
    fifteen points before it is taken, each twice as far along `back`. Zero where none has any.
    """
    step = _ZERO
    for lane in range(_LANES):
        q = p + back * step
        store_float(slots, lane, q.x)
        store_float(slots, GRADIENT_SLOT + lane, q.y)
        store_float(slots, 2 * GRADIENT_SLOT + lane, q.z)
        step = step + step if step > _ZERO else _ONE
    gradients_on(fields.interpreters, fields.rows, tape.first, tape.length, data, slots)
    at = (_RESULT + tape.length) * GRADIENT_SLOT
    value = load_float(slots, at)
    for lane in range(_LANES):
        gradient = vec3(
            load_float(slots, at + 16 + lane), load_float(slots, at + 32 + lane), load_float(slots, at + 48 + lane)
        )
        size2 = dot(gradient, gradient)
        if size2 > _LEAST_SLOPE2 and size2 < _FAR:
            return value, gradient
    return value, vec3(_ZERO, _ZERO, _ZERO)


@device
def _onto_surface(p, value, gradient, side):
    """A point moved by Newton's step, where that is short and makes sense."""
    step = value / dot(gradient, gradient)
    if abs(step) * length(gradient) < side * _LONGEST_STEP:
        return p - gradient * step
    return p


@device
def _error(fields, data, tape, k, place, normal, slope, least, slots):
    """The least of eight distances off the surface, from `least` on, at which the field's signs are clear on both
    sides; where one side has none, as in a thin wall, on the side that the normal points to. Negative where the signs
    are clear the other way round: of a value next to 0 rounding may tell the slope of the wrong side."""
    e = least
    m = fields.to_object
    for i in range(_TRIES):
        for at, q in ((i, place + normal * e), (i + _TRIES, place - normal * e)):
            x, y, z = affine_doubles(m, k, np.float64(q.x), np.float64(q.y), np.float64(q.z), _DOUBLE_ONE)
            store_float(slots, at, np.float32(x))
            store_float(slots, at + 16, np.float32(y))
            store_float(slots, at + 32, np.float32(z))
        e += e
    values_on(fields.interpreters, fields.rows, tape.first, tape.length, data, slots, _ONE_VECTOR)
    at = (_RESULT + tape.length) * 16
    e = least * slope * _QUARTER
    for i in range(_TRIES):
        store_float(slots, i, e)
        store_float(slots, i + _TRIES, -e)
        e += e
    wanted, values = load16(slots, np.int64(0)), load16(slots, at)
    outside = bits(values >= wanted) & _TRY_MASK
    inside = (bits(values <= wanted) >> np.int32(_TRIES)) & _TRY_MASK
    clear = outside & inside
    both, none = values + wanted, wanted - wanted
    against = bits(both <= none) & (bits(both >= none) >> np.int32(_TRIES)) & _TRY_MASK
    if clear == 0 and against != 0:
        return -least * np.float32(1 << lowest_bit(against))
    if clear == 0:
        clear = outside if outside != 0 else np.int32(1) << np.int32(_TRIES - 1)
    return least * np.float32(1 << lowest_bit(clear))


@entry
def field_surface(fields_address, scratch_address):
    """Place, outward unit normal and error of a hit.

    Words of the scratch: the ray's origin and direction, t, and as int32 the numbers of the field and of the tape that
    gives it there. The first seven become place, normal, error.
    """
    fields = open_fields_at(fields_address)
    words = floats_at(scratch_address, np.int64(layout.RAY_WORDS))
    slots = slots_at(fields, scratch_address)
    k = np.int64(load_int(words, np.int64(7)))
    root, number = np.int64(fields.numbers[k, layout.ROOT_TAPE]), np.int64(load_int(words, np.int64(8)))
    tape, data = tape_at(fields, root, number), open_field_data(fields.data[k])
    t = np.float64(words[6])
    hit = (words[0] + t * words[3], words[1] + t * words[4], words[2] + t * words[5])
    x, y, z = affine_doubles(fields.to_object, k, hit[0], hit[1], hit[2], _DOUBLE_ONE)
    p = vec3(np.float32(x), np.float32(y), np.float32(z))
    dx, dy, dz = affine_doubles(
        fields.to_object, k, np.float64(words[3]), np.float64(words[4]), np.float64(words[5]), _NOTHING
    )
    toward = -normalise(vec3(np.float32(dx), np.float32(dy), np.float32(dz)))
    value, gradient = _gradient(fields, data, tape, p, toward * (_reach(p) * _LEAST_ERROR), slots)
    if dot(gradient, gradient) > _ZERO:
        p = _onto_surface(p, value, gradient, fields.cubes[k, layout.DETAIL])
    else:
        # Where nothing is known of the slope, the surface faces the ray.
        gradient = toward
    m = fields.to_object
    # Normals go by the transposed inverse.
    normal = normalise(
        vec3(
            np.float32(m[k, 0] * gradient.x + m[k, 4] * gradient.y + m[k, 8] * gradient.z),
            np.float32(m[k, 1] * gradient.x + m[k, 5] * gradient.y + m[k, 9] * gradient.z),
            np.float32(m[k, 2] * gradient.x + m[k, 6] * gradient.y + m[k, 10] * gradient.z),
        )
    )
    x, y, z = affine_doubles(fields.to_world, k, np.float64(p.x), np.float64(p.y), np.float64(p.z), _DOUBLE_ONE)
    place = vec3(np.float32(x), np.float32(y), np.float32(z))
    x, y, z = affine_doubles(m, k, np.float64(normal.x), np.float64(normal.y), np.float64(normal.z), _NOTHING)
    slope = np.float32(gradient.x * x + gradient.y * y + gradient.z * z)
    least = (_reach(place) + _reach(p) * fields.cubes[k, layout.STRETCH]) * _LEAST_ERROR
    error = _error(fields, data, tape, k, place, normal, slope, least, slots)
    if error < _ZERO:
        normal, error = -normal, -error
    for at, v in ((0, place), (3, normal)):
        words[at], words[at + 1], words[at + 2] = v.x, v.y, v.z
    words[6] = error
    return np.int64(0)
