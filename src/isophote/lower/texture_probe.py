"""A texture by itself, asked at places."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.kernels.texture import contract
from isophote.kernels.texture.many import look_up_many
from isophote.lower.textures import TextureTable
from isophote.scene.texture import Texture

__all__ = ["texture_values"]

Floats: TypeAlias = npt.NDArray[np.float32]

# Places that are asked in one go: records take 128 bytes each.
_AT_ONCE = 1 << 16


def texture_values(
    texture: Texture,
    uv: npt.ArrayLike = (0.0, 0.0),
    own: npt.ArrayLike = (0.0, 0.0, 0.0),
    world: npt.ArrayLike | None = None,
    *,
    uv_axes: npt.ArrayLike = 0.0,
    own_axes: npt.ArrayLike = 0.0,
    world_axes: npt.ArrayLike | None = None,
) -> Floats:
    """(n, 4) float32: linear red, green, blue and alpha of a texture at n places, as renderings look it up.

    `uv` is (n, 2) or (2,), texture coordinates; `own` is (n, 3) or (3,), places in the shape's own space, and `world`
    in the world, the same unless given. What surrounds a place and is averaged over is an ellipse: `uv_axes` (n, 2, 2),
    `own_axes` and `world_axes` (n, 2, 3) are its two half-axes, a row each; zeros, as they are by default, ask for the
    place alone.

    Raises `SceneError` for other shapes and for places that are not finite.
    """
    parts = {
        contract.U: _columns("uv", uv, (2,)),
        contract.AXIS_A: _columns("uv_axes", uv_axes, (2, 2)),
        contract.OWN: _columns("own", own, (3,)),
        contract.OWN_A: _columns("own_axes", own_axes, (2, 3)),
        contract.WORLD: _columns("world", own if world is None else world, (3,)),
        contract.WORLD_A: _columns("world_axes", own_axes if world_axes is None else world_axes, (2, 3)),
    }
    counts = {len(part) for part in parts.values()} - {1}
    if len(counts) > 1:
        raise SceneError(f"texture_values: places are given for {sorted(counts)} numbers of them; give as many each")
    count = counts.pop() if counts else 1
    table = TextureTable()
    node = np.int64(table.number(texture))
    packed = table.build()
    found = np.empty((count, 4), np.float32)
    for first in range(0, count, _AT_ONCE):
        last = min(first + _AT_ONCE, count)
        records = np.zeros((last - first, contract.WORDS), np.float32)
        for column, part in parts.items():
            records[:, column : column + part.shape[1]] = part if len(part) == 1 else part[first:last]
        look_up_many(packed.words, node, records.reshape(-1))
        found[first:last] = records[:, contract.RESULT : contract.RESULT + 4]
    return found


def _columns(name: str, given: npt.ArrayLike, shape: tuple[int, ...]) -> Floats:
    """(n, numbers of one place) or (1, …) where one is given for all."""
    try:
        values = np.asarray(given, np.float32)
    except (TypeError, ValueError) as error:
        raise SceneError(f"texture_values: {name} must be numbers: {error}") from None
    if values.ndim == 0:
        values = np.broadcast_to(values, shape)
    if values.shape[-len(shape) :] != shape or values.ndim > len(shape) + 1:
        rows = ", ".join(map(str, shape))
        raise SceneError(f"texture_values: {name} must be (n, {rows}) or ({rows}), not {values.shape}")
    if not np.isfinite(values).all():
        raise SceneError(f"texture_values: {name} must be finite")
    return values.reshape(-1, int(np.prod(shape)))
