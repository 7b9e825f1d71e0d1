"""How a grid of grids lies in memory.

Grid 0 holds everything; any cell may be a grid of its own. `frames` (grids, 6) float64: least corner and cell's size.
`shapes` (grids, 4) int64: cells on x, y, z, and the number of the first; then cells go by x, then y, then z. A cell is
one int32:

    0         nothing
    c > 0     list c: two int32 of `lists`, its first block and its number of triangles
    c < 0     grid −c

A list holds every triangle that comes within `slack` of its cell.
"""

from __future__ import annotations

from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT, INTS, LONG_ROWS, Table

__all__ = ["GRID", "MOST_LEVELS", "NEAR_ORIGINS", "SLACK"]

GRID = Table("Grid", frames=DOUBLE_BOXES, shapes=LONG_ROWS, cells=INTS, lists=INTS, slack=FLOAT, reach=FLOAT)

# Grids within grids.
MOST_LEVELS = 4

# `slack` is SLACK times the largest coordinate, `reach`: twice as much as spread.py asks for rays that begin within
# NEAR_ORIGINS times that. Rays from further away take a way of their own (grid_far.py).
NEAR_ORIGINS = 16.0
SLACK = NEAR_ORIGINS * 2.0**-19
