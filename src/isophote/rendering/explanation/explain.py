"""`explain`: the tree of rays behind one pixel."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from isophote.errors import RenderError
from isophote.progress import reporter
from isophote.rendering.explanation.text import names_of, written
from isophote.rendering.image import Image
from isophote.rendering.method import Job, Size, checked_seed, checked_size
from isophote.rendering.pool import checked_threads
from isophote.rendering.ray_log import LoggedRay, Triple, log_pixel
from isophote.rendering.ray_trace import RayTrace
from isophote.rendering.warm import warm_up
from isophote.scene.scene import Item, Scene, Shape
from isophote.scene.studio import studio

__all__ = ["Explanation", "explain"]


@attrs.frozen(repr=False)
class Explanation:
    """The rays of `pixel` (column, row) in a picture of `size` by `method`, and what each adds to its `colour`.

    `print` shows them as a tree; `data` is the same for programs, `picture` draws the rays in the scene. The colour of
    a ray is tint · (emitted + ambient + Σ colour of lights + Σ weight · colour of branches), the pixel's Σ weight ·
    colour of its camera rays; `added_up` is that sum, worked out again from the terms.
    """

    pixel: tuple[int, int]
    size: Size
    method: RayTrace
    seed: int
    colour: Triple
    rays: tuple[LoggedRay, ...]
    scene: Scene

    @property
    def added_up(self) -> Triple:
        """Σ weight · colour of the camera rays."""
        total = np.zeros(3)
        for ray in self.rays:
            if ray.parent < 0:
                total += np.array(ray.weight) * np.array(ray.colour)
        r, g, b = total.tolist()
        return r, g, b

    def data(self) -> dict[str, Any]:
        """All of it as dictionaries, lists, numbers and texts, as JSON has them: what is endless is None."""
        items, lights = names_of(self.scene)
        found: dict[str, Any] = {
            "pixel": list(self.pixel),
            "size": list(self.size),
            "method": repr(self.method),
            "seed": self.seed,
            "colour": list(self.colour),
            "rays": [_plain(attrs.asdict(ray)) for ray in self.rays],
            "items": items,
            "lights": lights,
        }
        return found

    def picture(self, size: Size = (800, 600), *, threads: int | None = None) -> Image:
        """The scene from aside, with the rays of the pixel drawn in: white the camera's, blue reflected, green
        refracted, grey straight on, yellow to lights that are seen and red to those that are not. What lies behind
        surfaces is faint."""
        from isophote.rendering.explanation.drawing import drawn

        return drawn(self.scene, self.rays, checked_size(size), threads)

    def __str__(self) -> str:
        return written(self.scene, self.pixel, self.size, self.method, self.colour, self.rays)

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        # What notebooks and IPython show.
        printer.text(str(self))

    def __repr__(self) -> str:
        return f"<Explanation of pixel {self.pixel}: {len(self.rays)} rays, colour {self.colour}>"


def explain(
    subject: Shape | Item | Scene,
    pixel: tuple[int, int] | None = None,
    *,
    method: RayTrace | None = None,
    size: Size = (640, 480),
    seed: int = 0,
    threads: int | None = None,
) -> Explanation:
    """Why a pixel of a picture by `RayTrace` has its colour: its rays, what they hit, each light's terms, the sum.

    `pixel` is (column, row) from the upper left, the middle of the picture if None. `method` defaults to
    `RayTrace(samples=1)`: one ray of the camera. The colour is that of the picture that `render` makes with the same
    method, size and seed. Raises `RenderError` for pixels outside the picture and for other methods.
    """
    chosen = RayTrace(samples=1) if method is None else method
    if not isinstance(chosen, RayTrace):
        raise RenderError(f"explain knows the rays of RayTrace, not those of {chosen!r}; give method=RayTrace(...)")
    pixels = checked_size(size)
    where = (pixels[0] // 2, pixels[1] // 2) if pixel is None else _checked_pixel(pixel)
    scene = studio(subject, aspect=pixels[0] / pixels[1])
    crew = checked_threads(threads)
    with reporter(None) as report:
        job = Job(scene, pixels, checked_seed(seed), crew, report)
        warm_up(report, scene, "ray")
        log = log_pixel(job, chosen, where)
    return Explanation(log.pixel, pixels, chosen, seed, log.colour, log.rays, scene)


def _checked_pixel(pixel: object) -> tuple[int, int]:
    place = np.asarray(pixel) if isinstance(pixel, tuple | list | np.ndarray) else np.zeros(0)
    if place.shape != (2,) or place.dtype.kind not in "iu":
        raise RenderError(f"pixel must be (column, row), two whole numbers, not {pixel!r}")
    return int(place[0]), int(place[1])


def _plain(value: Any) -> Any:
    """Values as JSON has them."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    return value
