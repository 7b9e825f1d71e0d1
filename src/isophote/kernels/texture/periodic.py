"""Patterns that repeat evenly, each a mean over what is looked at, in closed form.

A pattern of period 1 with values s(x) has the antiderivative S; its mean over a width w around x is
(S(x + w/2) − S(x − w/2)) / w. Source for checkers: Apodaca, Gritz, "Advanced RenderMan", 2000, chapter 11.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, load_vec3, vec3
from isophote.kernels.texture.combine import child
from isophote.kernels.texture.contract import CHILD_A, OWN, OWN_A, OWN_B, open_place
from isophote.kernels.texture.lattice import answer_number, datum, fraction

__all__ = [
    "ANGULAR",
    "LINEAR",
    "RADIAL",
    "SAW",
    "SINE",
    "SPHERICAL",
    "SQUARE",
    "TRIANGLE",
    "checker",
    "coordinate",
    "grid",
    "waves",
]

LINEAR, RADIAL, SPHERICAL, ANGULAR = 0, 1, 2, 3
SINE, SAW, TRIANGLE, SQUARE = 0, 1, 2, 3

_FIRST = np.int64(0)
_ZERO, _QUARTER, _HALF, _ONE, _TWO = (np.float32(x) for x in (0, 0.25, 0.5, 1, 2))
_LEAST, _MOST = np.float32(1e-4), np.float32(2.0**16)
# Borders lie so many cells beside whole numbers: faces of solids often lie there, and would flicker.
_ASIDE = np.float32(2.0**-10)
_TURN = np.float32(2 * math.pi)


@device
def _diameter(place, k):
    """How wide the ellipse is along axis `k` of the texture's space."""
    a, b = place.record[OWN_A + k], place.record[OWN_B + k]
    return _TWO * np.sqrt(a * a + b * b)


@device
def _bounded(width):
    """A width in periods; over very many of them, means do not depend on it."""
    return width if width < _MOST else _MOST


@device
def _below(x, share):
    """∫₀ˣ of 1 where the fractional part is below `share`, else 0."""
    whole = np.floor(x)
    return whole * share + min(x - whole, share)


@device
def _part(x, width, share):
    """The part of a width around x where the fractional part is below `share`."""
    x = fraction(x)
    if width < _LEAST:
        return _ONE if x < share else _ZERO
    low = fraction(x - _HALF * width)
    # Exactly, where there is but one of both.
    if low + width <= share:
        return _ONE
    if low >= share and low + width <= _ONE:
        return _ZERO
    return (_below(low + width, share) - _below(low, share)) / width


@device
def _sign(place, k, scale):
    """Mean along an axis of what is 1 in every other cell and −1 in those between."""
    x = (place.record[OWN + k] * scale + _ASIDE) * _HALF
    return _TWO * _part(x, _bounded(_diameter(place, k) * scale * _HALF), _HALF) - _ONE


@entry
def checker(textures, node, record):
    """0 and 1 in cubes by turns: the chance of each from the mean of their product of signs. Data: size of a cube."""
    place = open_place(textures, node, record)
    scale = _ONE / datum(place, _FIRST)
    product = _sign(place, 0, scale) * _sign(place, 1, scale) * _sign(place, 2, scale)
    return answer_number(place, _HALF - _HALF * product)


@entry
def grid(textures, node, record):
    """1 within the width of a line around planes across some of the axes. Data: size of a cell, width in cells, and for
    each axis whether it counts."""
    place = open_place(textures, node, record)
    scale, width = _ONE / datum(place, 0), datum(place, 1)
    clear = _ONE
    for k in range(3):
        if datum(place, 2 + k) != _ZERO:
            x = place.record[OWN + k] * scale + _HALF * width
            clear *= _ONE - _part(x, _bounded(_diameter(place, k) * scale), width)
    return answer_number(place, _ONE - clear)


@device
def _frame(place, k):
    return vec3(datum(place, k), datum(place, k + 1), datum(place, k + 2))


@device
def _coordinate(place):
    """(coordinate, how wide it is looked at), in sizes. Data: shape, size, three axes of a frame."""
    record = place.record
    p, a, b = load_vec3(record, OWN), load_vec3(record, OWN_A), load_vec3(record, OWN_B)
    shape, size = np.int64(datum(place, 0)), datum(place, 1)
    axis, x_axis, y_axis = _frame(place, 2), _frame(place, 5), _frame(place, 8)
    x, y, z = dot(p, x_axis), dot(p, y_axis), dot(p, axis)
    if shape == LINEAR:
        value, slope = z, axis
    elif shape == RADIAL:
        value = np.sqrt(x * x + y * y)
        slope = (x_axis * x + y_axis * y) * (_ONE / value if value > _ZERO else _ZERO)
    elif shape == SPHERICAL:
        value = np.sqrt(dot(p, p))
        slope = p * (_ONE / value if value > _ZERO else _ZERO)
    else:
        # ANGULAR
        square = x * x + y * y
        value = np.float32(math.atan2(y, x)) / _TURN
        value += _ONE if value < _ZERO else _ZERO
        slope = (y_axis * x - x_axis * y) * (_ONE / (square * _TURN) if square > _ZERO else _ZERO)
    across, along = dot(slope, a), dot(slope, b)
    return value / size, _bounded(_TWO * np.sqrt(across * across + along * along) / size)


@entry
def coordinate(textures, node, record):
    """How far it is along a line, from a line or from a point, or in turns around a line; all in sizes."""
    place = open_place(textures, node, record)
    value, _ = _coordinate(place)
    return answer_number(place, value)


@device
def _wave(profile, x, width, share):
    """Mean of a profile of period 1 over a width around x, from 0 to 1."""
    if profile == SQUARE:
        return _part(x, width, share)
    x = fraction(x)
    if profile == SINE:
        half = np.float32(math.pi) * width
        left = np.float32(math.sin(half)) / half if half > _LEAST else _ONE
        return _HALF + _HALF * left * np.float32(math.sin(_TURN * x))
    if width < _LEAST:
        return x if profile == SAW else _ONE - abs(_TWO * x - _ONE)
    high, low = x + _HALF * width, x - _HALF * width
    return (_area(profile, high) - _area(profile, low)) / width


@device
def _area(profile, x):
    """∫₀ˣ of the sawtooth x − ⌊x⌋, or of the triangle 1 − |2 (x − ⌊x⌋) − 1|."""
    whole = np.floor(x)
    rest = x - whole
    if profile == SAW:
        return _HALF * (whole + rest * rest)
    if rest < _HALF:
        return _HALF * whole + rest * rest
    return _HALF * whole + _HALF - (_ONE - rest) * (_ONE - rest)


@entry
def waves(textures, node, record):
    """A profile along a coordinate, moved by so many periods as the child's red channel is above 1/2. Data: those of
    `coordinate`, profile, share of what is high, periods."""
    place = open_place(textures, node, record)
    x, width = _coordinate(place)
    profile, share, moved = np.int64(datum(place, 11)), datum(place, 12), datum(place, 13)
    if moved != _ZERO:
        by, _ = child(place, CHILD_A)
        x += moved * (_TWO * by.x - _ONE)
    return answer_number(place, _wave(profile, x, width, share))
