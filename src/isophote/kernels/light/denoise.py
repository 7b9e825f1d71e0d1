"""Denoising by weighted means of pixels that look alike.

    ĉ(p) = Σ_q w(p, q) c(q) / Σ_q w(p, q),   w = exp(−max(0, d_c, d_f))

over the square of pixels q around p, where d_c compares the colours of the patches around p and q, less what their
variances v explain, and d_f the features f (albedo, normal, nearness), in parts of what they may differ by:

    d_c = mean over patch and channels of ((c_p − c_q)² − (v_p + min(v_p, v_q))) / (ε + k² (v_p + v_q))
    d_f = max over features of ((f_p − f_q)² − (s_p + min(s_p, s_q))) · t_p

(Rousselle, Manzi, Zwicker: "Robust Denoising using Feature and Color Information", Pacific Graphics 2013.) The loops
run along rows, one array at a time, so that the compiler does eight pixels at once.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.table import FLOAT, FLOAT_ROWS, FLOATS, INT, Table

__all__ = ["DENOISE", "SCRATCH_PLANES", "denoise_tile"]

# Planes of one picture lie below each other, `height` rows each, with a border on every side as wide as the search and
# a patch reach together. `colour`, `variance`: 3 planes; `feature`, `spread` (its variance), `scale` (t above): as many
# as there are features; `inside`: 1 in the picture, 0 in the border. `result`: 3 planes. `scratch`: SCRATCH_PLANES
# tiles with their patches' borders, one set for each thread.
DENOISE = Table(
    "Denoise",
    height=INT,
    search=INT,
    patch=INT,
    strength=FLOAT,
    colour=FLOAT_ROWS,
    variance=FLOAT_ROWS,
    feature=FLOAT_ROWS,
    spread=FLOAT_ROWS,
    scale=FLOAT_ROWS,
    inside=FLOAT_ROWS,
    result=FLOAT_ROWS,
    scratch=FLOATS,
)

open_denoise = DENOISE.open

# Differences, their sums along rows, weights; then the sum of weights and those of the three channels.
_DIFFERENCE, _ALONG, _WEIGHT, _TOTAL = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
SCRATCH_PLANES = 7

_ZERO, _ONE, _EPSILON = np.float32(0), np.float32(1), np.float32(1e-10)
_EIGHTH, _THIRD = np.float32(1 / 8), np.float32(1 / 3)
_CHANNELS = np.int64(3)


@device
def _add_colour_difference(t, k, row, other, column, beside, count, out):
    """Add channel `k` of the difference between pixels of a row, and those of row `other`, to scratch from `out` on."""
    colour, variance, scratch = t.colour, t.variance, t.scratch
    own, theirs = k * t.height + row, k * t.height + other
    strength = t.strength
    for i in range(count):
        v, w = variance[own, column + i], variance[theirs, beside + i]
        step = colour[own, column + i] - colour[theirs, beside + i]
        scratch[out + i] += (step * step - (v + min(v, w))) / (_EPSILON + strength * (v + w))


@device
def _raise_to_feature_difference(t, k, row, other, column, beside, count, out):
    """Raise distances in scratch from `out` on to that of feature `k`."""
    feature, spread, scale, scratch = t.feature, t.spread, t.scale, t.scratch
    own, theirs = k * t.height + row, k * t.height + other
    for i in range(count):
        v, w = spread[own, column + i], spread[theirs, beside + i]
        step = feature[own, column + i] - feature[theirs, beside + i]
        scratch[out + i] = max(scratch[out + i], (step * step - (v + min(v, w))) * scale[own, column + i])


@device
def _patch_sums(t, first, count, columns, rows, plane):
    """Sums of the differences over patches, into the plane of weights: along rows, then along columns."""
    scratch, width = t.scratch, 2 * t.patch + 1
    difference, along, weight = first, first + _ALONG * plane, first + _WEIGHT * plane
    for y in range(rows + 2 * t.patch):
        for i in range(count):
            scratch[along + y * columns + i] = scratch[difference + y * columns + i]
        for k in range(1, width):
            for i in range(count):
                scratch[along + y * columns + i] += scratch[difference + y * columns + i + k]
    for y in range(rows):
        for i in range(count):
            scratch[weight + y * columns + i] = scratch[along + y * columns + i]
        for k in range(1, width):
            for i in range(count):
                scratch[weight + y * columns + i] += scratch[along + (y + k) * columns + i]


@device
def _add_row(t, total, other, beside, count, plane, weights):
    """Turn distances into weights, and add a row of pixels so weighted."""
    colour, inside, scratch = t.colour, t.inside, t.scratch
    for i in range(count):
        # exp(−d), near enough: (1 − d/8)⁸.
        w = max(_ZERO, _ONE - _EIGHTH * max(_ZERO, scratch[weights + i]))
        w *= w
        w *= w
        w = w * w * inside[other, beside + i]
        scratch[weights + i] = w
        scratch[total + i] += w
    for k in range(_CHANNELS):
        at, theirs = total + (k + 1) * plane, k * t.height + other
        for i in range(count):
            scratch[at + i] += scratch[weights + i] * colour[theirs, beside + i]


@device
def _add_shifted(t, first, plane, columns, x0, y0, count, rows, dx, dy):
    """Add the pixels (dx, dy) away from those of a tile."""
    scratch, patch = t.scratch, t.patch
    wide = count + 2 * patch
    for y in range(rows + 2 * patch):
        out, row = first + _DIFFERENCE * plane + y * columns, y0 - patch + y
        for i in range(wide):
            scratch[out + i] = _ZERO
        for k in range(_CHANNELS):
            _add_colour_difference(t, k, row, row + dy, x0 - patch, x0 - patch + dx, wide, out)
    _patch_sums(t, first, count, columns, rows, plane)
    width = np.float32(2 * patch + 1)
    share = _THIRD / (width * width)
    features = t.feature.rows // t.height
    for y in range(rows):
        weights, row = first + _WEIGHT * plane + y * columns, y0 + y
        for i in range(count):
            scratch[weights + i] *= share
        for k in range(features):
            _raise_to_feature_difference(t, k, row, row + dy, x0, x0 + dx, count, weights)
        _add_row(t, first + _TOTAL * plane + y * columns, row + dy, x0 + dx, count, plane, weights)


@kernel
def denoise_tile(words, first, x0, x1, y0, y1):
    """Denoise pixels x0 ≤ x < x1, y0 ≤ y < y1 (border included in the numbering), in scratch from `first` on."""
    t = open_denoise(words)
    count, rows = x1 - x0, y1 - y0
    columns = count + 2 * t.patch
    plane = columns * (rows + 2 * t.patch)
    for i in range(_TOTAL * plane, SCRATCH_PLANES * plane):
        t.scratch[first + i] = _ZERO
    for dy in range(-t.search, t.search + 1):
        for dx in range(-t.search, t.search + 1):
            _add_shifted(t, first, plane, columns, x0, y0, count, rows, dx, dy)
    for k in range(_CHANNELS):
        for y in range(rows):
            total = first + _TOTAL * plane + y * columns
            for i in range(count):
                t.result[k * t.height + y0 + y, x0 + i] = t.scratch[total + (k + 1) * plane + i] / t.scratch[total + i]
