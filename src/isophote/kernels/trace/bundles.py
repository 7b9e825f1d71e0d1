"""Rays of a wave that share their origins, up to 64 through the tree at a time."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bundle import BUNDLE, blocked_of_bundle, set_ray_of_bundle
from isophote.kernels.accel.packet import longest_axis
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.wave import row_vec3

__all__ = ["blocked_in_bundles", "in_bundles"]

_BUNDLE = np.int64(BUNDLE)


@device
def in_bundles(geometry):
    """Whether rays can go in bundles: through trees that are finished, and for one object."""
    tree = geometry.closest == 0 and geometry.finish == 0
    return geometry.top_nodes.rows == 0 and tree and geometry.blocks.rows > 0


@device
def blocked_in_bundles(geometry, openings, wave, count):
    """Whether each shadow ray of the wave meets a triangle before its end, 0 or 1 in its row BLOCKED. Rays of one
    number in the row PIXEL start at one point, above that normal."""
    points = wave.ints[rows.PIXEL]
    first = np.int64(0)
    while first < count:
        point = points[first]
        last = first + 1
        most = min(first + _BUNDLE, count)
        while last < most and points[last] == point:
            last += 1
        _blocked_in_bundle(geometry, openings, wave, first, last)
        first = last


@device
def _blocked_in_bundle(geometry, openings, wave, first, last):
    order, ints = wave.longs[rows.ORDER], wave.ints
    count0, count1, limit = _load(wave, first, last)
    k = np.int64(ints[rows.PIXEL, first])
    normal = vec3(openings.normals[k, 0], openings.normals[k, 1], openings.normals[k, 2])
    origin = row_vec3(wave.floats, rows.SHADOW_ORIGIN, first)
    nodes, blocks, root = geometry.nodes, geometry.blocks, geometry.roots[0]
    blocked = blocked_of_bundle(nodes, blocks, root, origin, normal, last - first, count0, count1, limit, wave.scratch)
    for i in range(last - first):
        ints[rows.BLOCKED, order[first + i]] = (blocked >> i) & 1


@device
def _load(wave, first, last):
    """Copy rays to the scratch, sorted by the longest axis of their directions: how many are longest along x, and along
    y, and the largest limit."""
    floats, order = wave.floats, wave.longs[rows.ORDER]
    count0, count1 = np.int64(0), np.int64(0)
    limit = floats[rows.SHADOW_END, first]
    for i in range(first, last):
        axis = longest_axis(row_vec3(floats, rows.SHADOW_DIRECTION, i))
        count0 += axis == 0
        count1 += axis == 1
        limit = max(limit, floats[rows.SHADOW_END, i])
    next0, next1, next2 = np.int64(0), count0, count0 + count1
    for i in range(first, last):
        direction = row_vec3(floats, rows.SHADOW_DIRECTION, i)
        axis = longest_axis(direction)
        if axis == 0:
            place, next0 = next0, next0 + 1
        elif axis == 1:
            place, next1 = next1, next1 + 1
        else:
            place, next2 = next2, next2 + 1
        order[first + place] = i
        set_ray_of_bundle(wave.scratch, place, direction, floats[rows.SHADOW_END, i])
    return count0, count1, limit
