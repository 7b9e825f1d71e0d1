"""The medial axis of a closed mesh, as a complex of inner Voronoi vertices, edges and polygons."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.spatial import Delaunay

from isophote.analysis.arrays import read_only
from isophote.analysis.connectivity.topology import topology
from isophote.analysis.inside import contains
from isophote.analysis.sampling import sample_points
from isophote.analysis.skeleton.collapse import collapsed
from isophote.analysis.skeleton.surface import MedialSurface
from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh

__all__ = ["MedialSurface", "medial_axis_of_mesh"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
LongArray: TypeAlias = npt.NDArray[np.int64]

_MOST_SAMPLES = 200_000
_FEATURE = 0.03
# Samples are moved by this part of the diagonal, so that no five lie on a sphere and no four in a plane.
_JITTER = 1e-6
_DOUBLINGS = 3
_SIDES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))


def medial_axis_of_mesh(mesh: Mesh, samples: int, feature: float | None, seed: int) -> MedialSurface:
    """The pruned axis of a closed mesh; see `medial_axis`."""
    if isinstance(samples, bool) or not isinstance(samples, int | np.integer) or not 4 <= samples <= _MOST_SAMPLES:
        raise GeometryError(f"samples must be a whole number from 4 to {_MOST_SAMPLES:,}, not {samples!r}")
    found = topology(mesh)
    if not (found.closed and found.manifold and found.oriented):
        raise GeometryError(
            "a medial axis needs a closed, consistently oriented mesh; iso.analysis.repair may make one"
        )
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices[mesh.indices], axis=0)))
    least = _FEATURE * diagonal if feature is None else float(feature)
    if not 0 <= least < math.inf:
        raise GeometryError(f"feature must be a finite number, 0 or more, not {feature!r}")
    count = int(samples)
    for _ in range(_DOUBLINGS + 1):
        whole = _inner(mesh, _samples(mesh, count, seed, _JITTER * diagonal))
        # The boundary of a solid has twice its Euler characteristic.
        if 2 * whole.euler == found.euler:
            return collapsed(whole, least)
        count *= 2
    raise GeometryError(
        f"the axis of {count // 2:,} samples is not connected as the mesh is; its walls are too thin for so few: "
        "give more samples"
    )


def _samples(mesh: Mesh, count: int, seed: int, jitter: float) -> FloatArray:
    """Points on the surface: its vertices, and others spread evenly."""
    corners = mesh.vertices[np.unique(mesh.indices)]
    spread = sample_points(mesh, count, "blue-noise", seed).points
    if len(corners) > count:
        corners = corners[np.random.default_rng(seed).choice(len(corners), count, replace=False)]
    points = np.concatenate([corners, spread])
    return points + np.random.default_rng(seed).uniform(-jitter, jitter, points.shape)


def _inner(mesh: Mesh, points: FloatArray) -> MedialSurface:
    """All that lies inside of the Voronoi diagram of points: vertices, edges and polygons."""
    cut = Delaunay(points)
    corners: LongArray = cut.simplices.astype(np.int64)
    centres, radius = _spheres(points[corners])
    inside = np.zeros(len(corners), np.bool_)
    low, high = mesh.bounds
    within = np.flatnonzero(((centres > low) & (centres < high)).all(axis=1))
    inside[within] = contains(mesh, centres[within])
    number = np.cumsum(inside) - 1
    edges, edge_lambda, edge_sides = _edges(points, corners, cut.neighbors, inside)
    polygon_sides, polygon_of_edge = _polygons(corners, cut.neighbors, inside, edge_sides, len(points))
    ends = points[np.stack(np.divmod(polygon_sides, len(points)), axis=1)]
    return MedialSurface(
        read_only(centres[inside]),
        read_only(radius[inside]),
        read_only(number[edges].astype(np.int32)),
        read_only(polygon_of_edge),
        read_only(edge_lambda),
        read_only(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) / 2),
    )


def _spheres(p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Middles and radii of the spheres through rows of four points."""
    sides = p[:, 1:] - p[:, :1]
    squares = (sides**2).sum(axis=2)
    across = np.stack([np.cross(sides[:, (k + 1) % 3], sides[:, (k + 2) % 3]) for k in range(3)], axis=1)
    volume = (sides[:, 0] * across[:, 0]).sum(axis=1)
    with np.errstate(all="ignore"):
        away = (squares[:, :, None] * across).sum(axis=1) / (2 * volume)[:, None]
    away = np.where(np.isfinite(away), away, np.inf)
    return p[:, 0] + away, np.linalg.norm(away, axis=1)


def _edges(
    points: FloatArray, corners: LongArray, neighbours: npt.NDArray[np.int32], inside: npt.NDArray[np.bool_]
) -> tuple[LongArray, FloatArray, LongArray]:
    """(e, 2) neighbouring tetrahedra inside; half the longest side of the triangle between; its three sides."""
    t, k = np.nonzero((neighbours > np.arange(len(corners))[:, None]) & inside[:, None])
    s = neighbours[t, k]
    t, k, s = t[inside[s]], k[inside[s]], s[inside[s]]
    triangle = np.sort(corners[t][np.arange(4) != k[:, None]].reshape(-1, 3), axis=1)
    pairs = triangle[:, [[0, 1], [0, 2], [1, 2]]]
    lengths = np.linalg.norm(points[pairs[..., 0]] - points[pairs[..., 1]], axis=2)
    sides = pairs[..., 0] * len(points) + pairs[..., 1]
    return np.stack([t, s], axis=1), lengths.max(axis=1) / 2, sides


def _polygons(
    corners: LongArray,
    neighbours: npt.NDArray[np.int32],
    inside: npt.NDArray[np.bool_],
    edge_sides: LongArray,
    count: int,
) -> tuple[LongArray, npt.NDArray[np.int32]]:
    """Sides of which all tetrahedra around lie inside, and for each edge the polygons at it, (e, 3), -1 for none."""
    rows = np.sort(corners, axis=1)
    sides = np.stack([rows[:, a] * count + rows[:, b] for a, b in _SIDES], axis=1)
    t, k = np.nonzero(neighbours < 0)
    hull = np.sort(corners[t][np.arange(4) != k[:, None]].reshape(-1, 3), axis=1)
    outer = np.concatenate([hull[:, a] * count + hull[:, b] for a, b in ((0, 1), (0, 2), (1, 2))])
    open_sides = np.unique(np.concatenate([sides[~inside].reshape(-1), outer]))
    whole = np.setdiff1d(np.unique(edge_sides), open_sides, assume_unique=True)
    place = np.searchsorted(whole, edge_sides)
    known = np.zeros(edge_sides.shape, np.bool_)
    if len(whole):
        known = whole[np.minimum(place, len(whole) - 1)] == edge_sides
    return whole, np.where(known, place, -1).astype(np.int32)
