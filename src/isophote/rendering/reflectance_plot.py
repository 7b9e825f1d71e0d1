"""Reflectance drawn as lobes: how much light a material sends where."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow
from PIL import ImageDraw, ImageFont

from isophote.errors import RenderError
from isophote.lower.probe import Probe
from isophote.rendering.image import Image
from isophote.rendering.method import checked_size
from isophote.scene.colour import srgb_to_linear
from isophote.scene.material_base import Material
from isophote.scene.measured import Measured

__all__ = ["brdf_plot"]

Floats: TypeAlias = npt.NDArray[Any]
Ink: TypeAlias = tuple[int, int, int]

# Each pixel is drawn as so many by so many.
_FINER = 3
_PAPER, _GRID, _TEXT = (255, 255, 255), (214, 218, 224), (70, 76, 86)
_INKS: tuple[Ink, ...] = ((31, 95, 153), (42, 140, 108), (214, 142, 30), (200, 66, 54), (122, 78, 156), (90, 90, 90))
_DIRECTIONS = 7201
# Reflectances that differ by more than this are drawn on a scale of powers of ten.
_WIDE = 30.0
_MOST_ANGLES = len(_INKS)
_LEAST_SIZE = 200


class _Scale(NamedTuple):
    """From reflectance to radius, 0 to 1, and the rings that are drawn."""

    largest: float
    logarithmic: bool
    rings: tuple[float, ...]

    def radius(self, value: Floats) -> Floats:
        share = np.maximum(value, 0.0) / self.largest
        if not self.logarithmic:
            return share
        least = self.rings[0] / self.largest / 10
        found: Floats = np.maximum(np.log(np.maximum(share, least) / least) / -math.log(least), 0.0)
        return found


def brdf_plot(
    material: Material, angles_degrees: Sequence[float] = (0.0, 30.0, 60.0, 80.0), size: tuple[int, int] = (640, 420)
) -> Image:
    """A picture of a `material`'s lobes in the plane of incidence, a colour for each angle between light and normal.

    From the middle of the picture, where the surface is, each curve is as far as the reflectance f in that direction,
    mean of the channels, per steradian: linear, or on a scale of powers of ten where it spans many; rings tell values.
    What goes through the surface is drawn below it. Arrows are single directions, with their share of the light. `size`
    is (width, height) in pixels, 200 or more each way. Raises `RenderError` for angles beyond 0 to 89.9, more than six
    of them, and for what is no material.
    """
    if not isinstance(material, Material):
        raise RenderError(f"brdf_plot: give a material, such as a Metal, not {material!r}")
    checked = _checked_angles(angles_degrees)
    width, height = checked_size(size)
    if min(width, height) < _LEAST_SIZE:
        raise RenderError(f"brdf_plot: size must be {_LEAST_SIZE} pixels or more each way, not {width} × {height}")
    probe = Probe(material)
    lobes = [_lobe(probe, angle) for angle in checked]
    page = _Page(width, height, below=_goes_through(probe, lobes))
    scale = _scale_of(lobes)
    page.grid(scale)
    for ink, angle, (around, values) in zip(_INKS, checked, lobes, strict=False):
        page.curve(around, scale.radius(values), ink)
        page.incoming(angle, ink)
        for into, share in _single(probe, angle):
            page.arrow(math.atan2(into[0], into[2]), share, ink)
    page.title(material, checked)
    return Image({"colour": page.pixels()}, {"plot": "f by direction, per steradian", "material": repr(material)[:400]})


def _checked_angles(angles: Any) -> tuple[float, ...]:
    try:
        given = tuple(float(angle) for angle in angles)
    except (TypeError, ValueError):
        raise RenderError(f"brdf_plot: angles_degrees must be a list of numbers, not {angles!r}") from None
    if not 1 <= len(given) <= _MOST_ANGLES or not all(0 <= angle <= 89.9 for angle in given):
        raise RenderError(
            f"brdf_plot: angles_degrees must be 1 to {_MOST_ANGLES} numbers from 0 to 89.9, but are {given}"
        )
    return given


def _out(angle: float) -> Floats:
    """Where light comes from: left of the normal."""
    return np.array([-math.sin(math.radians(angle)), 0.0, math.cos(math.radians(angle))])


def _lobe(probe: Probe, angle: float) -> tuple[Floats, Floats]:
    """Angles from the normal, to the right, and f there, all around the plane of incidence."""
    around = np.linspace(-np.pi, np.pi, _DIRECTIONS)
    into = np.stack([np.sin(around), 0 * around, np.cos(around)], 1)
    found = probe.evaluate(_out(angle), into).value.mean(axis=1)
    cosine = np.abs(into[:, 2])
    return around, np.where(cosine > 1e-3, found / np.maximum(cosine, 1e-3), 0.0)


def _single(probe: Probe, angle: float) -> list[tuple[Floats, float]]:
    found = [probe.branch(_out(angle), k) for k in range(probe.branches)]
    return [(one.into[0], float(one.value.mean())) for one in found if one.value.any()]


def _goes_through(probe: Probe, lobes: list[tuple[Floats, Floats]]) -> bool:
    through = any(values[np.abs(around) > np.pi / 2 + 1e-3].any() for around, values in lobes)
    return through or any(into[2] < 0 for into, _ in _single(probe, 0.0))


def _scale_of(lobes: list[tuple[Floats, Floats]]) -> _Scale:
    largest = max(float(values.max()) for _, values in lobes)
    if not largest > 0:
        return _Scale(1.0, False, ())
    seen = np.concatenate([values[values > 0] for _, values in lobes])
    if largest > _WIDE * float(np.median(seen)):
        top = math.ceil(math.log10(largest))
        return _Scale(largest, True, tuple(10.0**k for k in range(max(top - 5, -2), top)))
    step = 10.0 ** math.floor(math.log10(largest / 2))
    step *= next(k for k in (1, 2, 5) if largest / (k * step) <= 4.5 or k == 5)
    return _Scale(largest, False, tuple(step * k for k in range(1, int(largest / step) + 1)))


def _short(material: Material) -> str:
    """A material with what is not as usual, in few digits."""
    if isinstance(material, Measured):
        return repr(material)
    values = [(field, getattr(material, field.name)) for field in attrs.fields(type(material))]  # type: ignore[arg-type]
    given = [f"{field.name}={value!r}" for field, value in values if value != field.default]
    text = f"{type(material).__name__}({', '.join(given)})"
    return re.sub(r"\d+\.\d+", lambda number: f"{float(number[0]):.3g}", text)


class _Page:
    """The drawing; lengths in pixels of the picture."""

    def __init__(self, width: int, height: int, below: bool) -> None:
        self._size = width, height
        self._picture = Pillow.new("RGB", (width * _FINER, height * _FINER), _PAPER)
        self._draw = ImageDraw.Draw(self._picture)
        self._below = below
        text = max(10.0, height / 30)
        self._line = text * 1.5
        self._font = ImageFont.load_default(text * _FINER)
        room = height - 3.2 * self._line
        self._reach = min(width / 2 - 2 * text, room / 2 if below else room)
        middle = 2.2 * self._line + self._reach
        self._middle = width / 2, middle

    def _at(self, around: Floats, radius: Floats) -> list[tuple[float, float]]:
        x = (self._middle[0] + self._reach * radius * np.sin(around)) * _FINER
        y = (self._middle[1] - self._reach * radius * np.cos(around)) * _FINER
        return list(zip(x.tolist(), y.tolist(), strict=True))

    def _stroke(self, points: list[tuple[float, float]], ink: Ink, width: float) -> None:
        self._draw.line(points, ink, max(round(width * _FINER), 1), joint="curve")

    def _write(self, x: float, y: float, text: str, ink: Ink, anchor: str) -> None:
        self._draw.text((x * _FINER, y * _FINER), text, ink, self._font, anchor)

    def grid(self, scale: _Scale) -> None:
        """The surface, its normal, directions every thirty degrees, and rings of equal reflectance."""
        half = np.pi if self._below else np.pi / 2
        around = np.linspace(-half, half, 361)
        for value in (*scale.rings, scale.largest):
            radius = scale.radius(np.full(len(around), value))
            if radius[0] > 0.02:
                self._stroke(self._at(around, radius), _GRID, 1)
        for degrees in range(-150 if self._below else -60, 151 if self._below else 61, 30):
            self._stroke(self._at(np.full(2, math.radians(degrees)), np.array([0.0, 1.0])), _GRID, 1)
        self._stroke(self._at(np.array([-np.pi / 2, np.pi / 2]), np.array([1.0, 1.0])), _TEXT, 1.5)
        for value in scale.rings:
            far = float(scale.radius(np.array([value]))[0])
            if far > 0.1:
                self._write(self._middle[0] + far * self._reach, self._middle[1] + 3, f"{value:g}", _TEXT, "ma")

    def curve(self, around: Floats, radius: Floats, ink: Ink) -> None:
        """One lobe."""
        if radius.any():
            self._stroke(self._at(around, radius), ink, 1.8)

    def incoming(self, angle: float, ink: Ink) -> None:
        """Where light comes from: a short line at the rim."""
        self._stroke(self._at(np.full(2, -math.radians(angle)), np.array([0.93, 1.04])), ink, 3.5)

    def arrow(self, around: float, share: float, ink: Ink) -> None:
        """A single direction, as long as its share of the light."""
        tip = max(share, 0.04)
        self._stroke(self._at(np.full(2, around), np.array([0.0, tip])), ink, 2.2)
        head = self._at(
            np.array([around, around - 0.06, around + 0.06]), np.array([tip + 0.04, tip - 0.03, tip - 0.03])
        )
        self._draw.polygon(head, ink)

    def title(self, material: Material, angles: tuple[float, ...]) -> None:
        """What is drawn, and the colours of the angles."""
        text = _short(material)
        room = int(self._size[0] / self._line * 2.6)
        self._write(self._line / 2, self._line / 3, text if len(text) <= room else text[: room - 1] + "…", _TEXT, "la")
        x = self._line / 2
        for ink, angle in zip(_INKS, angles, strict=False):
            label = f"{angle:g}°"
            self._write(x, 1.25 * self._line, label, ink, "la")
            x += self._font.getlength(label) / _FINER + self._line

    def pixels(self) -> npt.NDArray[np.float32]:
        """Linear colours (h, w, 3)."""
        fine = srgb_to_linear(np.asarray(self._picture, np.float32) / np.float32(255))
        width, height = self._size
        linear: npt.NDArray[np.float32] = fine.reshape(height, _FINER, width, _FINER, 3).mean(axis=(1, 3))
        return linear.astype(np.float32)
