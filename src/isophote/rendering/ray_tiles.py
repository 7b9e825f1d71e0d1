"""All that the kernel of ray tracing is given for one picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace.light_samples import draw_jobs, sample_lights
from isophote.kernels.trace.ray_log import LIGHT_COLUMNS, LIGHT_NUMBERS, LOG, RAY_COLUMNS, RAY_NUMBERS
from isophote.kernels.trace.ray_trace import ray_trace_tile
from isophote.kernels.trace.ray_tree import new_tree
from isophote.kernels.trace.shadow_tint import shadow_tint
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.rendering.exposure import Moment, over_moments
from isophote.rendering.film import Film
from isophote.rendering.method import Job
from isophote.rendering.passes import Limits
from isophote.rendering.pixel_filter import PixelFilter, as_pixel_filter, filter_table
from isophote.rendering.plan import plan_of
from isophote.rendering.pool import Tile

__all__ = ["RaySettings", "RayTiles", "new_log"]

Counts: TypeAlias = npt.NDArray[np.int64]

# Rays that are traced together; not a power of two (path_trace.py).
_WAVE = 1040
# Light samples of a surface at most, over all lights: their numbers are kept for several surfaces at once.
_MOST_JOBS = 2**20
# Where so many shadow rays leave each surface, smaller tiles: progress is told, and Ctrl-C obeyed, after seconds.
_MANY_JOBS, _EDGE, _EDGE_OF_MANY = 256, 32, 8


class RaySettings(Protocol):
    """What ray tracing is told; see `RayTrace`."""

    @property
    def depth(self) -> int: ...
    @property
    def light_samples(self) -> int: ...
    @property
    def min_weight(self) -> float: ...
    @property
    def filter(self) -> str | PixelFilter: ...
    @property
    def pattern(self) -> str: ...
    @property
    def shadows(self) -> str: ...
    @property
    def limits(self) -> Limits: ...


class RayTiles:
    """The film of a picture of a scene at the moments of its shutter, `rays` (h, w), the number of rays of each pixel,
    and what fills them."""

    def __init__(
        self,
        settings: RaySettings,
        moments: Sequence[Moment],
        job: Job,
        threads: int,
        log: Packed | None = None,
    ) -> None:
        table = filter_table(as_pixel_filter(settings.filter))
        width, height = job.size
        self.film = Film(job.size, table)
        self.rays: Counts = np.zeros((height, width), np.int64)
        self._moments = moments
        self._plans = [
            plan_of(
                job,
                table,
                samples=settings.limits.planned,
                pattern=settings.pattern,
                depth=settings.depth,
                inside=moment.inside,
            )
            for moment in moments
        ]
        self._log = new_log(0, 0) if log is None else log
        words = scratch_words(moments[0].scene.arrays["fields"])
        jobs, flat = _light_jobs(moments[0].scene, settings.light_samples), self.rays.reshape(-1)
        self._waves = [new_wave(_WAVE, words) for _ in range(threads)]
        tint = shadow_tint.address if settings.shadows == "tinted" else 0
        entries = {"draw_jobs": draw_jobs.address, "sample_lights": sample_lights.address, "tint": tint}
        self._trees = [
            new_tree(_WAVE, settings.depth, jobs, settings.min_weight, flat, **entries) for _ in range(threads)
        ]

        #: Pixels of a tile each way.
        self.edge = _EDGE if len(jobs) < _MANY_JOBS else _EDGE_OF_MANY
        #: Traces the samples that a tile's pixels are short of: `trace(tile, thread)`.
        self.trace = over_moments(self._trace, self.film, self._plans[0], len(moments))

    def _trace(self, tile: Tile, thread: int, moment: int) -> None:
        own = self._waves[thread].words, self._trees[thread].words
        scene, plan = self._moments[moment].scene, self._plans[moment]
        ray_trace_tile(scene.words, plan.words, self.film.words, *own, self._log.words, *tile)


def _light_jobs(scene: Packed, light_samples: int) -> npt.NDArray[np.int32]:
    """(n, 3): all samples of all lights, as TREE has them. Raises `RenderError` where there are too many."""
    groups = scene.arrays["lights"].arrays["groups"]
    counts = np.where(groups[:, 2] != 0, light_samples, 1)
    if counts.sum() > _MOST_JOBS:
        raise RenderError(
            f"RayTrace aims at every light: {counts.sum():,} shadow rays from each surface are more than "
            f"{_MOST_JOBS:,}; give fewer lights or light_samples, or use PathTrace"
        )
    number = np.repeat(np.arange(len(groups)), counts)
    trial = np.arange(len(number)) - np.repeat(np.cumsum(counts) - counts, counts)
    several = np.where(groups[:, 2] != 0, light_samples, 0)[number]
    return np.stack([number, trial, several], axis=1).astype(np.int32).reshape(-1, 3)


def new_log(rays: int, lights: int) -> Packed:
    """A log with room for so many rays and samples of lights; without room it takes nothing down."""
    return LOG.pack(
        rays=np.zeros((rays, RAY_COLUMNS), np.float32),
        ray_numbers=np.zeros((rays, RAY_NUMBERS), np.int64),
        lights=np.zeros((lights, LIGHT_COLUMNS), np.float32),
        light_numbers=np.zeros((lights, LIGHT_NUMBERS), np.int64),
        counts=np.zeros(2, np.int64),
    )
