"""Tangents of texture coordinates at the corners of triangles, grouped and weighted as MikkTSpace does.

A tangent is the mean of those of the triangles around a vertex, by their angles there. Triangles belong together whose
corners agree in position, normal and texture coordinates, which share edges, and whose texture is not mirrored in the
one and plain in the other. A triangle without area in texture coordinates goes with any neighbour.

(Mikkelsen: "Simulation of Wrinkled Surfaces Revisited", thesis, University of Copenhagen, 2008.)
"""

from __future__ import annotations

import math

from isophote.kernels.base.double3 import Double3, difference, dot3, norm, row3, scaled, total
from isophote.kernels.base.jit import device, kernel

__all__ = ["find_directions", "find_groups", "match_edges", "mean_tangents"]

# What is no larger is nothing: the least number of single precision.
_LEAST = 1.1754944e-38


@kernel
def find_directions(points, uvs, directions, turned, loose):
    """Of triangles with corners `points` (t, 3, 3) and `uvs` (t, 3, 2): the unit direction ∂P/∂u (t, 3), 1 where
    texture coordinates run as the corners do and 0 where they are mirrored, and 1 where they tell no direction."""
    for f in range(len(points)):
        a = row3(points[f], 0)
        d1, d2 = difference(row3(points[f], 1), a), difference(row3(points[f], 2), a)
        u1, v1 = uvs[f, 1, 0] - uvs[f, 0, 0], uvs[f, 1, 1] - uvs[f, 0, 1]
        u2, v2 = uvs[f, 2, 0] - uvs[f, 0, 0], uvs[f, 2, 1] - uvs[f, 0, 1]
        area = u1 * v2 - v1 * u2
        along = difference(scaled(d1, v2), scaled(d2, v1))
        across = difference(scaled(d2, u1), scaled(d1, u2))
        turned[f] = area > 0
        size = norm(along)
        loose[f] = not (abs(area) > _LEAST and size > _LEAST and norm(across) > _LEAST)
        sign = (1.0 if area > 0 else -1.0) / size if size > _LEAST else 0.0
        directions[f, 0], directions[f, 1], directions[f, 2] = along.x * sign, along.y * sign, along.z * sign


@kernel
def match_edges(corners, order, neighbours):
    """The triangle beyond each edge k, from corner k to k + 1, of triangles `corners` (t, 3), where there is one that
    runs along it the other way. `order`: all edges 3 f + k by their least and greatest end, then by their triangle;
    `neighbours` (t, 3) are −1 before. Of more than two triangles at an edge the first ones are matched."""
    count = len(order)
    for i in range(count):
        f, k = order[i] // 3, order[i] % 3
        if neighbours[f, k] >= 0:
            continue
        a, b = corners[f, k], corners[f, (k + 1) % 3]
        for j in range(i + 1, count):
            g, m = order[j] // 3, order[j] % 3
            c, d = corners[g, m], corners[g, (m + 1) % 3]
            if min(c, d) != min(a, b) or max(c, d) != max(a, b):
                break
            if c == b and d == a and neighbours[g, m] < 0:
                neighbours[f, k], neighbours[g, m] = g, f
                break


@device
def _corner_of(corners, f, vertex):
    if corners[f, 0] == vertex:
        return 0
    return 1 if corners[f, 1] == vertex else 2


@device
def _joins(groups, turned, loose, f, k, orientation):
    """Whether triangle `f` joins a group of this orientation with its corner `k`."""
    if groups[f, k] >= 0:
        return False
    if loose[f] and groups[f, 0] < 0 and groups[f, 1] < 0 and groups[f, 2] < 0:
        turned[f] = orientation
    return turned[f] == orientation


@kernel
def find_groups(corners, neighbours, turned, loose, stack, groups):
    """Number of the group of each corner, into `groups` (t, 3), which is −1 before and stays so where there is none;
    returns how many there are. Loose triangles take the orientation of the group that they are first met by. `stack`
    (6 t + 2,) is scratch."""
    count = 0
    for first in range(len(corners)):
        for start in range(3):
            if loose[first] or groups[first, start] >= 0:
                continue
            vertex, orientation = corners[first, start], turned[first]
            stack[0], depth = first, 1
            while depth > 0:
                depth -= 1
                f = stack[depth]
                k = start if f == first else _corner_of(corners, f, vertex)
                if not _joins(groups, turned, loose, f, k, orientation):
                    continue
                groups[f, k] = count
                # The one on the left is gone to first.
                for edge in ((k + 2) % 3, k):
                    if neighbours[f, edge] >= 0:
                        stack[depth] = neighbours[f, edge]
                        depth += 1
            count += 1
    return count


@device
def _flattened(v, normal):
    """Unit vector of what of `v` is across the normal."""
    flat = difference(v, scaled(normal, dot3(normal, v)))
    size = norm(flat)
    return scaled(flat, 1.0 / size) if size > _LEAST else flat


@device
def _angle(points, f, k, normal):
    """The angle of triangle `f` at its corner `k`, seen along the normal."""
    here = row3(points[f], k)
    before = _flattened(difference(row3(points[f], (k + 2) % 3), here), normal)
    after = _flattened(difference(row3(points[f], (k + 1) % 3), here), normal)
    return math.acos(min(max(dot3(before, after), -1.0), 1.0))


@kernel
def mean_tangents(points, normals, directions, turned, loose, groups, sums, tangents):
    """The unit tangent of each corner and in the fourth column 1, or −1 where the texture is mirrored, into `tangents`
    (t, 3, 4); `sums` (groups, 3) are 0 before. Corners without a group get (1, 0, 0) and −1."""
    for f in range(len(points)):
        for k in range(3):
            if loose[f] or groups[f, k] < 0:
                continue
            normal = row3(normals[f], k)
            part = scaled(_flattened(row3(directions, f), normal), _angle(points, f, k, normal))
            sum_ = total(row3(sums, groups[f, k]), part)
            sums[groups[f, k], 0], sums[groups[f, k], 1], sums[groups[f, k], 2] = sum_.x, sum_.y, sum_.z
    for f in range(len(points)):
        for k in range(3):
            tangent, sign = Double3(1.0, 0.0, 0.0), -1.0
            if groups[f, k] >= 0:
                mean = row3(sums, groups[f, k])
                size = norm(mean)
                tangent = scaled(mean, 1.0 / size) if size > _LEAST else mean
                sign = 1.0 if turned[f] else -1.0
            row = tangents[f, k]
            row[0], row[1], row[2], row[3] = tangent.x, tangent.y, tangent.z, sign
