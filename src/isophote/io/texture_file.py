"""Textures from files: PNG, JPEG and their like, Radiance and OpenEXR."""

from __future__ import annotations

import warnings
from io import BytesIO
from os import fspath
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow
from PIL import UnidentifiedImageError

from isophote.errors import FileError, IsophoteWarning
from isophote.io.exr import EXR_MAGIC, read_exr
from isophote.io.files import StrPath
from isophote.io.radiance import RADIANCE_MAGIC, decode_radiance
from isophote.io.source import read_source
from isophote.scene.image_texture import ImageTexture

__all__ = ["Decoded", "decode_picture", "load_texture"]

Pixels: TypeAlias = npt.NDArray[Any]

# Only formats that are decoded in this process: Pillow hands some others, EPS among them, to other programs.
_FORMATS = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF", "PPM", "JPEG2000")
_FREE_BYTES = 64 << 20
_BYTES_PER_BYTE = 4096


class Decoded(NamedTuple):
    """Pixels as `ImageTexture` holds them, their colour space, and the texts that a PNG holds."""

    pixels: Pixels
    colour_space: str
    text: dict[str, str]


def load_texture(
    path: StrPath,
    *,
    colour_space: str | None = None,
    wrap: str | tuple[str, str] = "repeat",
    filter: str = "ewa",
) -> ImageTexture:
    """Read a picture file as an `ImageTexture`.

    The kind is told by content: Radiance (.hdr) and OpenEXR give float32 pixels, linear; PNG, JPEG, WebP,
    TIFF, BMP, GIF, PPM, JPEG 2000 and TGA give uint8 pixels, sRGB, or float32 ones where the file has grey
    pixels of 16 bits (sRGB) or floats (linear). Colour pictures of 16 bits a channel keep the upper 8.
    Palettes become colours, transparency a fourth channel. `colour_space` ("srgb" or "linear") says otherwise,
    as for normal maps; `wrap` and `filter` are those of `ImageTexture`. Values of an EXR that are no number
    become 0, infinite ones the largest finite one, with an `IsophoteWarning`.

    Raises `FileError` for files that are missing, damaged, of another kind, or far larger than their bytes
    can hold.
    """
    data = read_source(Path(path))
    if data.startswith(EXR_MAGIC):
        pixels, space = _exr_pixels(path), "linear"
    else:
        pixels, space, _ = decode_picture(data, path)
    return ImageTexture(pixels, colour_space or space, wrap, filter, name=Path(path).name)


def decode_picture(data: bytes, path: StrPath, place: str = "") -> Decoded:
    """What a picture file's bytes hold (not those of an EXR).

    `path` and `place` say where the bytes come from in the `FileError` that is raised where they are no
    picture.
    """
    if data.startswith(RADIANCE_MAGIC):
        try:
            return Decoded(decode_radiance(data), "linear", {})
        except ValueError as error:
            raise FileError(path, str(error), place) from error
    formats = (*_FORMATS, "TGA") if Path(path).suffix.lower() == ".tga" else _FORMATS
    try:
        with Pillow.open(BytesIO(data), formats=formats) as picture:
            _check_size(picture, len(data))
            picture.load()
            text = {str(key): str(value) for key, value in getattr(picture, "text", {}).items()}
            return Decoded(*_pillow_pixels(picture), text)
    except UnidentifiedImageError as error:
        raise FileError(path, "is no picture that can be read, such as PNG, JPEG, HDR or EXR", place) from error
    # Pillow's decoders raise almost anything on damaged files, from OSError to struct.error and SyntaxError.
    except Exception as error:
        raise FileError(path, f"the picture cannot be read: {error}", place) from error


def _check_size(picture: Pillow.Image, size: int) -> None:
    width, height = picture.size
    if width * height * len(picture.getbands()) > _FREE_BYTES + _BYTES_PER_BYTE * size:
        raise ValueError(f"it declares {width} by {height} pixels, more than its {size} bytes can hold")


def _pillow_pixels(picture: Pillow.Image) -> tuple[Pixels, str]:
    mode = picture.mode
    if mode.startswith("I"):
        return _grey_16(np.asarray(picture)), "srgb"
    if mode == "F":
        return np.asarray(picture, np.float32), "linear"
    if "transparency" in picture.info or mode in ("LA", "La", "PA", "RGBA", "RGBa"):
        return np.asarray(picture.convert("RGBA")), "srgb"
    return np.asarray(picture.convert("L" if mode in ("1", "L") else "RGB")), "srgb"


def _grey_16(pixels: Pixels) -> Pixels:
    if pixels.min() < 0 or pixels.max() > 65535:
        raise ValueError("its whole numbers go beyond 16 bits")
    return (pixels / np.float32(65535)).astype(np.float32)


def _exr_pixels(path: StrPath) -> Pixels:
    channels = read_exr(path).channels
    if "colour" in channels:
        alpha = [channels["alpha"][..., None]] if "alpha" in channels else []
        pixels = np.concatenate([channels["colour"], *alpha], axis=2)
    elif len(channels) == 1:
        (pixels,) = channels.values()
    else:
        raise FileError(path, f"has no channels R, G and B or Y, but {', '.join(sorted(channels))}")
    return _finite(np.asarray(pixels, np.float32), path)


def _finite(pixels: Pixels, path: StrPath) -> Pixels:
    finite = np.isfinite(pixels)
    if finite.all():
        return pixels
    warnings.warn(
        f"{fspath(path)}: {int((~finite).sum())} values are infinite or not a number; they become the largest "
        "finite value and 0",
        IsophoteWarning,
        stacklevel=4,
    )
    largest = float(np.abs(pixels[finite]).max(initial=0.0))
    return np.nan_to_num(pixels, nan=0.0, posinf=largest, neginf=-largest)
