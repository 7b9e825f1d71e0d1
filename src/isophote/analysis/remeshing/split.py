"""Splitting long edges: every triangle is cut by a pattern that its split edges tell."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["split_long"]

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int32]

# Triangles of a triangle 0, 1, 2 whose edges 01, 12, 20 have middles 3, 4, 5 where they are split, by which they are:
# bit 0 for edge 01, bit 1 for 12, bit 2 for 20. With two middles the remaining quad is cut from the first of them.
_PATTERNS = (
    ((0, 1, 2),),
    ((0, 3, 2), (3, 1, 2)),
    ((0, 1, 4), (0, 4, 2)),
    ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    ((0, 1, 5), (5, 1, 2)),
    ((0, 3, 5), (3, 1, 2), (3, 2, 5)),
    ((5, 4, 2), (0, 1, 4), (0, 4, 5)),
    ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
)
# Halving brings edges of any length below the longest one in this many rounds.
_MOST_ROUNDS = 40


def split_long(positions: Floats, triangles: Ints, longest: float) -> tuple[Floats, Ints]:
    """Split edges above `longest` in the middle until there are none."""
    for _ in range(_MOST_ROUNDS):
        ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2).astype(np.int64)
        far = np.linalg.norm(positions[ends[:, 0]] - positions[ends[:, 1]], axis=1) > longest
        if not far.any():
            break
        keys = ends.min(axis=1) * len(positions) + ends.max(axis=1)
        edges, which = np.unique(keys[far], return_inverse=True)
        middles = (positions[edges // len(positions)] + positions[edges % len(positions)]) / 2
        numbers = np.full(len(keys), -1, np.int64)
        numbers[far] = len(positions) + which.reshape(-1)
        triangles = _cut(triangles, numbers.reshape(-1, 3))
        positions = np.concatenate([positions, middles])
    return positions, triangles


def _cut(triangles: Ints, middles: npt.NDArray[np.int64]) -> Ints:
    pattern = ((middles >= 0) * np.array([1, 2, 4])).sum(axis=1)
    six = np.concatenate([triangles, middles], axis=1)
    pieces = [six[pattern == k][:, piece] for k, cut in enumerate(_PATTERNS) for piece in cut]
    return np.ascontiguousarray(np.concatenate(pieces), np.int32)
