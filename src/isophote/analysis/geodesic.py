"""Distances along a surface."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.half_edges import half_edges
from isophote.analysis.curvature.operators import laplacian, mass_matrix
from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError
from isophote.kernels.measure.geodesic import exact_distances
from isophote.shapes.mesh import Mesh

__all__ = ["geodesic_distance"]

Floats: TypeAlias = npt.NDArray[np.float64]
Indices: TypeAlias = npt.NDArray[np.int64]

# Windows that may wait at one time: 64 bytes each and as much again while their room grows.
_MOST = 1 << 24
# Angles round a vertex within so much of 2π are taken for more: a path may run through it.
_FLAT = 1e-9


def geodesic_distance(
    mesh: Mesh, sources: npt.ArrayLike, method: Literal["exact", "heat"] = "exact", *, time: float = 1.0
) -> Floats:
    """(n,) float64: for each vertex of `mesh` the length of the shortest path over the surface to one of `sources`.

    `sources` are vertex numbers, or one. Infinite where no path leads, or no face is. "exact": shortest paths over the
    flat faces, across edges, by windows (Xin, Wang 2009); to rounding. "heat": from the gradient of heat that flows
    from the sources for a short time, `time` times the square of the mean edge length; smooth, two sparse solutions,
    and wrong by some per cent, the more the less regular the triangles (Crane, Weischedel, Wardetzky: "Geodesics in
    Heat", 2013). Faces of more than three corners are taken as their triangles.

    Raises `GeometryError` for sources that are no vertices, edges of three or more faces, faces that run against each
    other, edges without length, and, "exact", for meshes that need more than 16 million windows at a time.
    """
    if method not in ("exact", "heat"):
        raise GeometryError(f'method must be "exact" or "heat", not {method!r}')
    given = np.atleast_1d(np.asarray(sources))
    if given.ndim != 1 or not len(given) or not np.issubdtype(given.dtype, np.integer):
        raise GeometryError("sources must be the numbers of one or more vertices")
    if given.min() < 0 or given.max() >= len(mesh.vertices):
        raise GeometryError(f"sources must be vertices from 0 to {len(mesh.vertices) - 1}, not {given.tolist()[:5]}")
    triangles = Mesh(mesh.vertices, triangulate(mesh).triangles)
    starts = np.unique(given).astype(np.int64)
    if method == "heat":
        if not (np.isfinite(time) and time > 0):
            raise GeometryError(f"time must be positive, not {time!r}")
        return _by_heat(triangles, starts, float(time))
    return _exact(triangles, starts)


def _edge_lengths(mesh: Mesh) -> Floats:
    """(m, 3) lengths of the edges from each corner to the next, all above 0."""
    corners = mesh.vertices[np.asarray(mesh.faces)]
    lengths: Floats = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    if not lengths.all():
        face = int(np.argmin(lengths.min(axis=1)))
        raise GeometryError(f"face {face} has an edge without length; `analysis.repair` takes such faces out")
    return lengths


def _across(mesh: Mesh) -> npt.NDArray[np.int64]:
    """(m, 3) the half-edge on the other side of each edge, or -1."""
    twin = half_edges(mesh).twin.astype(np.int64).reshape(-1, 3)
    for code, what, mend in (
        (-2, "has an edge of three or more faces", "no path over it has a side to go on to"),
        (-3, "runs against its neighbour", "`analysis.orient` turns it round"),
        (-4, "names a vertex twice", "`analysis.repair` takes it out"),
    ):
        bad = (twin == code).any(axis=1)
        if bad.any():
            raise GeometryError(f"face {int(np.argmax(bad))} {what}; {mend}")
    return twin


def _exact(mesh: Mesh, sources: Indices) -> Floats:
    # A unit of about the mesh's size, so that no square over- or underflows.
    faces = np.ascontiguousarray(mesh.faces, np.int64)
    scale = float(np.ldexp(1.0, -int(np.frexp(np.abs(mesh.bounds).max())[1])))
    mesh = mesh.with_(vertices=mesh.vertices * scale, attributes={})
    lengths, across = _edge_lengths(mesh), _across(mesh)
    count = len(mesh.vertices)
    order = np.argsort(faces.reshape(-1), kind="stable")
    firsts = np.concatenate([np.zeros(1, np.int64), np.cumsum(np.bincount(faces.reshape(-1), minlength=count))])
    turning = _turning(faces, lengths, across, count)
    turning[sources] = True
    distance = np.full(count, np.inf)
    points = np.require(mesh.vertices, np.float64, ["C", "W"])
    flags = turning.astype(np.uint8)
    carried = exact_distances(points, faces, across, lengths, flags, firsts, order, sources, _MOST, distance)
    if carried < 0:
        raise GeometryError(f'more than {_MOST:,} windows at a time; use method="heat"')
    return distance / scale


def _turning(faces: Indices, lengths: Floats, across: npt.NDArray[np.int64], count: int) -> npt.NDArray[np.bool_]:
    """(n,) whether shortest paths may turn at a vertex: 2π or more lie round it, or it is on the boundary."""
    before, after = np.roll(lengths, 1, axis=1), lengths
    opposite = np.roll(lengths, -1, axis=1)
    # Kahan's formula for angles of needles would order the lengths; half-angles by factors of Heron's are as good here.
    s = (before + after + opposite) / 2
    top, bottom = np.maximum((s - before) * (s - after), 0), np.maximum(s * (s - opposite), 0)
    angles = 2 * np.arctan2(np.sqrt(top), np.sqrt(bottom))
    turning: npt.NDArray[np.bool_] = np.bincount(faces.reshape(-1), angles.reshape(-1), count) > 2 * np.pi - _FLAT
    rim = across < 0
    turning[faces[rim]] = True
    turning[np.roll(faces, -1, axis=1)[rim]] = True
    return turning


def _by_heat(mesh: Mesh, sources: Indices, time: float) -> Floats:
    from scipy.sparse import csc_array
    from scipy.sparse.csgraph import connected_components
    from scipy.sparse.linalg import splu

    faces = np.asarray(mesh.faces)
    lengths = _edge_lengths(mesh)
    size = float(lengths.mean())
    mesh = mesh.with_(vertices=mesh.vertices / size, attributes={})
    stiffness, mass = csc_array(laplacian(mesh)), csc_array(mass_matrix(mesh, "barycentric"))
    count = len(mesh.vertices)
    # Vertices without faces would make the systems singular; so would a component's constant without a little mass.
    lonely = np.flatnonzero(mass.diagonal() == 0)
    filler = csc_array((np.ones(len(lonely)), (lonely, lonely)), shape=(count, count))
    heat = np.zeros(count)
    heat[sources] = 1.0
    options = {"permc_spec": "MMD_AT_PLUS_A", "options": {"SymmetricMode": True}}
    flow = splu(csc_array(mass + time * stiffness + filler), **options).solve(heat)
    sink = splu(csc_array(stiffness + 1e-9 * mass + filler), **options).solve(_divergence(mesh.vertices, faces, flow))
    sheets = connected_components(stiffness + filler, directed=False)[1]
    distance = np.full(count, np.inf)
    for sheet in np.unique(sheets[sources]):
        own = sheets == sheet
        distance[own] = sink[own] - sink[sources[sheets[sources] == sheet]].mean()
    found: Floats = np.maximum(distance, 0.0) * size
    return found


def _divergence(points: Floats, faces: npt.NDArray[np.integer], values: Floats) -> Floats:
    """(n,) minus the integrated divergence of the unit field along the gradient of `values`, downhill."""
    p = points[faces]
    normal = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    # Gradients of the corners' hat functions, times twice the area; of the heat only the direction counts.
    hats = np.stack([np.cross(normal, p[:, (k + 2) % 3] - p[:, (k + 1) % 3]) for k in range(3)], axis=1)
    area = np.linalg.norm(normal, axis=1)
    largest = np.maximum(np.abs(values[faces]).max(axis=1), np.finfo(float).tiny)
    gradient = ((values[faces] / largest[:, None])[:, :, None] * hats).sum(axis=1)
    length = np.linalg.norm(gradient, axis=1)
    field = -gradient / np.where(length > 0, length, 1.0)[:, None]
    flux = (hats * field[:, None, :]).sum(axis=2) / np.where(area > 0, 2 * area, 1.0)[:, None]
    sums: Floats = np.bincount(faces.reshape(-1), flux.reshape(-1), len(points)).astype(np.float64)
    return sums
