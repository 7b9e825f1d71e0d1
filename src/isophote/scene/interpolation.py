"""What lies between placements: rotations along arcs, the rest in straight lines; many at once."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.scene.transform import Transform

__all__ = ["Apart", "between", "taken_apart"]

Matrix: TypeAlias = npt.NDArray[np.float64]

# Below this angle the arc between two quaternions is its chord, to double precision.
_CHORD = 1e-4


class Apart(NamedTuple):
    """Placements as T R S: `offsets` (n, 3), `turns` (n, 4), unit quaternions (x, y, z, w), `stretches` (n, 3, 3), and
    which are `mirrored` (n,), where S is −(a stretch)."""

    offsets: Matrix
    turns: Matrix
    stretches: Matrix
    mirrored: npt.NDArray[np.bool_]

    def rows(self, numbers: npt.NDArray[np.int64]) -> Apart:
        """Those of these numbers."""
        return Apart(self.offsets[numbers], self.turns[numbers], self.stretches[numbers], self.mirrored[numbers])


def taken_apart(transforms: Iterable[Transform]) -> Apart:
    """Placements by polar decomposition of their linear parts, M = R S."""
    offsets, turns, stretches, mirrored = zip(*map(_taken_apart, transforms), strict=True)
    return Apart(np.array(offsets), np.array(turns), np.array(stretches), np.array(mirrored))


@lru_cache(maxsize=4096)
def _taken_apart(transform: Transform) -> tuple[Matrix, Matrix, Matrix, bool]:
    u, sizes, vt = np.linalg.svd(transform.matrix[:3, :3])
    sign = 1.0 if np.linalg.det(u @ vt) > 0 else -1.0
    return transform.matrix[:3, 3], _quaternion(sign * (u @ vt)), sign * (vt.T * sizes) @ vt, sign < 0


def _quaternion(rotation: Matrix) -> Matrix:
    """(4,) of a rotation. Source: Shepperd, "Quaternion from Rotation Matrix", 1978."""
    r = rotation
    squares = np.array([r[0, 0], r[1, 1], r[2, 2], np.trace(r)])
    k = int(np.argmax(squares))
    if k == 3:
        q = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 1 + squares[3]])
    else:
        i, j = (k + 1) % 3, (k + 2) % 3
        q = np.empty(4)
        q[k] = 1 - squares[3] + 2 * r[k, k]
        q[i], q[j], q[3] = r[i, k] + r[k, i], r[j, k] + r[k, j], r[j, i] - r[i, j]
    unit: Matrix = q / np.linalg.norm(q)
    return unit


def between(a: Apart, b: Apart, parts: Matrix) -> Matrix:
    """(n, 4, 4): what lies at `parts` (n,), 0 to 1, of the way from one placement to the other of each pair."""
    matrices = np.zeros((len(parts), 4, 4))
    back, on = (1 - parts)[:, None], parts[:, None]
    stretches = back[:, None] * a.stretches + on[:, None] * b.stretches
    matrices[:, :3, :3] = _rotations(_arcs(a.turns, b.turns, parts)) @ stretches
    matrices[:, :3, 3] = back * a.offsets + on * b.offsets
    matrices[:, 3, 3] = 1.0
    return matrices


def _arcs(a: Matrix, b: Matrix, parts: Matrix) -> Matrix:
    """(n, 4): the unit quaternions at `parts` of the shorter arcs from `a` to `b`."""
    nearer = np.where((a * b).sum(axis=1, keepdims=True) >= 0, b, -b)
    # Of the chord and not of the cosine, which says little of small angles.
    angle = 2 * np.arcsin(np.minimum(1.0, np.linalg.norm(nearer - a, axis=1) / 2))
    chord = angle < _CHORD
    q = np.where(chord, 1 - parts, np.sin((1 - parts) * angle))[:, None] * a
    q += np.where(chord, parts, np.sin(parts * angle))[:, None] * nearer
    unit: Matrix = q / np.linalg.norm(q, axis=1, keepdims=True)
    return unit


def _rotations(q: Matrix) -> Matrix:
    """(n, 3, 3) of unit quaternions."""
    x, y, z, w = q.T
    cross = np.zeros((len(q), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -z, y, -x
    cross[:, 1, 0], cross[:, 2, 0], cross[:, 2, 1] = z, -y, x
    turned: Matrix = np.eye(3) + 2 * w[:, None, None] * cross + 2 * (cross @ cross)
    return turned
