"""PNG pictures: linear colour in, 8-bit sRGB out, with the making of the picture as text."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from io import BytesIO
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow
from PIL.PngImagePlugin import PngInfo

from isophote.errors import FileError, IsophoteWarning
from isophote.io.files import StrPath, write_bytes
from isophote.io.srgb import to_srgb_bytes

__all__ = ["display_bytes", "encode_png", "write_png"]

_MAGENTA = (255, 0, 255)


def write_png(path: StrPath, colour: npt.NDArray[np.floating[Any]], metadata: Mapping[str, str] | None = None) -> None:
    """Write a picture as an 8-bit sRGB PNG, whole or not at all.

    `colour` is (h, w, 3) linear, or (h, w, 4) with straight alpha, which is stored without the curve.
    Values are clipped to [0, 1] and rounded to the nearest level; NaN shows as magenta, with an
    `IsophoteWarning`. `metadata` is stored as tEXt, or iTXt where Latin-1 does not suffice. Raises
    `FileError` for empty pictures, keys that PNG cannot hold and files that cannot be written.
    """
    try:
        data = encode_png(colour, metadata)
    except ValueError as error:
        raise FileError(path, str(error)) from error
    write_bytes(path, data)


def encode_png(colour: npt.NDArray[np.floating[Any]], metadata: Mapping[str, str] | None = None) -> bytes:
    """The bytes of the file that `write_png` writes. Raises `ValueError` where that raises `FileError`."""
    info = PngInfo()
    info.add(b"sRGB", b"\x00")  # rendering intent: perceptual
    for key, value in (metadata or {}).items():
        _add_text(info, key, value)
    buffer = BytesIO()
    Pillow.fromarray(display_bytes(colour)).save(buffer, "PNG", pnginfo=info, compress_level=6)
    return buffer.getvalue()


def display_bytes(colour: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.uint8]:
    """(h, w, 3 or 4) linear colour as 8-bit sRGB; alpha without the curve; NaN as magenta, with a warning.

    Raises `ValueError` for other shapes and for pictures without pixels.
    """
    colour = np.asarray(colour)
    if colour.ndim != 3 or colour.shape[2] not in (3, 4):
        raise ValueError(f"a picture must have shape (h, w, 3) or (h, w, 4), but has {colour.shape}")
    if colour.size == 0:
        raise ValueError(f"a picture needs pixels, but is {colour.shape[1]} by {colour.shape[0]}")
    undefined = np.isnan(colour).any(axis=2)
    known = np.nan_to_num(colour, posinf=1.0, neginf=0.0) if not np.isfinite(colour).all() else colour
    levels = to_srgb_bytes(known)
    if colour.shape[2] == 4:
        alpha = np.clip(known[..., 3].astype(np.float64), 0.0, 1.0)
        levels[..., 3] = np.floor(alpha * 255.0 + 0.5).astype(np.uint8)
    if undefined.any():
        y, x = np.argwhere(undefined)[0]
        warnings.warn(
            f"{int(undefined.sum())} pixels are not a number (the first at x={x}, y={y}): shown in magenta",
            IsophoteWarning,
            stacklevel=3,
        )
        levels[undefined, :3] = _MAGENTA
    return levels


def _add_text(info: PngInfo, key: str, value: str) -> None:
    try:
        length = len(key.encode("latin-1"))
    except UnicodeEncodeError:
        length = 0
    if not 1 <= length <= 79 or "\x00" in key or "\x00" in value:
        raise ValueError(f"metadata {key!r}: PNG wants keys of 1 to 79 Latin-1 letters, and no NUL anywhere")
    try:
        value.encode("latin-1")
    except UnicodeEncodeError:
        info.add_itxt(key, value)
    else:
        info.add_text(key, value)
