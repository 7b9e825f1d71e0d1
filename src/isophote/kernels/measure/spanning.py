"""The first points that span a line, a plane, a space, and, lifted to a paraboloid, one dimension more."""

from __future__ import annotations

from isophote.kernels.base.jit import exact_apart, exact_device, exact_kernel
from isophote.kernels.base.orient4d import orient4d
from isophote.kernels.base.predicates import orient2d, orient3d
from isophote.kernels.measure.quickhull import KIND_LIFTED_PLANE, KIND_LIFTED_SPACE, side_of

__all__ = ["lifted_spanning_points", "spanning_points"]


@exact_device
def _differ(points, a, b):
    count = 0
    for k in range(points.shape[1]):
        count += points[a, k] != points[b, k]
    return count > 0


@exact_apart
def _turn_somewhere(points, a, b, c):
    """Whether three points are not on a line, as seen along some axes."""
    for i in range(points.shape[1]):
        for j in range(i):
            if orient2d(points[a, i], points[a, j], points[b, i], points[b, j], points[c, i], points[c, j]) != 0:
                return True
    return False


@exact_apart
def _volume_somewhere(points, a, b, c, d):
    """Whether four points are not in a plane, as seen along some axes."""
    for i in range(points.shape[1]):
        for j in range(i):
            for k in range(j):
                ax, ay, az = points[a, i], points[a, j], points[a, k]
                bx, by, bz = points[b, i], points[b, j], points[b, k]
                cx, cy, cz = points[c, i], points[c, j], points[c, k]
                dx, dy, dz = points[d, i], points[d, j], points[d, k]
                if orient3d(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz) != 0:
                    return True
    return False


@exact_device
def _place4(points, a):
    return points[a, 0], points[a, 1], points[a, 2], points[a, 3]


@exact_device
def _is_new(points, found, count, p):
    """Whether a point lies outside the flat through those found."""
    if count == 0:
        return True
    if count == 1:
        return _differ(points, found[0], p)
    if count == 2:
        return _turn_somewhere(points, found[0], found[1], p)
    if count == 3:
        return _volume_somewhere(points, found[0], found[1], found[2], p)
    a, b = _place4(points, found[0]), _place4(points, found[1])
    return orient4d(a, b, _place4(points, found[2]), _place4(points, found[3]), _place4(points, p)) != 0


@exact_kernel
def spanning_points(points, found):
    """Write the numbers of the first points (n, d), d = 2 to 4, that are affinely independent, at most d + 1."""
    count = 0
    for p in range(len(points)):
        if _is_new(points, found, count, p):
            found[count] = p
            count += 1
            if count == points.shape[1] + 1:
                break
    return count


@exact_kernel
def lifted_spanning_points(points, found, count):
    """Add a point that is not on the circle or sphere through those found, d + 1 in d dimensions; how many then."""
    dimension = points.shape[1]
    if count < dimension + 1:
        return count
    kind = KIND_LIFTED_PLANE if dimension == 2 else KIND_LIFTED_SPACE
    for p in range(len(points)):
        if side_of(points, kind, found[0], found[1], found[2], found[dimension], p) != 0:
            found[count] = p
            return count + 1
    return count
