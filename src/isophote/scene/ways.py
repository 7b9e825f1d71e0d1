"""Many motions, asked together for where things stand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.scene.interpolation import between, taken_apart
from isophote.scene.motion import Motion
from isophote.scene.transform import Transform

__all__ = ["Ways"]

Matrix: TypeAlias = npt.NDArray[np.float64]


class Ways:
    """The places of many things at a time; those that stand still as well."""

    def __init__(self, placed: Sequence[Transform | Motion]) -> None:
        """Take the placements of all that moves apart, once for all times."""
        self._still = np.array([one.matrix for one in placed]).reshape(-1, 4, 4)
        self._moving = np.array([k for k, one in enumerate(placed) if isinstance(one, Motion)], np.int64)
        motions = [one for one in placed if isinstance(one, Motion)]
        if not motions:
            return
        transforms = [transform for motion in motions for _, transform in motion.placements]
        self._times = np.array([time for motion in motions for time in motion.times])
        self._counts = np.array([len(motion.placements) for motion in motions])
        self._first = np.cumsum(self._counts) - self._counts
        self._matrices = np.array([transform.matrix for transform in transforms])
        self._apart = taken_apart(transforms)

    def at(self, time: float) -> Matrix:
        """(n, 4, 4): the matrix of each at a time, as `Motion.at` has it."""
        matrices = self._still.copy()
        if len(self._moving):
            matrices[self._moving] = self._moved(time)
        return matrices

    def _moved(self, time: float) -> Matrix:
        passed = np.add.reduceat(self._times <= time, self._first, dtype=np.int64)
        a = self._first + np.clip(passed - 1, 0, self._counts - 2)
        b = a + 1
        parts = np.clip((time - self._times[a]) / (self._times[b] - self._times[a]), 0.0, 1.0)
        # What stands at one of its placements stands there to the last bit.
        matrices: Matrix = self._matrices[np.where(parts < 1, a, b)]
        differ = (self._matrices[a] != self._matrices[b]).any(axis=(1, 2))
        rows = np.flatnonzero((parts > 0) & (parts < 1) & differ)
        matrices[rows] = between(self._apart.rows(a[rows]), self._apart.rows(b[rows]), parts[rows])
        return matrices
