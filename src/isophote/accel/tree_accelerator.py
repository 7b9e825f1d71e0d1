"""The tree of eight children a node as an accelerator."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Accelerator, Built
from isophote.accel.tree import build_triangles
from isophote.kernels.accel.tree_entry import TREE, any_in_tree, closest_in_tree

__all__ = ["BVH"]


def _build(positions: npt.NDArray[np.float32], triangles: npt.NDArray[np.int32], threads: int | None) -> Built:
    tree = build_triangles(positions, triangles, threads)
    return Built(TREE.pack(nodes=tree.nodes, root=0), tree.blocks.view(np.float32), tree.bounds)


BVH = Accelerator("bvh", _build, closest_in_tree, any_in_tree)
