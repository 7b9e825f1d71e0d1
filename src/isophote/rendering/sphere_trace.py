"""Sphere tracing as a method."""

from __future__ import annotations

import math
import time
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace import sphere_lights, sphere_trace
from isophote.kernels.trace.sphere_march import MARCH_ROWS
from isophote.kernels.trace.sphere_pixels import PIXEL_ROWS
from isophote.kernels.trace.sphere_tables import MARCH, SHADOW_WORDS, SPHERE_PICTURE
from isophote.kernels.trace.sphere_trace import sphere_trace_tile
from isophote.lower.field_table import scratch_words
from isophote.lower.scene import lower_scene
from isophote.rendering.darkness import warn_if_dark
from isophote.rendering.image import Image
from isophote.rendering.left_out import warn_of_left_out
from isophote.rendering.method import Array, Job, Size, extent_of
from isophote.rendering.oddities import warn_of_oddities
from isophote.rendering.pool import Pool, Tile, tiles_of
from isophote.rendering.stills import over_shutter
from isophote.rendering.warm import warm_up
from isophote.scene.light import AreaLight, DiskLight, Light, PointLight, RectLight, SphereLight, Sun
from isophote.scene.spot_light import SpotLight

__all__ = ["SphereTrace"]

Floats: TypeAlias = npt.NDArray[np.float32]

_SHADOWS = {"none": sphere_trace.NO_SHADOWS, "hard": sphere_trace.HARD, "soft": sphere_trace.SOFT}
_MARCHERS = ("sphere", "fixed")
_LIGHTS = PointLight | SpotLight | Sun | AreaLight
_TILE = 32
# Where none is given: the fixed step and the reach of occlusion, in parts of the finite items' diagonal.
_STEP, _REACH = 1 / 256, 1 / 12


def _one_of(names: Any) -> Any:
    def check(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
        if value not in names:
            raise RenderError(f"SphereTrace: {attribute.name} must be one of {', '.join(names)}, not {value!r}")

    return check


def _number(wanted: str, least: float, most: float = math.inf, *, above: bool = False) -> Any:
    def check(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
        right = isinstance(value, int | float | np.number) and not isinstance(value, bool)
        if not right or not least <= value <= most or (above and value == least):  # type: ignore[operator]
            raise RenderError(f"SphereTrace: {attribute.name} must be {wanted}, not {value!r}")

    return check


_positive = attrs.validators.optional(_number("a number above 0, or None", 0.0, above=True))


def _steps(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not 1 <= value <= 1_000_000:
        raise RenderError(f"SphereTrace: {attribute.name} must be a whole number from 1 to 1,000,000, not {value!r}")


@attrs.frozen
class SphereTrace:
    """Sphere tracing of signed distance fields, with the look of real-time renderers.

    A ray goes on by the field's value over its Lipschitz constant, times `relaxation` (1 to 2; where two spheres do not
    overlap it goes back), until the surface is nearer than `epsilon` times the pixel's width there, `max_steps` are
    taken through a field or `max_distance` is reached. `marcher="fixed"` goes on by `step` metres instead, and steps
    over what is thinner. Shadows are "soft", "hard" or "none"; a soft one is told by how near the ray to the light's
    middle passes (area lights have their size; points and suns are seen under the half angle atan `softness`).
    `occlusion` is how far above the surface, in metres, the field is asked what dims the sky; 0 for no occlusion.

    What moves while the shutter is open is the mean of 16 pictures of what stands still.

    All surfaces reflect like matte ones of their base colour, with normal maps and bumps. Meshes are drawn, and shadow
    hard. What is cut out is seen where it is at least half there; its shadow is hard, and lighter by 1 − α. The channel
    "steps" counts the evaluations of the field along each pixel's ray.
    """

    max_steps: int = attrs.field(default=512, validator=_steps)
    max_distance: float | None = attrs.field(default=None, validator=_positive)
    relaxation: float = attrs.field(default=1.3, validator=_number("a number from 1 to 2", 1.0, 2.0))
    epsilon: float = attrs.field(default=0.25, validator=_number("a number above 0", 0.0, above=True))
    marcher: str = attrs.field(default="sphere", validator=_one_of(_MARCHERS))
    step: float | None = attrs.field(default=None, validator=_positive)
    shadows: str = attrs.field(default="soft", validator=_one_of(_SHADOWS))
    softness: float = attrs.field(default=0.05, validator=_number("a number from 0 to 1", 0.0, 1.0))
    occlusion: float | None = attrs.field(
        default=None, validator=attrs.validators.optional(_number("a number, 0 or above, or None", 0.0))
    )

    def __attrs_post_init__(self) -> None:
        if self.step is not None and self.marcher != "fixed":
            raise RenderError('SphereTrace: step is the length of fixed steps; give marcher="fixed" too')

    def render(self, job: Job) -> Image:
        """The sphere-traced picture."""
        warn_if_dark(job.scene)
        warn_of_oddities(job.scene)
        warn_of_left_out(job.scene, "SphereTrace")
        warm_up(job.report, job.scene, "sphere")
        return over_shutter(self._still, job)

    def _still(self, job: Job) -> Image:
        began = time.monotonic()
        job.report("building the tree", 0.0)
        scene = lower_scene(job.scene, job.size, job.threads, marched=True)
        job.report("building the tree", 1.0)
        channels = _channels(job.size)
        march = self._march(job, scene)
        pool = Pool(job.threads)
        words = scratch_words(scene.arrays["fields"])
        pictures = [_picture(channels, job.size, words) for _ in range(pool.threads)]

        def work(tile: Tile, thread: int) -> None:
            sphere_trace_tile(scene.words, march.words, pictures[thread].words, *tile)

        tiles = tiles_of(job.size, _TILE)
        pool.run(work, tiles, lambda done: job.report("sphere tracing", done / len(tiles)))
        metadata = {"method": repr(self), "seconds": f"{time.monotonic() - began:.3f}"}
        if pool.interrupted:
            metadata["stopped"] = "interrupted before all pixels were traced"
        for channel in channels.values():
            # What nobody can write to, a picture shares instead of copying it.
            channel.flags.writeable = False
        return Image(channels, metadata)

    def _march(self, job: Job, scene: Packed) -> Packed:
        size = extent_of(job.scene)
        step = 0.0 if self.marcher == "sphere" else self.step or _STEP * size
        return MARCH.pack(
            max_steps=self.max_steps,
            max_distance=np.inf if self.max_distance is None else self.max_distance,
            relaxation=self.relaxation,
            epsilon=self.epsilon,
            step=step,
            shadows=_SHADOWS[self.shadows],
            light_width=self.softness,
            occlusion=_REACH * size if self.occlusion is None else self.occlusion,
            lights=_lights(job.scene.lights),
            **_hole_entries(scene),
        )


def _channels(size: Size) -> dict[str, Array]:
    width, height = size
    return {
        "colour": np.zeros((height, width, 3), np.float32),
        "depth": np.full((height, width), np.inf, np.float32),
        "distance": np.full((height, width), np.inf, np.float32),
        "normal": np.zeros((height, width, 3), np.float32),
        "albedo": np.zeros((height, width, 3), np.float32),
        "uv": np.zeros((height, width, 2), np.float32),
        "item": np.full((height, width), -1, np.int32),
        "primitive": np.full((height, width), -1, np.int32),
        "steps": np.zeros((height, width), np.int32),
    }


def _picture(channels: dict[str, Array], size: Size, words: int) -> Packed:
    flat = {name: array.reshape(size[1], -1) for name, array in channels.items()}
    return SPHERE_PICTURE.pack(
        **flat,
        scratch=np.zeros(words, np.float32),
        lanes=np.zeros(16 * MARCH_ROWS, np.float32),
        pixels=np.zeros(16 * PIXEL_ROWS, np.float32),
        shadow=np.zeros(SHADOW_WORDS, np.float32),
    )


def _hole_entries(scene: Packed) -> dict[str, int]:
    if not scene.arrays["materials"].arrays["pass_holes"]:
        return {"pass_holes": 0, "light_left": 0}
    # Loaded, and compiled, where there is something to look through.
    from isophote.kernels.trace.sphere_holes import sphere_left, sphere_pass

    return {"pass_holes": sphere_pass.address, "light_left": sphere_left.address}


def _lights(lights: tuple[Light, ...]) -> Floats:
    """The table of lights in sphere_lights.py's columns; skies are looked up by themselves."""
    rows = [_light(light) for light in lights if isinstance(light, _LIGHTS)]
    return np.array(rows, np.float32).reshape(-1, sphere_lights.COLUMNS)


def _light(light: PointLight | SpotLight | Sun | AreaLight) -> tuple[float, ...]:
    nowhere = (0.0, 0.0, 0.0)
    if isinstance(light, PointLight):
        return (sphere_lights.POINT, *light.position, *nowhere, *light.intensity_rgb, 0.0, 0.0, 0.0)
    if isinstance(light, SpotLight):
        shape = *light.cosines, light.exponent
        return (sphere_lights.SPOT, *light.position, *light.unit_axis, *light.intensity_rgb, *shape)
    if isinstance(light, Sun):
        return (sphere_lights.SUN, *light.unit_direction, *nowhere, *light.irradiance_rgb, 0.0, 0.0, 0.0)
    if isinstance(light, SphereLight):
        area = math.pi * light.radius**2
        intensity = tuple(area * value for value in light.radiance_rgb)
        return (sphere_lights.ROUND, *light.position, *nowhere, *intensity, light.radius, 0.0, 0.0)
    intensity = tuple(light.area * value for value in light.radiance_rgb)
    normal = (-light.transform.matrix[:3, 1]).tolist()
    two_sided = isinstance(light, RectLight | DiskLight) and light.two_sided
    radius = math.sqrt(light.area / math.pi)
    return (sphere_lights.FLAT, *light.position, *normal, *intensity, radius, float(two_sided), 0.0)
