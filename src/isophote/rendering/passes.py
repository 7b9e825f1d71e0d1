"""The passes of a picture: which pixels get samples, how many, and when there are enough.

Every method that takes samples of pixels renders so: `PATTERNS` and a `PixelFilter` go into the plan of its kernel, and
its kernel fills tiles of a `Film`, each pixel up to the film's target:

    film = Film(job.size, filter_table(pixel_filter))
    trace_passes(tile_work, film, Limits(samples, seconds, noise), job, pool, "ray tracing", began)

The first pass gives every pixel the same few samples. Later ones double what a pixel has at most. Without `noise` all
pixels get the same. With it samples go where they help: the root mean square of the pixels' standard errors σ / √n is
least, for so many samples in all, where n is in proportion to σ. A pixel's σ is told by the samples that it and its
neighbours had before the pass, and by nothing else. So neither threads nor tiles change a picture, and a pixel whose
first samples missed all light is not given up while its neighbours saw some. That pixels which saw little by chance
stop early makes pictures darker nevertheless, by far less than their noise (docs/design/sampling.md).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.kernels.base import sampler
from isophote.rendering.film import LUMINANCE, Film
from isophote.rendering.method import Job
from isophote.rendering.pool import Pool, Tile, tiles_of

__all__ = ["MOST_SAMPLES", "PATTERNS", "Limits", "trace_passes"]

TileWork: TypeAlias = Callable[[Tile, int], None]

PATTERNS = {
    "blue-noise": sampler.BLUE_NOISE,
    "antithetic": sampler.ANTITHETIC,
    "sobol": sampler.SOBOL,
    "jittered": sampler.JITTERED,
    "regular": sampler.REGULAR,
    "independent": sampler.INDEPENDENT,
}
MOST_SAMPLES = 2**20
_DEFAULT_SAMPLES = 64
_FIRST_PASS = 16
_LARGEST_PASS = 64
_TILE = 32
# A pass for less than this part more samples is not worth its start.
_WORTH_A_PASS = 1 / 16


@attrs.frozen
class Limits:
    """When a picture is done: at `samples` for each pixel, after `seconds`, or when the root mean square of the pixels'
    standard errors, in parts of the picture's mean, is below `noise`."""

    samples: int | None
    seconds: float | None = None
    noise: float | None = None

    @property
    def planned(self) -> int:
        """The most samples that a pixel may get."""
        if self.samples is not None:
            return int(self.samples)
        return _DEFAULT_SAMPLES if self.seconds is None and self.noise is None else MOST_SAMPLES


def trace_passes(
    work: TileWork, film: Film, limits: Limits, job: Job, pool: Pool, stage: str, began: float, edge: int = _TILE
) -> None:
    """Call `work(tile, thread)` for all tiles, pass by pass, until a limit is reached or the user interrupts.

    `began` is the `time.monotonic` from which seconds count. Every pixel has its first samples, however short the time.
    `stage` names the work in reports, which come, as does the end, with tiles of `edge` pixels each way.
    """
    deadline = None if limits.seconds is None else began + limits.seconds
    tiles = tiles_of(job.size, edge)
    progress = _Progress(limits, job, film, stage, len(tiles), began)
    film.target[:] = min(_FIRST_PASS, limits.planned)
    try:
        while True:
            pool.run(work, tiles, progress.show)
            pool.deadline = deadline
            if pool.stopped or not _next_targets(film, limits):
                break
            progress.next_pass()
    except KeyboardInterrupt:
        # The pool catches those that come while it runs; this one came between two passes.
        pool.stop()
    job.report(stage, 1.0)


def _next_targets(film: Film, limits: Limits) -> bool:
    """Set what each pixel shall have after the next pass. Returns whether any gets more."""
    count = film.count
    most = count + np.clip(count, _FIRST_PASS, _LARGEST_PASS)
    if limits.noise is not None:
        excess = film.noise() / limits.noise
        if excess <= 1:
            return False
        wanted = _wanted(film, limits.noise)
        # What the blurred errors ask for is there, and yet it is not enough: some more for all that err.
        if not (wanted > count).any():
            wanted = np.where(film.sample_variance().any(axis=2), np.ceil(count * min(excess**2, 2.0)), count)
        most = np.minimum(wanted, 2 * np.maximum(count, _FIRST_PASS)).astype(np.int64)
    film.target[:] = np.clip(most, count, limits.planned)
    return bool((film.target > count).any())


def _wanted(film: Film, noise: float) -> npt.NDArray[np.float64]:
    """(h, w): samples for a root mean square error of `noise` times the mean with the fewest samples in all."""
    level = float((film.mean() @ LUMINANCE).mean())
    if not level > 0:
        return film.count.astype(np.float64)
    loss = np.maximum(film.count, 1) / film.effective_count()
    deviation = np.sqrt(_blurred(film.sample_variance() @ LUMINANCE * loss))
    wanted = np.ceil(deviation * deviation.mean() / (noise * level) ** 2)
    return np.where(wanted > film.count * (1 + _WORTH_A_PASS), wanted, film.count)


def _blurred(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Mean over 3 × 3 pixels, twice; at the border over those that are there."""
    for _ in range(2):
        for axis in (0, 1):
            padded = np.pad(values, [(1, 1) if k == axis else (0, 0) for k in (0, 1)], mode="edge")
            size = values.shape[axis]
            values = np.mean([np.take(padded, range(k, k + size), axis) for k in range(3)], axis=0)
    return values


class _Progress:
    """Fraction done: by samples, time or noise, which falls with the root of the samples; whichever is furthest."""

    def __init__(self, limits: Limits, job: Job, film: Film, stage: str, tiles: int, began: float) -> None:
        self._limits = limits
        self._report = job.report
        self._film = film
        self._stage = stage
        self._tiles = tiles
        self._began = began
        self._before = 0.0
        self._quiet = 0.0

    def next_pass(self) -> None:
        """Tell that targets are set for another pass."""
        self._before = float(self._film.count.mean())
        if self._limits.noise is not None:
            self._quiet = (self._limits.noise / self._film.noise()) ** 2

    def show(self, done: int) -> None:
        """Report with so many tiles of a pass done."""
        samples = self._before + (float(self._film.target.mean()) - self._before) * done / self._tiles
        fraction = max(samples / self._limits.planned, self._quiet)
        if self._limits.seconds is not None:
            fraction = max(fraction, (time.monotonic() - self._began) / self._limits.seconds)
        self._report(self._stage, fraction)
