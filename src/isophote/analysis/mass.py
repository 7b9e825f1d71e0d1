"""Area, volume, centre of mass and inertia of meshes."""

from __future__ import annotations

import math

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.connectivity.topology import Topology, topology
from isophote.analysis.crew import pieces
from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh

__all__ = ["MassProperties", "area", "mass_properties"]

Points = npt.NDArray[np.float64]

_GRAIN = 1 << 16
_ROUNDING = 1e-15


@attrs.frozen(eq=False)
class MassProperties:
    """A solid of density 1: volume, area of its surface, centroid (3,), inertia (3, 3) about the centroid.

    inertia is ∫ |r|² I − r rᵀ dV, with r from the centroid. Units are the mesh's: m³, m², m, m⁵ if it is in metres.
    """

    volume: float
    area: float
    centroid: Points = attrs.field(converter=read_only)
    inertia: Points = attrs.field(converter=read_only)

    @property
    def principal(self) -> tuple[Points, Points]:
        """Principal moments of inertia (3,), the least first, and their unit axes, the rows of (3, 3)."""
        moments, axes = np.linalg.eigh(self.inertia)
        return moments, axes.T


def mass_properties(mesh: Mesh) -> MassProperties:
    """Volume, area, centroid and inertia of the solid that a closed mesh bounds, in float64.

    Integrals over the tetrahedra between a point and each triangle; polygons count as `triangulate` cuts them. A mesh
    whose faces look inward has a negative volume and inertia. Parts that overlap count twice. Source: Tonon, "Explicit
    exact formulas for the 3-D tetrahedron inertia tensor", 2004.

    Raises `GeometryError` where the faces bound no solid: at edges that they do not pass equally often both ways, and
    for coordinates so large that volumes overflow.
    """
    _check_bounds_a_solid(mesh, topology(mesh))
    origin = mesh.bounds.mean(axis=0)
    # What overflows is told below.
    with np.errstate(over="ignore", invalid="ignore"):
        sums = [_moments(corners - origin) for corners in _triangles(mesh)]
    volume, first, second, surface, size = (_total([np.asarray(part[i]) for part in sums]) for i in range(5))
    if not (np.isfinite(second).all() and math.isfinite(float(volume))):
        raise GeometryError("the mesh is too large for its inertia to be a finite number; scale it down")
    if abs(volume) <= _ROUNDING * size:
        raise GeometryError("the mesh has no volume, or one too small for a number, and so no centre of mass")
    offset = first / volume
    about_centroid = second - volume * np.outer(offset, offset)
    about_centroid = (about_centroid + about_centroid.T) / 2
    inertia = np.trace(about_centroid) * np.eye(3) - about_centroid
    return MassProperties(float(volume), float(surface), origin + offset, inertia)


def area(mesh: Mesh) -> float:
    """The area of all faces; polygons count as `triangulate` cuts them."""
    return math.fsum(float(np.linalg.norm(_doubled(corners), axis=1).sum()) for corners in _triangles(mesh)) / 2


def _triangles(mesh: Mesh) -> list[Points]:
    """The corners of the triangles, (t, 3, 3), in pieces."""
    triangles = triangulate(mesh).triangles
    return [mesh.vertices[triangles[first:last]] for first, last in pieces(len(triangles), _GRAIN)]


def _doubled(corners: Points) -> Points:
    """(t, 3) normals as long as twice the area."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _moments(corners: Points) -> tuple[float, Points, Points, float, float]:
    """Volume, ∫ r dV, ∫ r rᵀ dV between the origin and some triangles, their area, and all volumes without a sign.

    With d = det(a, b, c) and s = a + b + c these are d / 6, d s / 24 and d (a aᵀ + b bᵀ + c cᵀ + s sᵀ) / 120.
    """
    doubled = _doubled(corners)
    det = np.einsum("ti,ti->t", corners[:, 0], doubled)
    total = corners.sum(axis=1)
    spread = np.einsum("t,tki,tkj->ij", det, corners, corners, optimize=True)
    spread += np.einsum("t,ti,tj->ij", det, total, total, optimize=True)
    surface = np.linalg.norm(doubled, axis=1).sum() / 2
    return float(det.sum() / 6), det @ total / 24, spread / 120, float(surface), float(np.abs(det).sum() / 6)


def _total(parts: list[Points]) -> Points:
    """The sum over the pieces, each entry rounded once; NaN where one is not finite."""
    rows = np.stack(parts).reshape(len(parts), -1)
    sums = [math.fsum(column) if np.isfinite(column).all() else math.nan for column in rows.T]
    return np.array(sums).reshape(parts[0].shape)


def _check_bounds_a_solid(mesh: Mesh, found: Topology) -> None:
    if not found.closed:
        raise GeometryError(
            f"the mesh is not closed: {len(found.boundary_edges)} edges have one face, {_edge(found.boundary_edges)}; "
            "repair(mesh) fills holes"
        )
    if not found.oriented:
        raise GeometryError(
            f"along {len(found.turned_edges)} edges two faces run the same way, {_edge(found.turned_edges)}; "
            "orient(mesh) turns them"
        )
    unequal = _unequal_edges(mesh, found)
    if len(unequal):
        raise GeometryError(
            f"{len(unequal)} edges of three or more faces are not passed equally often both ways, {_edge(unequal)}"
        )


def _edge(edges: npt.NDArray[np.int32]) -> str:
    return f"the first from vertex {edges[0, 0]} to {edges[0, 1]}" if len(edges) else "all faces being degenerate"


def _unequal_edges(mesh: Mesh, found: Topology) -> npt.NDArray[np.int32]:
    """The edges of three or more faces that more faces pass one way than the other."""
    if len(found.non_manifold_edges) == 0:
        return found.non_manifold_edges
    balance = dict.fromkeys(map(tuple, found.non_manifold_edges.tolist()), 0)
    for face in found.non_manifold_faces:
        corners = mesh.indices[mesh.offsets[face] : mesh.offsets[face + 1]].tolist()
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            edge = (min(a, b), max(a, b))
            if edge in balance:
                balance[edge] += 1 if a < b else -1
    return np.array([edge for edge, excess in balance.items() if excess], np.int32).reshape(-1, 2)
