"""Vertices of a contour's components: from their error functions, sixteen at once."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.measure.morton import unpacked
from isophote.kernels.measure.qef import BOX_HIGH, BOX_LOW, MATRIX, RIGHT, SOLUTION

__all__ = ["VERTICES", "load_error", "place_at_mean", "place_found", "put_plane", "square_error"]

# Functions solved at once.
VERTICES = 16


@device
def put_plane(row, x, y, z, u, v, w):
    """Write the plane at a point with a normal (u, v, w)."""
    row[0], row[1], row[2], row[3] = u, v, w, u * x + v * y + w * z
    row[4], row[5], row[6], row[7] = x, y, z, 1.0


@device
def place_at_mean(work, component):
    """Put a component's vertex in the middle of its crossings."""
    row, place = work.moments[component], work.places[component]
    share = 1.0 / row[13]
    place[0], place[1], place[2] = row[10] * share, row[11] * share, row[12] * share


@device
def load_error(work, lane, component, size):
    """Put a component's error function into a lane, with the cell of `size` that its code names as its box.

    Its vertex is put in the middle of its crossings, which the solution is relative to.
    """
    place_at_mean(work, component)
    row, place, qefs = work.moments[component], work.places[component], work.qefs
    x, y, z = place[0], place[1], place[2]
    xx, xy, xz, yy, yz, zz = row[0], row[1], row[2], row[3], row[4], row[5]
    qefs[MATRIX + lane], qefs[MATRIX + 16 + lane] = np.float32(xx), np.float32(xy)
    qefs[MATRIX + 32 + lane], qefs[MATRIX + 48 + lane] = np.float32(xz), np.float32(yy)
    qefs[MATRIX + 64 + lane], qefs[MATRIX + 80 + lane] = np.float32(yz), np.float32(zz)
    qefs[RIGHT + lane] = np.float32(row[6] - (xx * x + xy * y + xz * z))
    qefs[RIGHT + 16 + lane] = np.float32(row[7] - (xy * x + yy * y + yz * z))
    qefs[RIGHT + 32 + lane] = np.float32(row[8] - (xz * x + yz * y + zz * z))
    code = np.int64(work.codes[component])
    for axis in range(3):
        low = np.float64(unpacked(code >> axis) * size) - place[axis]
        qefs[BOX_LOW + 16 * axis + lane] = np.float32(low)
        qefs[BOX_HIGH + 16 * axis + lane] = np.float32(low + np.float64(size))


@device
def place_found(work, lane, component):
    """Move a component's vertex to what was found in a lane."""
    place, qefs = work.places[component], work.qefs
    for axis in range(3):
        place[axis] += np.float64(qefs[SOLUTION + 16 * axis + lane])


@device
def square_error(work, component, x, y, z):
    """Sum of the square distances of a point from the planes of a component, and their number."""
    row = work.moments[component]
    square = x * (row[0] * x + 2.0 * (row[1] * y + row[2] * z)) + y * (row[3] * y + 2.0 * row[4] * z) + row[5] * z * z
    return square - 2.0 * (row[6] * x + row[7] * y + row[8] * z) + row[9], row[13]
