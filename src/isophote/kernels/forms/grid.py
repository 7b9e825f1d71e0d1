"""Samples on grids of squares or cubes, linear between them along each axis.

Beyond the grid, at a distance e from its nearest point, where the value is g, it is √(max(g, 0)² + e²) + min(g, 0).
A grid in the plane is one with a single layer.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, store_float
from isophote.kernels.base.table import FLOAT, FLOATS, INT, Table
from isophote.kernels.forms.field_data import DataTable
from isophote.kernels.forms.table_slots import ANY, LANES, reach_of, store_around, store_gradient
from isophote.kernels.forms.tape_interval import REGION_MIDDLE

__all__ = ["grid_table"]

# `values`: samples, x fastest, of `nx` · `ny` · `nz`; that of place (i, j, k) is at (x, y, z) + step · (i, j, k).
_GRID = Table(
    "Grid",
    values=FLOATS, nx=INT, ny=INT, nz=INT, x=FLOAT, y=FLOAT, z=FLOAT, step=FLOAT, slope=FLOAT, error=FLOAT,
)  # fmt: skip
_open_grid = opener_at(_GRID)

_ZERO, _ONE, _NAN = np.float32(0), np.float32(1), np.float32(np.nan)
# Single precision's error, as a part of coordinates, in cells, times slope, and of samples.
_ERROR = np.float32(2.0**-20)


class Place(NamedTuple):
    """A coordinate's cell, its place there from 0 to 1, and how far beyond the grid it is."""

    cell: int
    part: float
    beyond: float


class Sample(NamedTuple):
    """A grid's value at a point, and its derivatives."""

    value: float
    dx: float
    dy: float
    dz: float


@device
def _place(x, low, step, count):
    held = max(low, min(low + step * np.float32(count - 1), x))
    at = max(_ZERO, min(np.float32(count - 1), (held - low) / step))
    cell = max(min(np.int64(at), count - 2), 0)
    return Place(cell, at - np.float32(cell), x - held)


@device
def _mix(a, b, t):
    return a + t * (b - a)


@device
def _sample(grid, x, y, z):
    """The value and its derivatives; NaN where the point is."""
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        return Sample(_NAN, _NAN, _NAN, _NAN)
    p, q = _place(x, grid.x, grid.step, grid.nx), _place(y, grid.y, grid.step, grid.ny)
    flat = grid.nz == 1
    r = Place(np.int64(0), _ZERO, _ZERO) if flat else _place(z, grid.z, grid.step, grid.nz)
    row, layer = grid.nx, grid.nx * grid.ny
    at = p.cell + row * q.cell + layer * r.cell
    above = at if flat else at + layer
    v = grid.values
    a, b, c, d = v[at], v[at + 1], v[at + row], v[at + row + 1]
    e, f, g, h = v[above], v[above + 1], v[above + row], v[above + row + 1]
    low, high = (
        _mix(_mix(a, b, p.part), _mix(c, d, p.part), q.part),
        _mix(_mix(e, f, p.part), _mix(g, h, p.part), q.part),
    )
    held = _mix(low, high, r.part)
    dx = _mix(_mix(b - a, d - c, q.part), _mix(f - e, h - g, q.part), r.part) / grid.step
    dy = _mix(_mix(c - a, d - b, p.part), _mix(g - e, h - f, p.part), r.part) / grid.step
    dz = (high - low) / grid.step
    away = p.beyond * p.beyond + q.beyond * q.beyond + r.beyond * r.beyond
    if away == _ZERO:
        return Sample(held, dx, dy, dz)
    # Where samples are below 0 they count in full.
    part = max(held, _ZERO)
    length = np.float32(math.sqrt(part * part + away))
    share = part / length if part > _ZERO else _ONE
    return Sample(
        length + min(held, _ZERO),
        dx * share if p.beyond == _ZERO else p.beyond / length,
        dy * share if q.beyond == _ZERO else q.beyond / length,
        dz * share if r.beyond == _ZERO else r.beyond / length,
    )


@entry
def _values(words, slots_at, out, a, b, c, width):
    """Values at `width` · 16 points."""
    grid, slots = _open_grid(words), floats_at(slots_at, ANY)
    for i in range(LANES * width):
        z = _ZERO if grid.nz == 1 else load_float(slots, c + i)
        store_float(slots, out + i, _sample(grid, load_float(slots, a + i), load_float(slots, b + i), z).value)
    return 0


@entry
def _intervals(words, slots_at, out, a, b, c, width):
    """Bounds in sixteen regions."""
    grid, slots = _open_grid(words), floats_at(slots_at, ANY)
    for i in range(LANES):
        x, y = load_float(slots, a + REGION_MIDDLE + i), load_float(slots, b + REGION_MIDDLE + i)
        z = _ZERO if grid.nz == 1 else load_float(slots, c + REGION_MIDDLE + i)
        dx, dy = reach_of(slots, a, i), reach_of(slots, b, i)
        dz = _ZERO if grid.nz == 1 else reach_of(slots, c, i)
        error = grid.error + _ERROR * grid.slope * (abs(x) + abs(y) + abs(z))
        spread = grid.slope * np.float32(math.sqrt(dx * dx + dy * dy + dz * dz)) + error
        store_around(slots, out, i, _sample(grid, x, y, z).value, spread)
    return 0


@entry
def _gradients(words, slots_at, out, a, b, c, width):
    """Values and gradients at sixteen points."""
    grid, slots = _open_grid(words), floats_at(slots_at, ANY)
    for i in range(LANES):
        z = _ZERO if grid.nz == 1 else load_float(slots, c + i)
        found = _sample(grid, load_float(slots, a + i), load_float(slots, b + i), z)
        store_gradient(slots, out, i, found.value, (a, b, c), (found.dx, found.dy, found.dz))
    return 0


def grid_table(values: Any, low: Any, step: float, slope: float) -> DataTable:
    """Samples `values` (ny, nx) or (nz, ny, nx) float32, with the functions that interpreters call.

    `low` is the place of the first sample, `step` the distance between samples, `slope` a Lipschitz constant.
    """
    layers = values.reshape(-1, *values.shape[-2:])
    corner = (*low, 0.0)[:3]
    extent = np.abs(corner).max() + step * max(layers.shape)
    packed = _GRID.pack(
        values=np.ascontiguousarray(layers, np.float32).reshape(-1),
        nz=layers.shape[0], ny=layers.shape[1], nx=layers.shape[2],
        x=corner[0], y=corner[1], z=corner[2], step=step, slope=slope,
        error=_ERROR * (np.abs(layers).max() + slope * extent),
    )  # fmt: skip
    return DataTable(packed, (_values, _intervals, _gradients))
