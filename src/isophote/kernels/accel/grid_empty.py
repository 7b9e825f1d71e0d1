"""How far cells around an empty cell are empty, so that rays pass many at once: grid_layout.py.

Cohen, Sheffer: "Proximity clouds: an acceleration technique for 3D grid traversal", The Visual Computer 11(1), 1994;
here there is a distance for each octant of directions, so that a ray that leaves a surface hops at once.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel

__all__ = ["measure_empty"]

_MOST = np.int64(7)


@device
def _toward(cells, shape, x, y, z, octant):
    """The least number of empty cells, this one not counted, that the seven neighbours toward an octant begin; all of
    space around the grid is empty."""
    least = _MOST
    for near in range(1, 8):
        i = x + (near & 1) * (1 - 2 * (octant & 1))
        j = y + (near >> 1 & 1) * (1 - (octant & 2))
        k = z + (near >> 2) * (1 - (octant >> 1 & 2))
        if 0 <= i < shape[0] and 0 <= j < shape[1] and 0 <= k < shape[2]:
            code = np.int64(cells[shape[3] + (k * shape[1] + j) * shape[0] + i])
            least = min(least, (code >> (3 * octant) & _MOST) + 1 if code < 0 else 0)
    return least


@kernel
def measure_empty(cells, shapes, begin, end):
    """Write to the empty cells of grids begin ≤ g < end how far it is empty toward each octant."""
    for grid in range(begin, end):
        shape = shapes[grid]
        nx, ny, nz = shape[0], shape[1], shape[2]
        for octant in range(8):
            for c in range(nx * ny * nz):
                # From the far end: what lies toward the octant comes first.
                x, y, z = c % nx, c // nx % ny, c // (nx * ny)
                x = x if octant & 1 else nx - 1 - x
                y = y if octant & 2 else ny - 1 - y
                z = z if octant & 4 else nz - 1 - z
                cell = shape[3] + (z * ny + y) * nx + x
                if cells[cell] < 0:
                    empty = _toward(cells, shape, x, y, z, octant)
                    cells[cell] = np.int32(np.int64(cells[cell]) + (empty << (3 * octant)))
