"""Facets of convex hulls of three and four dimensions, plain and lifted, by exact quickhull."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from isophote.kernels.measure import quickhull, spanning

__all__ = ["Facets", "hull_facets", "lifted_facets"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]
_Number = TypeVar("_Number", np.int32, np.float64)

_ROOM = 1024
# Heights over facets err by less than this, in a box of size 1 of up to four dimensions: a few hundred roundings of
# numbers of at most 50. Not for points so small that they lose places when they are halved.
_SURE, _SMALLEST = 1e-11, 1e-280


class Facets(NamedTuple):
    """`corners` and `neighbours`, each opposite its corner: (f, d) int32. The outside is where the determinant of the
    corners and a point is positive.
    """

    corners: IntArray
    neighbours: IntArray


def hull_facets(points: FloatArray) -> Facets | None:
    """The facets of the convex hull of points (n, 3) or (n, 4); None where they lie in a flat."""
    dimension = points.shape[1]
    simplex = np.empty(dimension + 1, np.int64)
    if spanning.spanning_points(points, simplex) <= dimension:
        return None
    kind = quickhull.KIND_SPACE if dimension == 3 else quickhull.KIND_SPACE_4
    return _quickhull(points, _places(points), kind, simplex)


def lifted_facets(points: FloatArray) -> Facets | None:
    """The facets of the hull of points (n, 2) or (n, 3) with the sum of their squares as another coordinate.

    None where all lie on one circle or sphere, line or plane. No point may occur twice.
    """
    dimension = points.shape[1]
    simplex = np.empty(dimension + 2, np.int64)
    count = spanning.spanning_points(points, simplex)
    if spanning.lifted_spanning_points(points, simplex, count) < dimension + 2:
        return None
    kind = quickhull.KIND_LIFTED_PLANE if dimension == 2 else quickhull.KIND_LIFTED_SPACE
    places = _places(points)
    return _quickhull(points, np.column_stack([places, (places**2).sum(axis=1)]), kind, simplex)


def _places(points: FloatArray) -> FloatArray:
    """Points about their middle in a box of size 1, for rounded distances."""
    least, greatest = points.min(axis=0) * 0.5, points.max(axis=0) * 0.5
    extent = (greatest - least).max()
    return np.asarray((points * 0.5 - 0.5 * (least + greatest)) / (extent if extent > 0 else 1.0))


def _quickhull(points: FloatArray, places: FloatArray, kind: int, simplex: npt.NDArray[np.int64]) -> Facets:
    dimension = places.shape[1]
    places = np.ascontiguousarray(places)
    tolerance = _SURE if np.ptp(points * 0.5, axis=0).max() > _SMALLEST else np.inf
    count, capacity, room = len(points), 16 * len(points) + _ROOM, _ROOM
    facets, planes = np.empty((capacity, quickhull.RECORD), np.int32), np.empty((capacity, 4))
    lists, distances, marks = np.empty(capacity, np.int32), np.empty(capacity), np.full(capacity, -1, np.int64)
    following, heads = np.empty(count, np.int32), np.full(count, -1, np.int32)
    state = np.zeros(2, np.int64)
    quickhull.first_facets(
        points, places, kind, dimension, tolerance, simplex, facets, planes, lists, distances, following, state
    )
    while True:
        seen, rim, chains = np.empty(room, np.int32), np.empty(4 * room, np.int32), np.empty((12 * room, 4), np.int32)
        tables = (facets, planes, lists, distances, following, marks, heads, seen, rim, chains, state)
        if quickhull.expand_hull(points, places, kind, dimension, tolerance, *tables):
            break
        if state[quickhull.COUNT] + 4 * room > len(facets):
            facets, lists = _longer(facets), _longer(lists)
            planes, distances = _longer(planes), _longer(distances)
            marks = np.concatenate([marks, np.full_like(marks, -1)])
        else:
            room *= 2
    total = int(state[quickhull.COUNT])
    return chosen_facets(facets[:total], marks[:total] != -2, dimension)


def _longer(array: npt.NDArray[_Number]) -> npt.NDArray[_Number]:
    """Twice the rows, of which the first are these."""
    return np.concatenate([array, np.empty_like(array)])


def chosen_facets(facets: IntArray, chosen: npt.NDArray[np.bool_], dimension: int) -> Facets:
    """Some of the facets; neighbours that are not among them become -1."""
    number = np.full(len(facets), -1, np.int32)
    number[chosen] = np.arange(np.count_nonzero(chosen), dtype=np.int32)
    kept = facets[chosen]
    links = quickhull.RECORD // 2
    return Facets(kept[:, :dimension].copy(), number[kept[:, links : links + dimension]])
