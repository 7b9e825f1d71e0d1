"""`show_tree`: the boxes of an accelerator, drawn around what it holds."""

from __future__ import annotations

import colorsys
from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import build_accelerator
from isophote.accel.cells import SHOWN, Edges, edges_of
from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError, RenderError
from isophote.rendering.image import Image
from isophote.rendering.method import Size, checked_size
from isophote.rendering.overlay import Line, overlaid
from isophote.rendering.pool import checked_threads
from isophote.rendering.ray_trace import RayTrace
from isophote.rendering.render import render
from isophote.scene.camera import AnyCamera
from isophote.scene.studio import studio
from isophote.shapes.mesh import Mesh

__all__ = ["show_tree"]

Points: TypeAlias = npt.NDArray[np.float64]

_DEEPEST = 64


def show_tree(
    mesh: Mesh,
    accelerator: str = "bvh",
    depth: int = 6,
    *,
    levels: Sequence[int] | None = None,
    camera: AnyCamera | None = None,
    size: Size = (640, 480),
    threads: int | None = None,
) -> Image:
    """The mesh with the boxes of the nodes of its tree, of all levels from the root, 0, to `depth`, or of `levels`.

    `accelerator` is "bvh", "bih" (which is built to the end first), "kdtree" (cells between planes), "bsp" (polyhedra
    between planes in any direction) or "grid" (cells that hold anything, and the grids within them).
    Levels go from blue through green to red; what lies behind the surface is faint. Levels of more than 8,192 boxes are
    left out; the picture's metadata tells how many boxes each has. Raises `RenderError` for depths without meaning and
    levels that are not there, `GeometryError` for other accelerators.
    """
    if not isinstance(mesh, Mesh):
        raise RenderError(f"show_tree shows the tree over a mesh's triangles, but this is a {type(mesh).__name__}")
    if isinstance(depth, bool) or not isinstance(depth, int | np.integer) or not 0 <= depth <= _DEEPEST:
        raise RenderError(f"show_tree: depth must be a whole number from 0 to {_DEEPEST}, not {depth!r}")
    pixels = checked_size(size)
    crew = checked_threads(threads)
    deepest = int(depth) if levels is None else max((int(depth), *(k for k in levels if _is_level(k))))
    found = _levels(mesh, accelerator, deepest, crew)
    chosen = range(len(found)) if levels is None else _chosen(levels, len(found), accelerator)
    scene = studio(mesh, aspect=pixels[0] / pixels[1])
    scene = scene if camera is None else scene.with_(camera=camera)
    view = render(scene, RayTrace(samples=4), size=pixels, progress=False, threads=threads)
    if scene.camera is None:
        raise RenderError("show_tree: there is no camera")
    image = overlaid(view, scene.camera, _lines(found, chosen))
    boxes = ", ".join(f"{level.cells}" for level in found)
    return image.with_(metadata={**view.metadata, "accelerator": accelerator, "boxes by level": boxes})


def _is_level(level: object) -> bool:
    return isinstance(level, int | np.integer) and not isinstance(level, bool) and 0 <= int(level) <= _DEEPEST


def _chosen(levels: Sequence[int], count: int, accelerator: str) -> list[int]:
    chosen = list(levels)
    missing = [k for k in chosen if not _is_level(k) or k >= count]
    if missing or not chosen:
        raise RenderError(
            f"show_tree: the {accelerator} has levels 0 to {count - 1}; levels must be some of them, not {levels!r}"
        )
    return chosen


def _levels(mesh: Mesh, accelerator: str, depth: int, threads: int | None) -> list[Edges]:
    if accelerator not in SHOWN:
        raise GeometryError(f"show_tree knows {', '.join(SHOWN)}, not {accelerator!r}")
    built = build_accelerator(accelerator, mesh.vertices.astype(np.float32), triangulate(mesh).triangles, threads)
    return edges_of(accelerator, built, depth)


def _lines(found: Sequence[Edges], chosen: Sequence[int]) -> Iterator[Line]:
    """Edges of boxes, thinner and redder from level to level; deep ones first, so that shallow ones lie over them."""
    for number in sorted(chosen, reverse=True):
        part = number / max(len(found) - 1, 1)
        red, green, blue = colorsys.hls_to_rgb(0.62 * (1 - part), 0.55, 0.85)
        colour = (round(255 * red), round(255 * green), round(255 * blue))
        width = max(2.5 * 0.75**number, 0.5)
        for start, end in found[number].ends:
            yield Line(start, end, colour, width)
