"""`render`: a shape or a scene into a picture."""

from __future__ import annotations

from isophote import __version__
from isophote.errors import RenderError
from isophote.progress import ProgressLike, reporter
from isophote.rendering.field_plot import FieldPlot
from isophote.rendering.image import Image
from isophote.rendering.method import Job, Method, Size, checked_seed, checked_size
from isophote.rendering.path_trace import PathTrace
from isophote.scene.scene import Item, Scene, Shape
from isophote.scene.studio import studio
from isophote.shapes.field.field2 import Field2

__all__ = ["render"]


def render(
    subject: Shape | Item | Scene | Field2,
    method: Method | FieldPlot | None = None,
    *,
    size: Size = (640, 480),
    seed: int = 0,
    progress: ProgressLike = None,
    threads: int | None = None,
) -> Image:
    """The picture of a shape or a scene, by a method (`PathTrace()` if none is given).

    A field in the plane is drawn with isolines, as a `FieldPlot` says; neither `seed` nor `threads` matter then.
    A bare shape gets a camera that frames it, light and a ground; a scene without camera or light gets that.
    `size` is (width, height) in pixels. The same `seed` gives the same picture for any number of `threads` (all
    processors if None). `progress`: True shows bars, False none, None shows them on a terminal; a function is
    called with (stage, fraction). Interrupting (Ctrl-C) returns the picture so far.

    Raises `RenderError` for sizes, seeds and methods that make no sense, `SceneError` for scenes.
    """
    pixels = checked_size(size)
    number = checked_seed(seed)
    if isinstance(subject, Field2):
        return _plotted(subject, method, pixels, progress)
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


def _plotted(field: Field2, method: Method | FieldPlot | None, size: Size, progress: ProgressLike) -> Image:
    plot = FieldPlot() if method is None else method
    if not isinstance(plot, FieldPlot):
        raise RenderError(
            f"a field in the plane is drawn by FieldPlot, not by {method!r}; extrude or revolve it to make it a solid"
        )
    with reporter(progress) as report:
        image = plot.plot(field, size, report)
    return image.with_(metadata={"Software": f"Isophote {__version__}", **image.metadata})
