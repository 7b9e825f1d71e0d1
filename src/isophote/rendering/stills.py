"""Moving scenes by methods that look at each pixel once: the mean of several pictures of what stands still."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import numpy as np

from isophote.rendering.exposure import shutter_times
from isophote.rendering.image import Image
from isophote.rendering.method import Array, Job

__all__ = ["over_shutter"]

_STILLS = 16


def over_shutter(picture: Callable[[Job], Image], job: Job, means: Sequence[str] = ("colour",)) -> Image:
    """The picture of a job; where something moves while the shutter is open, the channels `means` are means over 16
    pictures at even times, and all else is of a picture of the middle."""
    middle = picture(attrs.evolve(job, scene=job.scene.still()))
    if not job.scene.moves:
        return middle
    totals: dict[str, Array] = {name: np.zeros(middle.channels[name].shape) for name in means}
    for time in shutter_times(job.scene, _STILLS, job.seed):
        still = picture(attrs.evolve(job, scene=job.scene.still(time)))
        for name, total in totals.items():
            total += still.channels[name]
        if "stopped" in still.metadata:
            return middle.with_(metadata={**middle.metadata, "stopped": still.metadata["stopped"]})
    blurred = {name: (total / _STILLS).astype(np.float32) for name, total in totals.items()}
    metadata = {**middle.metadata, "stills": str(_STILLS)}
    return Image({**middle.channels, **blurred}, metadata)
