"""Lines in space drawn over a picture, faint where surfaces are before them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow
from PIL import ImageDraw

from isophote.rendering.image import Image
from isophote.scene.camera import AnyCamera
from isophote.scene.colour import linear_to_srgb, srgb_to_linear

__all__ = ["Line", "overlaid"]

Points: TypeAlias = npt.NDArray[np.float64]

_FINER = 2
_PIECES = 48
_FAINT = 0.25
# How far behind a surface a place may be and still count as on it, in parts of its depth.
_ON = 2e-3
# Pixels beyond which nothing is drawn: drawing libraries take no huge numbers.
_OUTSIDE = 1e5


class Line(NamedTuple):
    """A line from one place to another: its sRGB colour, 0 to 255, and its width in pixels."""

    start: Points
    end: Points
    colour: tuple[int, int, int]
    width: float = 2.0


def overlaid(view: Image, camera: AnyCamera, lines: Iterable[Line], *, brightness: float = 0.6) -> Image:
    """`view`, made with `camera` and with its channel "depth", darkened by `brightness`, with lines over it."""
    size = view.size
    fine = (size[0] * _FINER, size[1] * _FINER)
    depth = np.repeat(np.repeat(view.channels["depth"].astype(np.float64), _FINER, axis=0), _FINER, axis=1)
    colour = np.clip(view.channels["colour"], 0, 1) * brightness
    picture = Pillow.fromarray(np.rint(linear_to_srgb(colour) * 255).astype(np.uint8))
    picture = picture.resize(fine, Pillow.Resampling.BICUBIC).convert("RGBA")
    layer = Pillow.new("RGBA", picture.size, (0, 0, 0, 0))
    pen = ImageDraw.Draw(layer)
    for line in lines:
        _draw(pen, camera, fine, depth, line)
    flat = Pillow.alpha_composite(picture, layer).convert("RGB").resize(size, Pillow.Resampling.LANCZOS)
    pixels = srgb_to_linear(np.asarray(flat) / 255.0).astype(np.float32)
    return view.with_(channels={**view.channels, "colour": pixels})


def _draw(pen: ImageDraw.ImageDraw, camera: AnyCamera, size: tuple[int, int], depth: Points, line: Line) -> None:
    """A line in pieces, and as few as can be: those that are seen alike are one."""
    along = np.linspace(0, 1, _PIECES + 1)[:, None]
    places, depths = camera.project(line.start + along * (line.end - line.start), size)
    middles, far = (places[1:] + places[:-1]) / 2, (depths[1:] + depths[:-1]) / 2
    with np.errstate(invalid="ignore"):
        drawn = np.isfinite(places).all(axis=1) & (np.abs(places).max(axis=1) < _OUTSIDE)
        drawn = drawn[1:] & drawn[:-1] & ((middles >= 0) & (middles < size)).all(axis=1)
    x, y = np.where(drawn[:, None], middles, 0).astype(np.int64).T
    behind = far > depth[y, x] * (1 + _ON)
    state = np.where(drawn, np.where(behind, 1, 2), 0)
    changes = np.flatnonzero(np.diff(state)) + 1
    for first, last in zip([0, *changes.tolist()], [*changes.tolist(), _PIECES], strict=True):
        if state[first]:
            opacity = _FAINT if state[first] == 1 else 1.0
            ends = [tuple(places[first].tolist()), tuple(places[last].tolist())]
            pen.line(ends, fill=(*line.colour, round(255 * opacity)), width=max(1, round(line.width * _FINER)))
