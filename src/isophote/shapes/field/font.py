"""Fonts: the outlines of their glyphs as quadratic arcs, advance widths and kerning."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt
from fontTools.cu2qu import curve_to_quadratic
from fontTools.pens.basePen import BasePen
from fontTools.ttLib import TTFont, TTLibError

from isophote.errors import FileError

__all__ = ["CUBIC_TOLERANCE", "Font", "Glyph", "load_font"]

Floats: TypeAlias = npt.NDArray[np.float64]

# How far, in ems, quadratic arcs may be from the cubic ones of an OpenType font that they stand for.
CUBIC_TOLERANCE = 1e-4

# What readers of damaged tables run into.
_DAMAGED = (
    TTLibError,
    struct.error,
    zlib.error,
    LookupError,
    ValueError,
    TypeError,
    AttributeError,
    AssertionError,
    ArithmeticError,
    EOFError,
    OSError,
    RecursionError,
)


class _ArcPen(BasePen):  # type: ignore[misc]
    """Keeps what is drawn as loops of arcs, flat lists of six numbers each."""

    def __init__(self, glyph_set: Any, tolerance: float) -> None:
        super().__init__(glyph_set)
        self.loops: list[list[float]] = []
        self._tolerance = tolerance
        self._start: tuple[float, float] = (0.0, 0.0)

    def _moveTo(self, point: Any) -> None:  # noqa: N802
        self.loops.append([])
        self._start = point

    def _lineTo(self, point: Any) -> None:  # noqa: N802
        (x, y), (u, v) = self._getCurrentPoint(), point
        if (x, y) != (u, v):
            self.loops[-1] += [x, y, (x + u) / 2, (y + v) / 2, u, v]

    def _qCurveToOne(self, control: Any, point: Any) -> None:  # noqa: N802
        self.loops[-1] += [*self._getCurrentPoint(), *control, *point]

    def _curveToOne(self, first: Any, second: Any, point: Any) -> None:  # noqa: N802
        start = self._getCurrentPoint()
        spline = curve_to_quadratic([start, first, second, point], self._tolerance)
        # Ends between control points are implied, half way.
        controls = np.array(spline[1:-1])
        ends = [start, *((controls[:-1] + controls[1:]) / 2), point]
        for a, control, b in zip(ends[:-1], controls, ends[1:], strict=True):
            self.loops[-1] += [*a, *control, *b]

    def _closePath(self) -> None:  # noqa: N802
        self._lineTo(self._start)

    def _endPath(self) -> None:  # noqa: N802
        self._lineTo(self._start)


@contextmanager
def _refusing(path: Path) -> Iterator[None]:
    """What goes wrong in reading a damaged font becomes a `FileError`."""
    try:
        yield
    except _DAMAGED as error:
        raise FileError(path, f"the font cannot be read: {error or type(error).__name__}", "text") from error


@attrs.frozen(eq=False)
class Glyph:
    """Closed loops of arcs, (k, 6) each, and the advance width, in ems."""

    loops: tuple[Floats, ...]
    advance: float


class Font:
    """A font file, opened; all lengths are in ems. Raises `FileError` where the file is no font with outlines."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with _refusing(path):
            self._font = TTFont(path, fontNumber=0, lazy=True)
            self._unit = 1 / float(self._font["head"].unitsPerEm)
            self._names: dict[int, str] = self._font.getBestCmap() or {}
            self._glyph_set = self._font.getGlyphSet()
        if not any(table in self._font for table in ("glyf", "CFF ", "CFF2")):
            raise FileError(path, "the font has no outlines, only pictures; use another font", "text")
        self._glyphs: dict[str, Glyph] = {}
        self._kerns: dict[tuple[str, str], float] = {}

    def has(self, character: str) -> bool:
        """Whether the font draws a character."""
        return ord(character) in self._names

    def glyph(self, character: str) -> Glyph:
        """What a character looks like."""
        name = self._names[ord(character)]
        if name not in self._glyphs:
            with _refusing(self.path):
                self._glyphs[name] = self._read(name)
        return self._glyphs[name]

    def _read(self, name: str) -> Glyph:
        pen = _ArcPen(self._glyph_set, CUBIC_TOLERANCE / self._unit)
        drawn = self._glyph_set[name]
        drawn.draw(pen)
        loops = tuple(np.array(loop, np.float64).reshape(-1, 6) * self._unit for loop in pen.loops if loop)
        return Glyph(loops, float(drawn.width) * self._unit)

    def kerning(self, left: str, right: str) -> float:
        """How much farther apart two characters stand than their advance widths say; mostly less than 0."""
        pair = self._names[ord(left)], self._names[ord(right)]
        if pair not in self._kerns:
            with _refusing(self.path):
                self._kerns[pair] = self._kern(*pair) * self._unit
        return self._kerns[pair]

    def _kern(self, left: str, right: str) -> float:
        if self._pair_lookups is not None:
            return sum(_adjusted(lookup, left, right) for lookup in self._pair_lookups)
        if "kern" not in self._font:
            return 0.0
        tables = (t for t in self._font["kern"].kernTables if hasattr(t, "kernTable"))
        return float(sum(table.kernTable.get((left, right), 0) for table in tables))

    @cached_property
    def _pair_lookups(self) -> list[list[Any]] | None:
        """Subtables of each lookup of the feature "kern" in GPOS, for the default script; None without any."""
        if "GPOS" not in self._font:
            return None
        table = self._font["GPOS"].table
        if table.ScriptList is None or table.FeatureList is None or table.LookupList is None:
            return None
        numbers: set[int] = set()
        scripts = {record.ScriptTag: record.Script for record in table.ScriptList.ScriptRecord}
        script = scripts.get("latn") or scripts.get("DFLT") or next(iter(scripts.values()), None)
        if script is None or script.DefaultLangSys is None:
            return None
        for index in script.DefaultLangSys.FeatureIndex:
            record = table.FeatureList.FeatureRecord[index]
            if record.FeatureTag == "kern":
                numbers.update(record.Feature.LookupListIndex)
        lookups = [_pair_tables(table.LookupList.Lookup[number]) for number in sorted(numbers)]
        return lookups if any(lookups) else None


def _pair_tables(lookup: Any) -> list[Any]:
    """A lookup's tables of pairs; those of kind 9 are pointers to others."""
    tables = [t.ExtSubTable if t.LookupType == 9 else t for t in lookup.SubTable]
    return [t for t in tables if t.LookupType == 2]


def _adjusted(tables: list[Any], left: str, right: str) -> float:
    """What the first table that knows the pair adds to the advance."""
    for table in tables:
        if left not in table.Coverage.glyphs:
            continue
        if table.Format == 1:
            pairs = table.PairSet[table.Coverage.glyphs.index(left)].PairValueRecord
            record = next((pair for pair in pairs if pair.SecondGlyph == right), None)
        else:
            row = table.Class1Record[table.ClassDef1.classDefs.get(left, 0)]
            record = row.Class2Record[table.ClassDef2.classDefs.get(right, 0)]
        if record is not None:
            return float(getattr(record.Value1, "XAdvance", 0) or 0) if record.Value1 else 0.0
    return 0.0


@lru_cache(maxsize=16)
def _loaded(path: Path, stamp: int) -> Font:
    return Font(path)


def load_font(path: Path) -> Font:
    """The font in a file, read once until the file changes."""
    return _loaded(path, path.stat().st_mtime_ns)
