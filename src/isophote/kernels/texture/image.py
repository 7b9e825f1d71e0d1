"""Pictures as textures, from the texels next to a place.

What filtered.py shares: places in texels, and texels by their column and row.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3
from isophote.kernels.texture.contract import (
    CLAMP,
    ENCODING,
    FIRST_LEVEL,
    IN_FLOATS,
    MIRROR,
    PICTURE,
    PLAIN,
    REPEAT,
    WRAP_U,
    WRAP_V,
    U,
    V,
    answer,
    open_place,
)

__all__ = ["between", "bilinear", "bilinear_at", "nearest", "texel_at", "unit_place", "wrapped"]

_HALF, _ONE = np.float32(0.5), np.float32(1)
_FIRST_LEVEL, _WRAP_U, _WRAP_V = np.int64(FIRST_LEVEL), np.int64(WRAP_U), np.int64(WRAP_V)
_ENCODING, _PLAIN = np.int64(ENCODING), np.int64(PLAIN)
# Coordinates of a clamped or mirrored texture beyond this many pictures are cut, so that texel numbers stay exact.
_BOUND = np.float32(2**10)


@device
def wrapped(i, n, wrap):
    """Number of a texel column or row from 0 to n − 1."""
    if wrap == CLAMP:
        return min(max(i, 0), n - 1)
    if wrap == MIRROR:
        k = i % (2 * n)
        return k if k < n else 2 * n - 1 - k
    return i % n


@device
def texel_at(textures, encoding, at):
    """Linear (colour, alpha) of texel number `at`."""
    if encoding == IN_FLOATS:
        texels = textures.floats
        return vec3(texels[at, 0], texels[at, 1], texels[at, 2]), texels[at, 3]
    texels, decode = textures.bytes, textures.decode
    colour = vec3(decode[encoding, texels[at, 0]], decode[encoding, texels[at, 1]], decode[encoding, texels[at, 2]])
    return colour, decode[_PLAIN, texels[at, 3]]


@device
def between(first, second, share):
    """(colour, alpha) that much of the way from one to another."""
    rest = _ONE - share
    return first[0] * rest + second[0] * share, first[1] * rest + second[1] * share


@device
def unit_place(textures, number, u, v):
    """(x, y): texture coordinates from the upper left corner of the picture, y down, where it is looked at; in the
    first picture, if it is repeated."""
    codes = textures.codes
    # The fractional part first: large coordinates would overflow the texel's number.
    x = u - math.floor(u) if codes[number, _WRAP_U] == REPEAT else min(max(u, -_BOUND), _BOUND)
    y = math.floor(v) + _ONE - v if codes[number, _WRAP_V] == REPEAT else _ONE - min(max(v, -_BOUND), _BOUND)
    return x, y


@device
def _texel(textures, number, level, x, y):
    codes, levels = textures.codes, textures.levels
    width, height = levels[level, 1], levels[level, 2]
    x, y = wrapped(x, width, codes[number, _WRAP_U]), wrapped(y, height, codes[number, _WRAP_V])
    return texel_at(textures, codes[number, _ENCODING], levels[level, 0] + y * width + x)


@device
def bilinear_at(textures, number, level, x, y):
    """Linear (colour, alpha) of a level, a row of `levels`, at a `unit_place`."""
    x, y = x * textures.levels[level, 1] - _HALF, y * textures.levels[level, 2] - _HALF
    left, upper = math.floor(x), math.floor(y)
    a, b = np.float32(x - left), np.float32(y - upper)
    i, j = np.int64(left), np.int64(upper)
    top = between(_texel(textures, number, level, i, j), _texel(textures, number, level, i + 1, j), a)
    low = between(_texel(textures, number, level, i, j + 1), _texel(textures, number, level, i + 1, j + 1), a)
    return between(top, low, b)


@entry
def nearest(textures, node, record):
    """The picture's texel that the place lies in."""
    place = open_place(textures, node, record)
    textures, number = place.textures, np.int64(place.textures.nodes[node, PICTURE])
    x, y = unit_place(textures, number, place.record[U], place.record[V])
    level = textures.codes[number, _FIRST_LEVEL]
    x, y = math.floor(x * textures.levels[level, 1]), math.floor(y * textures.levels[level, 2])
    colour, alpha = _texel(textures, number, level, np.int64(x), np.int64(y))
    return answer(place, colour, alpha)


@entry
def bilinear(textures, node, record):
    """The picture between the centres of its four next texels."""
    place = open_place(textures, node, record)
    number = np.int64(place.textures.nodes[node, PICTURE])
    x, y = unit_place(place.textures, number, place.record[U], place.record[V])
    colour, alpha = bilinear_at(place.textures, number, place.textures.codes[number, _FIRST_LEVEL], x, y)
    return answer(place, colour, alpha)
