"""Clear media of materials into a table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from isophote.errors import SceneError
from isophote.kernels.base.table import Packed
from isophote.kernels.light.medium import MEDIA
from isophote.scene.material import Glass
from isophote.scene.material_base import Material
from isophote.scene.relief import unturned

__all__ = ["lower_media"]

# Air: index of refraction, priority below all, absorption.
_AIR = (1.0, -np.inf, 0.0, 0.0, 0.0)
# Numbers of media have fifteen bits in the lists of rays.
_MOST_MEDIA = 2**15 - 1


def lower_media(materials: Sequence[Material]) -> Packed:
    """The table of what is behind surfaces of each material. Raises `SceneError` for more media than can be told."""
    numbers: dict[tuple[float, ...], int] = {}
    of_material = np.zeros(len(materials), np.int32)
    for k, material in enumerate(materials):
        glass = unturned(material)
        if isinstance(glass, Glass):
            medium = (glass.ior, glass.priority, *glass.absorption)
            of_material[k] = numbers.setdefault(medium, len(numbers) + 1)
    if len(numbers) > _MOST_MEDIA:
        raise SceneError(f"{len(numbers):,} kinds of glass are more than the {_MOST_MEDIA:,} that rays can tell apart")
    return MEDIA.pack(of_material=of_material, values=np.array([_AIR, *numbers], np.float32))
