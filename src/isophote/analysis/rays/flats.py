"""Rays against planes, triangles and polygons: the vector method.

    t = n · (p − o) / (n · d)

A triangle is met where the ray passes its three edges on one side, told by the signs of det(d, a − o, b − o), exactly:
so no ray slips between two triangles that share an edge, and what lies on an edge meets both.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.polygon_inside import point_in_polygon
from isophote.analysis.rays.given import checked_rays, rows
from isophote.analysis.rays.result import RayCrossings
from isophote.errors import GeometryError
from isophote.shapes.primitive.polygon import Polygon

__all__ = ["ray_plane", "ray_polygon", "ray_triangle"]

Floats: TypeAlias = npt.NDArray[np.float64]

# Bound on the error of det(d, a − o, b − o) in parts of the sum of its terms' sizes, with room to spare: each term is a
# product of three numbers, two of them differences, and there are six.
_DETERMINANT_ERROR = 12 * 2.0**-53


def ray_plane(
    origins: npt.ArrayLike, directions: npt.ArrayLike, point: npt.ArrayLike, normal: npt.ArrayLike
) -> RayCrossings:
    """Rays against planes through `point` across `normal`, (3,) each, or (n, 3), one for each ray.

    Rays that run along the plane do not meet it. Normals may have any length but 0. Raises `GeometryError` for zero
    normals and directions, and numbers that are not finite.
    """
    o, d = checked_rays(origins, directions)
    p, n = rows("point", point, (3,), len(o)), rows("normal", normal, (3,), len(o))
    size = np.linalg.norm(n, axis=1)
    if not (size > 0).all():
        raise GeometryError(f"normal must not be zero, but number {int(np.argmin(size))} is")
    return _crossings(o, d, _plane_distances(o, d, p, n), n / size[:, None])


def ray_triangle(origins: npt.ArrayLike, directions: npt.ArrayLike, triangles: npt.ArrayLike) -> RayCrossings:
    """Rays against triangles, (3, 3) corners, or (n, 3, 3), one for each ray; from both sides, edges included.

    Which triangles are met is exact for all doubles, so that no ray slips through where triangles join. Normals point
    to where the corners are seen counterclockwise; a triangle without area is not met, nor one seen from its edge.
    """
    o, d = checked_rays(origins, directions)
    corners = rows("triangles", triangles, (3, 3), len(o))
    v = np.broadcast_to(corners, (len(o), 3, 3))
    signs = np.stack([_edge_signs(o, d, v[:, k], v[:, (k + 1) % 3]) for k in range(3)], axis=1)
    met = ((signs >= 0).all(axis=1) | (signs <= 0).all(axis=1)) & signs.any(axis=1)
    normal = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    size = np.linalg.norm(normal, axis=1)
    met &= size > 0
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = normal / size[:, None]
    distances = np.where(met, _plane_distances(o, d, v[:, 0], normal), np.nan)
    return _crossings(o, d, distances, unit)


def ray_polygon(
    origins: npt.ArrayLike, directions: npt.ArrayLike, polygon: Polygon | npt.ArrayLike | Sequence[Any]
) -> RayCrossings:
    """Rays against one planar polygon, a `Polygon` or its outline, (k, 3); from both sides, edges included.

    The crossing with the plane, in doubles, is inside by the crossing rule: an odd number of rings goes round it,
    exactly.
    """
    o, d = checked_rays(origins, directions)
    shape = polygon if isinstance(polygon, Polygon) else Polygon(polygon)
    t = _plane_distances(o, d, shape.frame[None, :3, 3], shape.normal[None])
    known = np.isfinite(t)
    # Without one axis, as it is: turned into the plane, corners would be rounded.
    flat = np.delete(np.arange(3), int(np.abs(shape.normal).argmax()))
    place = o[known] + t[known, None] * d[known]
    known[known] = (
        point_in_polygon([ring[:, flat] for ring in (shape.outline, *shape.holes)], place[:, flat], "evenodd") >= 0
    )
    return _crossings(o, d, np.where(known, t, np.nan), shape.normal[None])


def _plane_distances(o: Floats, d: Floats, p: Floats, n: Floats) -> Floats:
    """(n,) distances to planes; NaN for rays along them."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        t = ((p - o) * n).sum(axis=1) / (d * n).sum(axis=1)
    return np.asarray(np.where(np.isfinite(t), t, np.nan))


def _crossings(o: Floats, d: Floats, distances: Floats, normals: Floats) -> RayCrossings:
    ahead = distances >= 0
    first = np.where(ahead, distances, np.inf)
    point = np.where(ahead[:, None], o + np.where(ahead, distances, 0.0)[:, None] * d, np.nan)
    normal = np.where(ahead[:, None], np.broadcast_to(normals, o.shape), np.nan)
    return RayCrossings(first, distances[:, None], point, normal)


def _edge_signs(o: Floats, d: Floats, a: Floats, b: Floats) -> npt.NDArray[np.int8]:
    """(n,) exact signs of det(d, a − o, b − o): on which side a ray passes the edge from a to b."""
    p, q = a - o, b - o
    value = (d * np.cross(p, q)).sum(axis=1)
    size = sum(
        np.abs(d[:, i]) * (np.abs(p[:, j] * q[:, k]) + np.abs(p[:, k] * q[:, j]))
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    )
    signs: npt.NDArray[np.int8] = np.sign(value).astype(np.int8)
    for i in np.flatnonzero(np.abs(value) <= _DETERMINANT_ERROR * size):
        signs[i] = _exact_sign(o[i], d[i], a[i], b[i])
    return signs


def _exact_sign(o: Floats, d: Floats, a: Floats, b: Floats) -> int:
    origin, direction, start, end = (list(map(Fraction, row.tolist())) for row in (o, d, a, b))
    p = [s - c for s, c in zip(start, origin, strict=True)]
    q = [e - c for e, c in zip(end, origin, strict=True)]
    value = (
        direction[0] * (p[1] * q[2] - p[2] * q[1])
        + direction[1] * (p[2] * q[0] - p[0] * q[2])
        + direction[2] * (p[0] * q[1] - p[1] * q[0])
    )
    return (value > 0) - (value < 0)
