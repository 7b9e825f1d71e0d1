"""Vertices that lie at one place made one."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from isophote.analysis.mending.edit import Edit, Longs, unchanged
from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh

__all__ = ["weld"]

# More neighbours than this, for each vertex, and the tolerance is no tolerance.
_MOST_NEAR = 64
_FEW = 10_000


def weld(mesh: Mesh, tolerance: float) -> tuple[Edit, Longs]:
    """Merge each vertex into the first one that lies within `tolerance` of it and was not merged itself.

    Returns the edit, and the merged vertices with those that they went into, (k, 2).
    """
    is_number = isinstance(tolerance, int | float | np.number) and not isinstance(tolerance, bool)
    if not (is_number and math.isfinite(tolerance) and tolerance >= 0):
        raise GeometryError(f"weld must be None or a distance, finite and 0 or above, but is {tolerance!r}")
    leader = _same_place(mesh.vertices)
    if tolerance > 0:
        own = np.flatnonzero(leader == np.arange(len(leader)))
        leader = own[_near(mesh.vertices[own], tolerance)][np.searchsorted(own, leader)]
    stays = leader == np.arange(len(leader))
    merged = np.flatnonzero(~stays)
    number = np.cumsum(stays) - 1
    edit = unchanged(mesh)._replace(vertex=np.flatnonzero(stays), indices=number[leader[mesh.indices]])
    return edit, np.stack([merged, leader[merged]], axis=1)


def _same_place(points: npt.NDArray[np.float64]) -> Longs:
    """For each point the first one with the same coordinates."""
    order = np.lexsort(points.T)
    ordered = points[order]
    new = np.concatenate([[True], (ordered[1:] != ordered[:-1]).any(axis=1)])
    # Sorting keeps the order of equal points: the first one of a group has the least number.
    leader = np.empty(len(points), np.int64)
    leader[order] = order[new][np.cumsum(new) - 1]
    return leader


def _near(points: npt.NDArray[np.float64], tolerance: float) -> Longs:
    """For each point the first one within the tolerance that stands for itself."""
    from scipy.spatial import cKDTree

    from isophote.kernels.measure.weld import lead

    tree = cKDTree(points)
    near = (int(tree.count_neighbors(tree, tolerance)) - len(points)) // 2
    if near > _FEW + _MOST_NEAR * len(points):
        raise GeometryError(
            f"welding within {tolerance:g} would compare {near:,} pairs of {len(points):,} vertices; the tolerance is "
            "too large for this mesh, whose vertices should be farther apart"
        )
    pairs = tree.query_pairs(tolerance, output_type="ndarray").astype(np.int64)
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    leader = np.arange(len(points))
    lead(pairs, leader)
    return leader
