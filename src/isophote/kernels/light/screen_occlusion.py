"""Ambient occlusion out of what a picture shows: the depth of each pixel, and nothing behind it.

Places and normals are in the camera's frame, x right, y up, −z ahead. A place (x, y, z) falls on the film at

    px = cx + x / (w sx),   py = cy − y / (w sy)

with w = −z in perspective and 1 otherwise.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.random import combine, mix, unit_float
from isophote.kernels.base.sampler import SOBOL, pair
from isophote.kernels.base.table import FLOAT, FLOAT_ROWS, INT, Table
from isophote.kernels.base.vec import cross, dot, length, orthonormal, vec3

__all__ = ["SCREEN", "classic_rows", "horizon_rows"]

# `places`, `normals` (height, 3 · width): NaN places where nothing is seen. `open` (height, width): the answer.
# `radius` in metres; `samples`: points around a place, or steps to each side of a slice; `slices` through a place.
SCREEN = Table(
    "Screen",
    places=FLOAT_ROWS,
    normals=FLOAT_ROWS,
    open=FLOAT_ROWS,
    width=INT,
    height=INT,
    radius=FLOAT,
    samples=INT,
    slices=INT,
    seed=INT,
    perspective=INT,
    cx=FLOAT,
    cy=FLOAT,
    sx=FLOAT,
    sy=FLOAT,
)

_U = np.uint32
_ZERO, _QUARTER, _HALF, _ONE, _TWO = (np.float32(v) for v in (0, 0.25, 0.5, 1, 2))
_PI, _HALF_PI = np.float32(math.pi), np.float32(math.pi / 2)
# What rises by less than this part of the radius is the surface itself: what is sampled at pixels is stepped.
_SAME = np.float32(0.025)
_PATTERN, _FIRST, _SECOND = np.int64(SOBOL), np.int64(0), np.int64(1)
# What rises less above the surface, in parts of its distance, is taken for the surface.
_LEVEL = np.float32(0.02)
# Farther than this part of the radius, what rises counts less and less, and not at all from the radius on.
_FADE = np.float32(0.6)

open_screen = SCREEN.open


@device
def _at(rows, y, x):
    return vec3(rows[y, 3 * x], rows[y, 3 * x + 1], rows[y, 3 * x + 2])


@device
def _on_film(screen, p):
    """Pixel column and row of a place ahead."""
    w = -p.z if screen.perspective != 0 else _ONE
    return screen.cx + p.x / (w * screen.sx), screen.cy - p.y / (w * screen.sy)


@device
def _inside(screen, x, y):
    return (x >= 0) & (y >= 0) & (x < screen.width) & (y < screen.height)


@device
def _blocked(screen, place, normal, sample):
    """Whether what the picture shows at a place's neighbour `sample` lies before it, rises above the place's surface,
    and is not so far before it that it is another thing."""
    if screen.perspective != 0 and sample.z >= _ZERO:
        return False
    px, py = _on_film(screen, sample)
    x, y = np.int64(math.floor(px)), np.int64(math.floor(py))
    if not _inside(screen, x, y):
        return False
    seen = _at(screen.places, y, x)
    before = seen.z - sample.z
    rises = dot(seen - place, normal) > _SAME * screen.radius
    return (before > _ZERO) & rises & (abs(seen.z - place.z) < screen.radius)


@kernel
def classic_rows(screen_words, first, last):
    """The part of `samples` points in the half ball above each place that lies before what the picture shows, for rows
    first ≤ y < last (Mittring: "Finding Next Gen: CryEngine 2", SIGGRAPH 2007 courses, with the normal's half ball and
    a range beyond which nothing counts)."""
    screen = open_screen(screen_words)
    for y in range(first, last):
        for x in range(screen.width):
            place = _at(screen.places, y, x)
            if place.z != place.z:
                continue
            screen.open[y, x] = _ONE - _classic(screen, place, _at(screen.normals, y, x), y * screen.width + x)


@device
def _classic(screen, place, normal, pixel):
    tangent, bitangent = orthonormal(normal)
    blocked = np.int64(0)
    for k in range(screen.samples):
        # Cosine-weighted directions; radii as even in length, for what is near counts most.
        u, v = pair(_PATTERN, screen.seed, pixel, k, screen.samples, _FIRST)
        reach, _ = pair(_PATTERN, screen.seed, pixel, k, screen.samples, _SECOND)
        across, angle = math.sqrt(u), _TWO * _PI * v
        a, b, c = across * math.cos(angle), across * math.sin(angle), math.sqrt(_ONE - u)
        sample = place + (tangent * a + bitangent * b + normal * c) * (screen.radius * reach)
        blocked += _blocked(screen, place, normal, sample)
    return np.float32(blocked) / np.float32(screen.samples)


@kernel
def horizon_rows(screen_words, first, last):
    """1/π ∫ v cosθ dω below the horizons of slices through each place, for rows first ≤ y < last
    (Jiménez, Wu, Pesce, Jarabo: "Practical Realtime Strategies for Accurate Indirect Occlusion", 2016)."""
    screen = open_screen(screen_words)
    for y in range(first, last):
        for x in range(screen.width):
            place = _at(screen.places, y, x)
            if place.z != place.z:
                continue
            screen.open[y, x] = _horizons(screen, x, y, place, _at(screen.normals, y, x))


@device
def _horizons(screen, x, y, place, normal):
    view = vec3(_ZERO, _ZERO, _ONE)
    if screen.perspective != 0:
        view = place * (-_ONE / length(place))
    width = (-place.z if screen.perspective != 0 else _ONE) * screen.sx
    reach = screen.radius / width
    key = combine(_U(screen.seed), _U(y * screen.width + x))
    turn, shift = unit_float(mix(key)), unit_float(mix(_U(key ^ _U(0x9E3779B9))))
    total = _ZERO
    for k in range(screen.slices):
        angle = _PI * (np.float32(k) + turn) / np.float32(screen.slices)
        c, s = math.cos(angle), math.sin(angle)
        along = vec3(c, s, _ZERO)
        axis = cross(along, view)
        axis = axis * (_ONE / max(length(axis), np.float32(1e-6)))
        flat = normal - axis * dot(normal, axis)
        size = length(flat)
        if size < np.float32(1e-6):
            continue
        tilt = math.acos(min(max(dot(flat, view) / size, -_ONE), _ONE))
        tilt = tilt if dot(along - view * dot(along, view), flat) >= _ZERO else -tilt
        low = max(-math.acos(_highest(screen, x, y, place, normal, view, -c, s, reach, shift)), tilt - _HALF_PI)
        high = min(math.acos(_highest(screen, x, y, place, normal, view, c, -s, reach, shift)), tilt + _HALF_PI)
        total += size * (_arc(low, tilt) + _arc(high, tilt))
    return min(total / np.float32(screen.slices), _ONE)


@device
def _arc(horizon, tilt):
    """Integral of the cosine's part from the view to a horizon, in a slice whose normal is tilted."""
    return _QUARTER * (math.cos(tilt) - math.cos(_TWO * horizon - tilt) + _TWO * horizon * math.sin(tilt))


@device
def _highest(screen, x, y, place, normal, view, dx, dy, reach, shift):
    """Cosine between the view and the highest thing seen from a place in a direction on the film (dy down)."""
    highest = -_ONE
    for k in range(screen.samples):
        part = (np.float32(k) + shift) / np.float32(screen.samples)
        # Steps grow with the distance, and the first is a pixel away.
        step = _ONE + part * part * max(reach - _ONE, _ZERO)
        sx = np.int64(math.floor(np.float32(x) + _HALF + dx * step))
        sy = np.int64(math.floor(np.float32(y) + _HALF + dy * step))
        if not _inside(screen, sx, sy):
            break
        rise = _at(screen.places, sy, sx) - place
        distance = length(rise)
        # Samples stand in the middle of pixels beside the slice: what hardly rises is the surface itself.
        if not distance < screen.radius or dot(rise, normal) <= _LEVEL * distance:
            continue
        fade = min((screen.radius - distance) / ((_ONE - _FADE) * screen.radius), _ONE)
        cosine = dot(rise, view) / distance
        highest = max(highest, cosine * fade - (_ONE - fade))
    return highest
