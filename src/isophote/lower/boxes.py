"""Accelerators over the boxes of instances, and of things that are no triangles, as kernels know them."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import accelerator_of, build_things
from isophote.accel.tree import build_boxes
from isophote.kernels.accel.geometry import GEOMETRY
from isophote.kernels.accel.instance_entry import any_in_instance, closest_in_instance
from isophote.kernels.accel.things import BOXES
from isophote.kernels.accel.tree_entry import TREE
from isophote.kernels.base.entry import Entry
from isophote.kernels.base.table import Packed, Table
from isophote.lower.packing import repacked

__all__ = [
    "ACCELERATOR",
    "counting_boxes",
    "counting_instances",
    "lower_boxes",
    "no_boxes",
    "over_boxes",
    "over_instances",
]

Boxes: TypeAlias = npt.NDArray[np.floating]

ACCELERATOR = "accelerator"
"""What packed things hold beside their fields: the name of the accelerator over their boxes."""


def no_boxes() -> Packed:
    """The table where there is no accelerator over boxes."""
    return BOXES.pack(things=0, test=0, tables=0, blocks=np.zeros(0, np.float32))


def _tree_over(boxes: Boxes, threads: int | None = None) -> dict[str, npt.NDArray[Any]]:
    """`top_nodes` and `top_items`: the tree over boxes (n, 2, 3); empty where there are none."""
    if len(boxes) == 0:
        return {"top_nodes": np.zeros(0, np.float32), "top_items": np.zeros(0, np.int32)}
    top = build_boxes(boxes[:, 0], boxes[:, 1], threads)
    return {"top_nodes": top.nodes, "top_items": top.blocks.astype(np.int32, copy=False)}


def lower_boxes(accelerator: str, boxes: Boxes, test: Entry, threads: int | None = None) -> Packed:
    """The accelerator of a name over `boxes`, (k, 2, 3), of things that `test` tests (kernels/accel/things.py)."""
    corners = boxes.astype(np.float32)
    built = build_things(accelerator, corners[:, 0], corners[:, 1], threads)
    return _packed(accelerator, built.tables, built.blocks, test)


def over_boxes(accelerator: str, boxes: Boxes, test: Entry, threads: int | None = None) -> dict[str, Any]:
    """`top_nodes`, `top_items` and `boxes`: the tree over `boxes`, (k, 2, 3), which kernels go through themselves, or
    the other accelerator of a name; all empty where there are none."""
    if accelerator == "bvh" or len(boxes) == 0:
        return {**_tree_over(boxes.astype(np.float32), threads), "boxes": no_boxes()}
    return {**_tree_over(np.zeros((0, 2, 3), np.float32)), "boxes": lower_boxes(accelerator, boxes, test, threads)}


def over_instances(accelerator: str, boxes: Boxes) -> dict[str, Any]:
    """As over_boxes, over instances; and `blocking`, which asks whether rays meet any."""
    over = over_boxes(accelerator, boxes, closest_in_instance)
    first: Packed = over["boxes"]
    blocking = repacked(BOXES, first, test=any_in_instance.address) if first.arrays["things"] else first
    return over | {"blocking": blocking}


def counting_instances(geometry: Packed) -> Packed:
    """A geometry whose rays count what they visit among its instances."""
    return counting_boxes(GEOMETRY, geometry, closest_in_instance)


def counting_boxes(table: Table, packed: Packed, test: Entry) -> Packed:
    """Packed things whose rays count what they visit: the same tree over their boxes, behind an entry."""
    nodes, items = packed.arrays["top_nodes"], packed.arrays["top_items"]
    if len(nodes) == 0:
        return packed
    boxes = _packed("bvh", TREE.pack(nodes=nodes, root=0), items.view(np.float32), test)
    return repacked(table, packed, boxes=boxes)


def _packed(accelerator: str, tables: Packed, blocks: npt.NDArray[np.float32], test: Entry) -> Packed:
    packed = BOXES.pack(
        things=accelerator_of(accelerator).things.address,
        test=test.address,
        tables=tables.words.ctypes.data,
        blocks=blocks,
    )
    # The words name the tables by their address, so these must live as long.
    return packed.holding({"tables of boxes": tables})
