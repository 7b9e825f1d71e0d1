"""`isophote render`: a scene or a model into a picture."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from isophote.cli.messages import log, print_json
from isophote.cli.methods import METHODS, new_method
from isophote.cli.options import FILTERS, FORM_FACTORS, PATTERNS, SOLVERS, WAYS, one_of, picture_size, shutter_of

if TYPE_CHECKING:
    from isophote.cli.subject import Subject
    from isophote.rendering.image import Image
    from isophote.scene.scene import Scene

__all__ = ["EXAMPLES", "render"]

EXAMPLES = """\b
Examples:
  isophote render examples/cornell_box.py -o cornell.png
  isophote render bunny.obj -o bunny.png --size 800x800 --samples 256
  isophote render truck.glb -o truck.exr --noise 0.02 --denoise
  isophote render room.py -o room.png --seconds 30 --max-depth 16 --seed 7
  isophote render wheel.py -o wheel.png --shutter 0,0.02
  isophote render glasses.py -o glasses.png --method ray --depth 10 --light-samples 16
  isophote render room.py -o room.png --method radiosity --patch 0.05 --error 0.005
  isophote render room.py -o room.png --method radiosity --solver shooting --form-factors hemicube --patch 0.2
  isophote render bunny.obj -o occlusion.png --method occlusion --max-distance 0.5

\b
A Python file defines the picture's `scene`, or a `shape`:
  import isophote as iso
  scene = iso.Scene([iso.Item(iso.load_mesh("bunny.obj"), iso.Matte("tomato"))])

What has no camera or light gets one. .exr keeps all channels and full range; other endings keep 8-bit colours. Ctrl-C
stops early and keeps the picture so far.
"""


def render(
    scene: Annotated[
        Path,
        typer.Argument(
            metavar="SCENE", help="A Python file that defines `scene` or `shape`, a glTF, an OBJ or any mesh file."
        ),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="The picture: .png, .exr, .jpg, .webp, .tif or .bmp.")
    ],
    method: Annotated[
        str, typer.Option(metavar="|".join(METHODS), callback=one_of(METHODS), help="How to render.")
    ] = "path",
    samples: Annotated[
        int | None,
        typer.Option(metavar="N", help="Paths, or trees of rays, a pixel.  [default: 64; ray and radiosity: 16]"),
    ] = None,
    seconds: Annotated[float | None, typer.Option(metavar="S", help="Stop after this time.")] = None,
    noise: Annotated[
        float | None,
        typer.Option(
            metavar="X", help="Sample where it is noisy, until the noise, in parts of the brightness, is below X."
        ),
    ] = None,
    max_depth: Annotated[int | None, typer.Option(metavar="N", help="Rays a path at most.  [default: 8]")] = None,
    depth: Annotated[
        int | None, typer.Option(metavar="N", help="Rays in a row at most, by --method ray.  [default: 6]")
    ] = None,
    light_samples: Annotated[
        int | None, typer.Option(metavar="N", help="Shadow rays to each light with a size.  [default: 4]")
    ] = None,
    filter_name: Annotated[
        str | None,
        typer.Option(
            "--filter",
            metavar="|".join(FILTERS),
            callback=one_of(FILTERS),
            help="Reconstruction filter.  [default: box]",
        ),
    ] = None,
    pattern: Annotated[
        str | None,
        typer.Option(
            metavar="|".join(PATTERNS),
            callback=one_of(PATTERNS),
            help="Where samples lie in a pixel, on lights and so on.  [default: blue-noise]",
        ),
    ] = None,
    denoise: Annotated[
        bool, typer.Option("--denoise", help="Take the noise out, by Open Image Denoise where it is installed.")
    ] = False,
    accelerator: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="What finds what rays meet: bvh, grid, kdtree, bih, bsp.  [default: bvh]"),
    ] = None,
    by: Annotated[
        str | None,
        typer.Option(
            metavar="|".join(WAYS),
            callback=one_of(WAYS),
            help="--method occlusion: by random rays, or from the picture's depth by horizons or the classic way.  "
            "[default: rays]",
        ),
    ] = None,
    max_distance: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            help="--method occlusion: how far away things still shut the sky out, in metres; sphere: how far rays are "
            "followed.  [default: without end; from depth, an eighth of the scene]",
        ),
    ] = None,
    patch: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            help="--method radiosity: finest edge of a patch, in metres.  [default: a hundredth of the scene]",
        ),
    ] = None,
    error: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            help="--method radiosity: patches and links are refined until each is off by less than X, in parts of the "
            "mean light.  [default: 0.01]",
        ),
    ] = None,
    residual: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            help="--method radiosity: light bounces until no patch changes by more than X, in parts of the brightest, "
            "or until shooting has only X of it left.  [default: 0.0001]",
        ),
    ] = None,
    solver: Annotated[
        str | None,
        typer.Option(
            metavar="|".join(SOLVERS),
            callback=one_of(SOLVERS),
            help="--method radiosity: links between clusters and patches; or between all pairs of even patches, bounce "
            "by bounce, or the brightest patch first.  [default: hierarchical]",
        ),
    ] = None,
    form_factors: Annotated[
        str | None,
        typer.Option(
            metavar="|".join(FORM_FACTORS),
            callback=one_of(FORM_FACTORS),
            help="--solver gathering or shooting: what patches see of each other, by rays between each two, or by "
            "--directions from each through the pixels of a half cube or a hemisphere.  [default: rays]",
        ),
    ] = None,
    directions: Annotated[
        int | None,
        typer.Option(metavar="N", help="--form-factors hemicube or hemisphere: rays from each patch.  [default: 4096]"),
    ] = None,
    max_links: Annotated[
        int | None,
        typer.Option(
            metavar="N", help="--method radiosity: links at most, or form factors; bounds memory.  [default: 50000000]"
        ),
    ] = None,
    shutter: Annotated[
        str | None,
        typer.Option(metavar="T,T", help="When the camera's shutter opens and closes, in seconds, instead of its own."),
    ] = None,
    size: Annotated[str, typer.Option(metavar="WxH", help="Width and height in pixels.")] = "640x480",
    seed: Annotated[int, typer.Option(metavar="N", help="The same seed gives the same picture.")] = 0,
    threads: Annotated[
        int | None, typer.Option(metavar="N", help="Threads to render with.  [default: all processors]")
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Fail where a texture or material is missing, instead of replacing it.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
    backend: Annotated[
        str, typer.Option(metavar="auto|cpu", callback=one_of(("auto", "cpu")), help="What to compute on.")
    ] = "auto",
) -> None:
    """Render a scene or a model into a picture."""
    del backend  # Every method runs on the processor, whichever of the two is asked for.
    width, height = picture_size(size)
    times = None if shutter is None else shutter_of(shutter)
    settings = {
        "samples": samples,
        "seconds": seconds,
        "noise": noise,
        "max_depth": max_depth,
        "depth": depth,
        "light_samples": light_samples,
        "filter": filter_name,
        "pattern": pattern,
        "accelerator": accelerator,
        "by": by,
        "max_distance": max_distance,
        "patch": patch,
        "error": error,
        "residual": residual,
        "solver": solver,
        "form_factors": form_factors,
        "directions": directions,
        "max_links": max_links,
    }
    from isophote.cli.progress import progress
    from isophote.cli.subject import load_subject
    from isophote.io.picture_file import check_picture_path
    from isophote.rendering.method import checked_size
    from isophote.rendering.pool import Pool
    from isophote.rendering.render import render as render_image

    # All that can be wrong without the scene is said before it is read.
    check_picture_path(output)
    chosen = new_method(method, settings)
    pixels = checked_size((width, height))
    Pool(threads)
    target = output.resolve()
    began = time.monotonic()
    subject = load_subject(scene, strict=strict)
    if times is not None:
        subject = _exposed(subject, times, width / height)
    image = render_image(subject, chosen, size=pixels, seed=seed, progress=progress(), threads=threads, denoise=denoise)
    image.save(target)
    _report(output, image, time.monotonic() - began, as_json)


def _exposed(subject: Subject, times: tuple[float, float], aspect: float) -> Scene:
    """A subject, with a camera whose shutter is open at the times."""
    from isophote.scene.studio import studio

    scene = studio(subject, aspect=aspect)
    return scene if scene.camera is None else scene.with_(camera=scene.camera.with_(shutter=times))


def _report(output: Path, image: Image, seconds: float, as_json: bool) -> None:
    width, height = image.size
    details = dict(image.metadata)
    if as_json:
        rendering = float(details.pop("seconds")) if "seconds" in details else None
        facts = {"output": str(output), "size": [width, height], "backend": "cpu", "total_seconds": round(seconds, 3)}
        print_json({**facts, "rendering_seconds": rendering, **details, "stopped": details.get("stopped")})
    else:
        samples = f", {details['samples']} samples a pixel" if "samples" in details else ""
        typer.echo(f"{output}: {width} × {height} pixels{samples}, {seconds:.1f} s")
    if "stopped" in details:
        log(f"{details['stopped']}; the picture so far is in {output}")
        raise typer.Exit(1)
