"""Ray tracing after Whitted as a method."""

from __future__ import annotations

import time
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace.ray_log import LIGHT_COLUMNS, LIGHT_NUMBERS, LOG, RAY_COLUMNS, RAY_NUMBERS
from isophote.kernels.trace.ray_trace import ray_trace_tile
from isophote.kernels.trace.ray_tree import new_tree
from isophote.kernels.trace.tables import PLAN
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.lower.scene import lower_scene
from isophote.rendering.film import Film
from isophote.rendering.image import Image
from isophote.rendering.method import Job, checked_accelerator, first_hit_channels
from isophote.rendering.passes import MOST_SAMPLES, PATTERNS, Limits, trace_passes
from isophote.rendering.pixel_filter import PixelFilter, as_pixel_filter, filter_table, pixel_filter
from isophote.rendering.pool import Pool, Tile
from isophote.rendering.settings import one_of, optional_positive, optional_whole, whole
from isophote.rendering.warm import warm_up

__all__ = ["RayTrace", "new_log"]

_SAMPLES = 16
# Rays that are traced together; not a power of two (path_trace.py).
_WAVE = 1040
_MOST_DEPTH = 256
# Light samples of a surface at most, over all lights: their numbers are kept for several surfaces at once.
_MOST_JOBS = 2**20


def _weight(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
    right = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not right or not 0 <= value < 1:  # type: ignore[operator]
        raise RenderError(f"RayTrace: {attribute.name} must be a number from 0 to below 1, not {value!r}")


@attrs.frozen
class RayTrace:
    """Ray tracing after Whitted: a tree of rays for each sample of a pixel.

    Surfaces that scatter light show the ambient light, which is that of a constant `Sky` as if nothing stood in its
    way, and every light for itself, by shadow rays: one to each point, spot and sun, `light_samples` spread evenly over
    each light with a size and over an `Environment`. Mirrors, smooth metals and glass send on rays, glass two by
    Fresnel's equations, up to `depth` rays in a row: 1 shows no reflections. Rays that would carry less than
    `min_weight` of what the pixel shows are left out. Light that surfaces scatter at each other is not seen:
    `PathTrace` does that.

    `samples` trees of each pixel (16, or as many as it takes where `seconds` or `noise` is given) smooth edges;
    `filter`, `pattern`, `seconds`, `noise` and `accelerator` are those of `PathTrace`. Glass shadows like any
    other surface. The channel "rays" counts the rays of each pixel, shadow rays included. The same seed gives the same
    bits on every machine of one kind, whatever the threads and tiles.

    Source: Whitted, "An improved illumination model for shaded display", CACM 23(6), 1980; Cook, Porter, Carpenter,
    "Distributed ray tracing", SIGGRAPH 1984.
    """

    depth: int = attrs.field(default=6, validator=whole(1, _MOST_DEPTH))
    samples: int | None = attrs.field(default=None, validator=optional_whole(1, MOST_SAMPLES))
    light_samples: int = attrs.field(default=4, validator=whole(1, 4096))
    min_weight: float = attrs.field(default=1e-3, validator=_weight)
    filter: str | PixelFilter = attrs.field(default="box", validator=pixel_filter)
    seconds: float | None = attrs.field(default=None, validator=optional_positive)
    noise: float | None = attrs.field(default=None, validator=optional_positive)
    pattern: str = attrs.field(default="blue-noise", validator=one_of(PATTERNS))
    accelerator: str = attrs.field(default="bvh", converter=checked_accelerator)

    @property
    def limits(self) -> Limits:
        """When a picture is done."""
        endless = self.seconds is not None or self.noise is not None
        return Limits(self.samples or (None if endless else _SAMPLES), self.seconds, self.noise)

    def render(self, job: Job) -> Image:
        """The ray-traced picture."""
        warm_up(job.report, job.scene, "ray")
        began = time.monotonic()
        job.report("building the tree", 0.0)
        scene = lower_scene(job.scene, job.size, job.threads, self.accelerator)
        job.report("building the tree", 1.0)
        pool = Pool(job.threads)
        film, rays = self._trace(scene, job, pool, began)
        channels = first_hit_channels(scene, job.size, Pool(job.threads))
        metadata = {
            "method": repr(self),
            "seed": str(job.seed),
            "samples": film.counts_in_words(),
            "rays": str(rays.sum()),
            "seconds": f"{time.monotonic() - began:.3f}",
        }
        if pool.interrupted:
            metadata["stopped"] = "interrupted before all samples were taken"
        return Image({**film.channels(), **channels, "rays": rays.astype(np.int32)}, metadata)

    def _trace(self, scene: Packed, job: Job, pool: Pool, began: float) -> tuple[Film, npt.NDArray[np.int64]]:
        """The film, and the number of rays of each pixel."""
        table = filter_table(as_pixel_filter(self.filter))
        film = Film(job.size, table)
        width, height = job.size
        plan = PLAN.pack(
            width=width,
            height=height,
            samples=self.limits.planned,
            seed=job.seed,
            pattern=PATTERNS[self.pattern],
            offsets=table.offsets,
            crossings=table.crossings,
            max_depth=self.depth,
            roulette_depth=self.depth,
        )
        rays = np.zeros((height, width), np.int64)
        words = scratch_words(scene.arrays["fields"])
        waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]
        jobs = light_jobs(scene, self.light_samples)
        trees = [new_tree(_WAVE, self.depth, jobs, self.min_weight, rays.reshape(-1)) for _ in range(pool.threads)]
        log = new_log(0, 0)

        def work(tile: Tile, thread: int) -> None:
            own = waves[thread].words, trees[thread].words
            ray_trace_tile(scene.words, plan.words, film.words, *own, log.words, *tile)

        trace_passes(work, film, self.limits, job, pool, "ray tracing", began)
        return film, rays


def light_jobs(scene: Packed, light_samples: int) -> npt.NDArray[np.int32]:
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
