"""Quadrics: sums of squared distances to planes, ten numbers that add up.

Q(p) = pᵀ A p + 2 bᵀ p + c, kept as (a11, a12, a13, a22, a23, a33, b1, b2, b3, c).
Source: Garland, Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997.
"""

from __future__ import annotations

from isophote.kernels.base.double3 import Double3, dot3
from isophote.kernels.base.jit import device

__all__ = ["add_plane", "best_place", "quadric_error"]

# A determinant below this part of the cube of the trace: the planes don't determine a point.
_FLAT = 1e-6


@device
def add_plane(quadrics, v, n, p, weight):
    """Add `weight` times the squared distance to the plane through p with the unit normal n to quadric v."""
    d = -dot3(n, p)
    quadrics[v, 0] += weight * n.x * n.x
    quadrics[v, 1] += weight * n.x * n.y
    quadrics[v, 2] += weight * n.x * n.z
    quadrics[v, 3] += weight * n.y * n.y
    quadrics[v, 4] += weight * n.y * n.z
    quadrics[v, 5] += weight * n.z * n.z
    quadrics[v, 6] += weight * n.x * d
    quadrics[v, 7] += weight * n.y * d
    quadrics[v, 8] += weight * n.z * d
    quadrics[v, 9] += weight * d * d


@device
def quadric_error(q, p):
    """Q(p), for the ten numbers q; never below 0."""
    value = (
        q[0] * p.x * p.x
        + q[3] * p.y * p.y
        + q[5] * p.z * p.z
        + 2.0 * (q[1] * p.x * p.y + q[2] * p.x * p.z + q[4] * p.y * p.z)
        + 2.0 * (q[6] * p.x + q[7] * p.y + q[8] * p.z)
        + q[9]
    )
    return max(value, 0.0)


@device
def best_place(q, first, last):
    """Where Q is least; on the line from `first` to `last`, or at its ends or middle, where that is not determined."""
    c11, c12, c13 = q[3] * q[5] - q[4] * q[4], q[2] * q[4] - q[1] * q[5], q[1] * q[4] - q[2] * q[3]
    determinant = q[0] * c11 + q[1] * c12 + q[2] * c13
    trace = q[0] + q[3] + q[5]
    if determinant > _FLAT * trace * trace * trace:
        c22, c23, c33 = q[0] * q[5] - q[2] * q[2], q[1] * q[2] - q[0] * q[4], q[0] * q[3] - q[1] * q[1]
        return Double3(
            -(c11 * q[6] + c12 * q[7] + c13 * q[8]) / determinant,
            -(c12 * q[6] + c22 * q[7] + c23 * q[8]) / determinant,
            -(c13 * q[6] + c23 * q[7] + c33 * q[8]) / determinant,
        )
    middle = Double3(0.5 * (first.x + last.x), 0.5 * (first.y + last.y), 0.5 * (first.z + last.z))
    at_first, at_middle, at_last = quadric_error(q, first), quadric_error(q, middle), quadric_error(q, last)
    if at_middle <= at_first and at_middle <= at_last:
        return middle
    return first if at_first <= at_last else last
