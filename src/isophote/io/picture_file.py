"""Rendered pictures as files: which ending holds what, and reading it back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from isophote.errors import FileError
from isophote.io.exr import EXR_MAGIC, read_exr, write_exr
from isophote.io.files import StrPath, check_writable, replacing
from isophote.io.png import display_bytes, write_png
from isophote.io.source import read_source
from isophote.io.texture_file import decode_picture
from isophote.scene.colour import srgb_to_linear

__all__ = ["check_picture_path", "read_picture", "write_picture"]

Array: TypeAlias = npt.NDArray[Any]
Channels: TypeAlias = Mapping[str, Array]

_JPEG_QUALITY = 95


def write_picture(path: StrPath, channels: Channels, metadata: Mapping[str, str]) -> None:
    """Write a picture by the ending of its name.

    .exr holds every channel and the metadata; .png the colour (and "alpha") in 8-bit sRGB and the metadata;
    .jpg, .jpeg, .webp, .tif, .tiff and .bmp the colour in 8-bit sRGB. Raises `FileError` for other endings and
    for files that cannot be written.
    """
    _writer(path)(path, channels, metadata)


def check_picture_path(path: StrPath) -> None:
    """Raise the `FileError` now that `write_picture` would raise later: for the ending, the folder, the name.

    Nothing is left behind, and a file that is there is not touched.
    """
    _writer(path)
    check_writable(path)


def _writer(path: StrPath) -> Callable[[StrPath, Channels, Mapping[str, str]], None]:
    ending = Path(path).suffix.lower()
    write = _WRITERS.get(ending)
    if write is None:
        found = f'"{ending}" is no ending of a picture' if ending else "the name has no ending"
        raise FileError(path, f"{found}; use one of {', '.join(_WRITERS)}")
    return write


def _write_png(path: StrPath, channels: Channels, metadata: Mapping[str, str]) -> None:
    colour = channels["colour"]
    if "alpha" in channels:
        colour = np.concatenate([colour, channels["alpha"][..., None]], axis=2)
    write_png(path, colour, metadata)


def _write_exr(path: StrPath, channels: Channels, metadata: Mapping[str, str]) -> None:
    write_exr(path, channels, metadata)


def _write_by_pillow(path: StrPath, channels: Channels, metadata: Mapping[str, str]) -> None:
    del metadata  # These formats have no common place for it.
    with replacing(path) as temporary:
        try:
            Pillow.fromarray(display_bytes(channels["colour"])).save(temporary, quality=_JPEG_QUALITY)
        except ValueError as error:
            raise FileError(path, f"cannot be written: {error}") from error


_WRITERS: dict[str, Callable[[StrPath, Channels, Mapping[str, str]], None]] = {
    ".png": _write_png,
    ".exr": _write_exr,
    ".jpg": _write_by_pillow,
    ".jpeg": _write_by_pillow,
    ".webp": _write_by_pillow,
    ".tif": _write_by_pillow,
    ".tiff": _write_by_pillow,
    ".bmp": _write_by_pillow,
}


def read_picture(path: StrPath) -> tuple[dict[str, Array], dict[str, str]]:
    """Channels and metadata of a picture file, told by its content.

    Other files than EXR give "colour", (h, w, 3) linear float32, and "alpha" where they have transparency.
    Raises `FileError` for files that are no pictures, and for EXR files without colour.
    """
    data = read_source(Path(path))
    if data.startswith(EXR_MAGIC):
        channels, metadata = read_exr(path)
        if "colour" not in channels:
            raise FileError(path, f"has no channels R, G and B or Y, but {', '.join(sorted(channels))}")
        return channels, metadata
    pixels, space, metadata = decode_picture(data, path)
    values = pixels / np.float32(255) if pixels.dtype == np.uint8 else pixels
    stack = values[..., None] if values.ndim == 2 else values
    colour = stack[..., :3] if space == "linear" else srgb_to_linear(stack[..., :3])
    shape = (*stack.shape[:2], 3)
    channels = {"colour": np.broadcast_to(colour, shape).astype(np.float32)}
    if stack.shape[2] == 4:
        channels["alpha"] = np.ascontiguousarray(stack[..., 3], np.float32)
    return channels, metadata
