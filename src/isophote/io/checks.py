"""What every mesh reader must find out while it still knows the places in the file."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError
from isophote.io.files import StrPath

__all__ = ["check_faces", "check_points", "no_faces"]


def check_points(path: StrPath, points: npt.NDArray[np.float64], place: Callable[[int], str]) -> None:
    """Refuse points (n, 3) that are not finite; `place` says where in the file vertex `i` is."""
    finite = np.isfinite(points).all(axis=1)
    if finite.all():
        return
    bad = int(np.argmin(finite))
    count = int((~finite).sum())
    raise FileError(
        path,
        f"vertex {bad} is not finite: {points[bad].tolist()} ({count:,} such in all); "
        "export the mesh again without them",
        place(bad),
    )


def check_faces(
    path: StrPath,
    points: int,
    indices: npt.NDArray[Any],
    offsets: npt.NDArray[np.int64],
    place: Callable[[int], str],
    base: int = 0,
) -> None:
    """Refuse faces with fewer than three corners and faces that name vertices that are not there.

    `indices` count from 0; `base` is what the format counts from, for the message.
    """
    sizes = np.diff(offsets)
    if len(sizes) and sizes.min() < 3:
        face = int(np.argmax(sizes < 3))
        reason = f"face {face} has {int(sizes[face])} corners; a face needs 3 or more, so take it out"
        raise FileError(path, reason, place(face))
    wrong = (indices < 0) | (indices >= points)
    if wrong.any():
        corner = int(np.argmax(wrong))
        face = int(np.searchsorted(offsets, corner, side="right")) - 1
        known = f"the vertices are {base} to {points - 1 + base}" if points else "there are no vertices"
        reason = f"face {face} names vertex {int(indices[corner]) + base}, but {known}"
        raise FileError(path, f"{reason}; the file is damaged or was written wrongly", place(face))


def no_faces(path: StrPath, points: int) -> FileError:
    """The error for a file without faces: a point cloud, or nothing at all."""
    if points:
        reason = f"this is a point cloud: {points:,} points and no faces; make a surface of it before it is loaded"
    else:
        reason = "there is no mesh in the file: no vertices and no faces"
    return FileError(path, reason)
