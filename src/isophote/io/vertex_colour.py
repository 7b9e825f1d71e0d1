"""Colours of vertices, corners and faces: sRGB-coded in files, linear float32 in a mesh.

OBJ and OFF hold display colours, as numbers from 0 to 1 or bytes; so do the 8- and 16-bit columns of PLY.
The curve is that of IEC 61966-2-1; a fourth column is alpha, which has no curve.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.io.srgb import to_srgb_bytes
from isophote.scene.colour import linear_to_srgb, srgb_to_linear

__all__ = ["as_exact_bytes", "from_display", "from_integers", "to_display"]


def from_display(coded: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Linear float32 of coded colours, shape (k, 3 or 4), 0 to 1; beyond it the curve goes on."""
    linear = np.array(coded, np.float64)
    linear[:, :3] = srgb_to_linear(linear[:, :3])
    with np.errstate(over="ignore"):
        return linear.astype(np.float32)


def to_display(linear: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Coded float64 colours, from which `from_display` makes the very same float32 values again."""
    coded = np.array(linear, np.float64)
    coded[:, :3] = linear_to_srgb(coded[:, :3])
    return coded


def from_integers(coded: npt.NDArray[np.unsignedinteger[Any]]) -> npt.NDArray[np.float32]:
    """Linear float32 of colours with 8 or 16 bits a channel, shape (k, 3 or 4)."""
    return from_display(coded / np.iinfo(coded.dtype).max)


def as_exact_bytes(linear: npt.NDArray[Any]) -> npt.NDArray[np.uint8] | None:
    """Colours with 8 bits a channel, or None where they would not give the very same linear values again."""
    if linear.shape[1] not in (3, 4) or not np.isfinite(linear).all():
        return None
    coded = np.empty(linear.shape, np.uint8)
    coded[:, :3] = to_srgb_bytes(linear[:, :3])
    coded[:, 3:] = np.rint(np.clip(linear[:, 3:], 0, 1) * 255)
    return coded if np.array_equal(from_integers(coded), linear) else None
