"""Pictures as textures, averaged over the footprint of a sample.

`trilinear` mixes two levels of the pyramid (Williams: "Pyramidal Parametrics", 1983) by the footprint's long axis.
`elliptical` sums the texels of one level under an ellipse (Heckbert: "Fundamentals of Texture Mapping and Image
Warping", 1989, on elliptical weighted averages). A pixel's square in texels, of half-axes a and b, has the covariance

    V = (a aᵀ + b bᵀ) / 3 + ρ² I

with what a texel is spread by in between, less what the level's texels have been averaged over already; the weights

    w = (1 − xᵀ (8 V)⁻¹ x)²,  where that is positive,

have the same. Ellipses beyond 16 to 1 are made wider, and the level is that at which they are one or two texels wide.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3
from isophote.kernels.texture.contract import (
    AXIS_A,
    AXIS_B,
    ENCODING,
    FIRST_LEVEL,
    LEVELS,
    PICTURE,
    WRAP_U,
    WRAP_V,
    U,
    V,
    answer,
    open_place,
)
from isophote.kernels.texture.image import between, bilinear_at, texel_at, unit_place, wrapped

__all__ = ["elliptical", "trilinear"]

_ZERO, _HALF, _ONE, _TWO = np.float32(0), np.float32(0.5), np.float32(1), np.float32(2)
_THIRD, _LARGE = np.float32(1 / 3), np.float32(1e30)
_FIRST_LEVEL, _LEVELS, _ENCODING = np.int64(FIRST_LEVEL), np.int64(LEVELS), np.int64(ENCODING)
_WRAP_U, _WRAP_V = np.int64(WRAP_U), np.int64(WRAP_V)
_AXIS_A, _AXIS_B = np.int64(AXIS_A), np.int64(AXIS_B)
# Longest ellipses, and the sharpness of the level: how many texels the short axis of a pixel is across at least.
_MOST_LONG, _TEXELS_ACROSS = np.float32(16), np.float32(1.0)
# Variance of the weights that one texel is seen with, in texels of the picture itself and of its means, which have been
# spread by 1/12 already; and 1 / R² of the weights by variances.
_SPREAD, _SPREAD_OF_MEANS, _REACH2 = np.float32(0.16), np.float32(0.12), np.float32(8)
# Where all of a pixel is this much of a texel at most, its four next texels are all that counts; the ellipse takes over
# up to twice as much.
_MAGNIFIED = np.float32(0.5)
# Levels of one row or one column have no more to tell than this variance across.
_ACROSS_ONE = np.float32(1)


@device
def _trilinear(textures, number, x, y, across):
    """By the number of texels that a pixel is across."""
    first, last = textures.codes[number, _FIRST_LEVEL], textures.codes[number, _LEVELS] - 1
    level = math.log2(across) if across > _ONE else _ZERO
    low = min(np.int64(level), last)
    found = bilinear_at(textures, number, first + low, x, y)
    if low == last or level == _ZERO:
        return found
    return between(found, bilinear_at(textures, number, first + low + 1, x, y), np.float32(level - low))


@device
def _covariance(textures, number, record):
    """(xx, xy, yy) of the half-axes in texels of the picture, a aᵀ + b bᵀ."""
    level = textures.codes[number, _FIRST_LEVEL]
    width, height = np.float32(textures.levels[level, 1]), np.float32(textures.levels[level, 2])
    ax, ay = record[_AXIS_A] * width, -record[_AXIS_A + 1] * height
    bx, by = record[_AXIS_B] * width, -record[_AXIS_B + 1] * height
    return ax * ax + bx * bx, ax * ay + bx * by, ay * ay + by * by


@device
def _long_and_short(xx, xy, yy):
    """Squares of the half-axes of an ellipse."""
    mean, half = (xx + yy) * _HALF, (xx - yy) * _HALF
    long = mean + math.sqrt(half * half + xy * xy)
    short = (xx * yy - xy * xy) / long if long > _ZERO else _ZERO
    return long, max(short, _ZERO)


@device
def _sum_texels(textures, number, level, x, y, xx, xy, yy):
    """Weighted mean of the texels of a level around (x, y), in texels of it, for weights of a covariance."""
    codes, levels = textures.codes, textures.levels
    first, width, height = levels[level, 0], levels[level, 1], levels[level, 2]
    encoding, wrap_u, wrap_v = codes[number, _ENCODING], codes[number, _WRAP_U], codes[number, _WRAP_V]
    reach_x, reach_y = math.sqrt(_REACH2 * xx), math.sqrt(_REACH2 * yy)
    inverse = _ONE / (_REACH2 * (xx * yy - xy * xy))
    a, b, c = yy * inverse, -xy * inverse, xx * inverse
    top, low = np.int64(math.ceil(y - reach_y)), np.int64(math.floor(y + reach_y))
    colour, alpha, total = vec3(_ZERO, _ZERO, _ZERO), _ZERO, _ZERO
    inside = x - reach_x >= _ZERO and x + reach_x <= np.float32(width - 1)
    for row in range(top, low + 1):
        dy = np.float32(row) - y
        # The stretch of the row within the ellipse: a dx² + 2 b dx dy + c dy² < 1.
        under = b * b * dy * dy - a * (c * dy * dy - _ONE)
        if not under > _ZERO:
            continue
        middle, half = x - b * dy / a, math.sqrt(under) / a
        start = first + wrapped(row, height, wrap_v) * width
        for column in range(np.int64(math.ceil(middle - half)), np.int64(math.floor(middle + half)) + 1):
            dx = np.float32(column) - x
            rest = _ONE - (dx * (a * dx + _TWO * b * dy) + c * dy * dy)
            weight = rest * rest
            at = column if inside else wrapped(column, width, wrap_u)
            texel, opacity = texel_at(textures, encoding, start + at)
            colour, alpha, total = colour + texel * weight, alpha + opacity * weight, total + weight
    return colour * (_ONE / total), alpha / total


@device
def _elliptical(textures, number, x, y, xx, xy, yy):
    """By the ellipse of a pixel in texels of the picture."""
    codes, levels = textures.codes, textures.levels
    first, last = codes[number, _FIRST_LEVEL], codes[number, _LEVELS] - 1
    long, short = _long_and_short(xx, xy, yy)
    least = long / (_MOST_LONG * _MOST_LONG)
    if short < least:
        xx, yy, short = xx + (least - short), yy + (least - short), least
    # Number of texels that the pixel's short axis is across, squared.
    across2 = short * np.float32(4) / (_TEXELS_ACROSS * _TEXELS_ACROSS)
    number_of = np.int64(math.floor(_HALF * math.log2(across2))) if across2 > _ONE else np.int64(0)
    if number_of >= last:
        return bilinear_at(textures, number, first + last, x, y)
    level = first + number_of
    width, height = np.float32(levels[level, 1]), np.float32(levels[level, 2])
    sx, sy = width / np.float32(levels[first, 1]), height / np.float32(levels[first, 2])
    spread = _SPREAD if number_of == 0 else _SPREAD_OF_MEANS
    xx, xy, yy = xx * (sx * sx * _THIRD), xy * (sx * sy * _THIRD), yy * (sy * sy * _THIRD)
    if width == _ONE or height == _ONE:
        xx, xy = (min(xx, _ACROSS_ONE), _ZERO) if width == _ONE else (xx, xy)
        yy, xy = (min(yy, _ACROSS_ONE), _ZERO) if height == _ONE else (yy, xy)
    return _sum_texels(textures, number, level, x * width - _HALF, y * height - _HALF, xx + spread, xy, yy + spread)


@entry
def trilinear(textures, node, record):
    """The picture's mean over squares as large as the footprint is long."""
    place = open_place(textures, node, record)
    number = np.int64(place.textures.nodes[node, PICTURE])
    x, y = unit_place(place.textures, number, place.record[U], place.record[V])
    xx, xy, yy = _covariance(place.textures, number, place.record)
    long, _ = _long_and_short(xx, xy, yy)
    colour, alpha = _trilinear(place.textures, number, x, y, _TWO * math.sqrt(min(long, _LARGE)))
    return answer(place, colour, alpha)


@entry
def elliptical(textures, node, record):
    """The picture's mean over the footprint's ellipse."""
    place = open_place(textures, node, record)
    textures, number = place.textures, np.int64(place.textures.nodes[node, PICTURE])
    x, y = unit_place(textures, number, place.record[U], place.record[V])
    xx, xy, yy = _covariance(textures, number, place.record)
    long, _ = _long_and_short(xx, xy, yy)
    if not long < _LARGE:
        last = textures.codes[number, _FIRST_LEVEL] + textures.codes[number, _LEVELS] - 1
        colour, alpha = bilinear_at(textures, number, last, x, y)
        return answer(place, colour, alpha)
    across = _TWO * math.sqrt(long)
    if across <= _MAGNIFIED:
        colour, alpha = bilinear_at(textures, number, textures.codes[number, _FIRST_LEVEL], x, y)
        return answer(place, colour, alpha)
    found = _elliptical(textures, number, x, y, xx, xy, yy)
    if across < _TWO * _MAGNIFIED:
        near = bilinear_at(textures, number, textures.codes[number, _FIRST_LEVEL], x, y)
        found = between(near, found, across / _MAGNIFIED - _ONE)
    colour, alpha = found
    return answer(place, colour, alpha)
