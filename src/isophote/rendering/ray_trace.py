"""Ray tracing after Whitted as a method."""

from __future__ import annotations

import time
from typing import Any

import attrs
import numpy as np

from isophote.errors import RenderError
from isophote.rendering.darkness import warn_if_dark
from isophote.rendering.exposure import expose
from isophote.rendering.image import Image
from isophote.rendering.left_out import warn_of_left_out
from isophote.rendering.method import Job, checked_accelerator, first_hit_channels
from isophote.rendering.oddities import warn_of_oddities
from isophote.rendering.passes import MOST_SAMPLES, PATTERNS, Limits, trace_passes
from isophote.rendering.pixel_filter import PixelFilter, pixel_filter
from isophote.rendering.pool import Pool
from isophote.rendering.ray_tiles import RayTiles
from isophote.rendering.settings import one_of, optional_positive, optional_whole, whole
from isophote.rendering.warm import warm_up

__all__ = ["RayTrace"]

_SAMPLES = 16
_MOST_DEPTH = 256


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

    `shadows` are "opaque": glass shadows like any other surface, as in `PathTrace`, where light that comes through
    glass is met by chance only. With "tinted" shadow rays go straight on through clear things, as if these did not bend
    them, and keep what those let through; no light is gathered to caustics.

    `samples` trees of each pixel (16, or as many as it takes where `seconds` or `noise` is given) smooth edges;
    `filter`, `pattern`, `seconds`, `noise` and `accelerator` are those of `PathTrace`. The channel "rays" counts
    the rays of each pixel, shadow rays included. The same seed gives the same bits on every machine of one kind,
    whatever the threads and tiles.

    Source: Whitted, "An improved illumination model for shaded display", CACM 23(6), 1980; Cook, Porter, Carpenter,
    "Distributed ray tracing", SIGGRAPH 1984.
    """

    depth: int = attrs.field(default=6, validator=whole(1, _MOST_DEPTH))
    samples: int | None = attrs.field(default=None, validator=optional_whole(1, MOST_SAMPLES))
    light_samples: int = attrs.field(default=4, validator=whole(1, 4096))
    min_weight: float = attrs.field(default=1e-3, validator=_weight)
    shadows: str = attrs.field(default="opaque", validator=one_of(("opaque", "tinted")))
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
        warn_if_dark(job.scene)
        warn_of_oddities(job.scene)
        warn_of_left_out(job.scene, "RayTrace")
        warm_up(job.report, job.scene, "ray", self.accelerator)
        began = time.monotonic()
        job.report("building the tree", 0.0)
        moments, middle = expose(job, self.accelerator)
        job.report("building the tree", 1.0)
        pool = Pool(job.threads)
        tiles = RayTiles(self, moments, job, pool.threads)
        film, rays = tiles.film, tiles.rays
        trace_passes(tiles.trace, film, self.limits, job, pool, "ray tracing", began, tiles.edge)
        channels = first_hit_channels(middle, job.size, Pool(job.threads))
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
