"""An order of points of the plane in which neighbours are near each other, and the cuts that part it.

Points are sorted along a Z-curve over 65,536² cells; points of one cell are sorted again over their own bounds, a few
by x and y. Equal points end up side by side. The rank of the cut before each point says where a range is to be
divided: at its least rank, which occurs once. A cut of even rank is vertical and one of odd rank horizontal: points
before a cut lie strictly to the left of those behind it, or strictly below. Cuts among a few points sorted by x and y
are of even rank, and part points of equal x by y.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_kernel

__all__ = ["first_keys", "least_cut", "refine_cells", "sort_keys", "take_distinct"]

_CELLS = 65535.0
_KEY_BITS = np.uint64(32)
_INDEX_MASK = np.uint64(0xFFFFFFFF)
_FEW = np.int64(8)
_RANKS_A_LEVEL = np.int64(64)
_RANK_OF_FEW = np.int64(32)
_HUGE = 1e300
_DIGIT_BITS = np.uint64(11)
_DIGITS = 2048
_DIGIT_MASK = np.uint64(_DIGITS - 1)
_PASSES = 3


@exact_device
def _spread(cell):
    """The bits of a 16-bit number at even places."""
    x = cell & np.uint64(0xFFFF)
    x = (x | (x << np.uint64(8))) & np.uint64(0x00FF00FF)
    x = (x | (x << np.uint64(4))) & np.uint64(0x0F0F0F0F)
    x = (x | (x << np.uint64(2))) & np.uint64(0x33333333)
    return (x | (x << np.uint64(1))) & np.uint64(0x55555555)


@exact_device
def _key(x, y, frame):
    """The place along the curve; each step of rounding keeps the order of coordinates."""
    x_factor, y_factor, x_least, y_least, extent = frame
    cx = np.uint64((x * x_factor - x_least) / extent * _CELLS)
    cy = np.uint64((y * y_factor - y_least) / extent * _CELLS)
    return (_spread(cx) << np.uint64(1)) | _spread(cy)


@exact_device
def _frame(x_least, x_greatest, y_least, y_greatest):
    """What turns coordinates into cells; halves huge ones, whose differences would overflow."""
    x_factor = 0.5 if max(abs(x_least), abs(x_greatest)) > _HUGE else 1.0
    y_factor = 0.5 if max(abs(y_least), abs(y_greatest)) > _HUGE else 1.0
    extent = max((x_greatest * x_factor) - (x_least * x_factor), (y_greatest * y_factor) - (y_least * y_factor))
    return x_factor, y_factor, x_least * x_factor, y_least * y_factor, extent


@exact_kernel
def first_keys(points, begin, end, bounds, keys):
    """Write the keys of points `begin` to `end` (flat float64), with their numbers in the lower half.

    `bounds` are x_least, x_greatest, y_least, y_greatest.
    """
    frame = _frame(bounds[0], bounds[1], bounds[2], bounds[3])
    if frame[4] == 0:
        for i in range(begin, end):
            keys[i] = np.uint64(i)
        return
    for i in range(begin, end):
        keys[i] = (_key(points[2 * i], points[2 * i + 1], frame) << _KEY_BITS) | np.uint64(i)


@exact_kernel
def sort_keys(keys, spare):
    """Sort keys by their upper half, those of equal ones as they were; the result is in `spare`."""
    counts = np.zeros((_PASSES, _DIGITS), np.int64)
    for key in keys:
        for k in range(_PASSES):
            counts[k, (key >> (_KEY_BITS + np.uint64(k) * _DIGIT_BITS)) & _DIGIT_MASK] += 1
    source, target = keys, spare
    for k in range(_PASSES):
        places = counts[k]
        at = np.int64(0)
        for digit in range(_DIGITS):
            places[digit], at = at, at + places[digit]
        shift = _KEY_BITS + np.uint64(k) * _DIGIT_BITS
        for i in range(len(source)):
            digit = (source[i] >> shift) & _DIGIT_MASK
            target[np.uint64(places[digit])] = source[i]
            places[digit] += 1
        source, target = target, source


@exact_device
def _comes_before(points, a, b):
    ax, ay, bx, by = points[2 * a], points[2 * a + 1], points[2 * b], points[2 * b + 1]
    if ax != bx:
        return ax < bx
    if ay != by:
        return ay < by
    return a < b


@exact_device
def _same(points, a, b):
    return points[2 * a] == points[2 * b] and points[2 * a + 1] == points[2 * b + 1]


@exact_device
def _set_order(keys, i, point):
    keys[i] = np.uint64(point)


@exact_device
def _order(keys, i):
    return np.int64(keys[i] & _INDEX_MASK)


@exact_device
def _halve(cuts, begin, end, rank):
    """Ranks of the cuts within a range of at most `_FEW` points."""
    for i in range(begin + 1, end):
        low, high, finer = begin, end, rank
        while True:
            middle = (low + high) // 2
            if i == middle:
                break
            if i < middle:
                high = middle
            else:
                low = middle
            finer += 2
        cuts[i] = finer


@exact_device
def _sort_few(points, keys, cuts, same_as, begin, end, rank):
    """Sort a few points by x and y, equal ones behind the others."""
    for i in range(begin + 1, end):
        point = _order(keys, i)
        j = i
        while j > begin and _comes_before(points, point, _order(keys, j - 1)):
            keys[j] = keys[j - 1]
            j -= 1
        _set_order(keys, j, point)
    # Distinct ones move forward, the others behind.
    distinct = begin
    repeated = np.empty(_FEW, np.int64)
    count = 0
    for i in range(begin, end):
        point = _order(keys, i)
        if i > begin and _same(points, point, _order(keys, distinct - 1)):
            same_as[point] = _order(keys, distinct - 1)
            repeated[count] = point
            count += 1
        else:
            _set_order(keys, distinct, point)
            distinct += 1
    for i in range(count):
        _set_order(keys, distinct + i, repeated[i])
    _halve(cuts, begin, distinct, rank + _RANK_OF_FEW)


@exact_device
def _rank(key, before, rank):
    """The rank of the cut between two different keys, by the highest bit in which they differ."""
    difference = key ^ before
    while difference < np.uint64(1 << 31):
        difference <<= np.uint64(1)
        rank += 1
    return rank


@exact_device
def _sift(keys, base, at, count):
    key = keys[base + at]
    while True:
        child = 2 * at + 1
        if child >= count:
            break
        if child + 1 < count and keys[base + child + 1] > keys[base + child]:
            child += 1
        if keys[base + child] <= key:
            break
        keys[base + at] = keys[base + child]
        at = child
    keys[base + at] = key


@exact_device
def _heap_sort(keys, base, count):
    """Sort `count` keys from `base` on, at worst in count log count steps."""
    for at in range(count // 2 - 1, -1, -1):
        _sift(keys, base, at, count)
    for last in range(count - 1, 0, -1):
        keys[base], keys[base + last] = keys[base + last], keys[base]
        _sift(keys, base, np.int64(0), last)


@exact_device
def _resort(points, keys, begin, end):
    """Sort a range over its own bounds; returns whether all its points are equal."""
    first = _order(keys, begin)
    x_least = x_greatest = points[2 * first]
    y_least = y_greatest = points[2 * first + 1]
    for i in range(begin + 1, end):
        point = _order(keys, i)
        x, y = points[2 * point], points[2 * point + 1]
        x_least, x_greatest = min(x_least, x), max(x_greatest, x)
        y_least, y_greatest = min(y_least, y), max(y_greatest, y)
    frame = _frame(x_least, x_greatest, y_least, y_greatest)
    for i in range(begin, end):
        point = _order(keys, i)
        key = np.uint64(0) if frame[4] == 0 else _key(points[2 * point], points[2 * point + 1], frame)
        keys[i] = (key << _KEY_BITS) | np.uint64(point)
    _heap_sort(keys, begin, end - begin)
    return frame[4] == 0


@exact_device
def _longer(rows):
    """Twice the rows, of which the first are these."""
    longer = np.empty((2 * len(rows), 3), np.int64)
    for i in range(len(rows)):
        for k in range(3):
            longer[i, k] = rows[i, k]
    return longer


@exact_kernel
def refine_cells(points, keys, cuts, same_as, begin, end):
    """Sort within cells, and rank all cuts, for a range of sorted keys that ends where a cell does.

    `keys` become numbers of points in their lower halves. `same_as[i]` gets the number of the first point that equals
    point i, for all such i; their cuts mean nothing. The cut before `begin` is not ranked.
    """
    # Ranges of equal keys that are still to be sorted, and the ranks of their cuts.
    pending = np.empty((64, 3), np.int64)
    pending[0, 0], pending[0, 1], pending[0, 2] = begin, end, 0
    count = 1
    while count > 0:
        count -= 1
        low, high, rank = pending[count, 0], pending[count, 1], pending[count, 2]
        if rank > 0 and _resort(points, keys, low, high):
            for i in range(low + 1, high):
                same_as[_order(keys, i)] = _order(keys, low)
            continue
        start = low
        for i in range(low + 1, high + 1):
            key = keys[i] >> _KEY_BITS if i < high else np.uint64(0)
            before = keys[i - 1] >> _KEY_BITS
            if i < high and key == before:
                continue
            if i < high:
                cuts[i] = _rank(key, before, rank)
            if i - start > _FEW:
                if count == len(pending):
                    pending = _longer(pending)
                pending[count, 0], pending[count, 1], pending[count, 2] = start, i, rank + _RANKS_A_LEVEL
                count += 1
            elif i - start > 1:
                _sort_few(points, keys, cuts, same_as, start, i, rank)
            start = i


@exact_kernel
def take_distinct(points, keys, cuts, same_as, ordered, names):
    """Move the distinct points to `ordered` (flat), their numbers to `names`, and their cuts forward: how many."""
    count = np.int64(0)
    for i in range(len(keys)):
        point = _order(keys, i)
        if same_as[point] != point:
            continue
        ordered[2 * count] = points[2 * point]
        ordered[2 * count + 1] = points[2 * point + 1]
        names[count] = point
        cuts[count] = cuts[i]
        count += 1
    return count


@exact_kernel
def least_cut(cuts, begin, end):
    """Where a range of more than one point is to be divided."""
    best = begin + 1
    for i in range(begin + 2, end):
        if cuts[i] < cuts[best]:
            best = i
    return best
