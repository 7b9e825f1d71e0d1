"""Ambient occlusion from the depth of a picture."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.light import screen_occlusion as kernels
from isophote.rendering.image import Image
from isophote.rendering.method import checked_seed
from isophote.rendering.pool import Pool
from isophote.scene.camera import AnyCamera, Camera

__all__ = ["screen_occlusion"]

Floats: TypeAlias = npt.NDArray[np.float32]

_WAYS = {"classic": kernels.classic_rows, "horizon": kernels.horizon_rows}
_ROWS_A_JOB = 16


def screen_occlusion(
    image: Image,
    camera: AnyCamera,
    radius: float,
    *,
    by: str = "horizon",
    samples: int = 16,
    slices: int = 4,
    seed: int = 0,
    threads: int | None = None,
) -> Floats:
    """(h, w) float32: how open the sky is above what a picture shows, 0 to 1, out of its depth and normals alone.

    `image` has the channels "depth" and "normal"; `camera` is the one that it was made with, with its lens's centre.
    What lies within `radius` metres counts. `by="horizon"` finds the horizon to both sides of `slices` through each
    pixel in `samples` steps and integrates the cosine below it, 1/π ∫ v cosθ dω; `by="classic"` counts which of
    `samples` points above the surface lie behind what is seen, but not so far behind that it is another thing, with
    `slices` unused. Pixels that show nothing are 1. What the picture does not show, blocks nothing.

    Raises `RenderError` for missing channels and numbers without meaning. Sources: Jiménez et al., "Practical Realtime
    Strategies for Accurate Indirect Occlusion", 2016; Mittring, "Finding Next Gen: CryEngine 2", 2007.
    """
    if by not in _WAYS:
        raise RenderError(f"screen_occlusion: by must be one of {', '.join(map(repr, _WAYS))}, not {by!r}")
    if isinstance(radius, bool) or not isinstance(radius, int | float | np.number) or not 0 < radius < np.inf:
        raise RenderError(f"screen_occlusion: radius must be a number of metres above 0, not {radius!r}")
    for name, number in {"samples": samples, "slices": slices}.items():
        if isinstance(number, bool) or not isinstance(number, int | np.integer) or not 1 <= number <= 4096:
            raise RenderError(f"screen_occlusion: {name} must be a whole number from 1 to 4096, not {number!r}")
    if not isinstance(image, Image):
        raise RenderError(f"screen_occlusion: image must be a picture that render made, not {image!r}")
    missing = {"depth", "normal"} - image.channels.keys()
    if missing:
        raise RenderError(
            f"screen_occlusion: the picture has no channel {', '.join(sorted(missing))}; render one that has it"
        )
    width, height = image.size
    places, normals = _in_camera(image, camera)
    found = np.ones((height, width), np.float32)
    screen = kernels.SCREEN.pack(
        places=places,
        normals=normals,
        open=found,
        width=width,
        height=height,
        radius=radius,
        samples=int(samples),
        slices=int(slices),
        seed=checked_seed(seed),
        **_projection(camera, (width, height)),
    )

    def work(first: int, thread: int) -> None:
        _WAYS[by](screen.words, first, min(first + _ROWS_A_JOB, height))

    pool = Pool(threads)
    pool.run(work, range(0, height, _ROWS_A_JOB), lambda done: None)
    if pool.interrupted:
        raise KeyboardInterrupt
    return found


def _in_camera(image: Image, camera: AnyCamera) -> tuple[Floats, Floats]:
    """Places and normals of all pixels in the camera's frame, (h, 3 w); NaN places where nothing is seen."""
    width, height = image.size
    rays = camera.linear_map(image.size)
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    depth = image.channels["depth"].astype(np.float64)
    depth = np.where(np.isfinite(depth), depth, np.nan)[..., None]
    origin = rays.o + x[..., None] * rays.ox + y[..., None] * rays.oy
    direction = rays.d + x[..., None] * rays.dx + y[..., None] * rays.dy
    axes = camera.axes.T
    places = (origin + depth * direction - np.array(camera.eye)) @ axes
    normals = image.channels["normal"].astype(np.float64) @ axes
    return _rows(places), _rows(normals)


def _rows(values: npt.NDArray[np.float64]) -> Floats:
    return np.ascontiguousarray(values.reshape(len(values), -1), np.float32)


def _projection(camera: AnyCamera, size: tuple[int, int]) -> dict[str, Any]:
    """How places fall on the film, as the kernels' table has it, from where the camera puts four of them."""
    perspective = isinstance(camera, Camera)
    right, up, back = camera.axes
    ahead = np.array(camera.eye) - back
    (cx, cy), (rx, _), (_, uy) = camera.project(np.stack([ahead, ahead + right, ahead + up]), size)[0]
    return {"perspective": int(perspective), "cx": cx, "cy": cy, "sx": 1 / (rx - cx), "sy": 1 / (cy - uy)}
