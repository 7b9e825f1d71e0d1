"""Points of the plane by y and then by x: keys for a sort by digits, and what is left to compare after it.

Keys hold how far up a point lies in 32 bits, and below its number. Rounding keeps the order, so only points of equal
keys are compared.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_kernel

__all__ = ["row_keys", "sort_rows", "take_rows"]

_KEY_BITS = np.uint64(32)
_INDEX_MASK = np.uint64(0xFFFFFFFF)
# Points of one key that are sorted by insertion.
_FEW = 64


@exact_kernel
def row_keys(points, begin, end, least, factor, keys):
    """Write the keys of points `begin` to `end`; the greatest y times `factor`, from `least` on, is below 2^32."""
    for i in range(begin, end):
        keys[i] = (np.uint64((points[i, 1] - least) * factor) << _KEY_BITS) | np.uint64(i)


@exact_device
def _comes_before(points, i, j):
    """Whether point i comes before point j."""
    if points[i, 1] != points[j, 1]:
        return points[i, 1] < points[j, 1]
    return points[i, 0] < points[j, 0]


@exact_kernel
def sort_rows(points, keys):
    """Sort by y and x the points of each key, in sorted `keys`; whether all are distinct, and few are of one key."""
    first = 0
    for i in range(1, len(keys)):
        if keys[i] >> _KEY_BITS != keys[i - 1] >> _KEY_BITS:
            first = i
            continue
        if i - first >= _FEW:
            return False
        key, j = keys[i], i
        while j > first and _comes_before(points, key & _INDEX_MASK, keys[j - 1] & _INDEX_MASK):
            keys[j] = keys[j - 1]
            j -= 1
        keys[j] = key
        if j > first and not _comes_before(points, keys[j - 1] & _INDEX_MASK, key & _INDEX_MASK):
            return False
    return True


@exact_kernel
def take_rows(points, keys, begin, end, sites, names):
    """Write the points that keys `begin` to `end` name, and their numbers."""
    for i in range(begin, end):
        point = keys[i] & _INDEX_MASK
        sites[i, 0], sites[i, 1] = points[point, 0], points[point, 1]
        names[i] = point
