"""The clear media that a camera stands in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.rendering.tracer import Tracer
from isophote.scene.material import Glass
from isophote.scene.relief import unturned
from isophote.scene.scene import Item, Scene

__all__ = ["media_around", "packed_media"]

# As many as the list of a ray holds (medium.py), in so many bits each.
_MOST, _BITS = 4, 16


def media_around(scene: Scene, threads: int | None = None) -> tuple[Glass, ...]:
    """The glass around the camera's eye, which the line of sight leaves before it enters it; that whose surface is
    nearest comes last, as if it had been entered last."""
    camera = scene.camera
    if camera is None:
        return ()
    eye = np.asarray(camera.eye, np.float64)
    along = np.asarray(camera.target, np.float64) - eye
    along /= np.linalg.norm(along)
    around = []
    for item in scene.items:
        glass = unturned(item.material)
        if isinstance(glass, Glass) and _may_hold(item, eye):
            hits = Tracer(item, threads=threads).closest(eye[None], along[None])
            if hits.hit[0] and float(hits.normal[0] @ along) > 0:
                around.append((float(hits.distance[0]), glass))
    return tuple(glass for _, glass in sorted(around, key=lambda pair: -pair[0]))


def packed_media(tables: Packed, media: Sequence[Glass]) -> int:
    """The list of media (medium.py) of a ray that is in these, by their numbers in a lowered scene."""
    packed = 0
    for glass in media[-_MOST:]:
        packed = packed << _BITS | _number(tables, glass)
    return packed


def _may_hold(item: Item, place: npt.NDArray[np.float64]) -> bool:
    low, high = item.bounds
    return bool((low <= place).all() and (place <= high).all())


def _number(tables: Packed, glass: Glass) -> int:
    """Number of a glass's medium in the lowered scene."""
    values = tables.arrays["media"].arrays["values"]
    wanted = np.array([glass.ior, glass.priority, *glass.absorption], np.float32)
    return int(np.flatnonzero((values == wanted).all(axis=1))[0])
