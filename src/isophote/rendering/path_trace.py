"""Path tracing as a method."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import attrs
import numpy as np

from isophote.errors import RenderError
from isophote.kernels.base import sampler
from isophote.kernels.base.table import Packed
from isophote.kernels.light import film as film_kernels
from isophote.kernels.trace.path import path_trace_tile
from isophote.kernels.trace.tables import FILM, PLAN
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.lower.scene import lower_scene
from isophote.rendering.image import Image
from isophote.rendering.method import Array, Job, Size, checked_accelerator, first_hit_channels
from isophote.rendering.pool import Pool, Tile, tiles_of
from isophote.rendering.warm import warm_up

__all__ = ["PathTrace"]

_PATTERNS = {"independent": sampler.INDEPENDENT, "jittered": sampler.JITTERED, "sobol": sampler.SOBOL}
_FILTERS = {"box": film_kernels.BOX, "tent": film_kernels.TENT, "gaussian": film_kernels.GAUSSIAN}
_DEFAULT_SAMPLES = 64
_MOST_SAMPLES = 2**20
_FIRST_PASS = 16
_LARGEST_PASS = 64
_TILE = 32
# Paths that take each step together; not a power of two, or the rows of a wave would fall on the same cache lines.
_WAVE = 1040
_ROULETTE = 3
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def _whole(least: int, most: int) -> Any:
    def check(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
            raise RenderError(
                f"PathTrace: {attribute.name} must be a whole number from {least} to {most:,}, not {value!r}"
            )

    return check


def _positive(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
    if not isinstance(value, int | float) or not value > 0:
        raise RenderError(f"PathTrace: {attribute.name} must be a number above 0, or None, not {value!r}")


def _one_of(names: Any) -> Any:
    def check(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
        if value not in names:
            raise RenderError(f"PathTrace: {attribute.name} must be one of {', '.join(names)}, not {value!r}")

    return check


@attrs.frozen
class PathTrace:
    """Unbiased path tracing: light aimed at and light met by chance, joined by multiple importance sampling.

    `samples` paths a pixel (64, or as many as it takes where `seconds` or `noise` is given), of at most `max_depth`
    rays each: 1 shows what shines, 2 adds direct light, and so on. `filter` is "box", "tent" or "gaussian"; `pattern`
    is "sobol" (Owen-scrambled), "jittered" or "independent". Rendering stops after `seconds`, or when the standard
    error of the pixels, in parts of the picture's mean, is below `noise`. `accelerator` names what finds what rays
    meet. Without these limits the same seed gives the same bits on every machine of one kind, whatever the threads and
    tiles.
    """

    samples: int | None = attrs.field(default=None, validator=attrs.validators.optional(_whole(1, _MOST_SAMPLES)))
    max_depth: int = attrs.field(default=8, validator=_whole(1, 1024))
    filter: str = attrs.field(default="box", validator=_one_of(_FILTERS))
    seconds: float | None = attrs.field(default=None, validator=attrs.validators.optional(_positive))
    noise: float | None = attrs.field(default=None, validator=attrs.validators.optional(_positive))
    pattern: str = attrs.field(default="sobol", validator=_one_of(_PATTERNS))
    accelerator: str = attrs.field(default="bvh", converter=checked_accelerator)

    @property
    def planned_samples(self) -> int:
        """The most paths that a pixel may get."""
        if self.samples is not None:
            return int(self.samples)
        return _DEFAULT_SAMPLES if self.seconds is None and self.noise is None else _MOST_SAMPLES

    def render(self, job: Job) -> Image:
        """The path-traced picture."""
        warm_up(job.report, job.scene, "path")
        began = time.monotonic()
        deadline = None if self.seconds is None else began + self.seconds
        job.report("building the tree", 0.0)
        scene = lower_scene(job.scene, job.size, job.threads, self.accelerator)
        job.report("building the tree", 1.0)
        pool = Pool(job.threads)
        film = self._trace(scene, job, pool, deadline)
        channels = first_hit_channels(scene, job.size, Pool(job.threads))
        count = film.arrays["count"]
        metadata = {
            "method": repr(self),
            "seed": str(job.seed),
            "samples": f"{count.min()}" if count.min() == count.max() else f"{count.min()} to {count.max()}",
            "seconds": f"{time.monotonic() - began:.3f}",
        }
        if pool.interrupted:
            metadata["stopped"] = "interrupted before all samples were taken"
        return Image({**_developed(film, job.size), **channels}, metadata)

    def _trace(self, scene: Packed, job: Job, pool: Pool, deadline: float | None) -> Packed:
        width, height = job.size
        film = FILM.pack(
            total=np.zeros((height, 3 * width)),
            squares=np.zeros((height, 3 * width)),
            count=np.zeros((height, width), np.int64),
        )
        plan = PLAN.pack(
            width=width,
            height=height,
            samples=self.planned_samples,
            seed=job.seed,
            pattern=_PATTERNS[self.pattern],
            filter=_FILTERS[self.filter],
            max_depth=self.max_depth,
            roulette_depth=_ROULETTE,
        )
        words = scratch_words(scene.arrays["fields"])
        waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]
        tiles = tiles_of(job.size, _TILE)
        progress = _Progress(self, job, len(tiles))
        try:
            for span in _passes(self.planned_samples):

                def work(tile: Tile, thread: int, span: _Span = span) -> None:
                    path_trace_tile(scene.words, plan.words, film.words, waves[thread].words, *tile, *span)

                pool.run(work, tiles, lambda done, span=span: progress.show(span, done))  # type: ignore[misc]
                # From now on; every pixel has its first samples, however short the time.
                pool.deadline = deadline
                if pool.stopped or (self.noise is not None and _noise(film) <= self.noise):
                    break
        except KeyboardInterrupt:
            # The pool catches those that come while it runs; this one came between two passes.
            pool.stop()
        job.report("path tracing", 1.0)
        return film


class _Span(NamedTuple):
    """Samples first ≤ s < last of every pixel."""

    first: int
    last: int


def _passes(samples: int) -> Iterator[_Span]:
    """Sample ranges that double, so that a picture of all pixels is there early."""
    first, count = 0, _FIRST_PASS
    while first < samples:
        last = min(first + count, samples)
        yield _Span(first, last)
        first, count = last, min(last, _LARGEST_PASS)


class _Progress:
    """Fraction done, by time where there is a limit, else by samples."""

    def __init__(self, method: PathTrace, job: Job, tiles: int) -> None:
        self._method = method
        self._report = job.report
        self._tiles = tiles
        self._began = time.monotonic()

    def show(self, span: _Span, done: int) -> None:
        samples = span.first + (span.last - span.first) * done / self._tiles
        fraction = samples / self._method.planned_samples
        if self._method.seconds is not None:
            fraction = max(fraction, (time.monotonic() - self._began) / self._method.seconds)
        self._report("path tracing", fraction)


def _mean_and_variance(film: Packed) -> tuple[Array, Array]:
    """Mean of the samples of each pixel, (h, w, 3), and the variance of that mean as if samples were independent."""
    count = film.arrays["count"]
    shape = (*count.shape, 3)
    n = np.maximum(count, 1)[..., None]
    mean = film.arrays["total"].reshape(shape) / n
    spread = np.maximum(film.arrays["squares"].reshape(shape) / n - mean**2, 0.0)
    return mean, spread / np.maximum(n - 1, 1)


def _noise(film: Packed) -> float:
    """Root mean square of the pixels' standard errors, in parts of the mean; infinite until it can be told."""
    if film.arrays["count"].min() < 2:
        return np.inf
    mean, variance = _mean_and_variance(film)
    level = float((mean @ _LUMINANCE).mean())
    error = float(np.sqrt((variance @ _LUMINANCE).mean()))
    return error / level if level > 0 else 0.0


def _developed(film: Packed, size: Size) -> dict[str, Array]:
    mean, variance = _mean_and_variance(film)
    return {"colour": mean.astype(np.float32), "variance": variance.astype(np.float32)}
