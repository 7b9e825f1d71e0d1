"""The exact predicates over arrays of points, a row of coordinates for each tuple of points."""

from __future__ import annotations

from isophote.kernels.base.jit import exact_kernel
from isophote.kernels.base.predicates import incircle, insphere, orient2d, orient3d

__all__ = ["incircle_signs", "insphere_signs", "orient2d_signs", "orient3d_signs"]


@exact_kernel
def orient2d_signs(rows, signs):
    """Signs, (n,) int8, of rows (n, 6): ax, ay, bx, by, cx, cy."""
    for i in range(len(rows)):
        p = rows[i]
        signs[i] = orient2d(p[0], p[1], p[2], p[3], p[4], p[5])


@exact_kernel
def incircle_signs(rows, signs):
    """Signs, (n,) int8, of rows (n, 8)."""
    for i in range(len(rows)):
        p = rows[i]
        signs[i] = incircle(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7])


@exact_kernel
def orient3d_signs(rows, signs):
    """Signs, (n,) int8, of rows (n, 12)."""
    for i in range(len(rows)):
        p = rows[i]
        signs[i] = orient3d(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11])


@exact_kernel
def insphere_signs(rows, signs):
    """Signs, (n,) int8, of rows (n, 15)."""
    for i in range(len(rows)):
        p = rows[i]
        signs[i] = insphere(
            p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12], p[13], p[14]
        )
