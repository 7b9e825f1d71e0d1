"""Paths of points that are equally far from two sites of a polygon: lines and parabolas.

A path from a point is six numbers, x0, x1, x2, y0, y1, y2, for x(t) = x0 + x1 t + x2 t² and y(t) alike, t >= 0. Between
two edges and between two vertices it is a line, of which t is the length; between an edge and a vertex a parabola, of
which t is how far the foot has moved along the edge.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.measure.medial_sites import along, height, point_distance

__all__ = ["leaving", "path", "path_x", "path_y", "polished", "site_distance"]

_POLISH = 3
# Of the angle between two sides of the same way: below, rounding is too much enlarged.
_FLAT = 1e-4


@device
def site_distance(p, site, x, y):
    """The distance to a site, as if an edge went on endlessly."""
    n = p.lengths.rows
    return height(p, site, x, y) if site < n else point_distance(p, site - n, x, y)


@device
def _line(x, y, dx, dy, wx, wy):
    """The path along ±(dx, dy), whichever leads along w."""
    size = math.hypot(dx, dy)
    if dx * wx + dy * wy < 0:
        size = -size
    return x, dx / size, 0.0, y, dy / size, 0.0


@device
def _between_edges(p, a, b, x, y, wx, wy):
    """Along the difference of the directions, or across their sum, which is the same, whichever is longer."""
    ax, ay, bx, by = p.directions[2 * a], p.directions[2 * a + 1], p.directions[2 * b], p.directions[2 * b + 1]
    if ax * bx + ay * by > 0:
        return _line(x, y, -(ay + by), ax + bx, wx, wy)
    return _line(x, y, ax - bx, ay - by, wx, wy)


@device
def _between_vertices(p, a, b, x, y, wx, wy):
    dx, dy = p.starts[2 * a] - p.starts[2 * b], p.starts[2 * a + 1] - p.starts[2 * b + 1]
    return _line(x, y, -dy, dx, wx, wy)


@device
def _parabola(p, edge, v, x, y, wx, wy):
    """The foot is at u over the edge; the height over it is ((u - u_v)² + h²) / (2 h) for a vertex h above the line."""
    vx, vy = p.starts[2 * v], p.starts[2 * v + 1]
    dx, dy = p.directions[2 * edge], p.directions[2 * edge + 1]
    h = height(p, edge, vx, vy)
    a = along(p, edge, x, y) - along(p, edge, vx, vy)
    if h <= 0:
        return _line(x, y, -dy, dx, wx, wy)
    # The foot moves forwards or backwards along the edge: whichever moves the point along w.
    forward = 1.0 if (dx - dy * a / h) * wx + (dy + dx * a / h) * wy >= 0 else -1.0
    start = (a * a + h * h) / (2 * h)
    fx, fy = vx + a * dx + h * dy, vy + a * dy - h * dx
    x1, y1 = forward * (dx - dy * a / h), forward * (dy + dx * a / h)
    return fx - dy * start, x1, -dy / (2 * h), fy + dx * start, y1, dx / (2 * h)


@device
def path(p, a, b, x, y, wx, wy):
    """The path between sites a and b from (x, y) on, in the direction of w."""
    n = p.lengths.rows
    if a < n and b < n:
        return _between_edges(p, a, b, x, y, wx, wy)
    if a < n:
        return _parabola(p, a, b - n, x, y, wx, wy)
    if b < n:
        return _parabola(p, b, a - n, x, y, wx, wy)
    return _between_vertices(p, a - n, b - n, x, y, wx, wy)


@device
def path_x(c, t):
    """x at t."""
    return c[0] + t * (c[1] + t * c[2])


@device
def path_y(c, t):
    """y at t."""
    return c[3] + t * (c[4] + t * c[5])


@device
def _first_rise(c0, c1, c2, least):
    """The first t > `least` at which c0 + c1 t + c2 t² rises through zero; infinity where it does not."""
    if c2 == 0:
        return -c0 / c1 if c1 > 0 and -c0 > least * c1 else np.inf
    root = c1 * c1 - 4 * c0 * c2
    if root <= 0:
        return np.inf
    # Of both roots, the one at which the slope, c1 + 2 c2 t = root, is above zero.
    root = math.sqrt(root)
    t = (root - c1) / (2 * c2) if c1 < 0 else -2 * c0 / (c1 + root)
    return t if t > least else np.inf


@device
def _passing(c, x, y, dx, dy, least):
    """When a path passes the line through (x, y) across d, in the direction of d."""
    c0 = (c[0] - x) * dx + (c[3] - y) * dy
    return _first_rise(c0, c[1] * dx + c[4] * dy, c[2] * dx + c[5] * dy, least)


@device
def leaving(p, site, c, least):
    """The first t > `least` at which a path leaves what a site owns."""
    n = p.lengths.rows
    k = site if site < n else site - n
    x, y, dx, dy = p.starts[2 * k], p.starts[2 * k + 1], p.directions[2 * k], p.directions[2 * k + 1]
    if site < n:
        e = np.int64(p.after[k])
        return min(_passing(c, x, y, -dx, -dy, least), _passing(c, p.starts[2 * e], p.starts[2 * e + 1], dx, dy, least))
    b = np.int64(p.before[k])
    back = _passing(c, x, y, -p.directions[2 * b], -p.directions[2 * b + 1], least)
    return min(_passing(c, x, y, dx, dy, least), back)


@device
def _gradient(p, site, x, y):
    n = p.lengths.rows
    if site < n:
        return -p.directions[2 * site + 1], p.directions[2 * site]
    v = site - n
    dx, dy = x - p.starts[2 * v], y - p.starts[2 * v + 1]
    size = math.hypot(dx, dy)
    return dx / size, dy / size


@device
def polished(p, a, b, c, x, y):
    """A point made equally far from three sites, by Newton's method; itself where they lie too much alike."""
    for _ in range(_POLISH):
        da, db, dc = site_distance(p, a, x, y), site_distance(p, b, x, y), site_distance(p, c, x, y)
        if min(da, min(db, dc)) <= 0:
            return x, y
        ax, ay = _gradient(p, a, x, y)
        bx, by = _gradient(p, b, x, y)
        cx, cy = _gradient(p, c, x, y)
        ux, uy, vx, vy = ax - bx, ay - by, ax - cx, ay - cy
        area = ux * vy - uy * vx
        if abs(area) < _FLAT:
            return x, y
        x -= ((da - db) * vy - (da - dc) * uy) / area
        y -= (ux * (da - dc) - vx * (da - db)) / area
    return x, y
