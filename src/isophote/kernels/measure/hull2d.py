"""Convex hulls of points of the plane."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_kernel
from isophote.kernels.base.predicates import orient2d

__all__ = ["extreme_points", "hull_chains", "near_hull"]

_WAYS = np.array([[-1, 0], [-0.5, -0.5], [0, -1], [0.5, -0.5], [1, 0], [0.5, 0.5], [0, 1], [-0.5, 0.5]])


@exact_device
def _is_bent(points, a, b, c):
    """Whether a, b, c turn to the left."""
    return orient2d(points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1]) > 0


@exact_kernel
def hull_chains(points, order, hull):
    """Write the corners of the hull, counterclockwise, of points in the order of x and then y; how many.

    Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979. `hull` has room for twice as many.
    """
    count = 0
    for p in order:
        while count > 1 and not _is_bent(points, hull[count - 2], hull[count - 1], p):
            count -= 1
        hull[count] = p
        count += 1
    lower = count
    for i in range(len(order) - 2, -1, -1):
        p = order[i]
        while count > lower and not _is_bent(points, hull[count - 2], hull[count - 1], p):
            count -= 1
        hull[count] = p
        count += 1
    # The first corner was met again, unless there is but one point.
    return max(count - 1, 1)


@exact_kernel
def extreme_points(points, found):
    """Write the numbers of the points furthest along eight directions, counterclockwise from -x."""
    found[:] = 0
    for p in range(1, len(points)):
        x, y = points[p, 0], points[p, 1]
        for k in range(8):
            e = found[k]
            if _WAYS[k, 0] * x + _WAYS[k, 1] * y > _WAYS[k, 0] * points[e, 0] + _WAYS[k, 1] * points[e, 1]:
                found[k] = p


@exact_kernel
def near_hull(points, polygon, found):
    """Write the numbers of the points that do not lie strictly inside a polygon given counterclockwise; how many.

    `polygon` holds numbers of points, those that repeat their neighbour being left out of it.
    """
    count = 0
    for p in range(len(points)):
        inside = True
        for k in range(len(polygon)):
            if not _is_bent(points, polygon[k - 1], polygon[k], p):
                inside = False
                break
        if not inside:
            found[count] = p
            count += 1
    return count
