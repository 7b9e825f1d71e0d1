"""Values at the vertices of a mesh as colours."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Matte
from isophote.scene.scene import Item
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["coloured"]

Floats: TypeAlias = npt.NDArray[np.float64]

# Linear colours along the scales: dark blue, white, dark red; black, violet, orange, pale yellow.
_SCALES = {
    "diverging": [(0.04, 0.10, 0.55), (0.25, 0.45, 0.80), (0.80, 0.80, 0.80), (0.85, 0.35, 0.20), (0.45, 0.01, 0.02)],
    "sequential": [(0.01, 0.01, 0.03), (0.10, 0.01, 0.20), (0.45, 0.04, 0.15), (0.85, 0.28, 0.02), (0.97, 0.90, 0.40)],
}
_STEPS = 256
# A few vertices with extreme values, as at the tips of a mesh, must not flatten all others.
_CUT = 2.0


def coloured(
    mesh: Mesh,
    values: npt.ArrayLike,
    limits: tuple[float, float] | None = None,
    scale: str = "diverging",
    name: str | None = None,
) -> Item:
    """An item that shows values (n,) at the vertices of a mesh by colour, linear within faces.

    `limits` are the values at the two ends of the scale; without them they hold all but 2 % of the values at either
    end, and are symmetric about 0 for the scale "diverging", which is white there; "sequential" goes from dark to
    light. Values that are NaN count as 0. Raises `GeometryError` for other lengths, scales and limits.
    """
    array = np.asarray(values, np.float64)
    if array.shape != (len(mesh.vertices),):
        raise GeometryError(f"values must be one a vertex, ({len(mesh.vertices)},), but have shape {array.shape}")
    if scale not in _SCALES:
        raise GeometryError(f"scale must be one of {', '.join(map(repr, _SCALES))}, not {scale!r}")
    low, high = _limits(array, scale) if limits is None else limits
    if not (np.isfinite([low, high]).all() and low < high):
        raise GeometryError(f"limits must be two finite numbers, the smaller one first, not {limits!r}")
    place = np.clip((np.nan_to_num(array) - low) / (high - low), 0.0, 1.0)
    # Centres of the first and the last pixel are the ends of the scale.
    u = (0.5 + place * (_STEPS - 1)) / _STEPS
    shown = mesh.with_(attributes={"uv": Attribute(np.stack([u, np.full_like(u, 0.5)], 1))})
    return Item(shown, Matte(ImageTexture(_strip(scale), "linear", wrap="clamp")), name=name)


def _limits(values: Floats, scale: str) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return -1.0, 1.0
    low, high = (float(v) for v in np.percentile(finite, (_CUT, 100 - _CUT)))
    if scale == "diverging":
        high = max(abs(low), abs(high))
        low = -high
    return (low, high) if low < high else (low - 1.0, low + 1.0)


def _strip(scale: str) -> npt.NDArray[np.float32]:
    """(1, 256, 3) linear colours."""
    stops = np.array(_SCALES[scale])
    at = np.linspace(0, len(stops) - 1, _STEPS)
    return np.stack([np.interp(at, np.arange(len(stops)), stops[:, k]) for k in range(3)], 1).astype(np.float32)[None]
