"""What the channels of a picture are called in an EXR file, both ways.

colour → R, G, B       alpha → A            depth → Z
uv → uv.U, uv.V        normal → normal.X, normal.Y, normal.Z
albedo, variance and other channels of three → name.R, name.G, name.B
channels of four → name.R, name.G, name.B, name.A
channels of two → name.X, name.Y
channels of one, distance, item and primitive among them → name
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["joined", "split"]

Array: TypeAlias = npt.NDArray[Any]

_OWN_NAMES = {"colour": ("R", "G", "B"), "alpha": ("A",), "depth": ("Z",)}
_SUFFIXES = {"uv": ("U", "V"), "normal": ("X", "Y", "Z")}
_BY_COUNT = {2: ("X", "Y"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}
_KNOWN_SUFFIXES = (*_SUFFIXES.values(), *_BY_COUNT.values())


def split(channels: Mapping[str, Array]) -> dict[str, Array]:
    """The (h, w) planes of channels (h, w) or (h, w, k), by their names in the file.

    Raises `ValueError` for shapes that have no names and for two planes of one name.
    """
    planes: dict[str, Array] = {}
    for name, array in channels.items():
        stack = array[..., None] if array.ndim == 2 else array
        names = _plane_names(name, stack.shape[2]) if stack.ndim == 3 else None
        if names is None:
            raise ValueError(f'channel "{name}" must be (h, w) or (h, w, 1 to 4), but is {array.shape}')
        for index, plane in enumerate(names):
            if plane in planes:
                raise ValueError(f'two channels would both be called "{plane}" in the file')
            planes[plane] = stack[..., index]
    return planes


def _plane_names(name: str, count: int) -> tuple[str, ...] | None:
    own = _OWN_NAMES.get(name)
    if own is not None:
        return own if len(own) == count else None
    if count == 1:
        return (name,)
    suffixes = _SUFFIXES.get(name, _BY_COUNT.get(count, ()))
    return tuple(f"{name}.{suffix}" for suffix in suffixes) if len(suffixes) == count else None


def joined(planes: Mapping[str, Array]) -> dict[str, Array]:
    """The channels that planes of a file make up: the inverse of `split`.

    A file with luminance only (Y) has a grey colour. Planes that belong to no known group stay alone,
    under their own names.
    """
    left = dict(planes)
    channels: dict[str, Array] = {}
    for name, own in _OWN_NAMES.items():
        if all(plane in left for plane in own) and name not in left:
            channels[name] = _stack([left.pop(plane) for plane in own])
    if "colour" not in channels and "colour" not in left and "Y" in left:
        channels["colour"] = _stack([left.pop("Y")] * 3)
    for name, suffixes in _groups(left).items():
        if name not in channels:
            channels[name] = _stack([left.pop(f"{name}.{suffix}") for suffix in suffixes])
    return {**channels, **left}


def _groups(planes: Mapping[str, Array]) -> dict[str, tuple[str, ...]]:
    """Prefixes whose planes have exactly one of the known sets of suffixes, in its order."""
    found: dict[str, set[str]] = {}
    for plane in planes:
        prefix, dot, suffix = plane.rpartition(".")
        if dot and prefix and prefix not in planes:
            found.setdefault(prefix, set()).add(suffix)
    return {prefix: known for prefix, suffixes in found.items() for known in _KNOWN_SUFFIXES if suffixes == set(known)}


def _stack(planes: list[Array]) -> Array:
    return planes[0] if len(planes) == 1 else np.stack(planes, axis=2)
