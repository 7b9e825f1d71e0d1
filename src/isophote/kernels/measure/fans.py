"""What the triangles around each vertex say: normals, angles, areas, and curvatures that need no fit.

`starts` (n + 1,) and `corners` (3m,) int64 list the corners of triangles at each vertex; corner 3f + i is corner i of
triangle f. Every vertex gathers from its own triangles, in their order, so that sums don't depend on threads.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import Double3, cross3, difference, dot3, norm, row3, scaled, total
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.measure.arc import upper_angle

__all__ = ["ANGLE", "AREA", "UNIFORM", "corner_lists", "fan_curvatures", "fan_normals", "neighbour_lists"]

ANGLE, AREA, UNIFORM = np.int64(0), np.int64(1), np.int64(2)


@kernel
def corner_lists(triangles, starts, corners):
    """Fill `starts` and `corners` for triangles (m, 3); `starts` comes zeroed."""
    for f in range(triangles.shape[0]):
        for i in range(3):
            starts[triangles[f, i] + 1] += 1
    for v in range(1, starts.size):
        starts[v] += starts[v - 1]
    # Filling moves each start to its end, that is to the next one's start; moving all up by one undoes it.
    for f in range(triangles.shape[0]):
        for i in range(3):
            v = triangles[f, i]
            corners[starts[v]] = 3 * f + i
            starts[v] += 1
    for v in range(starts.size - 1, 0, -1):
        starts[v] = starts[v - 1]
    starts[0] = 0


@kernel
def neighbour_lists(triangles, starts, corners, mark, first, neighbours):
    """The vertices that share an edge with each: those of v are neighbours[first[v]] up to first[v + 1].

    `mark` (n,) int32 comes filled with −1; `neighbours` has room for two a corner. Returns how many there are.
    """
    count = 0
    for v in range(starts.size - 1):
        first[v] = count
        for k in range(starts[v], starts[v + 1]):
            f, i = corners[k] // 3, corners[k] % 3
            for step in (1, 2):
                w = triangles[f, (i + step) % 3]
                if mark[w] != v and w != v:
                    mark[w] = v
                    neighbours[count] = w
                    count += 1
    first[starts.size - 1] = count
    return count


@device
def _sides(positions, triangles, corner):
    """The two sides of a triangle that leave a corner, in its order."""
    f, i = corner // 3, corner % 3
    p = row3(positions, triangles[f, i])
    return (
        difference(row3(positions, triangles[f, (i + 1) % 3]), p),
        difference(row3(positions, triangles[f, (i + 2) % 3]), p),
    )


@device
def _angle(a, b):
    """Angle between two vectors. Source: Kahan, "How futile are mindless assessments of roundoff", section 12."""
    u, v = scaled(a, norm(b)), scaled(b, norm(a))
    return 2.0 * upper_angle(norm(difference(u, v)), norm(total(u, v)))


@kernel
def fan_normals(positions, triangles, starts, corners, weight, first, last, normals):
    """Unit normals at vertices `first` ≤ v < `last`: sums of triangles' normals by a weight; zero where they cancel."""
    for v in range(first, last):
        whole = Double3(0.0, 0.0, 0.0)
        for k in range(starts[v], starts[v + 1]):
            a, b = _sides(positions, triangles, corners[k])
            n = cross3(a, b)
            size = norm(n)
            if size > 0.0:
                share = (
                    1.0 if weight == AREA else upper_angle(size, dot3(a, b)) / size if weight == ANGLE else 1.0 / size
                )
                whole = total(whole, scaled(n, share))
        size = norm(whole)
        if size > 0.0:
            normals[v, 0], normals[v, 1], normals[v, 2] = whole.x / size, whole.y / size, whole.z / size
        else:
            normals[v, 0], normals[v, 1], normals[v, 2] = 0.0, 0.0, 0.0


@device
def _mixed_area(a, b, angle):
    """A vertex's share of a triangle with the sides a, b from it: what is nearest to it, or, in a triangle with an
    obtuse angle, half or a quarter. Source: Meyer et al., "Discrete Differential-Geometry Operators", 2003, 3.3."""
    area = 0.5 * norm(cross3(a, b))
    c = difference(b, a)
    if angle > 0.5 * math.pi:
        return 0.5 * area
    # At the end of a the angle lies between −a and c, at the end of b between −b and −c.
    at_a, at_b = -dot3(a, c), dot3(b, c)
    if at_a < 0.0 or at_b < 0.0:
        return 0.25 * area
    twice = 2.0 * area
    return 0.125 * (dot3(b, b) * at_a + dot3(a, a) * at_b) / twice if twice > 0.0 else 0.0


@device
def _spherical_area(a, b, c):
    """Signed area of the triangle of three directions on the unit sphere. Source: Van Oosterom, Strackee, 1983."""
    return 2.0 * math.atan2(dot3(a, cross3(b, c)), 1.0 + dot3(a, b) + dot3(b, c) + dot3(c, a))


@kernel
def fan_curvatures(positions, triangles, starts, corners, normals, first, last, angles, areas, means, images):
    """For vertices `first` ≤ v < `last`: the sum of `angles`, the mixed area in `areas`; in `means` (n, 3) the vector
    whose length is mean curvature times area, ¼ Σ (cot α + cot β)(p − q); in `images` (n, 2) the areas of
    the normals' image and of the triangles around."""
    for v in range(first, last):
        angle, area, image, around = 0.0, 0.0, 0.0, 0.0
        mean = Double3(0.0, 0.0, 0.0)
        for k in range(starts[v], starts[v + 1]):
            corner = corners[k]
            f, i = corner // 3, corner % 3
            a, b = _sides(positions, triangles, corner)
            here = _angle(a, b)
            angle += here
            area += _mixed_area(a, b, here)
            # Each side is weighted by the cotangent of the angle that faces it in this triangle.
            c = difference(b, a)
            at_a, at_b = -dot3(a, c), dot3(b, c)
            twice = norm(cross3(a, b))
            if twice > 0.0:
                mean = difference(mean, scaled(total(scaled(a, at_b), scaled(b, at_a)), 0.25 / twice))
            around += 0.5 * twice
            p, q, r = triangles[f, i], triangles[f, (i + 1) % 3], triangles[f, (i + 2) % 3]
            image += _spherical_area(row3(normals, p), row3(normals, q), row3(normals, r))
        angles[v], areas[v] = angle, area
        means[v, 0], means[v, 1], means[v, 2] = mean.x, mean.y, mean.z
        images[v, 0], images[v, 1] = image, around
