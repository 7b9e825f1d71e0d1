"""Form factors from places to nodes of a tree of patches, as if nothing were in the way.

A near patch is measured by Lambert's closed form, a far one by Gauss's rule; a cluster by its children that are
patches and by the children of the others, each of these with all its area at its centre.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import Double3, difference, dot3, norm, row3, scaled, total
from isophote.kernels.base.jit import device
from isophote.kernels.light.form_factor import corner3, on_patch, point_to_polygon

__all__ = ["brightness_seen", "heights_over", "mean_factor", "mean_source_factor", "source_factor"]

_ZERO, _ONE = np.float64(0), np.float64(1)
_INV_PI = 1 / math.pi
_CELLS, _GRID = 16, 4
# Distances of a patch, in its radii, from which on 2 × 2 of its places stand for it; and those of a cluster, from which
# on its children do.
_FAR_PATCH, _FAR_CLUSTER = 12.0, 12.0
# Distances between centres, in sums of radii, from which on one place or 2 × 2 places of the smaller patch are enough.
_FAR, _NEAR = 8.0, 2.5
# The lower places of Gauss and Legendre's rules with 2 and 4 places on 0 … 1, and the outer weight of the latter.
_GAUSS_2 = 0.5 - math.sqrt(3) / 6
_GAUSS_4 = (
    0.5 - math.sqrt(3 / 7 + 2 / 7 * math.sqrt(6 / 5)) / 2,
    0.5 - math.sqrt(3 / 7 - 2 / 7 * math.sqrt(6 / 5)) / 2,
)
_WEIGHT_4 = (18 - math.sqrt(30)) / 72


@device
def heights_over(patches, p, q):
    """(lowest, highest) place of node q over the plane of node p."""
    centre, normal = row3(patches.centres, p), row3(patches.normals, p)
    height = dot3(difference(row3(patches.centres, q), centre), normal)
    if patches.sides[q] == 0:
        reach = patches.sizes[q, 1]
        if patches.flat[q] != 0:
            along = Double3(patches.axes[q, 0], patches.axes[q, 1], patches.axes[q, 2])
            across = Double3(patches.axes[q, 3], patches.axes[q, 4], patches.axes[q, 5])
            reach = min(reach, abs(dot3(along, normal)) + abs(dot3(across, normal)))
        return height - reach, height + reach
    low, high = math.inf, -math.inf
    for c in range(patches.sides[q]):
        above = dot3(difference(corner3(patches.corners, q, c), centre), normal)
        low, high = min(low, above), max(high, above)
    return low, high


@device
def _point_factor(patches, place, normal, q, on, area):
    """Form factor from a place to an area of node q about the place `on`."""
    way = difference(on, place)
    square = dot3(way, way)
    first, second = dot3(way, normal), -dot3(way, row3(patches.normals, q))
    if first <= _ZERO or second <= _ZERO:
        return _ZERO
    return first * second * area * _INV_PI / (square * square)


@device
def _open_share(patches, place, normal, q):
    """The share of what a place could see of patch q, above its horizon, that lies within no solid."""
    covered = patches.covered[q]
    if covered == 0:
        return _ONE
    above, opened = np.int64(0), np.int64(0)
    for cell in range(_CELLS):
        on = on_patch(patches.corners, patches.sides, q, (cell % _GRID + 0.5) / _GRID, (cell // _GRID + 0.5) / _GRID)
        if dot3(difference(on, place), normal) > _ZERO:
            above += 1
            opened += 1 - ((covered >> cell) & 1)
    return opened / above if above > 0 else _ZERO


@device
def _gauss(grid, i):
    """(place in 0 … 1, weight) number i of Gauss and Legendre's rule with 1, 2 or 4 places."""
    if grid == 1:
        return 0.5, 1.0
    if grid == 2:
        return (_GAUSS_2 if i == 0 else 1.0 - _GAUSS_2), 0.5
    place = _GAUSS_4[0] if i == 0 or i == 3 else _GAUSS_4[1]
    weight = _WEIGHT_4 if i == 0 or i == 3 else 0.5 - _WEIGHT_4
    return (place if i < 2 else 1.0 - place), weight


@device
def _quadrature(patches, p, grid, i, j):
    """(place on patch p, weight): Gauss's rule along both edges; on a triangle one of them shrinks to a corner."""
    (a, weight_a), (b, weight_b) = _gauss(grid, i), _gauss(grid, j)
    origin = corner3(patches.corners, p, 0)
    along = difference(corner3(patches.corners, p, 1), origin)
    across = difference(corner3(patches.corners, p, patches.sides[p] - 1), origin)
    if patches.sides[p] == 3:
        if grid == 1:
            return total(origin, scaled(total(along, across), 1.0 / 3.0)), 1.0
        weight_a *= 2.0 * (1.0 - a)
        b *= 1.0 - a
    return total(origin, total(scaled(along, a), scaled(across, b))), weight_a * weight_b


@device
def _patch_factor(patches, place, normal, q):
    """Form factor from a place to patch q; 0 behind it."""
    way = difference(row3(patches.centres, q), place)
    if dot3(way, row3(patches.normals, q)) >= _ZERO:
        return _ZERO
    reach = _FAR_PATCH * patches.sizes[q, 1]
    if dot3(way, way) < reach * reach:
        factor = point_to_polygon(place, normal, patches.corners, patches.sides, q)
    else:
        factor = _ZERO
        for i in range(2):
            for j in range(2):
                on, weight = _quadrature(patches, q, 2, i, j)
                factor += _point_factor(patches, place, normal, q, on, weight * patches.sizes[q, 0])
    return factor


@device
def _cluster_factor(patches, place, normal, q):
    """Form factor from a place to a cluster, by its children or, where it is near, their children."""
    sum_ = _ZERO
    apart = norm(difference(row3(patches.centres, q), place))
    far = apart > _FAR_CLUSTER * patches.sizes[q, 1]
    first = np.int64(patches.first_child[q])
    for c in range(first, first + patches.children[q]):
        if patches.sides[c] != 0:
            sum_ += _patch_factor(patches, place, normal, c)
        elif far:
            sum_ += _point_factor(patches, place, normal, c, row3(patches.centres, c), patches.sizes[c, 0])
        else:
            inner = np.int64(patches.first_child[c])
            for k in range(inner, inner + patches.children[c]):
                sum_ += _point_factor(patches, place, normal, k, row3(patches.centres, k), patches.sizes[k, 0])
    return sum_


@device
def _whole_factor(patches, place, normal, q):
    """Form factor from a place to node q; 0 behind it."""
    if patches.sides[q] == 0:
        return _cluster_factor(patches, place, normal, q)
    return _patch_factor(patches, place, normal, q)


@device
def source_factor(patches, place, normal, q):
    """Form factor from a place to what of node q lies within no solid; 0 behind it."""
    factor = _whole_factor(patches, place, normal, q)
    return factor * _open_share(patches, place, normal, q) if factor > _ZERO else _ZERO


@device
def brightness_seen(patches, place, normal, q, bright):
    """How bright node q is as seen from a place, in parts of its mean: its children's children, or its children where
    these are leaves, count by what they would send there, `bright` (nodes,) being what each sends out."""
    if len(bright) == 0 or patches.first_child[q] < 0 or bright[q] <= _ZERO:
        return _ONE
    sum_, whole = _ZERO, _ZERO
    first = np.int64(patches.first_child[q])
    for c in range(first, first + patches.children[q]):
        inner, count = np.int64(patches.first_child[c]), np.int64(patches.children[c])
        if inner < 0:
            inner, count = np.int64(c), np.int64(1)
        for k in range(inner, inner + count):
            area = patches.sizes[k, 0] * patches.sizes[k, 2]
            factor = _point_factor(patches, place, normal, k, row3(patches.centres, k), area)
            whole += factor
            sum_ += factor * bright[k]
    return sum_ / (whole * bright[q]) if whole > _ZERO else _ONE


@device
def _rule_for(patches, p, q, distance):
    """How many places along each edge of patch p it takes, the centres of p and q so far apart."""
    reach = patches.sizes[p, 1] + patches.sizes[q, 1]
    return 1 if distance > _FAR * reach else (2 if distance > _NEAR * reach else _GRID)


@device
def mean_factor(patches, p, q, distance):
    """Mean form factor from patch p to node q, their centres so far apart."""
    normal, grid, sum_ = row3(patches.normals, p), _rule_for(patches, p, q, distance), _ZERO
    for i in range(grid):
        for j in range(grid):
            place, weight = _quadrature(patches, p, grid, i, j)
            sum_ += weight * _whole_factor(patches, place, normal, q)
    return sum_


@device
def mean_source_factor(patches, p, q, distance, bright):
    """Mean form factor from patch p to what of node q lies within no solid, times how bright q is from there."""
    normal, grid, sum_ = row3(patches.normals, p), _rule_for(patches, p, q, distance), _ZERO
    for i in range(grid):
        for j in range(grid):
            place, weight = _quadrature(patches, p, grid, i, j)
            factor = source_factor(patches, place, normal, q)
            sum_ += weight * factor * brightness_seen(patches, place, normal, q, bright)
    return sum_
