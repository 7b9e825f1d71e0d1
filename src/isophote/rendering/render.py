"""`render`: a shape or a scene into a picture."""

from __future__ import annotations

import warnings

from isophote import __version__
from isophote.errors import IsophoteWarning, RenderError
from isophote.lower.moments import lower_moments
from isophote.progress import ProgressLike, reporter
from isophote.rendering.denoise import can_be_denoised, checked_denoiser, denoised_colour
from isophote.rendering.features import PLACES, mean_features
from isophote.rendering.field_plot import FieldPlot
from isophote.rendering.image import Image
from isophote.rendering.method import Job, Method, Size, checked_seed, checked_size
from isophote.rendering.path_trace import PathTrace
from isophote.rendering.pixel_filter import as_pixel_filter
from isophote.rendering.pool import checked_threads
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
    denoise: bool | str = False,
) -> Image:
    """The picture of a shape or a scene, by a method (`PathTrace()` if none is given).

    A field in the plane is drawn with isolines, as a `FieldPlot` says; `seed`, `threads`, `denoise` do not matter then.
    A bare shape gets a camera that frames it, light and a ground; a scene without camera or light gets that.
    What moves while the camera's shutter is open, is blurred in "colour"; all other channels are of the middle of that
    time. `size` is (width, height) in pixels. The same `seed` gives the same picture for any number of `threads` (all
    processors if None). `progress`: True shows bars, False none, None shows them on a terminal; a function is
    called with (stage, fraction). Interrupting (Ctrl-C) returns the picture so far.

    `denoise` takes the noise out of the picture, as `Image.denoised` does but with features that are averaged over
    pixels: True by Open Image Denoise where it is installed, else by our own filter; "oidn" or "filter" by one of them.
    Our filter leaves pictures of methods that tell no variance as they are, with a warning.

    Raises `RenderError` for sizes, seeds and methods that make no sense, `SceneError` for scenes.
    """
    pixels = checked_size(size)
    number = checked_seed(seed)
    crew = checked_threads(threads)
    if isinstance(subject, Field2):
        return _plotted(subject, method, pixels, progress)
    chosen = PathTrace() if method is None else method
    if isinstance(chosen, type) or not hasattr(chosen, "render"):
        raise RenderError(f"method must be a rendering method such as PathTrace(samples=64), not {method!r}")
    denoiser = checked_denoiser(denoise)
    scene = studio(subject, aspect=pixels[0] / pixels[1])
    with reporter(progress) as report:
        image = chosen.render(Job(scene, pixels, number, crew, report))
        if denoiser is not None and not can_be_denoised(image.channels, denoiser):
            _warn_of_noise(chosen)
        elif denoiser is not None:
            report("denoising", 0.0)
            image = _denoised(image, scene, chosen, denoiser, crew)
            report("denoising", 1.0)
    metadata = {"Software": f"Isophote {__version__}", **image.metadata, "seed": str(seed)}
    if scene.name:
        metadata["scene"] = scene.name
    return image.with_(metadata=metadata)


def _warn_of_noise(method: Method) -> None:
    # What took long to make is not lost for it. At the call of iso.render.
    warnings.warn(
        f"{type(method).__name__} does not tell what is noise in its picture, so Isophote's filter leaves it as it is; "
        'Open Image Denoise needs no telling: pip install "isophote[denoise]"',
        IsophoteWarning,
        stacklevel=3,
    )


def _denoised(image: Image, scene: Scene, method: Method, denoiser: str, threads: int | None) -> Image:
    opened, closed = scene.shutter
    count = PLACES if scene.moves else 1
    times = [opened + (k + 0.5) / count * (closed - opened) for k in range(count)]
    tables = lower_moments(scene, image.size, times, threads, getattr(method, "accelerator", "bvh"))
    chosen = as_pixel_filter(getattr(method, "filter", "box"))
    features = mean_features(tables, image.size, chosen, threads)
    colour, by = denoised_colour(image.channels, features, denoiser=denoiser, threads=threads)
    return image.with_denoised(colour, by)


def _plotted(field: Field2, method: Method | FieldPlot | None, size: Size, progress: ProgressLike) -> Image:
    plot = FieldPlot() if method is None else method
    if not isinstance(plot, FieldPlot):
        raise RenderError(
            f"a field in the plane is drawn by FieldPlot, not by {method!r}; extrude or revolve it to make it a solid"
        )
    with reporter(progress) as report:
        image = plot.plot(field, size, report)
    return image.with_(metadata={"Software": f"Isophote {__version__}", **image.metadata})
