"""Binary trees as treelets of three levels, in which rays go through them: kernels/accel/treelet.py tells how."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.accel.treelet_build import cut_into_treelets

__all__ = ["CHILDREN", "MISSING", "PLANES", "ROOT", "Treelets", "leaf_lanes", "parted", "plane_lanes", "treelets_of"]

PLANES, CHILDREN = 7, 8
MISSING = -1

# A node of the binary tree that treelets are, by its number: sixteen times the treelet's and 1 for the treelet's first
# plane, 2 and 3 for those below it, 4 to 7, and 8 to 15 for children that are leaves.
ROOT = 1

IntArray: TypeAlias = npt.NDArray[np.int32]
FloatArray: TypeAlias = npt.NDArray[np.float32]
Numbers: TypeAlias = npt.NDArray[np.int64]
_LANES = np.array([0, 3, 1, 5, 0, 2, 4, 6, *[PLANES] * 8])
_COUNT_BITS, _MOST_COUNT, _MOST_FIRST = 5, 31, 1 << 26


class Treelets(NamedTuple):
    """A tree as treelets, the root first: nodes (k, 7) whose planes they have, or MISSING; codes (k, 8) of children,
    and which of them there are; and `leaves` (m, 2) that have no code of their own: first block, triangles."""

    planes: IntArray
    codes: IntArray
    present: npt.NDArray[np.bool_]
    leaves: IntArray


def treelets_of(child: IntArray, areas: FloatArray, firsts: IntArray, counts: IntArray) -> Treelets:
    """The treelets of a binary tree, whose root is node 0.

    `child` is the number of each node's lower child, which comes after it, the upper one being next, or MISSING for
    leaves; `areas` are those of nodes' cells, `firsts` and `counts` the first block and the number of triangles of
    leaves; those without any are left out.
    """
    leaf_codes, leaves = _leaf_codes(child, firsts, counts)
    most = max(1, int(np.count_nonzero(child != MISSING)))
    planes, codes = np.empty((most, PLANES), np.int32), np.empty((most, CHILDREN), np.int32)
    made = cut_into_treelets(child, areas, leaf_codes, planes, codes)
    return Treelets(planes[:made], codes[:made], codes[:made] != 0, leaves)


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


def parted(nodes: Numbers, places: FloatArray, codes: IntArray) -> tuple[Numbers, Numbers]:
    """The lower and the upper children of nodes with planes; `places` (k, 8) of the treelets' planes, infinite where
    they are missing, the last column being free, and `codes` (k, 8)."""
    treelet, lower = nodes >> 4, 2 * (nodes & 15)
    sides = []
    for own in (lower, lower + 1):
        code = codes[leaf_lanes(16 * treelet + own)].astype(np.int64)
        whole = (own >= 8) | np.isinf(places[treelet, _LANES[own]])
        sides.append(np.where(whole & (code > 0), 16 * code + ROOT, 16 * treelet + own))
    return sides[0], sides[1]
