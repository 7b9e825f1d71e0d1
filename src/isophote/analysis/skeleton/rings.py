"""Polygons with holes as they are given, checked and put in order."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.predicates import orient2d
from isophote.errors import GeometryError
from isophote.kernels.base.table import Packed
from isophote.kernels.measure.medial_sites import pack_polygon
from isophote.kernels.measure.ring_crossings import first_crossing

__all__ = ["Rings", "in_order"]

FloatArray: TypeAlias = npt.NDArray[np.float64]

_MOST_CORNERS = 10_000_000
# Turns of less than this, in radians, are none: leaving them out moves the boundary by some 1e-10 of its size.
_FLAT = 4e-10


class Rings(NamedTuple):
    """`rings`: the outer one counterclockwise, holes clockwise, none with three corners in line; and their table.

    `size` is the length of the diagonal of their box.
    """

    rings: tuple[FloatArray, ...]
    table: Packed
    size: float


def in_order(polygon: Any) -> Rings:
    """A polygon, (k, 2) corners or a sequence of such rings, of which the first is the outer one."""
    given = _rings(polygon)
    rings = tuple(_turned(_tidied(ring, k), outer=k == 0) for k, ring in enumerate(given))
    starts = np.concatenate(rings)
    ends = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    number = np.arange(len(starts))
    first = np.concatenate([[0], np.cumsum([len(ring) for ring in rings])])
    after, before = number + 1, number - 1
    after[first[1:] - 1], before[first[:-1]] = first[:-1], first[1:] - 1
    reflex = orient2d(starts[before], starts, ends) < 0
    table = pack_polygon(starts, ends, before.astype(np.int32), after.astype(np.int32), reflex)
    a, b = first_crossing(table.words)
    if a >= 0:
        raise GeometryError(
            f"the polygon's boundary crosses or touches itself: edges from {starts[a].tolist()} and "
            f"{starts[b].tolist()}; a medial axis needs rings that do not meet"
        )
    for hole in rings[1:]:
        if not _contains(rings[0], hole[0]):
            raise GeometryError(f"the hole at {hole[0].tolist()} does not lie within the outer ring, which comes first")
    return Rings(tuple(read_only(ring) for ring in rings), table, float(np.hypot(*np.ptp(starts, axis=0))))


def _rings(polygon: Any) -> list[FloatArray]:
    try:
        single = np.ndim(polygon[0]) == 1
        rings = [np.array(ring, np.float64) for ring in ([polygon] if single else polygon)]
    except (TypeError, ValueError, IndexError, KeyError):
        raise GeometryError("a polygon must be corners, (k, 2) numbers, or a sequence of such rings") from None
    for k, ring in enumerate(rings):
        if ring.ndim != 2 or ring.shape[1] != 2 or len(ring) < 3:
            raise GeometryError(f"ring {k} must have three corners or more, (k, 2), but has shape {ring.shape}")
        if not np.isfinite(ring).all():
            raise GeometryError(f"ring {k} has a corner that is not finite")
        if np.abs(ring).max() > 1e100:
            raise GeometryError(f"ring {k} has coordinates beyond 1e100; scale it")
    if sum(map(len, rings)) > _MOST_CORNERS:
        raise GeometryError(f"polygons may have {_MOST_CORNERS:,} corners")
    return rings


def _tidied(ring: FloatArray, k: int) -> FloatArray:
    """Without repeated corners, and without corners at which the boundary goes straight on, or nearly."""
    ring = ring[(ring != np.roll(ring, 1, axis=0)).any(axis=1)]
    while len(ring) > 2:
        before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
        u, v = ring - before, after - ring
        turn = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / (np.hypot(u[:, 0], u[:, 1]) * np.hypot(v[:, 0], v[:, 1]))
        exactly = orient2d(before, ring, after) == 0
        forward = (u * v).sum(axis=1) > 0
        back = exactly & ~forward
        if back.any():
            raise GeometryError(f"ring {k} runs back over itself at {ring[np.flatnonzero(back)[0]].tolist()}")
        nearly = (np.abs(turn) < _FLAT) & forward & ~exactly
        straight = exactly | (nearly & ~np.roll(nearly | exactly, 1))
        if not straight.any():
            return ring
        ring = ring[~straight]
    raise GeometryError(f"ring {k} encloses no area")


def _turned(ring: FloatArray, outer: bool) -> FloatArray:
    """Counterclockwise where it is the outer one, else clockwise."""
    lowest = int(np.lexsort((ring[:, 0], ring[:, 1]))[0])
    left = int(orient2d(ring[lowest - 1], ring[lowest], ring[(lowest + 1) % len(ring)])) > 0
    return ring if left == outer else ring[::-1]


def _contains(ring: FloatArray, point: FloatArray) -> bool:
    """Whether a point lies inside a ring, by crossings; exact."""
    after = np.roll(ring, -1, axis=0)
    up, down = (ring[:, 1] <= point[1]) & (after[:, 1] > point[1]), (ring[:, 1] > point[1]) & (after[:, 1] <= point[1])
    side = orient2d(ring, after, point)
    return bool(((up & (side > 0)).sum() + (down & (side < 0)).sum()) % 2)
