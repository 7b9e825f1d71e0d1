"""Pictures as textures."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3
from isophote.kernels.texture.contract import CLAMP, MIRROR, NEAREST, PICTURE, REPEAT, U, V, answer, open_place

__all__ = ["image"]

_HALF, _ONE = np.float32(0.5), np.float32(1)
# Row of `decode` that alpha goes through.
_PLAIN = np.int64(1)
# Coordinates of a clamped or mirrored texture beyond this many pictures are cut, so that texel numbers stay exact.
_BOUND = np.float32(2**10)


@device
def _wrapped(i, n, wrap):
    """Number of a texel column or row from 0 to n − 1."""
    if wrap == CLAMP:
        return min(max(i, 0), n - 1)
    if wrap == MIRROR:
        k = i % (2 * n)
        return k if k < n else 2 * n - 1 - k
    return i % n


@device
def _texel(textures, number, x, y):
    codes = textures.codes
    width, height, wrap = codes[number, 1], codes[number, 2], codes[number, 3]
    at = codes[number, 0] + _wrapped(y, height, wrap) * width + _wrapped(x, width, wrap)
    row = codes[number, 5]
    if row == 2:
        texels = textures.floats
        return vec3(texels[at, 0], texels[at, 1], texels[at, 2]), texels[at, 3]
    texels, decode = textures.bytes, textures.decode
    colour = vec3(decode[row, texels[at, 0]], decode[row, texels[at, 1]], decode[row, texels[at, 2]])
    return colour, decode[_PLAIN, texels[at, 3]]


@device
def _between(first, second, share):
    """(colour, alpha) that much of the way from one to another."""
    rest = _ONE - share
    return first[0] * rest + second[0] * share, first[1] * rest + second[1] * share


@device
def _colour(textures, number, u, v):
    """Linear (colour, alpha) of picture `number` at (u, v), whose origin is the picture's lower left corner."""
    codes = textures.codes
    # The fractional part first: large coordinates would overflow the texel's number.
    x = (u - math.floor(u) if codes[number, 3] == REPEAT else min(max(u, -_BOUND), _BOUND)) * codes[number, 1]
    y = math.floor(v) + _ONE - v if codes[number, 3] == REPEAT else _ONE - min(max(v, -_BOUND), _BOUND)
    y *= codes[number, 2]
    if codes[number, 4] == NEAREST:
        return _texel(textures, number, np.int64(math.floor(x)), np.int64(math.floor(y)))
    x, y = x - _HALF, y - _HALF
    left, upper = math.floor(x), math.floor(y)
    a, b = np.float32(x - left), np.float32(y - upper)
    i, j = np.int64(left), np.int64(upper)
    top = _between(_texel(textures, number, i, j), _texel(textures, number, i + 1, j), a)
    low = _between(_texel(textures, number, i, j + 1), _texel(textures, number, i + 1, j + 1), a)
    return _between(top, low, b)


@entry
def image(textures, node, record):
    """The picture's colour; bilinear between the centres of pixels, or the nearest one's."""
    place = open_place(textures, node, record)
    number = np.int64(place.textures.nodes[node, PICTURE])
    colour, alpha = _colour(place.textures, number, place.record[U], place.record[V])
    return answer(place, colour, alpha)
