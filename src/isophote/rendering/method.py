"""What a rendering method is, and what is the same for all: sizes, seeds, what the camera sees first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import ACCELERATORS, REFERENCE
from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace.first_hit import FEATURES, first_hits
from isophote.lower.field_table import scratch_words
from isophote.progress import Reporter
from isophote.rendering.image import Image
from isophote.rendering.pool import Pool
from isophote.scene.scene import Scene

__all__ = ["Job", "Method", "checked_accelerator", "checked_seed", "checked_size", "extent_of", "first_hit_channels"]

Array: TypeAlias = npt.NDArray[Any]
Size: TypeAlias = tuple[int, int]

_MOST_PIXELS = 2**28
_ROWS_A_JOB = 16


@attrs.frozen
class Job:
    """A picture to be made: what a `Method` is given."""

    scene: Scene
    size: Size
    seed: int
    threads: int | None
    report: Reporter


class Method(Protocol):
    """A way to render: a frozen value with its settings."""

    def render(self, job: Job) -> Image:
        """The picture of `job.scene`."""


def checked_accelerator(name: object) -> str:
    """`name`, if it is that of an accelerator. Raises `RenderError`."""
    if name not in (*ACCELERATORS, REFERENCE):
        raise RenderError(f"accelerator must be one of {', '.join(ACCELERATORS)}, not {name!r}")
    return str(name)


def checked_size(size: object) -> Size:
    """`size` as (width, height) in pixels, both 1 or more. Raises `RenderError`."""
    try:
        width, height = (int(n) for n in size)  # type: ignore[attr-defined]
        whole = tuple(size) == (width, height)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise RenderError(f"size must be (width, height) in pixels, not {size!r}") from None
    if not whole or width < 1 or height < 1:
        raise RenderError(f"size must be two whole numbers of 1 or more, (width, height), not {size!r}")
    if width * height > _MOST_PIXELS:
        raise RenderError(
            f"{width} × {height} pixels are more than {_MOST_PIXELS:,}; render tiles of the picture instead"
        )
    return width, height


def checked_seed(seed: object) -> int:
    """`seed` folded to 32 bits. Raises `RenderError` for anything but whole numbers."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise RenderError(f"seed must be a whole number, not {seed!r}")
    number = int(seed) % 2**64
    return (number ^ (number >> 32)) & 0xFFFFFFFF


def first_hit_channels(
    scene: Packed,
    size: Size,
    pool: Pool,
    place: tuple[float, float, float, float] = (0.5, 0.5, 0.0, 0.0),
    samples: int = 1,
) -> Mapping[str, Array]:
    """Channels of what is seen at one place in each pixel, the centre if none is given; see `Image`.

    `place` is (x, y) from the pixel's upper left corner, and a point (a, b) of the lens, in the unit disk; textures
    are filtered as for one of so many `samples` of a pixel.
    """
    width, height = size
    channels: dict[str, Array] = {
        "depth": np.full((height, width), np.inf, np.float32),
        "distance": np.full((height, width), np.inf, np.float32),
        "normal": np.zeros((height, width, 3), np.float32),
        "albedo": np.zeros((height, width, 3), np.float32),
        "uv": np.zeros((height, width, 2), np.float32),
        "item": np.full((height, width), -1, np.int32),
        "primitive": np.full((height, width), -1, np.int32),
    }
    flat = {name: array.reshape(height, -1) for name, array in channels.items()}
    words = scratch_words(scene.arrays["fields"])
    at = dict(zip(("film_x", "film_y", "lens_a", "lens_b"), place, strict=True))
    features = [
        FEATURES.pack(**flat, **at, samples=samples, scratch=np.zeros(words, np.float32)) for _ in range(pool.threads)
    ]

    def work(first: int, thread: int) -> None:
        first_hits(scene.words, features[thread].words, width, first, min(first + _ROWS_A_JOB, height))

    pool.run(work, range(0, height, _ROWS_A_JOB), lambda count: None)
    return channels


def extent_of(scene: Scene) -> float:
    """Diagonal of what is finite in the scene, without what is flat as a ground; 1 where nothing is."""
    boxes = [item.bounds for item in scene.items]
    solid = [box for box in boxes if np.isfinite(box).all() and (box[1] > box[0]).all()]
    if not solid:
        return 1.0
    return float(np.linalg.norm(np.max([b[1] for b in solid], axis=0) - np.min([b[0] for b in solid], axis=0)))
