"""Ambient occlusion as a method."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np

from isophote.errors import RenderError
from isophote.kernels.trace.occlusion_picture import SKY, occlusion_tile
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.rendering.exposure import Moment, expose, over_moments
from isophote.rendering.film import Film
from isophote.rendering.image import Image
from isophote.rendering.method import Array, Job, extent_of, first_hit_channels
from isophote.rendering.occlusion.points import checked_reach
from isophote.rendering.occlusion.screen import screen_occlusion
from isophote.rendering.passes import Limits, trace_passes
from isophote.rendering.pixel_filter import as_pixel_filter, filter_table
from isophote.rendering.plan import plan_of
from isophote.rendering.pool import Pool, Tile
from isophote.rendering.stills import over_shutter
from isophote.rendering.warm import warm_up

__all__ = ["AmbientOcclusion"]

_WAYS = ("rays", "horizon", "classic")
_MOST_SAMPLES = 2**20
_WAVE = 1040
# Half of the samples of a pixel go to each side of a slice, four slices through a pixel.
_SLICES = 4
# Reach of what is told from depth where none is given, in parts of the finite items' diagonal.
_REACH = 1 / 8


def _samples(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 1 <= value <= _MOST_SAMPLES:
        raise RenderError(
            f"AmbientOcclusion: samples must be a whole number from 1 to {_MOST_SAMPLES:,}, not {value!r}"
        )


def _way(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
    if value not in _WAYS:
        raise RenderError(f"AmbientOcclusion: by must be one of {', '.join(map(repr, _WAYS))}, not {value!r}")


def _reach(method: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    checked_reach(value)


@attrs.frozen
class AmbientOcclusion:
    """How open the sky is above what is seen, V = 1/π ∫ v cosθ dω, as greys: white is open, black closed.

    `by="rays"` traces `samples` random rays a pixel, each from its own place within the pixel, of at most
    `max_distance` metres (None: however long); the channel "bent_normal" is the mean direction of the free ones.
    `by="horizon"` and `by="classic"` take no rays but those of the camera: they find what is in the way in the depth of
    the pixels around, as real-time renderers do, within `max_distance` (None: an eighth of the scene's diagonal); see
    `screen_occlusion`. Lights, materials and what only they show play no part. The channel "visibility" is the grey.
    Raises `RenderError` for settings out of range.
    """

    samples: int = attrs.field(default=64, validator=_samples)
    max_distance: float | None = attrs.field(default=None, validator=_reach)
    by: str = attrs.field(default="rays", validator=_way)

    def render(self, job: Job) -> Image:
        """The picture of occlusion."""
        warm_up(job.report, job.scene, "occlusion")
        return self._picture(job) if self.by == "rays" else over_shutter(self._picture, job, ("colour", "visibility"))

    def _picture(self, job: Job) -> Image:
        began = time.monotonic()
        job.report("building the tree", 0.0)
        unlit = attrs.evolve(job, scene=job.scene.with_(lights=()))
        moments, scene = expose(unlit)
        job.report("building the tree", 1.0)
        pool = Pool(job.threads)
        channels = dict(first_hit_channels(scene, job.size, Pool(job.threads)))
        traced = self._traced(moments, job, pool) if self.by == "rays" else self._from_depth(job, channels)
        metadata = {"method": repr(self), "seed": str(job.seed), "seconds": f"{time.monotonic() - began:.3f}"}
        if pool.interrupted:
            metadata["stopped"] = "interrupted before all samples were taken"
        grey = traced["visibility"]
        return Image({"colour": np.repeat(grey[..., None], 3, axis=2), **channels, **traced}, metadata)

    def _traced(self, moments: Sequence[Moment], job: Job, pool: Pool) -> dict[str, Array]:
        width, height = job.size
        table = filter_table(as_pixel_filter("box"))
        film = Film(job.size, table)
        plan = plan_of(job, table, samples=self.samples, pattern="blue-noise", depth=1)
        bent = np.zeros((height * width, 3))
        sky = SKY.pack(reach=checked_reach(self.max_distance), bent=bent)
        waves = [new_wave(_WAVE, scratch_words(moments[0].scene.arrays["fields"])) for _ in range(pool.threads)]

        def work(tile: Tile, thread: int, moment: int) -> None:
            occlusion_tile(moments[moment].scene.words, plan.words, sky.words, film.words, waves[thread].words, *tile)

        over_all = over_moments(work, film, plan, len(moments))
        trace_passes(over_all, film, Limits(self.samples), job, pool, "ambient occlusion", time.monotonic())
        visibility = film.mean()[..., 0].astype(np.float32)
        return {"visibility": visibility, "bent_normal": _normalised(bent.reshape(height, width, 3))}

    def _from_depth(self, job: Job, channels: dict[str, Array]) -> dict[str, Array]:
        camera = job.scene.camera
        if camera is None:
            raise RenderError("AmbientOcclusion: the scene has no camera")
        grey = np.ones((*job.size[::-1], 3), np.float32)
        seen = Image({"colour": grey, "depth": channels["depth"], "normal": channels["normal"]})
        radius = _REACH * extent_of(job.scene) if self.max_distance is None else self.max_distance
        samples = self.samples if self.by == "classic" else max(1, self.samples // (2 * _SLICES))
        open_sky = screen_occlusion(
            seen, camera, radius, by=self.by, samples=samples, slices=_SLICES, seed=job.seed, threads=job.threads
        )
        return {"visibility": open_sky}


def _normalised(bent: Array) -> Array:
    length = np.linalg.norm(bent, axis=2, keepdims=True)
    unit: Array = np.divide(bent, length, out=np.zeros_like(bent), where=length > 0).astype(np.float32)
    return unit
