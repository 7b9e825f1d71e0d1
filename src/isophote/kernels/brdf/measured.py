"""Measured isotropic reflectance: tables over the half and the difference angle, in MERL's layout.

Data: `f` in (HALF, DIFFERENCE, TURN, 3) cells of √(θ_h / 90°), θ_d / 90° and φ_d / 180°, then the cumulative chances of
the rings of θ_h that half directions are sampled from. Values are those of the cells' middles, linear in between.
No slots. Source: Matusik et al.: "A Data-Driven Reflectance Model", SIGGRAPH 2003; Rusinkiewicz: "A New Change of
Variables for Efficient BRDF Representation", EGWR 1998.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, length, normalise, vec3
from isophote.kernels.base.warp import INV_PI, PI
from isophote.kernels.brdf.contract import (
    answer,
    answer_sample,
    cosine_direction,
    datum,
    into_of,
    no_sample,
    open_lobe,
    out_of,
    point_of,
)

__all__ = ["DIFFERENCE", "HALF", "TURN", "evaluate_measured", "sample_measured"]

HALF, DIFFERENCE, TURN = 90, 90, 180

_ZERO, _MIDDLE, _ONE, _TWO, _FOUR = (np.float32(k) for k in (0, 0.5, 1, 2, 4))
_HALVES, _DIFFERENCES, _TURNS = (np.float32(k) for k in (HALF, DIFFERENCE, TURN))
_CHANCES = np.int64(HALF * DIFFERENCE * TURN * 3)
_CHANNELS = np.int64(3)
_HALF_PI = np.float32(math.pi / 2)
_HALF_INV_PI = np.float32(0.5 / math.pi)
_TINY = np.float32(1e-12)
# How often half directions are sampled by the table, and not the cosine.
_SHARP = np.float32(0.5)


@device
def _cell(lobe, i, j, k):
    at = ((i * DIFFERENCE + j) * TURN + k) * _CHANNELS
    return vec3(datum(lobe, at), datum(lobe, at + 1), datum(lobe, at + 2))


@device
def _between(x, count):
    """(cell, fraction towards the next) of a coordinate in cells."""
    x = min(max(x - _MIDDLE, _ZERO), count - _ONE)
    i = min(np.int64(x), np.int64(count) - 2)
    return i, x - np.float32(i)


@device
def _turned(lobe, i, j, k, c):
    """Linear over φ_d, which comes round after half a turn."""
    after = k + 1 if k + 1 < TURN else np.int64(0)
    return _cell(lobe, i, j, k) * (_ONE - c) + _cell(lobe, i, j, after) * c


@device
def _reflectance(lobe, out, into):
    """f."""
    h = normalise(out + into)
    sine = math.sqrt(h.x * h.x + h.y * h.y)
    half = math.atan2(sine, h.z)
    turn_x, turn_y = (h.x / sine, h.y / sine) if sine > _ZERO else (_ONE, _ZERO)
    difference = math.atan2(length(into - out), length(into + out))
    along = (into.x * turn_x + into.y * turn_y) * h.z - into.z * sine
    turn = math.atan2(into.y * turn_x - into.x * turn_y, along)
    turn = turn + PI if turn < _ZERO else turn
    i, a = _between(math.sqrt(half / _HALF_PI) * _HALVES, _HALVES)
    j, b = _between(difference / _HALF_PI * _DIFFERENCES, _DIFFERENCES)
    z = turn * INV_PI * _TURNS - _MIDDLE
    floor = math.floor(z)
    k, c = np.int64(floor) % TURN, np.float32(z - floor)
    upper = _turned(lobe, i, j, k, c) * (_ONE - b) + _turned(lobe, i, j + 1, k, c) * b
    lower = _turned(lobe, i + 1, j, k, c) * (_ONE - b) + _turned(lobe, i + 1, j + 1, k, c) * b
    return upper * (_ONE - a) + lower * a


@device
def _edge(i):
    """1 − cosθ_h where ring `i` begins, as 2 sin²(θ/2)."""
    x = np.float32(i) / _HALVES
    sine = math.sin(_MIDDLE * _HALF_PI * x * x)
    return _TWO * sine * sine


@device
def _density(lobe, i):
    """Of half directions in ring `i`."""
    chance = datum(lobe, _CHANCES + i + 1) - datum(lobe, _CHANCES + i)
    return chance * _HALF_INV_PI / (_edge(i + 1) - _edge(i))


@device
def _value(lobe, out, into):
    """(f cosθ, density)."""
    h = normalise(out + into)
    theta = math.atan2(math.sqrt(h.x * h.x + h.y * h.y), h.z)
    ring = min(np.int64(math.sqrt(theta / _HALF_PI) * _HALVES), np.int64(HALF - 1))
    density = _density(lobe, ring) / (_FOUR * max(dot(out, h), _TINY))
    return _reflectance(lobe, out, into) * into.z, _SHARP * density + (_ONE - _SHARP) * into.z * INV_PI


@entry
def evaluate_measured(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    into = into_of(lobe)
    if into.z <= _ZERO:
        return answer(lobe, into * _ZERO, _ZERO)
    value, density = _value(lobe, out_of(lobe), into)
    return answer(lobe, value, density)


@device
def _half_direction(lobe, x, y):
    """A half direction: a ring by its chance, evenly over it."""
    r2 = min(x * x + y * y, _ONE)
    low, count = np.int64(0), np.int64(HALF)
    while count > 1:
        middle = count >> 1
        low += middle if datum(lobe, _CHANCES + low + middle) <= r2 else 0
        count -= middle
    first, last = datum(lobe, _CHANCES + low), datum(lobe, _CHANCES + low + 1)
    part = (r2 - first) / max(last - first, _TINY)
    below = _edge(low) + (_edge(low + 1) - _edge(low)) * min(part, _ONE)
    s = math.sqrt(below * (_TWO - below) / max(r2, _TINY))
    return vec3(s * x, s * y, _ONE - below)


@entry
def sample_measured(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    x, y, pick = point_of(lobe)
    into = cosine_direction(x, y)
    if pick < _SHARP:
        h = _half_direction(lobe, x, y)
        into = h * (_TWO * dot(out, h)) - out
    if into.z <= _ZERO:
        return no_sample(lobe)
    value, density = _value(lobe, out, into)
    return answer_sample(lobe, into, value, density)
