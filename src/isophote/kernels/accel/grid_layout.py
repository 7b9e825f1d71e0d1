"""How a grid of grids lies in memory.

Grid 0 holds everything; any cell may be a grid of its own. `frames` (grids, FRAME) float64: least corner, cell's size,
slack, how far from the frame's middle rays may begin that count as near, and how far from it corners of its triangles
lie, both along an axis; 1 / size. `shapes` (grids, 4) int64: cells on x, y, z, and the number of the first; then cells
go by x, then y, then z. A cell is one int32:

    c ≥ 0, even    list c / 2: lists[c / 2] are the first block of its triangles, how many these are, and its first row
                   of boxes; or NO_ROW where it has none; or MAILED where it has none and several cells have it
    c ≥ 0, odd     grid (c − 1) / 2
    c < 0          nothing; bits 3 o, 3 o + 1, 3 o + 2 say how many more cells on x, y and z, up to seven, lie empty
                   toward octant o, whose bit k is set where axis k goes down: a ray may pass all of that cube at once

A row holds the boxes of eight of a list's blocks, laid out as those of a node's children (layout.py): each is around
the parts of its triangles that lie in the cell. `reach` is the largest size of a coordinate.

The test of a triangle is as good as exact about a triangle whose corners have moved by ROUNDING times their distance
from the ray's origin along an axis. So a list holds every triangle that comes within that of its cell for the most
distant origins that count as near; rays from further away look into all cells as near to them as that (grid_far.py).
A frame is two slacks wider to every side than what it is to hold, where the slack is the largest of its triangles'.
"""

from __future__ import annotations

from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT, FLOATS, INT_ROWS, INTS, LONG_ROWS, Table

__all__ = ["FRAME", "GRID", "MAILED", "MOST_LEVELS", "NEAR_ORIGINS", "NOTHING", "NO_ROW", "ROUNDING", "ROW"]

GRID = Table("GridOfGrids", frames=DOUBLE_BOXES, shapes=LONG_ROWS, cells=INTS, lists=INT_ROWS, rows=FLOATS, reach=FLOAT)

# Columns of a frame.
FRAME = 12
SIZE, SLACK, NEAR, REACH, INVERSE = 3, 6, 7, 8, 9

# An empty cell that has no empty cells beside it.
NOTHING = -(1 << 31)
# Words of a row, and what stands for the first row of lists without.
ROW = 48
NO_ROW, MAILED = -1, -2
# Grids within grids.
MOST_LEVELS = 4
# Origins are near within so many half sizes of the grid.
NEAR_ORIGINS = 8.0
ROUNDING = 2.0**-20
