"""Which triangles lie in which cells of a grid, and how fine it should be."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.clip import CLIP_WORDS, clip_extent, is_box, round_down, round_up
from isophote.kernels.accel.grid_layout import NEAR, NEAR_ORIGINS, ROUNDING, SLACK
from isophote.kernels.accel.overlap import OVERLAP_WORDS, overlaps, prepare_overlap
from isophote.kernels.base.jit import device, kernel

__all__ = [
    "BOX_COST",
    "NARROWEST",
    "TRIANGLE_COST",
    "choose_root",
    "choose_subgrids",
    "place_triangles",
    "slack_for",
    "triangle_sums",
]

# What a ray pays where a step to the next cell costs 1: for a triangle in a cell's list, for a box there, and for
# entering a grid within a grid. By measurement; docs/design/accelerators.md has the numbers.
TRIANGLE_COST, BOX_COST, _ENTER_COST = 0.02, 0.05, 12.0
# Cells, and references to triangles, for each triangle at most.
_MOST_CELLS, _MOST_REFERENCES = 16.0, 4.0
_MOST_ON_AXIS = 1 << 12
# Candidates for cells on the longest axis grow by this factor.
_GROWTH = 1.15
_ZERO, _ONE = np.int64(0), np.int64(1)
# Lists are left as they are unless a grid costs less than this part of them.
_WORTH = 0.6
# Cells are not made narrower than so many slacks.
NARROWEST = 16.0
# Columns of a job.
_GRID, _LOW, _HIGH, _FIRST, _LAST = 0, 1, 2, 3, 4


@device
def _cells_on(extent, size):
    """Cells of about this size on an extent."""
    return np.int64(max(1.0, min(np.floor(extent / size + 0.5), np.float64(_MOST_ON_AXIS))))


@device
def _cost(count, item_cost, sums, extents, nx, ny, nz):
    """(cost, references) of a grid for a line that meets its box.

    A line meets a cell with the probability of their areas, a / A. So it steps through n a / A cells and comes by
    R a / A triangles in lists, where R is the number of references. Triangles of any place meet planes ρ apart on
    average R = N + Σ E ρ + Σ S ρ ρ' times: E is the sum of their extents along an axis, S of their areas along one.
    """
    x, y, z = extents[0], extents[1], extents[2]
    hx, hy, hz = x / nx, y / ny, z / nz
    px, py, pz = (nx - 1) / x, (ny - 1) / y, (nz - 1) / z
    references = count + sums[0] * px + sums[1] * py + sums[2] * pz
    references += sums[3] * py * pz + sums[4] * pz * px + sums[5] * px * py
    share = (hx * hy + hy * hz + hz * hx) / (x * y + y * z + z * x)
    return share * (np.float64(nx) * ny * nz + item_cost * references), references


@device
def _choose_shape(count, item_cost, sums, extents, shape):
    """Write the cells on x, y, z that cost least to `shape`; return what they cost a line that meets the box.

    `item_cost` is what a triangle costs in a list. `sums` (6,): of the triangles' extents along x, y, z and of their
    areas as seen along x, y, z. `extents` (3,) are the box's, all positive.
    """
    longest = max(extents[0], max(extents[1], extents[2]))
    shape[0] = shape[1] = shape[2] = _ONE
    least, _ = _cost(count, item_cost, sums, extents, _ONE, _ONE, _ONE)
    cells = 2.0
    while cells <= _MOST_ON_AXIS:
        size = longest / cells
        nx, ny, nz = _cells_on(extents[0], size), _cells_on(extents[1], size), _cells_on(extents[2], size)
        cost, references = _cost(count, item_cost, sums, extents, nx, ny, nz)
        if np.float64(nx) * ny * nz > _MOST_CELLS * count + 64 or references > _MOST_REFERENCES * count + 64:
            break
        if cost < least:
            least = cost
            shape[0], shape[1], shape[2] = nx, ny, nz
        cells = max(cells * _GROWTH, cells + 1)
    return least


@kernel
def choose_root(count, item_cost, sums, extents, shape):
    """Write the cells on x, y, z of the outermost grid to `shape`; see _choose_shape."""
    _choose_shape(count, item_cost, sums, extents, shape)


@device
def _load_corners(positions, triangles, triangle, corners):
    for corner in range(3):
        vertex = 3 * np.int64(triangles[3 * triangle + corner])
        for axis in range(3):
            corners[3 * corner + axis] = positions[vertex + axis]


@kernel
def triangle_sums(positions, triangles, begin, end, sums):
    """Sum up extents of triangles begin ≤ i < end along x, y, z, and areas as seen along these, in `sums` (6,)."""
    corners = np.empty(9, np.float64)
    sums[:] = 0
    for triangle in range(begin, end):
        _load_corners(positions, triangles, triangle, corners)
        for axis in range(3):
            a, b, c = corners[axis], corners[axis + 3], corners[axis + 6]
            sums[axis] += max(a, max(b, c)) - min(a, min(b, c))
            u, v = (axis + 1) % 3, (axis + 2) % 3
            u1, v1 = corners[3 + u] - corners[u], corners[3 + v] - corners[v]
            u2, v2 = corners[6 + u] - corners[u], corners[6 + v] - corners[v]
            # A box fills what its diagonal spans.
            boxed = is_box(triangles, triangle)
            sums[axis + 3] += abs(u1 * v1) if boxed else 0.5 * abs(u1 * v2 - u2 * v1)


@device
def _cell_range(corners, axis, lower, size, count, slack):
    """First and last cell on an axis that the triangle's box comes within `slack` of."""
    a, b, c = corners[axis], corners[axis + 3], corners[axis + 6]
    low, high = min(a, min(b, c)) - slack, max(a, max(b, c)) + slack
    return _cell_of((low - lower) / size, count), _cell_of((high - lower) / size, count)


@device
def _cell_of(place, count):
    return np.int64(max(0.0, min(np.floor(place), np.float64(count - 1))))


@device
def _main_axis(work):
    """The axis along which the plane of a triangle made ready is crossed most steeply."""
    x, y, z = abs(work[0]), abs(work[1]), abs(work[2])
    if x >= y and x >= z:
        return 0
    return 1 if y >= z else 2


@device
def _column(work, main, rest, frame, low, high):
    """First and last cell of low ≤ c ≤ high in a column along axis `main` that the plane may pass through, one more on
    either side; `rest` is what the column's place on the other axes adds to the normal's product."""
    if work[main] == 0.0:
        return low, high
    a, b = (work[3] - work[4] - rest) / work[main], (work[3] + work[4] - rest) / work[main]
    first = np.floor((min(a, b) - frame[main]) / frame[3 + main] - 0.5)
    last = np.ceil((max(a, b) - frame[main]) / frame[3 + main] - 0.5)
    return np.int64(max(first, np.float64(low))), np.int64(min(last, np.float64(high)))


@device
def _drop(cursors, filled, cell, triangle):
    if filled.size > 0:
        filled[cursors[cell]] = np.int32(triangle)
    cursors[cell] += 1


@device
def _place(triangle, frame, shape, low, high, corners, half, work, cursors, filled):
    """Move on the cursor of every cell of low ≤ c ≤ high, three axes each, that a triangle overlaps, having written it
    there. It goes column by column along the axis on which the triangle is thin."""
    middle = np.empty(3, np.float64)
    strides = np.int64(1), shape[0], shape[0] * shape[1]
    prepare_overlap(corners, half, work)
    main = _main_axis(work)
    one, two = (main + 1) % 3, (main + 2) % 3
    for j in range(low[two], high[two] + 1):
        middle[two] = frame[two] + (j + 0.5) * frame[3 + two]
        for i in range(low[one], high[one] + 1):
            middle[one] = frame[one] + (i + 0.5) * frame[3 + one]
            rest = work[one] * middle[one] + work[two] * middle[two]
            first, last = _column(work, main, rest, frame, low[main], high[main])
            for k in range(first, last + 1):
                middle[main] = frame[main] + (k + 0.5) * frame[3 + main]
                if overlaps(work, middle[0], middle[1], middle[2]):
                    cell = shape[3] + j * strides[two] + i * strides[one] + k * strides[main]
                    _drop(cursors, filled, cell, triangle)


@device
def _place_box(triangle, shape, low, high, cursors, filled):
    """As _place, of a box: it overlaps all these cells."""
    for z in range(low[2], high[2] + 1):
        for y in range(low[1], high[1] + 1):
            first = shape[3] + (z * shape[1] + y) * shape[0]
            for cell in range(first + low[0], first + high[0] + 1):
                _drop(cursors, filled, cell, triangle)


@kernel
def slack_for(extent, reach):
    """The slack of a grid of a largest extent, whose triangles' corners lie within `reach` of its middle."""
    return ROUNDING * (NEAR_ORIGINS * 0.5 * extent + reach)


@device
def _reach_of(corners, middle_x, middle_y, middle_z):
    """How far a triangle's corners lie from a place along an axis."""
    reach = 0.0
    for corner in range(3):
        x, y, z = corners[3 * corner] - middle_x, corners[3 * corner + 1] - middle_y, corners[3 * corner + 2] - middle_z
        reach = max(reach, max(abs(x), max(abs(y), abs(z))))
    return reach


@device
def _slack_of(corners, frame, shape):
    """A triangle's slack in a grid: grid_layout.py."""
    x = frame[0] + 0.5 * shape[0] * frame[3]
    y = frame[1] + 0.5 * shape[1] * frame[4]
    z = frame[2] + 0.5 * shape[2] * frame[5]
    return ROUNDING * (frame[NEAR] + _reach_of(corners, x, y, z))


@kernel
def place_triangles(positions, triangles, references, frames, shapes, jobs, begin, end, cursors, filled):
    """Do jobs begin ≤ j < end, rows (grid, low z, high z, first reference, last): for each reference of a job in order,
    and every cell of low ≤ z < high in its grid that the triangle comes within its slack of, write the triangle to
    `filled` at the cell's cursor and move that on. Where `filled` is empty, cursors only count."""
    corners, half, work = np.empty(9, np.float64), np.empty(3, np.float64), np.empty(OVERLAP_WORDS, np.float64)
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for j in range(begin, end):
        grid = jobs[j, _GRID]
        frame, shape = frames[grid], shapes[grid]
        for k in range(jobs[j, _FIRST], jobs[j, _LAST]):
            triangle = np.int64(references[k])
            _load_corners(positions, triangles, triangle, corners)
            slack = _slack_of(corners, frame, shape)
            for axis in range(3):
                half[axis] = 0.5 * frame[3 + axis] + slack
                low[axis], high[axis] = _cell_range(corners, axis, frame[axis], frame[3 + axis], shape[axis], slack)
            low[2], high[2] = max(low[2], jobs[j, _LOW]), min(high[2], jobs[j, _HIGH] - 1)
            if low[0] == high[0] and low[1] == high[1] and low[2] == high[2]:
                cell = shape[3] + (low[2] * shape[1] + low[1]) * shape[0] + low[0]
                _drop(cursors, filled, cell, triangle)
            elif low[2] <= high[2] and is_box(triangles, triangle):
                _place_box(triangle, shape, low, high, cursors, filled)
            elif low[2] <= high[2]:
                _place(triangle, frame, shape, low, high, corners, half, work, cursors, filled)


@device
def _parts_in_cell(positions, triangles, references, first, last, cell, work, extent, sums, box):
    """As triangle_sums, of the parts of triangles that lie in a cell, six float32; and the `box` around these parts."""
    sums[:] = 0
    for axis in range(3):
        box[axis], box[axis + 3] = np.inf, -np.inf
    for k in range(first, last):
        if not clip_extent(positions, triangles, np.int64(references[k]), cell, work, extent):
            continue
        for axis in range(3):
            box[axis] = min(box[axis], np.float64(extent[axis]))
            box[axis + 3] = max(box[axis + 3], np.float64(extent[axis + 3]))
        x = np.float64(extent[3]) - np.float64(extent[0])
        y = np.float64(extent[4]) - np.float64(extent[1])
        z = np.float64(extent[5]) - np.float64(extent[2])
        # Of a box's side, a triangle's part seldom covers more than half.
        covered = 1.0 if is_box(triangles, np.int64(references[k])) else 0.5
        sums[0] += x
        sums[1] += y
        sums[2] += z
        sums[3] += covered * y * z
        sums[4] += covered * z * x
        sums[5] += covered * x * y
    return box[0] <= box[3]


@device
def _cell_box(frames, shapes, grid, cell, box):
    """The box of a cell, a slack wider than it."""
    rest, slack = cell - shapes[grid, 3], frames[grid, SLACK]
    for axis in range(3):
        low = frames[grid, axis] + rest % shapes[grid, axis] * frames[grid, 3 + axis]
        rest //= shapes[grid, axis]
        box[axis], box[axis + 3] = round_down(low - slack), round_up(low + frames[grid, 3 + axis] + slack)


@device
def _reach_in(positions, triangles, references, first, last, box, corners):
    """How far corners of triangles lie from the middle of a box along an axis."""
    reach = 0.0
    x, y, z = 0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4]), 0.5 * (box[2] + box[5])
    for k in range(first, last):
        _load_corners(positions, triangles, np.int64(references[k]), corners)
        reach = max(reach, _reach_of(corners, x, y, z))
    return reach


@device
def _surface(x, y, z):
    return x * y + y * z + z * x


@kernel
def choose_subgrids(
    positions, triangles, item_cost, references, starts, frames, shapes, grid, begin, end, chosen, boxes, reaches
):
    """For the cells begin ≤ c < end of grids in a row, the first in grid number `grid`, write to rows of `chosen`
    (cells, 3) the cells on x, y, z of the grid that each should be, or 0 where its list is cheaper; to `boxes` the box
    of the parts of triangles in it, and to `reaches` how far corners of its triangles lie from that one's middle along
    an axis. Cell c's triangles are starts[c] ≤ r < starts[c + 1]."""
    corners, box = np.empty(9, np.float64), np.empty(6, np.float64)
    work, extent, around = np.empty(CLIP_WORDS, np.float64), np.empty(6, np.float32), np.empty(6, np.float32)
    sums, extents = np.empty(6, np.float64), np.empty(3, np.float64)
    for cell in range(begin, end):
        while cell >= shapes[grid, 3] + shapes[grid, 0] * shapes[grid, 1] * shapes[grid, 2]:
            grid += 1
        chosen[cell, 0] = chosen[cell, 1] = chosen[cell, 2] = _ZERO
        first, last = starts[cell], starts[cell + 1]
        count = last - first
        if _WORTH * item_cost * count <= _ENTER_COST:
            continue
        _cell_box(frames, shapes, grid, cell, around)
        if not _parts_in_cell(positions, triangles, references, first, last, around, work, extent, sums, box):
            continue
        reach = _reach_in(positions, triangles, references, first, last, box, corners)
        largest = max(box[3] - box[0], max(box[4] - box[1], box[5] - box[2]))
        smallest = NARROWEST * slack_for(largest, reach)
        for axis in range(3):
            extents[axis] = max(box[axis + 3] - box[axis], 0.25 * smallest)
        within = _choose_shape(count, item_cost, sums, extents, chosen[cell])
        share = _surface(extents[0], extents[1], extents[2]) / _surface(
            frames[grid, 3], frames[grid, 4], frames[grid, 5]
        )
        narrow = False
        for axis in range(3):
            narrow = narrow or (chosen[cell, axis] > 1 and extents[axis] < smallest * chosen[cell, axis])
        if narrow or _ENTER_COST + min(share, 1.0) * within > _WORTH * item_cost * count:
            chosen[cell, 0] = _ZERO
            continue
        boxes[cell] = box
        reaches[cell] = reach
