"""Topology of meshes: what is connected how, and which edges, vertices and faces stand in the way."""

from __future__ import annotations

import math
from typing import NamedTuple

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import distinct, read_only
from isophote.analysis.connectivity.boundary import Chains, Details, Walks, look_closer, passed_vertices, trace
from isophote.analysis.connectivity.components import Components, Pieces, find_pieces
from isophote.analysis.connectivity.sheets import find_sheets
from isophote.analysis.connectivity.stars import Faces, Longs, Stars, as_mesh, gather, pick_sound_faces
from isophote.analysis.crew import pieces, run
from isophote.convert.triangulate import triangulate
from isophote.kernels.measure import stars as kernels
from isophote.kernels.measure.angles import sum_angles
from isophote.shapes.mesh import Mesh

__all__ = ["Topology", "topology"]

_GRAIN = 1 << 16


@attrs.frozen(eq=False, kw_only=True)
class Topology:
    """What `topology` finds. Edges are (k, 2) vertex numbers, the smaller one first, in increasing order.

    closed: every edge has two or more faces. manifold: every edge has one or two, and the faces at each vertex form
    one fan, closed or open. oriented: no two faces run the same way along an edge of two faces. orientable: faces can
    be turned so that this holds; for a mesh that is not manifold, as far as edges of two faces connect them.

    vertices, edges, faces: V, E, F: vertices that faces use, undirected edges, faces. euler: χ = V − E + F. genus:
    the sum over the components, g = (2 − b − χ) / 2 with b boundary loops; None unless all are manifold and orientable.

    angle_deficit: the sum of 2π − Σθ over the vertices with as many edges as corners, those inside of a manifold.
    boundary_turning: the sum of π (2 − edges + corners) − Σθ over the others, which is π − Σθ at the boundary of a
    manifold. Together they are 2πχ on every mesh, up to rounding (Gauss and Bonnet).

    To blame: boundary_edges, of one face; non_manifold_edges, of three or more, and non_manifold_faces at them;
    turned_edges, along which two faces run the same way; non_manifold_vertices, whose faces do not form one fan (the
    ends of non-manifold edges among them). Set aside: unused_vertices, and degenerate_faces, which name a vertex
    twice and count nowhere else. Faces without area are faces like others.
    """

    closed: bool
    manifold: bool
    oriented: bool
    orientable: bool
    vertices: int
    edges: int
    faces: int
    euler: int
    genus: int | None
    angle_deficit: float
    boundary_turning: float
    components: Components = attrs.field(repr=lambda value: f"<{len(value)}>")
    boundary_edges: npt.NDArray[np.int32] = attrs.field(repr=False, converter=read_only)
    non_manifold_edges: npt.NDArray[np.int32] = attrs.field(repr=False, converter=read_only)
    non_manifold_faces: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    non_manifold_vertices: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    turned_edges: npt.NDArray[np.int32] = attrs.field(repr=False, converter=read_only)
    unused_vertices: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    degenerate_faces: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    _walks: Walks = attrs.field(repr=False)

    @property
    def boundary_loops(self) -> tuple[npt.NDArray[np.int32], ...]:
        """The vertices of each closed walk along the boundary, in the direction of its faces' sides.

        At a vertex of several fans a walk goes on along the fan by which it came.
        """
        return self._passed(is_open=False)

    @property
    def boundary_chains(self) -> tuple[npt.NDArray[np.int32], ...]:
        """The vertices of walks along the boundary that end at non-manifold edges; none on a manifold."""
        return self._passed(is_open=True)

    @property
    def loop_count(self) -> int:
        """How many `boundary_loops` there are."""
        return int((~self._walks.is_open).sum())

    @property
    def gauss_bonnet_error(self) -> float:
        """angle_deficit + boundary_turning − 2πχ: rounding."""
        return math.fsum([self.angle_deficit, self.boundary_turning, -2 * math.pi * self.euler])

    def _passed(self, *, is_open: bool) -> tuple[npt.NDArray[np.int32], ...]:
        vertices, starts = read_only(self._walks.vertices), self._walks.starts
        return tuple(vertices[starts[i] : starts[i + 1]] for i in np.flatnonzero(self._walks.is_open == is_open))


def topology(mesh: Mesh) -> Topology:
    """What is connected how in a mesh of triangles or polygons, by whole numbers; see `Topology`.

    Vertices are what the faces name: two at one place are two (`repair(mesh, weld=0)` merges them). Time is linear in
    the number of corners. Raises `GeometryError` for what is no mesh and for more than 2^30 − 1 corners.
    """
    faces = pick_sound_faces(mesh)
    stars = gather(faces)
    degree, kind = survey(stars)
    shape = kind & np.uint8(3)
    turned = bool((kind & kernels.TURNED).any())
    found = _details(stars, np.flatnonzero(kind > kernels.INSIDE))
    boundary, crowded = found.details.half_edges(kernels.EDGE_BOUNDARY), found.details.half_edges(kernels.EDGE_CROWDED)
    parts = find_pieces(faces, degree)
    singular = np.flatnonzero(shape == kernels.SINGULAR)
    manifold = np.ones(len(parts), np.bool_)
    manifold[parts.of_vertex[singular]] = False
    conflicts = find_sheets(faces, stars).conflicts if turned else np.empty(0, np.int64)
    components = _components(parts, faces, found, boundary, manifold, conflicts)
    deficit, turning = _angles(mesh, faces, stars, degree)
    used = int(parts.vertices.sum())
    whole = bool((manifold & components.orientable).all())
    return Topology(
        closed=faces.total > 0 and len(boundary) == 0,
        manifold=bool(manifold.all()),
        oriented=not turned,
        orientable=len(conflicts) == 0,
        vertices=used,
        edges=int(parts.edges.sum()),
        faces=faces.total,
        euler=used - int(parts.edges.sum()) + faces.total,
        genus=int(components.genus.sum()) if whole else None,
        angle_deficit=deficit,
        boundary_turning=turning,
        components=components,
        boundary_edges=_edges(faces, boundary),
        non_manifold_edges=_edges(faces, crowded),
        non_manifold_faces=faces.number(distinct(faces.of_half_edges(crowded))),
        non_manifold_vertices=singular,
        turned_edges=_edges(faces, found.details.half_edges(kernels.EDGE_TURNED)),
        unused_vertices=np.flatnonzero(degree == 0),
        degenerate_faces=faces.degenerate,
        walks=passed_vertices(faces, found.chains),
    )


def survey(stars: Stars) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.uint8]]:
    """(vertices,) the number of edges at each vertex, and its kind as in kernels/measure/stars.py."""
    count = len(stars.starts) - 1
    degree, kind = np.empty(count, np.int32), np.empty(count, np.uint8)
    run(kernels.survey, [(*stars.table, *piece, degree, kind) for piece in stars.ranges()])
    return degree, kind


class _Found(NamedTuple):
    details: Details
    chains: Chains


def _details(stars: Stars, chosen: Longs) -> _Found:
    details = look_closer(stars, chosen)
    return _Found(details, trace(details))


def _components(
    parts: Pieces,
    faces: Faces,
    found: _Found,
    boundary: Longs,
    manifold: npt.NDArray[np.bool_],
    conflicts: Longs,
) -> Components:
    """What can be said of each component."""

    def spared(half_edges: Longs) -> npt.NDArray[np.bool_]:
        """The components that none of these half-edges belongs to."""
        result = np.ones(len(parts), np.bool_)
        result[parts.of_vertex[faces.indices[half_edges]]] = False
        return result

    chains = found.chains
    firsts = chains.half_edges[chains.starts[:-1][~chains.is_open]]
    loops = np.bincount(parts.of_vertex[faces.indices[firsts]], minlength=len(parts))
    return Components(
        vertices=parts.vertices,
        edges=parts.edges,
        faces=parts.faces,
        boundary_loops=loops,
        closed=spared(boundary),
        manifold=manifold,
        oriented=spared(found.details.half_edges(kernels.EDGE_TURNED)),
        orientable=spared(conflicts),
        of_vertex=parts.of_vertex,
    )


def _edges(faces: Faces, half_edges: Longs) -> npt.NDArray[np.int32]:
    """The edges that half-edges lie on, each once, in increasing order."""
    ends = np.stack([faces.indices[half_edges], faces.indices[faces.ahead(half_edges)]], axis=1)
    low, high = ends.min(axis=1).astype(np.int64), ends.max(axis=1).astype(np.int64)
    packed = distinct(low << 32 | high)
    return np.stack([packed >> 32, packed & 0xFFFFFFFF], axis=1).astype(np.int32)


def _angles(mesh: Mesh, faces: Faces, stars: Stars, degree: npt.NDArray[np.int32]) -> tuple[float, float]:
    """`angle_deficit` and `boundary_turning` of a mesh."""
    sound = as_mesh(mesh, faces)
    if sound is None:
        return 0.0, 0.0
    triangles = triangulate(sound).triangles
    ranges = list(pieces(len(triangles), _GRAIN))
    # One sum for each piece of a fixed length: the number of threads must not change the result.
    sums = np.empty((len(ranges), 4))
    corners = np.diff(stars.starts)
    inside = degree == corners
    run(sum_angles, [(mesh.vertices, triangles, inside, *piece, sums[i]) for i, piece in enumerate(ranges)])
    others = np.flatnonzero(~inside)
    turns = 2 * int((inside & (degree > 0)).sum()) - int(sums[:, 2].sum())
    other_turns = int((2 - degree[others].astype(np.int64) + corners[others]).sum()) - int(sums[:, 3].sum())
    return math.fsum([math.pi * turns, *(-sums[:, 0])]), math.fsum([math.pi * other_turns, *(-sums[:, 1])])
