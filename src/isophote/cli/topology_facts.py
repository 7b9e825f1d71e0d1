"""What the topology of a mesh is, and what is wrong with it, in numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.topology import Topology, topology
from isophote.analysis.mass import area, mass_properties
from isophote.analysis.mending.repair import repair
from isophote.cli.facts import Facts
from isophote.errors import GeometryError
from isophote.scene.scene import Scene
from isophote.shapes.mesh import Mesh

__all__ = ["mesh_topology", "scene_topology", "with_weld"]

_DEFECTS = (
    "boundary_edges",
    "non_manifold_edges",
    "non_manifold_vertices",
    "turned_edges",
    "degenerate_faces",
    "unused_vertices",
)


def with_weld(subject: Scene | Mesh, path: Path, distance: float | None) -> Scene | Mesh:
    """The subject with vertices of each mesh within `distance` merged; without one only an STL's, at one place.

    An STL names no vertices: its triangles belong together where their corners coincide.
    """
    if distance is None:
        if [suffix.lower() for suffix in path.suffixes if suffix.lower() != ".gz"][-1:] != [".stl"]:
            return subject
        distance = 0.0
    if isinstance(subject, Mesh):
        return _welded(subject, distance)
    meshes = {id(item.shape): item.shape for item in subject.items if isinstance(item.shape, Mesh)}
    merged = {key: _welded(mesh, distance) for key, mesh in meshes.items()}
    return subject.with_(items=[item.with_(shape=merged.get(id(item.shape), item.shape)) for item in subject.items])


def _welded(mesh: Mesh, distance: float) -> Mesh:
    return repair(mesh, weld=distance, degenerate=False, duplicates=False, split=False, holes=False, unused=False)[0]


def mesh_topology(mesh: Mesh, most: int) -> Facts:
    """Topology, size and defects of a mesh, with the first `most` components and defects of each kind."""
    found = topology(mesh)
    defects = {name: getattr(found, name) for name in _DEFECTS}
    return {
        "topology": {
            **_judgement(found),
            "orientable": found.orientable,
            "V": found.vertices,
            "E": found.edges,
            "F": found.faces,
            "euler": found.euler,
            "boundary_loops": found.loop_count,
            "angle_deficit": found.angle_deficit,
            "boundary_turning": found.boundary_turning,
            "gauss_bonnet_error": found.gauss_bonnet_error,
        },
        "solid": _solid(mesh),
        "components": _components(found, most) if len(found.components) > 1 else None,
        "defects": {name: _listed(rows, most) for name, rows in defects.items() if len(rows)},
    }


def scene_topology(scene: Scene, most: int) -> Facts:
    """What can be said in short of the first `most` meshes of a scene."""
    meshes = {id(item.shape): item.shape for item in scene.items if isinstance(item.shape, Mesh)}
    told = {}
    for number, mesh in enumerate(list(meshes.values())[:most]):
        found = topology(mesh)
        told[f"mesh {number}"] = {
            **_judgement(found),
            **{name: len(getattr(found, name)) for name in _DEFECTS if len(getattr(found, name))},
        }
    return {"topology": told} if told else {}


def _judgement(found: Topology) -> Facts:
    return {
        "closed": found.closed,
        "manifold": found.manifold,
        "oriented": found.oriented,
        "components": len(found.components),
        "genus": found.genus,
    }


def _solid(mesh: Mesh) -> Facts:
    """Area, and of what bounds a solid also volume and centroid."""
    try:
        mass = mass_properties(mesh)
    except GeometryError:
        return {"area": area(mesh)}
    return {"area": mass.area, "volume": mass.volume, "centroid": mass.centroid.tolist()}


def _components(found: Topology, most: int) -> Facts:
    parts = found.components
    return {
        f"component {i}": {
            "V": int(parts.vertices[i]),
            "E": int(parts.edges[i]),
            "F": int(parts.faces[i]),
            "closed": bool(parts.closed[i]),
            "manifold": bool(parts.manifold[i]),
            "boundary_loops": int(parts.boundary_loops[i]),
            "genus": int(parts.genus[i]) if parts.genus[i] >= 0 else None,
        }
        for i in range(min(len(parts), most))
    }


def _listed(rows: npt.NDArray[np.integer], most: int) -> Facts:
    return {"count": len(rows), "first": rows[:most].tolist()}
