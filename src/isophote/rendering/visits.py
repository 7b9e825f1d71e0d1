"""What rays cost, as a picture."""

from __future__ import annotations

import time
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.trace.count import count_pixels
from isophote.kernels.trace.wave import new_wave
from isophote.lower.counting import counting
from isophote.lower.field_table import scratch_words
from isophote.lower.scene import lower_scene
from isophote.rendering.image import Image
from isophote.rendering.method import Job, Size, checked_accelerator, first_hit_channels
from isophote.rendering.pool import Pool
from isophote.rendering.settings import one_of, optional_positive
from isophote.rendering.warm import warm_up

__all__ = ["Visits"]

Ints: TypeAlias = npt.NDArray[np.int32]

_COUNTS = ("nodes", "primitives", "tree_depth")
_PIXELS_A_JOB = 4096
# Linear colours from nothing to the most: black, blue, magenta, orange, pale yellow; each is lighter than the last.
_COLOURS = np.array([[0, 0, 0.01], [0.05, 0.02, 0.35], [0.45, 0.03, 0.25], [0.95, 0.3, 0.03], [1, 0.95, 0.55]])


@attrs.frozen
class Visits:
    """What the camera's rays visit on their way to what they meet first, as a heat map.

    `count` is what the colours show: "nodes" (nodes, cells or planes of the `accelerator`), "primitives" (triangles,
    exact primitives and fields tested) or "tree_depth" (the deepest level reached); from black for none to pale yellow
    for `most`, or for the most that there is. All three are channels, (h, w) float32, beside those of what is seen
    first. Rays go through the middles of pixels; other methods count nothing and lose no time by it.
    """

    accelerator: str = attrs.field(default="bvh", converter=checked_accelerator)
    count: str = attrs.field(default="nodes", validator=one_of(_COUNTS))
    most: float | None = attrs.field(default=None, validator=optional_positive)

    def render(self, job: Job) -> Image:
        """The heat map."""
        warm_up(job.report, job.scene, "visits", self.accelerator)
        began = time.monotonic()
        job.report("building the accelerator", 0.0)
        scene = lower_scene(job.scene, job.size, job.threads, self.accelerator)
        job.report("building the accelerator", 1.0)
        counts = _counts(scene, job.size, Pool(job.threads))
        channels = {name: counts[k].astype(np.float32) for k, name in enumerate(_COUNTS)}
        most = float(channels[self.count].max()) if self.most is None else float(self.most)
        metadata = {
            "method": repr(self),
            "most": f"{most:g}",
            **{f"mean {name}": f"{channel.mean():.2f}" for name, channel in channels.items()},
            "seconds": f"{time.monotonic() - began:.3f}",
        }
        colour = _colours(channels[self.count] / max(most, 1.0))
        return Image({"colour": colour, **channels, **first_hit_channels(scene, job.size, Pool(job.threads))}, metadata)


def _counts(scene: Packed, size: Size, pool: Pool) -> Ints:
    """(3, h, w): nodes, triangles and depth of each pixel's ray."""
    width, height = size
    counts = np.zeros((3, width * height), np.int32)
    counted = counting(scene)
    words = scratch_words(scene.arrays["fields"])
    waves = [new_wave(1, words) for _ in range(pool.threads)]

    def work(first: int, thread: int) -> None:
        last = min(first + _PIXELS_A_JOB, width * height)
        count_pixels(counted.words, waves[thread].words, counts, width, first, last)

    pool.run(work, range(0, width * height, _PIXELS_A_JOB), lambda done: None)
    return counts.reshape(3, height, width)


def _colours(values: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """(h, w, 3): linear colours of values from 0 to 1."""
    places = np.linspace(0, 1, len(_COLOURS))
    clipped = np.clip(values, 0, 1)
    return np.stack([np.interp(clipped, places, _COLOURS[:, k]) for k in range(3)], axis=-1).astype(np.float32)
