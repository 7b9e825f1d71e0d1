"""Voronoi diagrams as drawings, and Fortune's sweep as a moving one."""

from __future__ import annotations

import colorsys
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow
from PIL import ImageDraw

from isophote.errors import FileError, RenderError
from isophote.io.files import check_writable, replacing, write_bytes
from isophote.io.picture_file import check_picture_path
from isophote.rendering.image import Image
from isophote.scene.colour import srgb_to_linear

if TYPE_CHECKING:
    from isophote.analysis.diagrams.events import SweepEvent
    from isophote.analysis.diagrams.result import Voronoi

__all__ = ["check_targets", "draw", "draw_sweep"]

FloatArray: TypeAlias = npt.NDArray[np.float64]

_MOVING = (".gif", ".webp", ".png")
_FINER = 3
_MOST_SIDE = 4096
_MARGIN = 0.02
_LINE, _SITE, _SWEEP, _BEACH, _PAPER = "#31353d", "#15171a", "#d1495b", "#2c6fbb", "#ffffff"
_GOLDEN = 0.6180339887498949
_MILLISECONDS, _LAST = 60, 1500
_STEPS = 24


def check_targets(output: Path | None, animation: Path | None, size: tuple[int, int]) -> None:
    """Raise the errors now that drawing would raise later."""
    if not 1 <= min(size) <= max(size) <= _MOST_SIDE:
        raise RenderError(f"pictures of diagrams are 1 to {_MOST_SIDE} pixels wide and high, not {size[0]}x{size[1]}")
    if output is not None:
        if output.suffix.lower() == ".svg":
            check_writable(output)
        else:
            check_picture_path(output)
    if animation is not None:
        if animation.suffix.lower() not in _MOVING:
            raise FileError(animation, f"moving pictures end in one of {', '.join(_MOVING)}")
        check_writable(animation)


class _Window:
    """Where points of the plane are in a picture, y upwards."""

    def __init__(self, bounds: FloatArray, size: tuple[int, int]) -> None:
        low, high = bounds.min(axis=0), bounds.max(axis=0)
        room = (1 - 2 * _MARGIN) * np.array(size)
        self.scale = float((room / np.maximum(high - low, np.finfo(np.float64).tiny)).min())
        self.middle, self.centre = (low + high) / 2, np.array(size) / 2
        self.size = size

    def __call__(self, points: FloatArray) -> list[tuple[float, float]]:
        placed = (points - self.middle) * self.scale * [1, -1] + self.centre
        # Drawing libraries take no endless numbers, and no huge ones.
        return [(x, y) for x, y in np.clip(np.nan_to_num(placed), -1e6, 1e6).tolist()]


def _tint(number: int) -> str:
    """A light colour for each site, different from those of near numbers."""
    red, green, blue = colorsys.hls_to_rgb(number * _GOLDEN % 1, 0.82, 0.55)
    return f"#{round(255 * red):02x}{round(255 * green):02x}{round(255 * blue):02x}"


def _dot(size: tuple[int, int], count: int) -> float:
    """The radius of a site's dot."""
    return float(np.clip(0.12 * np.sqrt(size[0] * size[1] / max(count, 1)), 0.4, 0.006 * min(size)))


def draw(found: Voronoi, output: Path, size: tuple[int, int]) -> None:
    """Draw cells and sites to an .svg or a picture."""
    if output.suffix.lower() == ".svg":
        write_bytes(output, _svg(found, size).encode())
        return
    canvas = _canvas(size)
    _draw_cells(ImageDraw.Draw(canvas), found, _Window(found.bounds, canvas.size), _FINER)
    pixels = np.asarray(canvas.resize(size, Pillow.Resampling.BOX))
    Image({"colour": srgb_to_linear(pixels / 255.0)}).save(output)


def _svg(found: Voronoi, size: tuple[int, int]) -> str:
    window = _Window(found.bounds, size)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]}" height="{size[1]}" '
        f'viewBox="0 0 {size[0]} {size[1]}">',
        f'<g stroke="{_LINE}" stroke-width="1" stroke-linejoin="round">',
    ]
    for number, cell in enumerate(found.cells):
        for piece in cell.pieces:
            corners = " ".join(f"{x:.3f},{y:.3f}" for x, y in window(piece))
            lines.append(f'<polygon points="{corners}" fill="{_tint(number)}"/>')
    lines += ["</g>", f'<g fill="{_SITE}">']
    radius = _dot(size, len(found.points))
    lines += [f'<circle cx="{x:.3f}" cy="{y:.3f}" r="{radius:.2f}"/>' for x, y in window(found.points)]
    return "\n".join([*lines, "</g>", "</svg>", ""])


def _canvas(size: tuple[int, int]) -> Pillow.Image:
    return Pillow.new("RGB", (size[0] * _FINER, size[1] * _FINER), _PAPER)


def _draw_cells(pen: Any, found: Voronoi, window: _Window, width: int) -> None:
    for number, cell in enumerate(found.cells):
        for piece in cell.pieces:
            corners = window(piece)
            pen.polygon(corners, fill=_tint(number))
            pen.line([*corners, corners[0]], fill=_LINE, width=width)
    _draw_sites(pen, found.points, window)


def _draw_sites(pen: Any, points: FloatArray, window: _Window) -> None:
    r = _dot(window.size, len(points))
    for x, y in window(points):
        pen.ellipse((x - r, y - r, x + r, y + r), fill=_SITE)


def draw_sweep(found: Voronoi, output: Path, size: tuple[int, int], most: int) -> int:
    """Draw Fortune's sweep as a moving picture of up to `most` frames, and the diagram last; returns how many."""
    window = _Window(found.bounds, (size[0] * _FINER, size[1] * _FINER))
    low, high = found.bounds.min(axis=0), found.bounds.max(axis=0)
    # Circles end later and later above; the last of them mean nothing to the eye.
    events = [event for event in found.replay() if event.y <= high[1] + (high[1] - low[1])]
    chosen = np.unique(np.linspace(0, max(len(events) - 1, 0), min(most, len(events))).round().astype(int)).tolist()
    trails = _trails(found)
    frames = [_frame(found, events[k], window, trails, size) for k in chosen]
    last = _canvas(size)
    _draw_cells(ImageDraw.Draw(last), found, window, _FINER)
    frames.append(last.resize(size, Pillow.Resampling.BOX))
    times = [_MILLISECONDS] * (len(frames) - 1) + [_LAST]
    with replacing(output) as temporary:
        frames[0].save(temporary, save_all=True, append_images=frames[1:], duration=times, loop=0)
    return len(frames)


def _trails(found: Voronoi) -> tuple[FloatArray, FloatArray]:
    """Points along all edges, (e, steps + 1, 2), and where the sweep line is when they are reached."""
    reach = 4 * float(np.ptp(found.bounds, axis=0).max())
    sites = found.points[found.edge_sites]
    start = np.where(found.edges[:, :1] >= 0, found.vertices[found.edges[:, 0]] if len(found.vertices) else 0.0, np.nan)
    end = np.where(found.edges[:, 1:] >= 0, found.vertices[found.edges[:, 1]] if len(found.vertices) else 0.0, np.nan)
    middle = sites.mean(axis=1)
    away = reach * found.directions
    end = np.where(np.isnan(end), np.where(np.isnan(start), middle, start) + away, end)
    start = np.where(np.isnan(start), middle - away, start)
    t = np.linspace(0, 1, _STEPS + 1)[:, None]
    # Long ends reach far out of the picture: steps that grow keep those near the start short.
    t = np.where(np.linalg.norm(end - start, axis=1)[:, None, None] > reach / 4, t**3, t)
    points = start[:, None] + t * (end - start)[:, None]
    when = points[..., 1] + np.linalg.norm(points - sites[:, :1], axis=2)
    return points, when


def _frame(
    found: Voronoi, event: SweepEvent, window: _Window, trails: tuple[FloatArray, FloatArray], size: tuple[int, int]
) -> Pillow.Image:
    canvas = _canvas(size)
    pen = ImageDraw.Draw(canvas)
    points, when = trails
    for trail, times in zip(points, when, strict=True):
        drawn = (times[1:] <= event.y) & (times[:-1] <= event.y)
        places = window(trail)
        for k in np.flatnonzero(drawn):
            pen.line((places[k], places[k + 1]), fill=_LINE, width=_FINER)
    _draw_sites(pen, found.points, window)
    low, high = found.bounds.min(axis=0), found.bounds.max(axis=0)
    x = np.linspace(low[0], high[0], window.size[0] // 2)
    beach = np.stack([x, np.maximum(event.beach(x), low[1] - 1.0)], axis=1)
    pen.line(window(beach), fill=_BEACH, width=2 * _FINER)
    (ax, y), (bx, _) = window(np.array([(low[0], event.y), (high[0], event.y)]))
    pen.line((ax, y, bx, y), fill=_SWEEP, width=2 * _FINER)
    return canvas.resize(size, Pillow.Resampling.BOX)
