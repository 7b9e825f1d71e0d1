"""Union, intersection and difference of solids given by their surfaces."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.topology import Topology, topology
from isophote.analysis.mass import mass_properties
from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError, IsophoteWarning
from isophote.shapes.mesh import FaceLabels, Mesh

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["boolean"]

_OPERATIONS = {"union": "Add", "intersection": "Intersect", "difference": "Subtract"}

Labels = dict[str, FaceLabels]


def boolean(a: Mesh, b: Mesh, operation: str) -> Mesh:
    """The "union", the "intersection" or the "difference" (a without b) of two solids, as a mesh of triangles.

    Computed by manifold3d in float64; polygons are cut as `triangulate` cuts them. Labels are kept, face by face, and
    those of both solids joined; a face has no label (-1) in what its own solid does not name. Attributes have no place
    in the result: an `IsophoteWarning` says so. Coordinates may move by rounding, about 1e-12 of the size.

    Raises `GeometryError` for a mesh that is not closed, manifold and oriented outward, saying what is wrong where, and
    where nothing is left.
    """
    if operation not in _OPERATIONS:
        raise GeometryError(f"a boolean is one of {', '.join(_OPERATIONS)}, not {operation!r}")
    from manifold3d import Manifold, OpType

    for name, mesh in (("a", a), ("b", b)):
        _check(name, mesh)
    lost = sorted({*a.attributes, *b.attributes})
    if lost:
        warnings.warn(f"a boolean leaves out the attributes {', '.join(lost)}", IsophoteWarning, stacklevel=2)
    first = Manifold.reserve_ids(2)
    solids = [_solid(mesh, first + i) for i, mesh in enumerate((a, b))]
    result = Manifold.batch_boolean(solids, getattr(OpType, _OPERATIONS[operation]))
    _check_status(result)
    if result.is_empty():
        raise GeometryError(f"nothing is left of the {operation}, and a mesh without faces is none")
    found = result.to_mesh64()
    triangles = np.asarray(found.tri_verts).astype(np.int32)
    source = np.repeat(np.asarray(found.run_original_id) - first, np.diff(found.run_index) // 3)
    labels = _labels((a, b), source, np.asarray(found.face_id).astype(np.int64))
    return Mesh(np.asarray(found.vert_properties)[:, :3], triangles, labels=labels)


def _check(name: str, mesh: Mesh) -> None:
    """Refuse what bounds no solid."""
    found = topology(mesh)
    wrong = _wrong(found)
    if not wrong and mass_properties(mesh).volume < 0:
        wrong = "its faces look inward; orient(mesh) turns them"
    if wrong:
        raise GeometryError(f"a boolean takes closed manifolds that look outward, but in mesh {name} {wrong}")


def _wrong(found: Topology) -> str:
    if len(found.degenerate_faces):
        return f"face {found.degenerate_faces[0]} names a vertex twice; repair(mesh) drops such faces"
    if not found.closed:
        a, b = found.boundary_edges[0]
        edges = f"{len(found.boundary_edges)} edges have one face, the first from vertex {a} to {b}"
        return f"{edges}; repair(mesh) fills holes"
    if len(found.non_manifold_edges):
        a, b = found.non_manifold_edges[0]
        return (
            f"{len(found.non_manifold_edges)} edges have three faces or more, the first from vertex {a} to {b}; "
            "repair(mesh) splits them"
        )
    if not found.manifold:
        return (
            f"the faces at {len(found.non_manifold_vertices)} vertices form several fans, the first at vertex "
            f"{found.non_manifold_vertices[0]}; repair(mesh) splits them"
        )
    if not found.oriented:
        a, b = found.turned_edges[0]
        return f"two faces run the same way from vertex {a} to {b}; orient(mesh) turns them"
    return ""


def _solid(mesh: Mesh, number: int) -> Manifold:
    from manifold3d import Manifold, Mesh64

    triangles, _, _ = triangulate(mesh)
    given = Mesh64(
        # Copies: read-only arrays are refused.
        vert_properties=np.array(mesh.vertices),
        tri_verts=np.array(triangles, np.uint64),
        run_index=np.array([0, 3 * len(triangles)], np.uint64),
        run_original_id=np.array([number], np.uint32),
        # Each triangle by itself: triangles with one number are taken to lie in one plane.
        face_id=np.arange(len(triangles), dtype=np.uint64),
    )
    solid = Manifold(given)
    _check_status(solid)
    return solid


def _check_status(solid: Manifold) -> None:
    status = solid.status()
    if status.name != "NoError":
        raise GeometryError(f"manifold3d refuses: {status.name}")


def _labels(meshes: tuple[Mesh, Mesh], source: npt.NDArray[Any], triangle: npt.NDArray[np.int64]) -> Labels:
    """The labels of the result, each triangle of which comes from a triangle of one of the meshes."""
    face = np.empty(len(source), np.int64)
    for i, mesh in enumerate(meshes):
        face[source == i] = triangulate(mesh).face[triangle[source == i]]
    labels = {}
    for name in sorted({*meshes[0].labels, *meshes[1].labels}):
        names = tuple(dict.fromkeys(word for mesh in meshes if name in mesh.labels for word in mesh.labels[name].names))
        index = np.full(len(source), -1, np.int32)
        for i, mesh in enumerate(meshes):
            if name in mesh.labels:
                # The last entry is what -1, no label, picks.
                places = np.array([*map(names.index, mesh.labels[name].names), -1], np.int32)
                index[source == i] = places[mesh.labels[name].index[face[source == i]]]
        labels[name] = FaceLabels(names, index)
    return labels
