"""Polygons that are not convex, cut by lines into pieces that are simple again."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["cut_by_lines"]

FloatArray: TypeAlias = npt.NDArray[np.float64]


def cut_by_lines(polygon: FloatArray, normals: FloatArray, heights: FloatArray) -> list[FloatArray]:
    """The parts of a simple polygon, (k, 2) counterclockwise, in which x · normal <= height for all lines."""
    parts = [polygon]
    for normal, height in zip(normals, heights, strict=True):
        parts = [piece for part in parts for piece in _cut(part, normal, float(height))]
    return parts


def _cut(polygon: FloatArray, normal: FloatArray, height: float) -> list[FloatArray]:
    """The parts on one side of a line.

    Chains on that side lead from an entry to an exit; along the line, the polygon's inside lies between the first and
    the second of them, the third and the fourth, and so on, which is how exits are joined to entries.
    """
    values = polygon @ normal - height
    inside = values <= 0
    if inside.all():
        return [polygon]
    if not inside.any():
        return []
    after = np.roll(inside, -1)
    entries, exits = np.flatnonzero(~inside & after), np.flatnonzero(inside & ~after)
    crossings = np.concatenate([entries, exits])
    ends = (crossings + 1) % len(polygon)
    t = values[crossings] / (values[crossings] - values[ends])
    places = polygon[crossings] + t[:, None] * (polygon[ends] - polygon[crossings])
    along = places @ np.array([-normal[1], normal[0]])
    order = np.argsort(along, kind="stable")
    partner = np.empty(len(order), np.int64)
    partner[order[0::2]], partner[order[1::2]] = order[1::2], order[0::2]
    return _join(polygon, entries, exits, places, partner)


def _join(
    polygon: FloatArray,
    entries: npt.NDArray[np.int64],
    exits: npt.NDArray[np.int64],
    places: FloatArray,
    partner: npt.NDArray[np.int64],
) -> list[FloatArray]:
    """Walk along chains and from exits to entries, until all entries have been passed."""
    count = len(entries)
    exit_behind = np.searchsorted(exits, entries) % count
    left = set(range(count))
    parts = []
    while left:
        entry = first = min(left)
        loop: list[FloatArray] = []
        while entry in left:
            left.discard(entry)
            way_out = exit_behind[entry]
            start, stop = entries[entry] + 1, exits[way_out] + 1
            if stop <= entries[entry]:
                stop += len(polygon)
            loop += [places[entry][None], polygon[np.arange(start, stop) % len(polygon)], places[count + way_out][None]]
            entry = int(partner[count + way_out])
        if entry == first:
            part = np.concatenate(loop)
            part = part[(part != np.roll(part, 1, axis=0)).any(axis=1)]
            if len(part) > 2:
                parts.append(part)
    return parts
