"""Path tracing as a method."""

from __future__ import annotations

import time
from collections.abc import Sequence

import attrs

from isophote.kernels.trace.path import path_trace_tile
from isophote.kernels.trace.wave import new_wave
from isophote.kernels.trace.wave_entries import pack_entries
from isophote.lower.field_table import scratch_words
from isophote.rendering.darkness import warn_if_dark, warn_if_swallowed
from isophote.rendering.exposure import Moment, expose, over_moments
from isophote.rendering.film import Film
from isophote.rendering.image import Image
from isophote.rendering.method import Job, checked_accelerator, first_hit_channels
from isophote.rendering.oddities import warn_of_oddities
from isophote.rendering.passes import MOST_SAMPLES, PATTERNS, Limits, trace_passes
from isophote.rendering.pixel_filter import PixelFilter, as_pixel_filter, filter_table, pixel_filter
from isophote.rendering.plan import plan_of
from isophote.rendering.pool import Pool, Tile
from isophote.rendering.settings import one_of, optional_positive, optional_whole, whole
from isophote.rendering.warm import warm_up

__all__ = ["PathTrace"]

# Paths that take each step together; not a power of two, or the rows of a wave would fall on the same cache lines.
_WAVE = 1040
_ROULETTE = 3


@attrs.frozen
class PathTrace:
    """Unbiased path tracing: light aimed at and light met by chance, joined by multiple importance sampling.

    `samples` paths a pixel (64, or as many as it takes where `seconds` or `noise` is given), of at most `max_depth`
    rays each: 1 shows what shines, 2 adds direct light, and so on. Rendering stops after `seconds`, or when the root
    mean square of the pixels' standard errors, in parts of the picture's mean, is below `noise`; with `noise`, samples
    go where the error is, and the channel "samples" says how many each pixel got.

    `filter` is a `PixelFilter` or its name: "box", "tent", "gaussian", "blackman-harris", "mitchell" or "lanczos".
    `pattern` is "blue-noise" (Owen-scrambled Sobol points, shared out among neighbours), "sobol" (the same for each
    pixel by itself), "antithetic" (as "blue-noise", but in the pixel one in each cell of a grid, mirrored from cell to
    cell: less error at edges), "jittered", "regular" (the middles of cells; not unbiased) or "independent".
    `accelerator` names what finds what rays meet. Without a limit of time the same seed gives the same bits on every
    machine of one kind, whatever the threads and tiles. Raises `RenderError` for settings out of range.

    Sources: Kajiya, "The Rendering Equation", SIGGRAPH 1986; Veach, Guibas, "Optimally Combining Sampling Techniques
    for Monte Carlo Rendering", SIGGRAPH 1995.
    """

    samples: int | None = attrs.field(default=None, validator=optional_whole(1, MOST_SAMPLES))
    max_depth: int = attrs.field(default=8, validator=whole(1, 1024))
    filter: str | PixelFilter = attrs.field(default="box", validator=pixel_filter)
    seconds: float | None = attrs.field(default=None, validator=optional_positive)
    noise: float | None = attrs.field(default=None, validator=optional_positive)
    pattern: str = attrs.field(default="blue-noise", validator=one_of(PATTERNS))
    accelerator: str = attrs.field(default="bvh", converter=checked_accelerator)

    @property
    def limits(self) -> Limits:
        """When a picture is done."""
        return Limits(self.samples, self.seconds, self.noise)

    def render(self, job: Job) -> Image:
        """The path-traced picture."""
        warn_if_dark(job.scene)
        warn_if_swallowed(job.scene)
        warn_of_oddities(job.scene)
        warm_up(job.report, job.scene, "path", self.accelerator)
        began = time.monotonic()
        job.report("building the tree", 0.0)
        moments, middle = expose(job, self.accelerator)
        job.report("building the tree", 1.0)
        pool = Pool(job.threads)
        film = self._trace(moments, job, pool, began)
        channels = first_hit_channels(middle, job.size, Pool(job.threads))
        metadata = {
            "method": repr(self),
            "seed": str(job.seed),
            "samples": film.counts_in_words(),
            "seconds": f"{time.monotonic() - began:.3f}",
        }
        if pool.interrupted:
            metadata["stopped"] = "interrupted before all samples were taken"
        return Image({**film.channels(), **channels}, metadata)

    def _trace(self, moments: Sequence[Moment], job: Job, pool: Pool, began: float) -> Film:
        table = filter_table(as_pixel_filter(self.filter))
        film = Film(job.size, table)
        plans = [
            plan_of(
                job,
                table,
                samples=self.limits.planned,
                pattern=self.pattern,
                depth=self.max_depth,
                roulette=_ROULETTE,
                inside=moment.inside,
            )
            for moment in moments
        ]
        words = scratch_words(moments[0].scene.arrays["fields"])
        waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]
        entries = pack_entries()

        def work(tile: Tile, thread: int, moment: int) -> None:
            scene, plan = moments[moment].scene, plans[moment]
            path_trace_tile(scene.words, plan.words, film.words, waves[thread].words, entries.words, *tile)

        trace_passes(
            over_moments(work, film, plans[0], len(moments)), film, self.limits, job, pool, "path tracing", began
        )
        return film
