"""Scenes whose rays count what they visit: the same accelerators, all behind entries."""

from __future__ import annotations

import numpy as np

from isophote.accel.accelerator import accelerator_of
from isophote.kernels.accel.geometry import GEOMETRY
from isophote.kernels.accel.tree_entry import TREE
from isophote.kernels.base.table import Packed
from isophote.kernels.trace.tables import SCENE
from isophote.lower.boxes import counting_instances
from isophote.lower.objects import keep_alive
from isophote.lower.packing import repacked

__all__ = ["counting"]


def counting(scene: Packed) -> Packed:
    """A lowered scene as a kernel that counts wants it; it finds the same."""
    tables = {name: scene.arrays[name] for name in SCENE.fields}
    tables["geometry"] = _geometry(tables["geometry"])
    if len(tables["primitives"].arrays["numbers"]):
        # Loaded where they are needed: pictures of meshes come sooner without.
        from isophote.lower.primitives import counting_primitives

        tables["primitives"] = counting_primitives(tables["primitives"])
    if len(tables["fields"].arrays["numbers"]):
        from isophote.lower.fields import counting_fields

        tables["fields"] = counting_fields(tables["fields"])
    return SCENE.pack(**tables)


def _geometry(geometry: Packed) -> Packed:
    geometry = counting_instances(geometry)
    if geometry.arrays["closest"] != 0:
        return geometry
    if geometry.arrays["finish"] != 0:
        kind = accelerator_of("bih")
        return repacked(GEOMETRY, geometry, closest=kind.closest.address, any=kind.any.address, finish=0)
    arrays = {name: geometry.arrays[name] for name in GEOMETRY.fields}
    tables = [TREE.pack(nodes=arrays["nodes"], root=root) for root in arrays["roots"].tolist()]
    kind = accelerator_of("bvh")
    arrays["closest"], arrays["any"] = kind.closest.address, kind.any.address
    arrays["objects"] = np.array([table.words.ctypes.data for table in tables], np.int64)
    return keep_alive(GEOMETRY.pack(**arrays), tables)
