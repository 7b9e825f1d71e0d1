"""Outlines as tables: closed loops of quadratic arcs, cut where they cross, with their boundary marked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field.crossings import cut_arcs, find_cuts, sides_of, split_monotone
from isophote.shapes.field.data import OutlineData

__all__ = ["line_arcs", "outline_data"]

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int64]


def line_arcs(points: Floats) -> Floats:
    """(n, 6) arcs of the closed polygon through points (n, 2): lines, with their middles as control points."""
    after = np.roll(points, -1, axis=0)
    return np.column_stack([points, (points + after) / 2, after])


def outline_data(loops: Sequence[Floats], name: str) -> OutlineData:
    """The table of closed loops of arcs, (k, 6) each, by the nonzero winding rule; loops may cross and overlap.

    `name` stands in messages. Raises `GeometryError` where nothing is enclosed.
    """
    arcs = _rounded(np.concatenate(loops))
    loop = np.repeat(np.arange(len(loops)), [len(each) for each in loops])
    arcs, origin = split_monotone(arcs)
    arcs, loop = _moving(_rounded(arcs), loop[origin])
    if len(arcs) == 0:
        raise GeometryError(f"{name}: the outline encloses nothing; it needs three points or more that are not in line")
    for where in ("ends", "crossings"):
        cuts = find_cuts(arcs, where)
        if len(cuts.arc):
            arcs, origin = cut_arcs(arcs, cuts)
            arcs, loop = _moving(_rounded(arcs), loop[origin])
    sides = sides_of(arcs, _alike(arcs, loop))
    if not sides.any():
        raise GeometryError(
            f"{name}: the outline encloses nothing; its points are in line, or it runs back over itself"
        )
    segments = arcs.astype(np.float32)
    segments.flags.writeable = sides.flags.writeable = False
    return OutlineData(segments, sides)


def _moving(arcs: Floats, loop: Ints) -> tuple[Floats, Ints]:
    """Without arcs that rounding left no length."""
    moving = (arcs[:, :2] != arcs[:, 4:]).any(axis=1)
    return arcs[moving], loop[moving]


def _alike(arcs: Floats, loop: Ints) -> Ints:
    """Groups of arcs with the same on their sides: loops of which no point belongs to other arcs too."""
    _, place, count = np.unique(arcs[:, :2], axis=0, return_inverse=True, return_counts=True)
    shared = np.unique(loop[count[place.reshape(-1)] > 1])
    own = np.isin(loop, shared)
    return np.where(own, loop.max() + 1 + np.arange(len(arcs)), loop)


def _rounded(arcs: Floats) -> Floats:
    """The arcs as single precision holds them, lines with the middle between their rounded ends."""
    middle = (arcs[:, :2] + arcs[:, 4:]) / 2
    size = np.abs(arcs[:, 4:] - arcs[:, :2]).max(axis=1)
    straight = np.abs(arcs[:, 2:4] - middle).max(axis=1) <= 1e-6 * size
    single = arcs.astype(np.float32).astype(np.float64)
    single[straight, 2:4] = ((single[:, :2] + single[:, 4:]) / 2).astype(np.float32)[straight]
    low, high = np.minimum(arcs[:, :2], arcs[:, 4:]), np.maximum(arcs[:, :2], arcs[:, 4:])
    monotone = ((arcs[:, 2:4] >= low) & (arcs[:, 2:4] <= high)).all(axis=1)
    low, high = np.minimum(single[:, :2], single[:, 4:]), np.maximum(single[:, :2], single[:, 4:])
    single[monotone, 2:4] = np.clip(single[:, 2:4], low, high)[monotone]
    return single
