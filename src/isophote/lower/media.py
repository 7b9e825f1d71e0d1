"""Clear media of materials into a table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from isophote.errors import SceneError
from isophote.kernels.base.table import Packed
from isophote.kernels.light.air import AIR
from isophote.kernels.light.medium import MEDIA
from isophote.scene.material import Glass
from isophote.scene.material_base import Material
from isophote.scene.medium import Medium
from isophote.scene.relief import unturned

__all__ = ["lower_media"]

# Air: index of refraction, priority below all, absorption.
_AIR = (1.0, -np.inf, 0.0, 0.0, 0.0)
# Numbers of media have fifteen bits in the lists of rays.
_MOST_MEDIA = 2**15 - 1


def lower_media(materials: Sequence[Material], medium: Medium | None = None) -> Packed:
    """The table of what is behind surfaces of each material, and of what fills the air. Raises `SceneError` for more
    media than can be told apart."""
    numbers: dict[tuple[float, ...], int] = {}
    of_material = np.zeros(len(materials), np.int32)
    for k, material in enumerate(materials):
        glass = unturned(material)
        if isinstance(glass, Glass):
            values = (glass.ior, glass.priority, *glass.absorption)
            of_material[k] = numbers.setdefault(values, len(numbers) + 1)
    if len(numbers) > _MOST_MEDIA:
        raise SceneError(f"{len(numbers):,} kinds of glass are more than the {_MOST_MEDIA:,} that rays can tell apart")
    return MEDIA.pack(of_material=of_material, values=np.array([_AIR, *numbers], np.float32), air=_air(medium))


def _air(medium: Medium | None) -> Packed:
    fills = Medium() if medium is None else medium
    bounds = np.array([[-np.inf] * 3, [np.inf] * 3]) if fills.bounds is None else fills.bounds
    scatter = dim = 0
    if max(*fills.scattering, *fills.absorption) > 0:
        # Loaded where there is something that scatters or swallows light.
        from isophote.kernels.trace import air_rays

        scatter, dim = air_rays.scatter.address, air_rays.dim_shadows.address
    return AIR.pack(
        scattering=np.array(fills.scattering, np.float32),
        absorption=np.array(fills.absorption, np.float32),
        box=bounds.reshape(-1).astype(np.float32),
        anisotropy=fills.anisotropy,
        scatter=scatter,
        dim=dim,
    )
