"""Barycentric coordinates: from points to weights of a triangle's corners, back, and between values at the corners."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["barycentric", "from_barycentric", "interpolate"]

Floats: TypeAlias = npt.NDArray[np.float64]


def barycentric(triangles: npt.ArrayLike, points: npt.ArrayLike) -> Floats:
    """(n, 3) weights of the corners at points (n, d), in the plane (d = 2) or in space (d = 3).

        w_k = area of the triangle of p and the other two corners / area of the triangle

    with the sign of the side that p lies on, so that p = Σ w_k v_k and Σ w_k = 1; in space, of p's foot in the plane of
    the triangle. `triangles` is (3, d), or (n, 3, d), one for each point. Inside no weight is negative.
    The largest weight is found from the two others, so the sum is 1 but for one rounding. Raises `GeometryError` for
    triangles without area, and coordinates that are not finite.
    """
    p = _finite("points", points)
    if p.ndim != 2 or p.shape[1] not in (2, 3):
        raise GeometryError(f"points must have shape (n, 2) or (n, 3), but have {p.shape}")
    v = _corners(triangles, len(p), p.shape[1])
    e1, e2 = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
    normal = _cross(e1, e2)
    size2 = (normal * normal).sum(axis=1)
    # Edges whose squares underflow, or that lie on one line to the last digit.
    least = (2.0**-50 * np.maximum((e1 * e1).sum(axis=1), (e2 * e2).sum(axis=1))) ** 2
    flat = ~(size2 > least)
    if flat.any():
        raise GeometryError(f"triangle {int(np.argmax(flat))} has no area, so its corners have no weights")
    from_corners = p[:, None] - v
    opposite = np.stack([v[:, 2] - v[:, 1], -e2, e1], axis=1)
    # Each from the nearer of its edge's ends, so that weights next to an edge keep their digits.
    starts, ends = from_corners[:, [1, 2, 0]], from_corners[:, [2, 0, 1]]
    nearer = (starts * starts).sum(axis=2) <= (ends * ends).sum(axis=2)
    arms = np.where(nearer[..., None], starts, ends)
    weights = np.stack([(_cross(opposite[:, k], arms[:, k]) * normal).sum(axis=1) for k in range(3)], axis=1)
    weights /= size2[:, None]
    largest = weights.argmax(axis=1)[:, None]
    np.put_along_axis(weights, largest, 0.0, axis=1)
    np.put_along_axis(weights, largest, 1.0 - weights.sum(axis=1, keepdims=True), axis=1)
    return np.asarray(weights)


def from_barycentric(corners: npt.ArrayLike, weights: npt.ArrayLike) -> Floats:
    """(n, d) points, or any other values, Σ w_k v_k, from `weights` (n, 3) of values at the corners.

    `corners` is (3, d), or (n, 3, d), one for each row of weights: positions of triangles, colours, normals (which must
    be made unit vectors again), texture coordinates. Raises `GeometryError` for other shapes.
    """
    w = _finite("weights", weights)
    if w.ndim != 2 or w.shape[1] != 3:
        raise GeometryError(f"weights must have shape (n, 3), but have {w.shape}")
    return np.asarray((w[:, :, None] * _corners(corners, len(w), None)).sum(axis=1))


def interpolate(mesh: Mesh, attribute: str | npt.ArrayLike, triangles: npt.ArrayLike, weights: npt.ArrayLike) -> Floats:
    """(n, d) values of an attribute within triangles of a mesh: `weights` (n, 3) of the corners of `triangles` (n,).

    `attribute` is the name of one of the mesh's ("uv", "normal", "colour", …; "position" for the vertices), or values
    at the vertices, (vertices, d). Triangles are counted as `triangulate` cuts the faces: a mesh of triangles has its
    own. Raises `GeometryError` for names and numbers that are not there, and corners without a value.
    """
    cut = triangulate(mesh)
    numbers = np.asarray(triangles)
    if numbers.ndim != 1 or not np.issubdtype(numbers.dtype, np.integer):
        raise GeometryError(f"triangles must be whole numbers of shape (n,), but are {numbers.dtype} {numbers.shape}")
    if numbers.size and not (numbers.min() >= 0 and numbers.max() < len(cut.triangles)):
        raise GeometryError(f"triangles must be 0 to {len(cut.triangles) - 1}, but {numbers.min()} to {numbers.max()}")
    values = _attribute(mesh, attribute)
    if values.indices is None:
        rows = cut.triangles[numbers]
    else:
        rows = values.indices[cut.corners[numbers]]
        if rows.size and rows.min() < 0:
            bad = int(np.argmax((rows < 0).any(axis=1)))
            raise GeometryError(f"triangle {int(numbers[bad])} has a corner without a value")
    return from_barycentric(np.asarray(values.values, np.float64)[rows], weights)


def _attribute(mesh: Mesh, attribute: str | npt.ArrayLike) -> Attribute:
    if isinstance(attribute, str):
        if attribute == "position":
            return Attribute(mesh.vertices)
        if attribute not in mesh.attributes:
            names = ", ".join(["position", *mesh.attributes])
            raise GeometryError(f'the mesh has no attribute "{attribute}"; it has {names}')
        return mesh.attributes[attribute]
    values = np.asarray(attribute)
    values = values[:, None] if values.ndim == 1 else values
    if values.ndim != 2 or len(values) != len(mesh.vertices):
        raise GeometryError(f"attribute must have a row for each of {len(mesh.vertices)} vertices, not {values.shape}")
    return Attribute(values)


def _finite(name: str, values: npt.ArrayLike) -> Floats:
    try:
        array = np.array(values, np.float64)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"{name} must be numbers: {error}") from None
    if not np.isfinite(array).all():
        raise GeometryError(f"{name} must be finite, but number {int(np.argwhere(~np.isfinite(array))[0][0])} is not")
    return array


def _corners(values: npt.ArrayLike, count: int, dimension: int | None) -> Floats:
    """(n, 3, d) values at corners, one row for all or one for each."""
    array = _finite("triangles" if dimension else "corners", values)
    array = array[None] if array.ndim == 2 else array
    right = array.ndim == 3 and array.shape[1] == 3 and dimension in (None, array.shape[2])
    if not right or len(array) not in (1, count):
        wanted = "d" if dimension is None else dimension
        raise GeometryError(
            f"triangles must have shape (3, {wanted}) or ({count}, 3, {wanted}), but {np.shape(values)}"
        )
    return array


def _cross(a: Floats, b: Floats) -> Floats:
    """(n, 3) a × b, or (n, 1) in the plane."""
    if a.shape[1] == 2:
        return np.asarray(a[:, :1] * b[:, 1:] - a[:, 1:] * b[:, :1])
    return np.asarray(np.cross(a, b))
