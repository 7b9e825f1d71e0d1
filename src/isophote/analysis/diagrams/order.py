"""Points of the plane in the order in which a sweep meets them, and of a size that nothing overflows at."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.kernels.measure import row_order, spatial_order

__all__ = ["Ordered", "Scaled", "in_order", "scaled"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_GRAIN = 65536
_HIGHEST_KEY = 2.0**32 - 1
# Sizes of coordinates at which neither cubes overflow nor products of differences underflow.
_SMALL, _GREAT = 1e-30, 1e30


class Scaled(NamedTuple):
    """Places (m, 2) that are points over 2^exponent, with nothing lost."""

    places: FloatArray
    exponent: int


class Ordered(NamedTuple):
    """Distinct sites by y and then by x, scaled; their numbers; for each point the first that equals it."""

    sites: Scaled
    names: IntArray
    representative: IntArray


def in_order(points: FloatArray) -> Ordered:
    """The sites of points (n, 2) in the order in which a sweep meets them."""
    found = _by_digits(points)
    if found is None:
        return _by_comparing(points)
    sites, names = found
    return Ordered(scaled(sites), names, np.arange(len(points), dtype=np.int32))


def scaled(sites: FloatArray) -> Scaled:
    """The sites times a power of two that makes them about 1, so that nothing overflows; if no place is lost by it."""
    greatest = max(sites.max(initial=0.0), -sites.min(initial=0.0))
    if greatest == 0 or _SMALL < greatest < _GREAT:
        return Scaled(sites, 0)
    exponent = int(np.frexp(greatest)[1])
    small = np.ldexp(sites, -exponent)
    return Scaled(small, exponent) if (np.ldexp(small, exponent) == sites).all() else Scaled(sites, 0)


def _by_digits(points: FloatArray) -> tuple[FloatArray, IntArray] | None:
    """Sites and their numbers; None where many points are of about the same y, or some are equal."""
    count = len(points)
    if count == 0:
        return None
    least, greatest = float(points[:, 1].min()), float(points[:, 1].max())
    with np.errstate(all="ignore"):
        factor = _HIGHEST_KEY / np.float64(greatest - least)
    if not 0 < factor < np.inf:
        return None
    keys, spare = np.empty(count, np.uint64), np.empty(count, np.uint64)
    run(row_order.row_keys, [(points, *piece, least, factor, keys) for piece in pieces(count, _GRAIN)])
    spatial_order.sort_keys(keys, spare)
    if not row_order.sort_rows(points, spare):
        return None
    sites, names = np.empty((count, 2)), np.empty(count, np.int32)
    run(row_order.take_rows, [(points, spare, *piece, sites, names) for piece in pieces(count, _GRAIN)])
    return sites, names


def _by_comparing(points: FloatArray) -> Ordered:
    order = np.lexsort((points[:, 0], points[:, 1]))
    sites = points[order]
    new = np.ones(len(sites), np.bool_)
    np.logical_or(sites[1:, 0] != sites[:-1, 0], sites[1:, 1] != sites[:-1, 1], out=new[1:])
    names = order.astype(np.int32)
    representative = np.arange(len(points), dtype=np.int32)
    if not new.all():
        # Sorting by both coordinates keeps the order of equal points: the first of them is the least.
        representative[order] = names[np.flatnonzero(new)][np.cumsum(new) - 1]
        sites, names = sites[new], names[new]
    return Ordered(scaled(np.ascontiguousarray(sites)), names, representative)
