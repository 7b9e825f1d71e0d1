"""What a tree looks like, in numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from isophote.accel.tree import BOXES, TRIANGLES, Tree
from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, LOWER, NODE, NUMBER, UPPER, WIDTH

__all__ = ["TreeStatistics", "tree_statistics"]


class TreeStatistics(NamedTuple):
    """Numbers of a tree.

    `depth` counts levels of nodes, `blocks` is the boxes' count in a tree of boxes, `occupancy` the part of the
    blocks' lanes that hold something (1 without blocks), `bytes` what nodes and blocks take. `cost` is the surface
    area heuristic's expected cost of a line that meets the root's box, in tests of nodes:

        (sum over nodes A + sum over leaves A (c_leaf + c_block blocks)) / A_root

    with A the surface of a box, the root among the nodes, and the constants of `Kind`; 0 where A_root is 0.
    """

    nodes: int
    leaves: int
    blocks: int
    depth: int
    occupancy: float
    cost: float
    bytes: int


def tree_statistics(tree: Tree) -> TreeStatistics:
    """The tree's `TreeStatistics`."""
    rows = tree.nodes.reshape(-1, NODE)
    lower = rows[:, LOWER:UPPER].reshape(-1, 3, WIDTH).astype(np.float64)
    upper = rows[:, UPPER:CHILD].reshape(-1, 3, WIDTH).astype(np.float64)
    codes = rows[:, CHILD : CHILD + WIDTH].copy().view(np.int32)
    present = np.isfinite(lower[:, 0])
    inner, leaf = present & (codes >= 0), present & (codes < 0)
    over_boxes = tree.blocks.dtype == np.int32
    kind = BOXES if over_boxes else TRIANGLES
    areas = _areas(np.where(present[:, None], upper - np.where(present[:, None], lower, 0), 0))
    leaf_blocks = np.where(leaf, (-1 - codes) & 7, 0)
    whole = float(_areas((tree.bounds[1].astype(np.float64) - tree.bounds[0])[None, :, None])[0, 0])
    spent = areas[inner].sum() + (areas * (kind.leaf_cost + kind.block_cost * leaf_blocks))[leaf].sum()
    return TreeStatistics(
        nodes=len(rows),
        leaves=int(leaf.sum()),
        blocks=len(tree.blocks) // (1 if over_boxes else BLOCK),
        depth=_depth(codes, inner),
        occupancy=1.0 if over_boxes else _occupancy(tree),
        cost=float(1 + spent / whole) if 0 < whole < np.inf else 0.0,
        bytes=tree.nodes.nbytes + tree.blocks.nbytes,
    )


def _areas(extents: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Half the surfaces of boxes of (n, 3, k) extents."""
    x, y, z = extents[:, 0], extents[:, 1], extents[:, 2]
    areas: npt.NDArray[np.float64] = x * y + y * z + z * x
    return areas


def _depth(codes: npt.NDArray[np.int32], inner: npt.NDArray[np.bool_]) -> int:
    depth, level = 0, np.zeros(1, np.int64)
    while len(level):
        depth += 1
        level = codes[level][inner[level]].astype(np.int64)
    return depth


def _occupancy(tree: Tree) -> float:
    numbers = tree.blocks.reshape(-1, BLOCK)[:, NUMBER : NUMBER + LANES].copy().view(np.int32)
    return float((numbers >= 0).mean()) if numbers.size else 1.0
