"""Radiance pictures (.hdr, .pic): RGBE pixels, flat and in both run-length codes.

Source: G. Ward, "Real Pixels", Graphics Gems II, 1991, and the Radiance file formats, "Picture File Format".
"""

from __future__ import annotations

import re
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["RADIANCE_MAGIC", "decode_radiance"]

Bytes: TypeAlias = npt.NDArray[np.uint8]
Colours: TypeAlias = npt.NDArray[np.float32]

RADIANCE_MAGIC = b"#?"

_RESOLUTION = re.compile(rb"([+-][XY]) (\d{1,9}) ([+-][XY]) (\d{1,9})\s*$")
_LARGEST_HEADER = 1 << 16
# The old run-length code packs without bound; a picture may still not be larger than this for its bytes.
_FREE_PIXELS = 1 << 22
_PIXELS_PER_BYTE = 1024
# 2^(e − 136): mantissas are 256ths and exponents are offset by 128; exponent 0 is black.
_SCALE = np.concatenate([[0.0], np.ldexp(1.0, np.arange(1, 256) - 136)]).astype(np.float32)


def decode_radiance(data: bytes) -> Colours:
    """Linear colours (h, w, 3) float32, top row first, of a Radiance picture.

    A pixel (r, g, b, e) is (r, g, b) 2^(e − 136), divided by the exposures of the header. Raises
    `ValueError`, saying what is wrong and where, for pictures in XYZ, cut short or garbled.
    """
    start, exposure, (first, count, second, length) = _header(data)
    if count * length > _FREE_PIXELS + _PIXELS_PER_BYTE * len(data):
        raise ValueError(f"declares {length} by {count} pixels, more than its {len(data)} bytes can hold")
    pixels = _pixels(data, start, count, length)
    colours = pixels[..., :3].astype(np.float32)
    colours *= _SCALE[pixels[..., 3]][..., None]
    if exposure != 1.0:
        with np.errstate(over="ignore"):
            colours = (colours / exposure).astype(np.float32)
    return _upright(colours, first, second)


def _header(data: bytes) -> tuple[int, float, tuple[bytes, int, bytes, int]]:
    """Where the pixels start, the product of the exposures, and the resolution line."""
    end = data.find(b"\n\n", 0, _LARGEST_HEADER)
    if not data.startswith(RADIANCE_MAGIC) or end < 0:
        raise ValueError("is no Radiance picture: its header has no start or no end")
    exposure = 1.0
    for line in data[:end].split(b"\n")[1:]:
        key, _, value = line.partition(b"=")
        if key.strip() == b"FORMAT" and value.strip() != b"32-bit_rle_rgbe":
            raise ValueError(f"holds pixels as {value.strip().decode('latin-1')}; only 32-bit_rle_rgbe can be read")
        if key.strip() == b"EXPOSURE":
            exposure *= _exposure(value)
    stop = data.find(b"\n", end + 2, end + 66)
    match = _RESOLUTION.match(data[end + 2 : max(stop, 0)])
    if match is None or match[1][1:] == match[3][1:]:
        raise ValueError(f"has no resolution, such as -Y 512 +X 1024, at byte {end + 2}")
    count, length = int(match[2]), int(match[4])
    if count == 0 or length == 0:
        raise ValueError(f"declares a picture of {length} by {count}")
    return stop + 1, exposure, (match[1], count, match[3], length)


def _exposure(text: bytes) -> float:
    try:
        exposure = float(text)
    except ValueError:
        exposure = 0.0
    if not 1e-30 < exposure < 1e30:
        raise ValueError(f"has an exposure of {text.decode('latin-1').strip()!r}, not a number above 0")
    return exposure


def _pixels(data: bytes, start: int, count: int, length: int) -> Bytes:
    """(count, length, 4) bytes: all scanlines."""
    if not _is_new_code(data, start, length):
        return _flat(data, start, count * length).reshape(count, length, 4)
    rows = bytearray()
    at = start
    for row in range(count):
        if not _is_new_code(data, at, length):
            raise ValueError(f"scanline {row} does not start as it should, at byte {at}")
        at = _unpack_scanline(data, at + 4, rows, 4 * length * (row + 1), row)
    planes = np.frombuffer(bytes(rows), np.uint8).reshape(count, 4, length)
    return planes.transpose(0, 2, 1)


def _is_new_code(data: bytes, at: int, length: int) -> bool:
    return 8 <= length < 32768 and data[at : at + 4] == bytes([2, 2, length >> 8, length & 255])


def _unpack_scanline(data: bytes, at: int, rows: bytearray, goal: int, row: int) -> int:
    """Append the four planes of one scanline, up to `goal` bytes in all; where the next one starts."""
    size = len(data) - 1
    while len(rows) < goal:
        if at >= size:
            raise ValueError(f"ends within scanline {row}")
        code = data[at]
        if code > 128:
            rows += data[at + 1 : at + 2] * (code - 128)
            at += 2
        elif code:
            rows += data[at + 1 : at + 1 + code]
            at += 1 + code
        else:
            raise ValueError(f"has an empty run in scanline {row}, at byte {at}")
    if len(rows) > goal:
        raise ValueError(f"has a run beyond the end of scanline {row}, at byte {at}")
    return at


def _flat(data: bytes, start: int, wanted: int) -> Bytes:
    """(wanted, 4) bytes of pixels that stand one after another, (1, 1, 1, n) repeating the one before n times."""
    given = np.frombuffer(data, np.uint8, (len(data) - start) // 4 * 4, start).reshape(-1, 4)
    if len(given) >= wanted and not (given[:wanted, :3] == 1).all(axis=1).any():
        return given[:wanted]
    repeats = (given[:, :3] == 1).all(axis=1)
    if len(given) and repeats[0]:
        raise ValueError(f"repeats a pixel before there is one, at byte {start}")
    order = np.arange(len(given))
    last_pixel = np.maximum.accumulate(np.where(repeats, 0, order))
    # Repeats in a row are the digits of one number, the least first.
    digit = np.minimum(order - last_pixel - 1, 4)
    counts = np.where(repeats, given[:, 3].astype(np.int64) << (8 * np.maximum(digit, 0)), 1)
    ends = np.cumsum(np.minimum(counts, wanted))
    used = int(np.searchsorted(ends, wanted)) + 1
    if used > len(given):
        raise ValueError(f"holds {int(ends[-1]) if len(ends) else 0} of {wanted} pixels")
    return np.asarray(np.repeat(given[last_pixel[:used]], np.minimum(counts[:used], wanted), axis=0)[:wanted])


def _upright(colours: Colours, first: bytes, second: bytes) -> Colours:
    """The picture with its top row first and its left column first, from the signs of the resolution line."""
    if first[1:] == b"X":
        colours, first, second = colours.transpose(1, 0, 2), second, first
    down = -1 if first == b"+Y" else 1
    across = -1 if second == b"-X" else 1
    return np.ascontiguousarray(colours[::down, ::across])
