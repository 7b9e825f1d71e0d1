"""The tree of eight children a node as an accelerator."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Accelerator, Built
from isophote.accel.tree import build_boxes, build_triangles
from isophote.kernels.accel.tree_entry import TREE, any_in_tree, closest_in_tree, things_in_tree

__all__ = ["BVH"]


def _build(positions: npt.NDArray[np.float32], triangles: npt.NDArray[np.int32], threads: int | None) -> Built:
    tree = build_triangles(positions, triangles, threads)
    return Built(TREE.pack(nodes=tree.nodes, root=0), tree.blocks.view(np.float32), tree.bounds)


def _build_boxes(lower: npt.NDArray[np.float32], upper: npt.NDArray[np.float32], threads: int | None) -> Built:
    tree = build_boxes(lower, upper, threads)
    items = tree.blocks.astype(np.int32, copy=False).view(np.float32)
    return Built(TREE.pack(nodes=tree.nodes, root=0), items, tree.bounds)


BVH = Accelerator("bvh", _build, closest_in_tree, any_in_tree, things_in_tree, _build_boxes)
