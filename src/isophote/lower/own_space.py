"""Where textures find the spaces in which items' shapes are described."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.accel.surface import PUBLIC
from isophote.kernels.base.table import Packed
from isophote.scene.scene import Item

__all__ = ["own_spaces"]

Floats: TypeAlias = npt.NDArray[np.float32]


def own_spaces(items: Sequence[Item], surfaces: Packed) -> Floats:
    """(rows, 12) float32: for each row of the surfaces' items, the affine map from the world to the item's shape.

    Corners and primitives are stored where they stand, so that what was hit no longer tells. Area lights, which are
    numbered behind the items, have the world's space.
    """
    matrices = np.stack([*(item.transform.matrix for item in items), np.eye(4)])
    public = np.minimum(surfaces.arrays["items"][:, PUBLIC], len(items))
    inverse: Floats = np.linalg.inv(matrices)[public, :3].reshape(-1, 12).astype(np.float32)
    return inverse
