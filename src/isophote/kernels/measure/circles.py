"""Circles through three points, in pairs of doubles; and points inside circles of neighbouring triangles."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.exact import pair_add, pair_multiply, pair_subtract, two_difference
from isophote.kernels.base.jit import exact_device, exact_kernel
from isophote.kernels.base.predicates import incircle, orient2d

__all__ = ["circumcircles", "inner_points", "opposite_violations"]


@exact_device
def _quotient(a, b):
    """The quotient of two pairs, as a double."""
    q = a[0] / b[0]
    rest = pair_subtract(a, pair_multiply((q, 0.0), b))
    return q + rest[0] / b[0]


@exact_kernel
def circumcircles(corners, centres, radii):
    """Centres (n, 2) and radii (n,) of circles through rows of three points (n, 6); NaN and infinity for lines."""
    for i in range(len(corners)):
        ax, ay, bx, by, cx, cy = (
            corners[i, 0],
            corners[i, 1],
            corners[i, 2],
            corners[i, 3],
            corners[i, 4],
            corners[i, 5],
        )
        if orient2d(ax, ay, bx, by, cx, cy) == 0:
            centres[i, 0], centres[i, 1], radii[i] = np.nan, np.nan, np.inf
            continue
        ux, uy = two_difference(bx, ax), two_difference(by, ay)
        vx, vy = two_difference(cx, ax), two_difference(cy, ay)
        u = pair_add(pair_multiply(ux, ux), pair_multiply(uy, uy))
        v = pair_add(pair_multiply(vx, vx), pair_multiply(vy, vy))
        area = pair_subtract(pair_multiply(ux, vy), pair_multiply(uy, vx))
        twice = (2 * area[0], 2 * area[1])
        x = _quotient(pair_subtract(pair_multiply(vy, u), pair_multiply(uy, v)), twice)
        y = _quotient(pair_subtract(pair_multiply(ux, v), pair_multiply(vx, u)), twice)
        centres[i, 0], centres[i, 1], radii[i] = ax + x, ay + y, math.hypot(x, y)


@exact_device
def _is_inside(points, triangles, t, v):
    """Whether a point lies strictly inside the circle of a triangle, whichever way that goes round."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    ax, ay, bx, by, cx, cy = points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1]
    way = orient2d(ax, ay, bx, by, cx, cy)
    return way * incircle(ax, ay, bx, by, cx, cy, points[v, 0], points[v, 1]) > 0


@exact_kernel
def opposite_violations(points, triangles, neighbours, found):
    """Write to `found`, (m, 3), the neighbours' far corners that lie in the triangle's circle; -1 for others."""
    for t in range(len(triangles)):
        for k in range(3):
            found[t, k] = -1
            s = neighbours[t, k]
            if s < 0:
                continue
            for j in range(3):
                if neighbours[s, j] == t and _is_inside(points, triangles, t, triangles[s, j]):
                    found[t, k] = triangles[s, j]


@exact_kernel
def inner_points(points, triangles, pairs):
    """Write pairs of a triangle and a point inside its circle, as many as there is room for; returns how many."""
    count = 0
    for t in range(len(triangles)):
        for v in range(len(points)):
            if v == triangles[t, 0] or v == triangles[t, 1] or v == triangles[t, 2]:
                continue
            if _is_inside(points, triangles, t, v):
                if count < len(pairs):
                    pairs[count, 0], pairs[count, 1] = t, v
                count += 1
    return count
