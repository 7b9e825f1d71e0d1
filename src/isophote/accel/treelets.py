"""Binary trees as treelets of three levels, in which rays go through them: kernels/accel/treelet.py tells how."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["CHILDREN", "MISSING", "PLANES", "ROOT", "Treelets", "leaf_lanes", "parted", "plane_lanes", "treelets_of"]

PLANES, CHILDREN = 7, 8
MISSING = -1

# A node of the binary tree that treelets are, by its number: sixteen times the treelet's and 1 for the treelet's first
# plane, 2 and 3 for those below it, 4 to 7, and 8 to 15 for children that are leaves.
ROOT = 1

IntArray: TypeAlias = npt.NDArray[np.int32]
Numbers: TypeAlias = npt.NDArray[np.int64]
# Where the planes of a treelet's levels stand among its seven, from side to side.
_LEVELS = ([3], [1, 5], [0, 2, 4, 6])
_LANES = np.array([0, 3, 1, 5, 0, 2, 4, 6, *[PLANES] * 8])
_COUNT_BITS, _MOST_COUNT, _MOST_FIRST = 5, 31, 1 << 26


class Treelets(NamedTuple):
    """A tree as treelets, the root first: nodes (k, 7) whose planes they have, or MISSING; codes (k, 8) of children,
    and which of them there are; and `leaves` (m, 2) that have no code of their own: first block, triangles."""

    planes: IntArray
    codes: IntArray
    present: npt.NDArray[np.bool_]
    leaves: IntArray


def treelets_of(child: IntArray, firsts: IntArray, counts: IntArray) -> Treelets:
    """The treelets of a binary tree, whose root is node 0. `child` is the number of each node's lower child, the upper
    one being next, or MISSING for leaves, `firsts` and `counts` the first block and the number of triangles of leaves;
    those without any are left out."""
    leaf_codes, leaves = _leaf_codes(child, firsts, counts)
    levels, roots, made = [], np.zeros(1, np.int32), 0
    while len(roots):
        planes, below = _opened(child, roots)
        there = below != MISSING
        inner = there & (child[below] != MISSING)
        codes = np.where(there & ~inner, leaf_codes[below], 0).astype(np.int32)
        made += len(roots)
        codes[inner] = made + np.arange(np.count_nonzero(inner))
        levels.append((planes, codes, inner | (codes < 0)))
        roots = below[inner]
    planes, codes, present = (np.concatenate(parts) for parts in zip(*levels, strict=True))
    return Treelets(planes, codes, present, leaves)


def _opened(child: IntArray, roots: IntArray) -> tuple[IntArray, IntArray]:
    """Nodes with the planes of the treelets from `roots` on, and those below them."""
    planes = np.full((len(roots), PLANES), MISSING, np.int32)
    nodes = roots[:, None]
    for places in _LEVELS:
        lower = np.where(nodes == MISSING, MISSING, child[nodes])
        inner = lower != MISSING
        planes[:, places] = np.where(inner, nodes, MISSING)
        pairs = np.stack([np.where(inner, lower, nodes), np.where(inner, lower + 1, MISSING)], axis=2)
        nodes = pairs.reshape(len(roots), -1)
    return planes, nodes


def _leaf_codes(child: IntArray, firsts: IntArray, counts: IntArray) -> tuple[IntArray, IntArray]:
    """Codes of nodes that are leaves, 0 for those without triangles; leaves that have a row of their own."""
    filled = (child == MISSING) & (counts > 0)
    long = filled & ((counts > _MOST_COUNT) | (firsts >= _MOST_FIRST))
    codes = np.where(filled & ~long, -1 - ((firsts << _COUNT_BITS) + counts), 0).astype(np.int32)
    codes[long] = -1 - (np.arange(np.count_nonzero(long)) << _COUNT_BITS)
    return codes, np.stack([firsts[long], counts[long]], axis=1).astype(np.int32)


def plane_lanes(nodes: Numbers) -> tuple[Numbers, Numbers]:
    """Treelet of each node, and where its plane stands there; PLANES where it is a leaf. It is a leaf, too, where its
    plane is missing."""
    return nodes >> 4, _LANES[nodes & 15]


def leaf_lanes(nodes: Numbers) -> tuple[Numbers, Numbers]:
    """Treelet of each node that is a leaf, and which of its children that is."""
    own = nodes & 15
    return nodes >> 4, (own << np.array([0, 3, 2, 2, 1, 1, 1, 1, *[0] * 8])[own]) - 8


def parted(nodes: Numbers, codes: IntArray) -> tuple[Numbers, Numbers]:
    """The lower and the upper children of nodes with planes; `codes` (k, 8) are those of the treelets."""
    treelet, lower = nodes >> 4, 2 * (nodes & 15)
    below = [codes[treelet, np.maximum(lower + side - 8, 0)].astype(np.int64) for side in (0, 1)]
    sides = [
        np.where((lower >= 8) & (code > 0), 16 * code + ROOT, 16 * treelet + lower + side)
        for side, code in enumerate(below)
    ]
    return sides[0], sides[1]
