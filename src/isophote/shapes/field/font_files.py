"""Where fonts are: files by their path, their name, or the first of some that most machines have."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from isophote.errors import FileError, GeometryError

__all__ = ["find_font", "font_folders"]

# Sans serif fonts that come with one system or another; each has all of Latin, Greek and Cyrillic.
_USUAL = (
    "DejaVuSans",
    "LiberationSans-Regular",
    "NotoSans-Regular",
    "Arial",
    "Helvetica",
    "FreeSans",
    "Ubuntu-R",
    "Cantarell-Regular",
    "OpenSans-Regular",
    "Roboto-Regular",
    "SegoeUI",
)
_ENDINGS = (".ttf", ".otf", ".ttc", ".otc")
_REMEDY = "give font= the path of a .ttf or .otf file, or install a font such as DejaVu Sans (package fonts-dejavu)"


def font_folders() -> list[Path]:
    """The folders in which this system keeps fonts, the user's own first."""
    home = Path.home()
    if sys.platform == "win32":
        own = Path(os.environ.get("LOCALAPPDATA", home / "AppData/Local")) / "Microsoft/Windows/Fonts"
        return [own, Path(os.environ.get("WINDIR", "C:/Windows")) / "Fonts"]
    if sys.platform == "darwin":
        return [home / "Library/Fonts", Path("/Library/Fonts"), Path("/System/Library/Fonts")]
    data = os.environ.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share"
    own = Path(os.environ.get("XDG_DATA_HOME") or home / ".local/share")
    return [own / "fonts", home / ".fonts", *(Path(part) / "fonts" for part in data.split(":") if part)]


def find_font(font: str | os.PathLike[str] | None) -> Path:
    """The file of a font: a path, a name such as "DejaVu Sans Bold", or None for a usual one.

    Raises `FileError` for a path where no file is, `GeometryError` where no font of the name is installed, or none.
    """
    if font is None:
        if (found := _first(tuple(map(_plain, _USUAL)))) is not None:
            return found
        places = ", ".join(map(str, font_folders()))
        raise GeometryError(f"text: none of the usual fonts is installed in {places}; {_REMEDY}")
    path = Path(font)
    if path.suffix.lower() in _ENDINGS or isinstance(font, os.PathLike) or len(path.parts) > 1:
        if not path.is_file():
            raise FileError(path, "there is no such font file", "text")
        return path.resolve()
    name = _plain(str(font))
    found = _first((name, name + "regular")) or _by_full_name(name)
    if found is None:
        raise GeometryError(f"text: no font named {str(font)!r} is installed; {_REMEDY}")
    return found


def _plain(name: str) -> str:
    """A name without what spellings differ in: case, blanks and hyphens."""
    return "".join(c for c in name.lower() if c.isalnum())


def _files() -> Iterator[Path]:
    for folder in font_folders():
        if folder.is_dir():
            yield from sorted(p for p in folder.rglob("*") if p.suffix.lower() in _ENDINGS)


@lru_cache(maxsize=1)
def _stems() -> dict[str, Path]:
    stems: dict[str, Path] = {}
    for path in _files():
        stems.setdefault(_plain(path.stem), path)
    return stems


def _first(names: tuple[str, ...]) -> Path | None:
    """The first font whose file has one of these names."""
    for _ in range(2):
        stems = _stems()
        path = next((stems[name] for name in names if name in stems), None)
        if path is not None and path.is_file():
            return path
        # Fonts may have come or gone since the folders were read.
        _stems.cache_clear()
    return None


def _by_full_name(name: str) -> Path | None:
    """The font that calls itself so: its family, or its family and style."""
    from fontTools.ttLib import TTFont, TTLibError

    for path in _stems().values():
        try:
            with TTFont(path, fontNumber=0, lazy=True) as font:
                names = [_plain(font["name"].getDebugName(number) or "") for number in (1, 2, 4, 6)]
        except (TTLibError, OSError, KeyError, ValueError):
            continue
        if name in (names[0], names[0] + names[1], *names[2:]):
            return path
    return None
