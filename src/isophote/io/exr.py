"""OpenEXR pictures with any number of channels, through the OpenEXR package."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Mapping
from contextlib import redirect_stdout
from io import StringIO
from os import fspath
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
import OpenEXR

from isophote.errors import FileError, IsophoteWarning
from isophote.io.exr_names import joined, split
from isophote.io.files import StrPath, replacing

__all__ = ["EXR_MAGIC", "ExrPicture", "read_exr", "write_exr"]

Array: TypeAlias = npt.NDArray[Any]

EXR_MAGIC = b"\x76\x2f\x31\x01"

_LARGEST_HALF = 65504.0
# Channels of whole numbers where -1 says "none": stored as 4294967295, since EXR's integers have no sign.
_SIGNED = ("item", "primitive")
# Attributes to which the format gives a meaning: metadata of these names is stored under a prefix.
# fmt: off
_RESERVED = frozenset((
    "adoptedNeutral", "altitude", "aperture", "channels", "chromaticities", "chunkCount",
    "compression", "dataWindow", "deepImageState", "displayWindow", "dwaCompressionLevel", "envmap",
    "expTime", "focus", "framesPerSecond", "idManifest", "imageCounter", "isoSpeed", "keyCode",
    "latitude", "lineOrder", "longitude", "maxSamplesPerPixel", "multiView", "name",
    "originalDataWindow", "pixelAspectRatio", "preview", "screenWindowCenter", "screenWindowWidth",
    "tiles", "timeCode", "type", "utcOffset", "version", "view", "whiteLuminance", "worldToCamera",
    "worldToNDC", "xDensity",
))
# fmt: on
_PREFIX = "isophote."

# How many bytes of pixels one byte of file can stand for. Deflate reaches 1032; PXR24 drops a quarter of
# each float before it; the wavelet and transform codecs have no bound for flat pictures.
_EXPANSION = {"NO": 1, "RLE": 64, "ZIPS": 1032, "ZIP": 1032, "PXR24": 1376}
_UNBOUNDED_EXPANSION = 4096
_FREE_BYTES = 64 << 20

# The package reports what it cannot decode by printing, and printing is redirected for the whole process.
_READING = threading.Lock()


class ExrPicture(NamedTuple):
    """What an EXR file holds: channels (h, w) or (h, w, k) by name, and its text attributes."""

    channels: dict[str, Array]
    metadata: dict[str, str]


def write_exr(
    path: StrPath,
    channels: Mapping[str, npt.ArrayLike],
    metadata: Mapping[str, str] | None = None,
    *,
    half: bool = False,
) -> None:
    """Write channels (h, w) or (h, w, 1 to 4) into one EXR file, ZIP-compressed, whole or not at all.

    Floats are stored as 32-bit floats; `half` stores colour, albedo and alpha as 16-bit ones, with finite
    values kept finite. Whole numbers and booleans are stored exactly, as 32-bit ones, -1 as 4294967295.
    `isophote.io.exr_names` lists the names in the file. `metadata` becomes text attributes. Raises
    `FileError` for shapes that do not fit, numbers beyond 32 bits and files that cannot be written.
    """
    try:
        arrays = {name: _storable(name, np.asarray(a), half) for name, a in channels.items()}
        planes = split(arrays)
        _check_sizes(planes)
        header = {
            "compression": OpenEXR.ZIP_COMPRESSION,
            "type": OpenEXR.scanlineimage,
            **_attributes(metadata or {}),
        }
        file = OpenEXR.File(header, {name: np.ascontiguousarray(p) for name, p in planes.items()})
    except (ValueError, RuntimeError, TypeError) as error:
        raise FileError(path, f"cannot be written: {error}") from error
    with replacing(path) as temporary:
        try:
            file.write(fspath(temporary))
        except RuntimeError as error:
            raise FileError(path, f"cannot be written: {error}") from error


def _storable(name: str, array: Array, half: bool) -> Array:
    if array.dtype.kind in "biu":
        if array.size and (int(array.min()) < -1 or int(array.max()) > 0xFFFFFFFF):
            raise ValueError(f'channel "{name}" holds whole numbers outside -1 to 4294967295')
        return array.astype(np.int64).astype(np.uint32)
    if array.dtype.kind != "f":
        raise ValueError(f'channel "{name}" must hold numbers, not {array.dtype}')
    if half and name in ("colour", "albedo", "alpha"):
        limited = np.clip(array, -_LARGEST_HALF, _LARGEST_HALF)
        return np.where(np.isfinite(array), limited, array).astype(np.float16)
    with np.errstate(over="ignore"):
        return array.astype(np.float32)


def _check_sizes(planes: Mapping[str, Array]) -> None:
    shapes = {plane.shape for plane in planes.values()}
    if len(shapes) != 1:
        raise ValueError(f"all channels must have one size, but there are {sorted(shapes)}")
    if 0 in next(iter(shapes)):
        raise ValueError(f"a picture needs pixels, but its channels are {next(iter(shapes))}")
    for name in planes:
        if not name or "\x00" in name or len(name.encode()) > 255:
            raise ValueError(f"channel name {name!r} must be 1 to 255 bytes without NUL")


def _attributes(metadata: Mapping[str, str]) -> dict[str, str]:
    stored = {(_PREFIX + key if key in _RESERVED else key): value for key, value in metadata.items()}
    for key in stored:
        if not key or "\x00" in key or len(key.encode()) > 255:
            raise ValueError(f"metadata key {key!r} must be 1 to 255 bytes without NUL")
    return stored


def read_exr(path: StrPath) -> ExrPicture:
    """Read the channels and text attributes of an EXR file (of its first part), at full resolution.

    16-bit and 32-bit floats give float32; whole numbers give uint32, "item" and "primitive" int32 with -1
    for none. Pixels are those of the data window. Raises `FileError` for files that are damaged, deep,
    subsampled, or that declare more pixels than their bytes can hold.
    """
    try:
        with Path(path).open("rb") as stream:
            magic = stream.read(4)
            size = stream.seek(0, 2)
    except (OSError, ValueError) as error:
        raise FileError(path, f"cannot be read: {error}") from error
    if magic != EXR_MAGIC:
        raise FileError(path, "is not an OpenEXR file", "byte 0")
    parts = _open(path, header_only=True).parts
    for part in parts:
        _check_part(path, part.header, size)
    if len(parts) > 1:
        warnings.warn(
            f"{fspath(path)}: only the first of its {len(parts)} parts is read", IsophoteWarning, stacklevel=2
        )
    part = _open(path, header_only=False).parts[0]
    planes = {name: _plane(path, channel) for name, channel in part.channels.items()}
    channels = joined(planes)
    for name in _SIGNED:
        if name in channels and channels[name].dtype == np.uint32:
            channels[name] = channels[name].view(np.int32)
    return ExrPicture(channels, _metadata(part.header))


def _open(path: StrPath, *, header_only: bool) -> Any:
    printed = StringIO()
    try:
        with _READING, redirect_stdout(printed):
            file = OpenEXR.File(fspath(path), separate_channels=True, header_only=header_only)
    except (RuntimeError, ValueError, TypeError, IndexError, MemoryError) as error:
        raise FileError(path, f"is damaged, or no OpenEXR file: {error}") from error
    # A part whose pixels cannot be decoded is left out of the list.
    if not file.parts or "reading pixel data" in printed.getvalue():
        reason = printed.getvalue().strip().rpartition(" - ")[2] or "no part can be read"
        raise FileError(path, f"is damaged or cut short: {reason}")
    return file


def _check_part(path: StrPath, header: Mapping[str, Any], file_size: int) -> None:
    """Refuse what cannot be right before anything is allocated for it."""
    if header.get("type") in (OpenEXR.deepscanline, OpenEXR.deeptile):
        raise FileError(path, "holds deep pixels; only flat pictures can be read", "type")
    channels = header.get("channels", [])
    if any(c.xSampling != 1 or c.ySampling != 1 for c in channels):
        raise FileError(path, "has subsampled channels; save it with one sample a pixel", "channels")
    low, high = (np.asarray(corner).astype(object) for corner in header["dataWindow"])
    width, height = high - low + 1
    if width < 1 or height < 1:
        raise FileError(path, f"declares a picture of {width} by {height}", "dataWindow")
    codec = header["compression"].name.removesuffix("_COMPRESSION")
    bound = _FREE_BYTES + file_size * _EXPANSION.get(codec, _UNBOUNDED_EXPANSION)
    tiles = header.get("tiles")
    sizes = [("dataWindow", width, height)] + ([("tiles", tiles.xSize, tiles.ySize)] if tiles else [])
    for place, across, down in sizes:
        # Two bytes is what the smallest kind of channel takes.
        if across * down * 2 * max(len(channels), 1) > bound:
            raise FileError(path, f"declares {across} by {down} pixels, more than its bytes can hold", place)


def _plane(path: StrPath, channel: Any) -> Array:
    pixels = channel.pixels
    if not isinstance(pixels, np.ndarray) or pixels.ndim != 2:
        raise FileError(path, "holds no pixels for this channel", str(channel.name))
    return pixels if pixels.dtype == np.uint32 else pixels.astype(np.float32)


def _metadata(header: Mapping[str, Any]) -> dict[str, str]:
    texts = {key: value for key, value in header.items() if isinstance(value, str)}
    texts.pop("name", None)
    return {key.removeprefix(_PREFIX): value for key, value in texts.items()}
