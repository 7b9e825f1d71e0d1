"""Sums of the angles of triangles."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device, kernel

__all__ = ["sum_angles"]

# Products of six lengths must stay in range.
_LARGE = 1e40
_SMALL = 1e-40
_STRAIGHT = 1e-8


@device
def _scale(px, py, pz, qx, qy, qz):
    """A power of two that brings two edges to about 1, where products of theirs could over- or underflow."""
    size = max(abs(px), abs(py), abs(pz), abs(qx), abs(qy), abs(qz))
    if size == 0.0 or (_SMALL < size < _LARGE):
        return 1.0
    return math.ldexp(1.0, -max(min(math.frexp(size)[1], 1000), -1000))


@device
def _edges(vertices, i, j, k):
    """Half the edges from vertex i to j and to k: no difference of halves overflows."""
    x, y, z = 0.5 * vertices[i, 0], 0.5 * vertices[i, 1], 0.5 * vertices[i, 2]
    px, py, pz = 0.5 * vertices[j, 0] - x, 0.5 * vertices[j, 1] - y, 0.5 * vertices[j, 2] - z
    qx, qy, qz = 0.5 * vertices[k, 0] - x, 0.5 * vertices[k, 1] - y, 0.5 * vertices[k, 2] - z
    s = _scale(px, py, pz, qx, qy, qz)
    return px * s, py * s, pz * s, qx * s, qy * s, qz * s


@device
def _sines_and_cosines(edges):
    """(s, a, b, c): the angles of a triangle are those of the complex numbers a + i s, b + i s, c + i s.

    With two corners at one place they are 0 at the third and π/2 at these, and π/3 with all at one.
    """
    px, py, pz, qx, qy, qz = edges
    x, y, z = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    pp, qq, pq = px * px + py * py + pz * pz, qx * qx + qy * qy + qz * qz, px * qx + py * qy + pz * qz
    if pp == 0.0 and qq == 0.0:
        return math.sqrt(3.0), 1.0, 1.0, 1.0
    if pp == 0.0 or qq == 0.0:
        # A number near 1 stands for the angle 0.
        return 1e-300, 0.0, 1.0 if qq == 0.0 else 0.0, 1.0 if pp == 0.0 else 0.0
    if px == qx and py == qy and pz == qz:
        return 1e-300, 1.0, 0.0, 0.0
    return math.sqrt(x * x + y * y + z * z), pq, pp - pq, qq - pq


@device
def _beyond_pi(s, a, b, c):
    """How much the sum of three angles is above π: it is the angle of the product of their numbers."""
    real, imaginary = a * b - s * s, s * (a + b)
    real, imaginary = real * c - imaginary * s, real * s + imaginary * c
    if real < 0.0 and abs(imaginary) < -_STRAIGHT * real:
        # To the third order of something below 1e-8.
        return imaginary / real
    return math.atan2(s, a) + math.atan2(s, b) + math.atan2(s, c) - math.pi


@kernel
def sum_angles(vertices, triangles, inside, first, last, total):
    """Add up the angles of the triangles `first` to `last`.

    `total[0]` gets those at vertices of `inside`, `total[1]` those at others, both without π for each triangle whose
    three vertices are alike; these are counted in `total[2]` and `total[3]`. Adding π a million times would round a
    million times the same way.
    """
    within, without = 0.0, 0.0
    whole_within, whole_without = 0, 0
    for t in range(first, last):
        i, j, k = np.int64(triangles[t, 0]), np.int64(triangles[t, 1]), np.int64(triangles[t, 2])
        s, a, b, c = _sines_and_cosines(_edges(vertices, i, j, k))
        if inside[i] and inside[j] and inside[k]:
            within += _beyond_pi(s, a, b, c)
            whole_within += 1
            continue
        if not (inside[i] or inside[j] or inside[k]):
            without += _beyond_pi(s, a, b, c)
            whole_without += 1
            continue
        for v, cosine in ((i, a), (j, b), (k, c)):
            if inside[v]:
                within += math.atan2(s, cosine)
            else:
                without += math.atan2(s, cosine)
    total[0], total[1], total[2], total[3] = within, without, whole_within, whole_without
