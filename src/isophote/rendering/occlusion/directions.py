"""Fixed sets of directions over the hemisphere around +z, with the weight that each has in ∫ … cosθ dω / π."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["hemicube", "hemisphere"]

Floats: TypeAlias = npt.NDArray[np.float32]


def hemicube(edge: int) -> Floats:
    """(n, 4) float32: directions through the pixels of a half cube of `edge` by `edge` pixels on its top, and the form
    factor of each pixel; the weights add up to 1.

    With a pixel at (x, y, 1) on the top and (1, y, z) on a side, each of area ΔA,

        ΔF = ΔA / (π (x² + y² + 1)²),   ΔF = z ΔA / (π (y² + z² + 1)²)

    Source: Cohen, Greenberg, "The Hemi-Cube: A Radiosity Solution for Complex Environments", SIGGRAPH 1985, at the
    middle of each pixel. `edge` is even.
    """
    step = 2.0 / edge
    across = -1 + step * (np.arange(edge) + 0.5)
    up = across[edge // 2 :]
    x, y = (grid.reshape(-1) for grid in np.meshgrid(across, across))
    top = np.stack([x, y, np.ones_like(x), 1 / (x * x + y * y + 1) ** 2], axis=1)
    y, z = (grid.reshape(-1) for grid in np.meshgrid(across, up))
    side = np.stack([np.ones_like(y), y, z, z / (y * y + z * z + 1) ** 2], axis=1)
    turns = [(0, 1, 1.0), (1, 0, 1.0), (0, 1, -1.0), (1, 0, -1.0)]
    sides = [np.stack([s * side[:, a], s * side[:, b], side[:, 2], side[:, 3]], axis=1) for a, b, s in turns]
    rows = np.concatenate([top, *sides])
    rows[:, :3] /= np.linalg.norm(rows[:, :3], axis=1, keepdims=True)
    # The middle of a pixel stands for all of it, which leaves the sum a little off 1.
    rows[:, 3] /= rows[:, 3].sum()
    return rows.astype(np.float32)


def hemisphere(edge: int) -> Floats:
    """(n, 4) float32: `edge` by `edge` directions whose feet on the unit disk stand for equal areas of it, and so for
    equal form factors (Nusselt's analogue): what a patch hides of the hemisphere, seen from above, is its part.

    Sources: Nusselt, "Graphische Bestimmung des Winkelverhältnisses bei der Wärmestrahlung", 1928; squares onto the
    disk: Shirley, Chiu, "A Low Distortion Map Between Disk and Square", Journal of Graphics Tools 2(3), 1997.
    """
    across = -1 + 2 / edge * (np.arange(edge) + 0.5)
    a, b = (grid.reshape(-1) for grid in np.meshgrid(across, across))
    wide = np.abs(a) > np.abs(b)
    radius = np.where(wide, a, b)
    small = np.where(wide, b, a) / np.where(radius == 0, 1.0, radius)
    angle = np.where(wide, np.pi / 4 * small, np.pi / 2 - np.pi / 4 * small)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    z = np.sqrt(np.maximum(1 - radius * radius, 0.0))
    return np.stack([x, y, z, np.full_like(x, 1 / edge**2)], axis=1).astype(np.float32)
