"""Sheets: the parts of a mesh that are connected across edges of two faces, and the sides that their faces take."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.stars import Faces, Ints, Longs, Stars, twins
from isophote.kernels.measure.pieces import agree_on_sides

__all__ = ["Sheets", "find_sheets", "one_sided_cycle"]


class Sheets(NamedTuple):
    """The sheet of each face, and whether the face is to be turned to agree with the first one of its sheet.

    `twin` is as `stars.twins` gives it, `face` the face of each half-edge. `reached`, (faces,), is the half-edge by
    which a face was found, -1 for the first one of a sheet. `conflicts` are half-edges across which faces cannot
    agree, one for each sheet that has no two sides.
    """

    total: int
    of_face: Ints
    turn: npt.NDArray[np.bool_]
    twin: Ints
    face: Ints
    reached: Ints
    conflicts: Longs


def find_sheets(faces: Faces, stars: Stars) -> Sheets:
    """Go over all faces, neighbour by neighbour."""
    twin = twins(stars, opposed=False)
    face = np.repeat(np.arange(faces.total, dtype=np.int32), np.diff(faces.offsets))
    sheet, reached, queue, conflict = np.empty((4, faces.total), np.int32)
    sheet[:] = -1
    side = np.empty(faces.total, np.uint8)
    count = agree_on_sides(faces.indices, face, faces.offsets, twin, sheet, side, reached, queue, conflict)
    found = conflict[:count]
    return Sheets(int(count), sheet, side.astype(bool), twin, face, reached, found[found >= 0].astype(np.int64))


def one_sided_cycle(sheets: Sheets, conflict: int) -> list[int]:
    """The faces of a band that comes back on its other side, across the edge of half-edge `conflict`."""

    def way(face: int) -> list[int]:
        found = [face]
        while sheets.reached[found[-1]] >= 0:
            found.append(int(sheets.face[sheets.reached[found[-1]]]))
        return found

    one = way(int(sheets.face[conflict]))
    other = way(int(sheets.face[sheets.twin[conflict]]))
    while len(one) > 1 and len(other) > 1 and one[-2] == other[-2]:
        one.pop()
        other.pop()
    return one[::-1] + other[:-1]
