"""Measured indices of refraction, as refractiveindex.info has them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, SceneError
from isophote.io.files import StrPath
from isophote.io.source import read_source
from isophote.scene.metal import Metal
from isophote.scene.spectrum import rgb_of_spectrum

__all__ = ["load_metal"]

_TABLE = re.compile(r"^\s*-?\s*type:\s*[\"']?([\w ]+?)[\"']?\s*$")
_DATA = re.compile(r"^\s*data:\s*[|>]")


def load_metal(path: StrPath, roughness: Any = 0.3, **rest: Any) -> Metal:
    """A `Metal` by a .yml file of refractiveindex.info: wavelengths in µm, n and k; `rest` is as there.

    The table must be of type "tabulated nk", or there must be one of "tabulated n" and one of "tabulated k", and reach
    from 0.4 to 0.7 µm. Raises `FileError` where it does not, and for files that are not such.
    """
    tables = _tables(path, read_source(Path(path)).decode("utf-8", "replace").splitlines())
    try:
        n, k = (_channel(tables, wanted) for wanted in ("n", "k"))
    except SceneError as error:
        raise FileError(path, str(error)) from error
    if n is None or k is None:
        raise FileError(path, f"has no table of {'n' if n is None else 'k'}; Metal needs n and k by wavelength")
    try:
        return Metal((n, k), roughness, **rest)
    except SceneError as error:
        raise FileError(path, f"this is no metal: {error}") from error


def _channel(tables: dict[str, npt.NDArray[np.float64]], wanted: str) -> Any:
    """n or k for red, green and blue; None where there is no table of it."""
    if "nk" in tables:
        rows = tables["nk"]
        return rgb_of_spectrum(1000 * rows[:, 0], rows[:, 1 if wanted == "n" else 2])
    if wanted not in tables:
        return None
    return rgb_of_spectrum(1000 * tables[wanted][:, 0], tables[wanted][:, 1])


def _tables(path: StrPath, lines: list[str]) -> dict[str, npt.NDArray[np.float64]]:
    """The tables of a file by what they hold: "nk", "n", "k"."""
    found: dict[str, npt.NDArray[np.float64]] = {}
    kind = ""
    for number, line in enumerate(lines):
        named = _TABLE.match(line)
        if named:
            kind = named[1].removeprefix("tabulated ") if named[1].startswith("tabulated ") else ""
        elif kind and _DATA.match(line):
            found[kind] = _rows(path, lines, number + 1, len(kind) + 1)
    return found


def _rows(path: StrPath, lines: list[str], first: int, columns: int) -> npt.NDArray[np.float64]:
    """The rows of numbers from a line on, as far as there are any."""
    rows = []
    for number in range(first, len(lines)):
        parts = lines[number].split()
        if not parts:
            continue
        try:
            row = [float(part) for part in parts]
        except ValueError:
            break
        if len(row) != columns:
            raise FileError(path, f"there should be {columns} numbers, not {len(row)}", f"line {number + 1}")
        rows.append(row)
    if not rows:
        raise FileError(path, "the table is empty", f"line {first}")
    return np.array(rows)
