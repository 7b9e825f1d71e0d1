"""What a picture's samples see while the shutter is open: the scene at many moments, each standing still.

All rays of a path run at one moment. A pixel's samples are spread over the moments by numbers of their own, drawn from
the same pattern as all others; sorted by time, so that a pass can go through the moments one after another (see
docs/design/motion.md):

    moments, middle = expose(job, accelerator)
    plans = [plan_of(..., inside=moment.inside) for moment in moments]
    trace_passes(over_moments(work, film, plans[0], len(moments)), film, ...)      # work(tile, thread, moment's number)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.table import Packed
from isophote.kernels.trace.shutter import count_moments
from isophote.lower.moments import lower_moments
from isophote.lower.scene import lower_scene
from isophote.rendering.camera_media import media_around, packed_media
from isophote.rendering.film import Film
from isophote.rendering.method import Job, Size
from isophote.rendering.pool import Tile
from isophote.scene.material import Glass
from isophote.scene.relief import unturned
from isophote.scene.scene import Scene, camera_at
from isophote.scene.ways import Ways

__all__ = ["Exposure", "Moment", "expose", "over_moments", "shutter_times"]

# So many moments for each pixel that what moves farthest crosses, within bounds: measured, errors by steps are then
# below those of a thousand samples (docs/design/motion.md).
_A_PIXEL, _LEAST, _MOST = 4, 64, 256
# Moments at which ways over the film are measured.
_PROBES = 17


class Moment(NamedTuple):
    """A lowered scene, and the list of media (kernels/light/medium.py) that its camera stands in."""

    scene: Packed
    inside: int


class Exposure(NamedTuple):
    """A scene at the moments of its shutter, one where nothing moves, and as it stands halfway through."""

    moments: Sequence[Moment]
    middle: Packed


def expose(job: Job, accelerator: str = "bvh") -> Exposure:
    """The scene of a job while its shutter is open."""
    if not job.scene.moves:
        still = job.scene.still()
        around = media_around(still, job.threads)
        tables = lower_scene(still, job.size, job.threads, accelerator)
        return Exposure([Moment(tables, packed_media(tables, around))], tables)
    opened, closed = job.scene.shutter
    times = shutter_times(job.scene, _moments(job.scene, job.size), job.seed)
    *lowered, middle = lower_moments(job.scene, job.size, [*times, opened / 2 + closed / 2], job.threads, accelerator)
    if not any(isinstance(unturned(item.material), Glass) for item in job.scene.items):
        return Exposure([Moment(tables, 0) for tables in lowered], middle)
    around_at = (media_around(job.scene.still(time), job.threads) for time in times)
    pairs = zip(lowered, around_at, strict=True)
    return Exposure([Moment(tables, packed_media(tables, around)) for tables, around in pairs], middle)


def shutter_times(scene: Scene, count: int, seed: int) -> list[float]:
    """So many times, evenly spread over the time that the shutter is open, from a start by chance: each by itself falls
    on any time as often as on any other."""
    opened, closed = scene.shutter
    start = float(np.random.default_rng(seed).random())
    return [opened + (k + start) / count * (closed - opened) for k in range(count)]


def _moments(scene: Scene, size: Size) -> int:
    """How many moments a picture takes: a power of two."""
    wanted = _A_PIXEL * _longest_way(scene, size)
    return 1 << math.ceil(math.log2(min(max(wanted, _LEAST), _MOST)))


def _longest_way(scene: Scene, size: Size) -> float:
    """The longest way over the film, in pixels, of corners of boxes around items; infinite where one cannot be told, as
    from behind the camera."""
    boxes = np.array([item.shape.bounds for item in scene.items], np.float64)
    finite = np.isfinite(boxes).all(axis=(1, 2))
    corners = np.stack([boxes[finite][:, (k >> 2, k >> 1 & 1, k & 1), (0, 1, 2)] for k in range(8)], axis=1)
    ways = Ways([scene.items[number].transform for number in np.flatnonzero(finite)])
    lengths, before = np.zeros(corners.shape[:2]), None
    for time in np.linspace(*scene.shutter, _PROBES).tolist():
        matrices, camera = ways.at(time), camera_at(scene, time)
        if camera is None:
            return 0.0
        placed = corners @ matrices[:, :3, :3].swapaxes(1, 2) + matrices[:, None, :3, 3]
        now = camera.project(placed, size)[0]
        lengths += 0.0 if before is None else np.linalg.norm(now - before, axis=2)
        before = now
    return float(np.where(np.isfinite(lengths), lengths, np.inf).max(initial=0.0))


def over_moments(
    work: Callable[[Tile, int, int], None], film: Film, plan: Packed, moments: int
) -> Callable[[Tile, int], None]:
    """What traces a tile's samples at all moments, by `work(tile, thread, moment)`, which traces all that the tile's
    pixels are short of; `plan` tells the pattern and the seed."""
    if moments == 1:
        return lambda tile, thread: work(tile, thread, 0)

    def all_moments(tile: Tile, thread: int) -> None:
        x0, x1, y0, y1 = tile
        counts = np.zeros((moments, (x1 - x0) * (y1 - y0)), np.uint32)
        count_moments(plan.words, film.words, x0, x1, y0, y1, counts)
        target = film.target[y0:y1, x0:x1]
        target[:] = film.count[y0:y1, x0:x1]
        for moment in np.flatnonzero(counts.any(axis=1)).tolist():
            target += counts[moment].reshape(target.shape)
            work(tile, thread, moment)

    return all_moments
