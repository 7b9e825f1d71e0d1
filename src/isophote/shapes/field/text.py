"""Text: lines of glyphs by their true outlines."""

from __future__ import annotations

import os
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field.data import OutlineData
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.flat import FlatForm
from isophote.shapes.field.font_files import find_font
from isophote.shapes.field.form import Box, number_spelled
from isophote.shapes.field.numbers import positive_number
from isophote.shapes.field.outline import outline_data

__all__ = ["Text"]

Floats: TypeAlias = npt.NDArray[np.float64]

# Which part of a line's width stands left of x = 0.
_ALIGN = {"left": 0.0, "centre": 0.5, "right": 1.0}
_MOST_CHARACTERS = 20_000


def _checked_string(form: Any, attribute: Any, value: Any) -> None:
    if not isinstance(value, str):
        raise GeometryError(f"text: string must be a str, but is {value!r}")
    if len(value) > _MOST_CHARACTERS:
        raise GeometryError(f"text: {len(value):,} characters are more than {_MOST_CHARACTERS:,}; make several texts")
    if not value.strip():
        raise GeometryError(f"text: {value!r} draws nothing, and a field needs an inside")


def _checked_align(form: Any, attribute: Any, value: Any) -> None:
    if value not in _ALIGN:
        raise GeometryError(f'text: align must be "left", "centre" or "right", but is {value!r}')


def _as_name(font: str | os.PathLike[str] | None) -> str | None:
    if font is not None and not isinstance(font, str | os.PathLike):
        raise GeometryError(f"text: font must be a path or a name, but is {font!r}")
    return None if font is None else os.fspath(font)


@attrs.frozen(repr=False)
class Text(FlatForm):
    """Lines of text; the first one's baseline is y = 0, an em is `size` long, baselines are `leading` ems apart."""

    string: str = attrs.field(validator=_checked_string)
    font: str | None = attrs.field(default=None, converter=_as_name)
    size: float = positive_number(default=1.0)
    align: str = attrs.field(default="left", validator=_checked_align)
    leading: float = positive_number(default=1.2)

    def __attrs_post_init__(self) -> None:
        _ = self.data

    @cached_property
    def data(self) -> OutlineData:
        """The outline of the text with ems of length 1; the same object for equal texts."""
        path = find_font(self.font)
        return _text_data(self.string, path, path.stat().st_mtime_ns, self.align, float(self.leading))

    def expression(self, p: Point) -> Value:
        size = p.number(self.size)
        x, y = p.x / size, p.y / size
        return p.bounded(p.graph.apply("OUTLINE", x, y, constant=self.data) * size, 1.0)

    @property
    def bounds(self) -> Box:
        box: Box = self.data.bounds * float(self.size)
        return box

    def spelled(self) -> str:
        plain = Text(self.string)
        names = ("font", "size", "align", "leading")
        changed = ((name, getattr(self, name)) for name in names if getattr(self, name) != getattr(plain, name))
        return f"text({', '.join([repr(self.string), *(f'{k}={number_spelled(v)}' for k, v in changed)])})"


@lru_cache(maxsize=64)
def _text_data(string: str, path: Path, stamp: int, align: str, leading: float) -> OutlineData:
    # Here, for reading fonts takes a while to load, and most fields hold no text.
    from isophote.shapes.field.font import load_font

    font = load_font(path)
    lines = string.expandtabs(4).split("\n")
    missing = sorted({c for line in lines for c in line if not font.has(c)})
    if missing:
        shown = ", ".join(f"{c!r} (U+{ord(c):04X})" for c in missing[:8])
        raise GeometryError(f"text: {path.name} has no glyph for {shown}; choose another font=")
    loops: list[Floats] = []
    for number, line in enumerate(lines):
        starts, width = _places(font, line)
        left = -_ALIGN[align] * width
        for character, start in zip(line, starts, strict=True):
            offset = np.tile([left + start, -leading * number], 3)
            loops += [loop + offset for loop in font.glyph(character).loops]
    if not loops:
        raise GeometryError(f"text: {string!r} draws nothing, and a field needs an inside")
    return outline_data(loops, "text")


def _places(font: Any, line: str) -> tuple[list[float], float]:
    """Where each character of a line starts, and the line's width, in ems."""
    starts, x = [], 0.0
    for number, character in enumerate(line):
        if number > 0:
            x += font.kerning(line[number - 1], character)
        starts.append(x)
        x += font.glyph(character).advance
    return starts, x
