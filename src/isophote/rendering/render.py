"""`render`: a shape or a scene into a picture."""

from __future__ import annotations

from isophote import __version__
from isophote.errors import RenderError
from isophote.progress import ProgressLike, reporter
from isophote.rendering.image import Image
from isophote.rendering.method import Job, Method, Size, checked_seed, checked_size
from isophote.rendering.path_trace import PathTrace
from isophote.scene.scene import Item, Scene, Shape
from isophote.scene.studio import studio

__all__ = ["render"]


def render(
    subject: Shape | Item | Scene,
    method: Method | None = None,
    *,
    size: Size = (640, 480),
    seed: int = 0,
    progress: ProgressLike = None,
    threads: int | None = None,
) -> Image:
    """The picture of a shape or a scene, by a method (`PathTrace()` if none is given).

    A bare shape gets a camera that frames it, light and a ground; a scene without camera or light gets that.
    `size` is (width, height) in pixels. The same `seed` gives the same picture for any number of `threads` (all
    processors if None). `progress`: True shows bars, False none, None shows them on a terminal; a function is
    called with (stage, fraction). Interrupting (Ctrl-C) returns the picture so far.

    Raises `RenderError` for sizes, seeds and methods that make no sense, `SceneError` for scenes.
    """
    pixels = checked_size(size)
    number = checked_seed(seed)
    chosen = PathTrace() if method is None else method
    if isinstance(chosen, type) or not hasattr(chosen, "render"):
        raise RenderError(f"method must be a rendering method such as PathTrace(samples=64), not {method!r}")
    scene = studio(subject, aspect=pixels[0] / pixels[1])
    with reporter(progress) as report:
        image = chosen.render(Job(scene, pixels, number, threads, report))
    metadata = {"Software": f"Isophote {__version__}", **image.metadata, "seed": str(seed)}
    if scene.name:
        metadata["scene"] = scene.name
    return image.with_(metadata=metadata)
