"""Accelerators of several objects as one geometry's arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Built, accelerator_of
from isophote.kernels.accel.layout import BLOCK, CHILD, NODE, WIDTH
from isophote.kernels.base.table import Packed

__all__ = ["join_objects", "keep_alive"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]

# What a Packed geometry holds beside its fields: the tables whose addresses stand in `objects`.
_ALIVE = "tables of objects"


def join_objects(accelerator: str, objects: Sequence[Built], uses: Sequence[int]) -> dict[str, Any]:
    """The fields of GEOMETRY that come from accelerators of one name; `uses` is the object of each instance.

    Trees become one array of nodes, which the kernels that ask go through themselves. The tables of other accelerators
    stay by themselves and must be kept alive.
    """
    firsts = np.cumsum([0, *(len(built.blocks) // BLOCK for built in objects)])
    fields: dict[str, Any] = {
        "blocks": objects[0].blocks if len(objects) == 1 else np.concatenate([built.blocks for built in objects]),
        "nodes": np.zeros(0, np.float32),
        "roots": np.zeros(len(uses), np.int32),
        "closest": 0,
        "any": 0,
        "objects": np.zeros(len(uses), np.int64),
        "first_blocks": np.zeros(len(uses), np.int64),
    }
    if accelerator == "bvh":
        fields["nodes"], roots = _join_trees([built.tables.arrays["nodes"] for built in objects], firsts)
        fields["roots"] = np.array([roots[number] for number in uses], np.int32)
        return fields
    kind = accelerator_of(accelerator)
    fields["closest"], fields["any"] = kind.closest.address, kind.any.address
    fields["objects"][:] = [objects[number].tables.words.ctypes.data for number in uses]
    fields["first_blocks"][:] = firsts[list(uses)]
    return fields


def keep_alive(geometry: Packed, tables: Sequence[Packed]) -> Packed:
    """`geometry`, with the tables that it names by their addresses."""
    return geometry._replace(arrays={**geometry.arrays, _ALIVE: tables})


def _join_trees(trees: Sequence[FloatArray], first_blocks: npt.NDArray[np.int64]) -> tuple[FloatArray, list[int]]:
    """All nodes in one array, the numbers of nodes and blocks moved on; the roots' numbers."""
    if len(trees) == 1:
        return trees[0], [0]
    roots, joined = [], []
    node = 0
    for tree, block in zip(trees, first_blocks.tolist(), strict=False):
        nodes = tree.copy().reshape(-1, NODE)
        children = nodes.view(np.int32)[:, CHILD : CHILD + WIDTH]
        present = nodes[:, :8] <= nodes[:, 24:32]
        inner = present & (children >= 0)
        leaf = present & (children < 0)
        children[inner] += node
        children[leaf] -= block * 8
        roots.append(node)
        joined.append(nodes.reshape(-1))
        node += len(nodes)
    return np.concatenate(joined), roots
