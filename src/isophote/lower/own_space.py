"""Where textures find the spaces in which items' shapes are described."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.accel.surface import PUBLIC
from isophote.kernels.base.table import Packed

__all__ = ["own_spaces"]

Floats: TypeAlias = npt.NDArray[np.float32]
Matrix: TypeAlias = npt.NDArray[np.float64]


def own_spaces(matrices: Matrix, surfaces: Packed) -> Floats:
    """(rows, 12) float32: for each row of the surfaces' items, the affine map from the world to the item's shape, of
    items that stand by `matrices` (n, 4, 4).

    Corners and primitives are stored where they stand, so that what was hit no longer tells. Area lights, which are
    numbered behind the items, have the world's space.
    """
    public = np.minimum(surfaces.arrays["items"][:, PUBLIC], len(matrices))
    inverse: Floats = np.linalg.inv([*matrices, np.eye(4)])[public, :3].reshape(-1, 12).astype(np.float32)
    return inverse
