"""Tables of measured reflectance in the format of MERL's database.

Three int32, 90, 90 and 180, then float64, all little-endian: red, then green, then blue, each over θ_h, θ_d and φ_d, to
be multiplied by 1/1500, 1.15/1500 and 1.66/1500. Source: Matusik et al.: "A Data-Driven Reflectance Model", SIGGRAPH
2003.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from isophote.errors import FileError
from isophote.io.files import StrPath, write_bytes
from isophote.io.source import read_source
from isophote.scene.measured import MEASURED_SHAPE, Measured

__all__ = ["load_brdf", "save_brdf"]

_HEADER = np.dtype("<i4")
_VALUE = np.dtype("<f8")
_SCALES = np.array([1.0, 1.15, 1.66]) / 1500
_CELLS = math.prod(MEASURED_SHAPE)
_ENDING = ".binary"


def load_brdf(path: StrPath) -> Measured:
    """The measured reflectance in a file of MERL's format (.binary, also packed by gzip).

    Raises `FileError` where it is no such file, is of another resolution, cut short, or holds values that are not
    finite.
    """
    place = Path(path)
    data = read_source(place)
    if len(data) < 3 * _HEADER.itemsize:
        raise FileError(path, f"has {len(data)} bytes, too few for a table of reflectance")
    size = tuple(int(n) for n in np.frombuffer(data, _HEADER, 3))
    if size != MEASURED_SHAPE[:3]:
        raise FileError(path, f"begins with {size}, where a table in MERL's format has {MEASURED_SHAPE[:3]}", "byte 0")
    body = len(data) - 3 * _HEADER.itemsize
    if body != _CELLS * _VALUE.itemsize:
        wanted = 3 * _HEADER.itemsize + _CELLS * _VALUE.itemsize
        raise FileError(path, f"has {len(data):,} bytes and should have {wanted:,}; fetch the file again")
    stored = np.frombuffer(data, _VALUE, offset=3 * _HEADER.itemsize)
    finite = np.isfinite(stored)
    if not finite.all():
        bad = int(np.argmin(finite))
        raise FileError(path, f"value {stored[bad]} is not finite", f"byte {3 * 4 + 8 * bad}")
    values = np.moveaxis(stored.reshape(3, *MEASURED_SHAPE[:3]), 0, -1) * _SCALES
    if np.abs(values).max() > np.finfo(np.float32).max:
        raise FileError(path, "holds values beyond single precision, which are no reflectance")
    return Measured(values.astype(np.float32), name=place.name.removesuffix(".gz").removesuffix(_ENDING))


def save_brdf(thing: Measured, path: StrPath) -> None:
    """Write a table in MERL's format; see `load_brdf`. Raises `FileError` for other endings than .binary."""
    if Path(path).suffix.lower() != _ENDING:
        raise FileError(path, f"measured reflectance is saved to {_ENDING}, MERL's format")
    header = np.array(MEASURED_SHAPE[:3], _HEADER).tobytes()
    stored = np.moveaxis(thing.values / _SCALES, -1, 0)
    write_bytes(path, header + np.ascontiguousarray(stored, _VALUE).tobytes())
