"""Exact signs of determinants of points: orientation, and inside or outside of circles and spheres."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.kernels.measure import signs

__all__ = ["incircle", "insphere", "orient2d", "orient3d"]

Signs: TypeAlias = npt.NDArray[np.int8]


def orient2d(a: npt.ArrayLike, b: npt.ArrayLike, c: npt.ArrayLike) -> Signs:
    """How the points a, b, c of the plane turn: 1 to the left (counterclockwise), -1 to the right, 0 on a line.

    sign det(a - c, b - c), exact for all finite doubles. Points are (..., 2), broadcast against each other; the signs
    have the shape (...). Raises `GeometryError` where a coordinate is not finite. Shewchuk, "Adaptive Precision
    Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997.
    """
    return _signs(signs.orient2d_signs, 2, a, b, c)


def orient3d(a: npt.ArrayLike, b: npt.ArrayLike, c: npt.ArrayLike, d: npt.ArrayLike) -> Signs:
    """On which side of the plane through a, b, c the point d lies: 1 where a, b, c are counterclockwise seen from the
    other side, -1 where they are clockwise, 0 in the plane.

    sign det(a - d, b - d, c - d), exact for all finite doubles. Points are (..., 3); else as `orient2d`.
    """
    return _signs(signs.orient3d_signs, 3, a, b, c, d)


def incircle(a: npt.ArrayLike, b: npt.ArrayLike, c: npt.ArrayLike, d: npt.ArrayLike) -> Signs:
    """Whether d lies inside the circle through a, b, c, counterclockwise: 1 inside, -1 outside, 0 on it.

    The sign of the determinant with the rows (p - d, |p - d|²) for p = a, b, c, exact for all finite doubles; it
    changes where a, b, c are clockwise. Points are (..., 2); else as `orient2d`.
    """
    return _signs(signs.incircle_signs, 2, a, b, c, d)


def insphere(a: npt.ArrayLike, b: npt.ArrayLike, c: npt.ArrayLike, d: npt.ArrayLike, e: npt.ArrayLike) -> Signs:
    """Whether e lies inside the sphere through a, b, c, d, with orient3d(a, b, c, d) = 1: 1 in, -1 out, 0 on it.

    The sign of the determinant with the rows (p - e, |p - e|²) for p = a, b, c, d, exact for all finite doubles; it
    changes with the sign of `orient3d`. Points are (..., 3); else as `orient2d`.
    """
    return _signs(signs.insphere_signs, 3, a, b, c, d, e)


def _signs(kernel: Callable[..., None], dimension: int, *points: npt.ArrayLike) -> Signs:
    arrays = [np.asarray(p, np.float64) for p in points]
    for name, array in zip("abcde", arrays, strict=False):
        if array.ndim == 0 or array.shape[-1] != dimension:
            raise GeometryError(f"{name} must be points of shape (..., {dimension}), but has shape {array.shape}")
        if not np.isfinite(array).all():
            raise GeometryError(f"{name} has a coordinate that is not finite")
    rows = _rows(arrays)
    found = np.empty(rows.shape[:-1], np.int8)
    kernel(rows.reshape(-1, rows.shape[-1]), found.reshape(-1))
    return found


def _rows(arrays: list[npt.NDArray[np.float64]]) -> npt.NDArray[Any]:
    """(..., points times dimension), contiguous."""
    try:
        return np.concatenate(np.broadcast_arrays(*arrays), axis=-1)
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise GeometryError(f"points of shapes {shapes} do not fit together") from None
