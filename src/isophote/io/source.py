"""The bytes of a file, read whole: packed ones unpacked within a bound, every failure a `FileError`."""

from __future__ import annotations

import os
import stat
import zlib
from pathlib import Path

from isophote.errors import FileError

__all__ = ["read_source"]

# Text that repeats itself packs to a hundredth, real meshes to a third or a tenth; deflate can reach a
# thousandth, which only a file made for it does.
_LARGEST_RATIO = 200
_ALWAYS_ALLOWED = 64 << 20
_GZIP = b"\x1f\x8b"


def read_source(path: Path) -> bytes:
    """All bytes of a regular file, unpacked where they are gzip's (told by content, not by the ending).

    Raises `FileError` where there is no such file, it is a folder or a device, may not be read, or is packed
    and broken, cut short, or larger unpacked than 64 MiB and 200 times the packed size.
    """
    try:
        mode = os.stat(path).st_mode
        if stat.S_ISDIR(mode):
            raise FileError(path, "this is a folder; name a file in it")
        if not stat.S_ISREG(mode):
            raise FileError(path, "this is not a regular file; copy its content into one")
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise FileError(path, f"there is no such file (looked from {os.getcwd()})") from error
    except (OSError, ValueError) as error:
        # ValueError: a name with a NUL in it.
        raise FileError(path, f"cannot be read: {error}") from error
    if data.startswith(_GZIP):
        return _unpack(path, data)
    if path.suffix.lower() == ".gz":
        raise FileError(path, "is not packed by gzip, though its ending says so; take .gz off its name")
    return data


def _unpack(path: Path, data: bytes) -> bytes:
    limit = max(_ALWAYS_ALLOWED, _LARGEST_RATIO * len(data))
    parts: list[bytes] = []
    room = limit
    while data.startswith(_GZIP):
        unpacker = zlib.decompressobj(wbits=31)
        try:
            parts.append(unpacker.decompress(data, room + 1))
        except zlib.error as error:
            raise FileError(path, f"the gzip data are broken ({error}); fetch the file again") from error
        room -= len(parts[-1])
        if room < 0:
            raise FileError(
                path, f"unpacks to more than {limit:,} bytes; if that is meant, unpack it and load the result"
            )
        if not unpacker.eof:
            raise FileError(path, "the gzip data end too early; fetch the file again")
        data = unpacker.unused_data
    return b"".join(parts)
