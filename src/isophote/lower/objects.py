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


def join_objects(
    accelerator: str, objects: Sequence[Built], uses: Sequence[int], *, alone: bool
) -> tuple[dict[str, Any], list[Packed]]:
    """The fields of GEOMETRY that come from accelerators of one name, and tables that they name by addresses and that
    must be kept alive; `uses` is the object of each instance, and `alone` tells that there is one, which never moves.

    Trees become one array of nodes, which the kernels that ask go through themselves; so they do with a hierarchy that
    is alone. The tables of other accelerators stay by themselves.
    """
    firsts = np.cumsum([0, *(len(built.blocks) // BLOCK for built in objects)])
    fields: dict[str, Any] = {
        "nodes": np.zeros(0, np.float32),
        "roots": np.zeros(len(uses), np.int32),
        "closest": 0,
        "any": 0,
        "objects": np.zeros(len(uses), np.int64),
        "first_blocks": np.zeros(len(uses), np.int64),
        "finish": 0,
    }
    tables = [built.tables for built in objects]
    if accelerator == "bih":
        # Loaded where it is asked for: pictures by trees come sooner without.
        from isophote.accel.bih import join_blocks

        fields["blocks"], tables = join_blocks(objects)
        if alone:
            fields["nodes"], fields["finish"] = tables[0].arrays["nodes"], tables[0].arrays["finish"]
            fields["objects"][0] = tables[0].words.ctypes.data
            return fields, tables
    else:
        fields["blocks"] = objects[0].blocks if len(objects) == 1 else np.concatenate([one.blocks for one in objects])
    if accelerator == "bvh":
        fields["nodes"], roots = _join_trees([built.tables.arrays["nodes"] for built in objects], firsts)
        fields["roots"] = np.array([roots[number] for number in uses], np.int32)
        return fields, tables
    kind = accelerator_of(accelerator)
    fields["closest"], fields["any"] = kind.closest.address, kind.any.address
    fields["objects"][:] = [tables[number].words.ctypes.data for number in uses]
    fields["first_blocks"][:] = firsts[list(uses)]
    return fields, tables


def keep_alive(geometry: Packed, tables: Sequence[Packed]) -> Packed:
    """`geometry`, with the tables that it names by their addresses."""
    return geometry.holding({_ALIVE: tables})


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
