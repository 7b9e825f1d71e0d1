"""What a shape is as an exact primitive: a kind in its own space, and the way from there."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["Matrix", "Primitive", "upright"]

Matrix: TypeAlias = npt.NDArray[np.float64]


class Primitive(NamedTuple):
    """A solid or surface of one of these kinds, under the affine map `matrix`, (4, 4), from its own space.

    | kind | in its own space | `values` |
    |---|---|---|
    | ball | p · p ≤ 1 | |
    | plane | y ≤ 0 | |
    | disk | y = 0, x² + z² ≤ 1 | |
    | block | each coordinate within ± its half | three halves, which may be infinite |
    | pipe | x² + z² ≤ 1 | |
    | tube | x² + z² ≤ 1, y within ±1 | |
    | cone | x² + z² ≤ (m + k y)², y within ±1 | m, k; the larger end's radius is 1 |
    | ring | within r of the circle x² + z² = 1, y = 0 | r |
    | quadric | a polynomial ≤ 0, within a box | as kernels/primitive/quadratic.py has them |
    | convex | a convex polygon in y = 0 | corners, as (x, −z) |
    | polygon | any polygon in y = 0 | edges of its rings, as (x, −z) |
    """

    kind: str
    matrix: Matrix
    values: npt.NDArray[np.float64]

    def placed(self, matrix: Matrix) -> Primitive:
        """The same, moved by another map after its own."""
        return self._replace(matrix=matrix @ self.matrix)


def upright(radius: float, half: float) -> Matrix:
    """What is 1 around y and ±1 along it, made as large as this."""
    return np.diag([radius, half, radius, 1.0])
