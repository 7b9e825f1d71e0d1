"""How a grid of grids lies in memory.

Grid 0 holds everything; any cell may be a grid of its own. `frames` (grids, FRAME) float64: least corner, cell's size,
slack, how far from the frame's middle rays may begin that count as near, and how far from it corners of its triangles
lie, both along an axis. `shapes` (grids, 4) int64: cells on x, y, z, and the number of the first; then cells go by x,
then y, then z. A cell is one int32:

    0         nothing
    c > 0     list c: lists[c, 0] is the first block of its triangles, and lists[c, 1] how many these are
    c < 0     grid −c

The test of a triangle is as good as exact about a triangle whose corners have moved by ROUNDING times their distance
from the ray's origin along an axis. So a list holds every triangle that comes within that of its cell for the most
distant origins that count as near; rays from further away look into all cells as near to them as that (grid_far.py).
A frame is two slacks wider to every side than what it is to hold, where the slack is the largest of its triangles'.
"""

from __future__ import annotations

from isophote.kernels.base.table import DOUBLE_BOXES, INT_ROWS, INTS, LONG_ROWS, Table

__all__ = ["FRAME", "GRID", "MOST_LEVELS", "NEAR_ORIGINS", "ROUNDING"]

GRID = Table("GridOfGrids", frames=DOUBLE_BOXES, shapes=LONG_ROWS, cells=INTS, lists=INT_ROWS)

# Columns of a frame.
FRAME = 9
SIZE, SLACK, NEAR, REACH = 3, 6, 7, 8

# Grids within grids.
MOST_LEVELS = 4
# Origins are near within so many half sizes of the grid.
NEAR_ORIGINS = 8.0
ROUNDING = 2.0**-20
