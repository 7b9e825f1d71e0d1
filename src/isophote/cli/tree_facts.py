"""What a mesh or a scene takes in memory once it is ready for rays."""

from __future__ import annotations

from typing import Any

import numpy as np

from isophote.accel.tree import build_triangles
from isophote.accel.tree_statistics import tree_statistics
from isophote.cli.facts import Facts, scene_facts
from isophote.convert.triangulate import triangulate
from isophote.kernels.base.table import Packed
from isophote.lower.scene import lower_scene
from isophote.scene.camera import Camera
from isophote.scene.scene import Item, Scene
from isophote.shapes.mesh import Mesh

__all__ = ["tree_facts"]


def tree_facts(subject: Scene | Mesh) -> Facts:
    """Bytes of all tables that a picture is made from, each table's, and by triangle; of a mesh its tree's numbers."""
    scene = subject if isinstance(subject, Scene) else Scene([Item(subject)])
    # The tables need some camera; their memory does not.
    tables = lower_scene(scene.with_(camera=Camera((0, 0, 1), (0, 0, 0))), (1, 1)).arrays
    parts = {name: _bytes(part) for name, part in tables.items() if name != "camera"}
    triangles = scene_facts(scene)["triangles"]
    facts: Facts = {
        "bytes": sum(parts.values()),
        "bytes_a_triangle": round(sum(parts.values()) / triangles, 1) if triangles else None,
        **parts,
    }
    return {"memory": facts} if isinstance(subject, Scene) else {"memory": facts, "tree": _statistics(subject)}


def _bytes(part: Any) -> int:
    """Memory of an array, or of all arrays of a table."""
    if isinstance(part, np.ndarray):
        return part.nbytes
    return sum(_bytes(member) for member in part.arrays.values()) if isinstance(part, Packed) else 0


def _statistics(mesh: Mesh) -> Facts:
    tree = build_triangles(np.ascontiguousarray(mesh.vertices, np.float32), triangulate(mesh).triangles)
    numbers = tree_statistics(tree)._asdict()
    return {**numbers, "occupancy": round(numbers["occupancy"], 3), "cost": round(numbers["cost"], 2)}
