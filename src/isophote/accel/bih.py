"""Bounding interval hierarchies of triangles, built by the rays that come: kernels/accel/bih_layout.py tells what they
are. Building leaves the root with all triangles; a node is split, and a leaf filled, when a ray first comes there."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Accelerator, Built
from isophote.accel.crew import crew, ranges
from isophote.kernels.accel.bih_entry import any_in_bih, closest_in_bih, things_in_bih
from isophote.kernels.accel.bih_layout import (
    BEGIN,
    BIH,
    CELLS,
    END,
    MOST_GRID_LEVELS,
    NODE,
    RANGE,
    REGION,
    SLAB,
    WAITING,
)
from isophote.kernels.accel.bih_split import split_all, split_node
from isophote.kernels.accel.build import RECORD, triangle_records
from isophote.kernels.accel.layout import BLOCK, LANES

__all__ = ["LAZY_BIH", "finish", "nodes_built"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]

# Levels of 2^28 triangles that are halved below the last level of the grid, and one to spare.
_MOST_LEVELS = MOST_GRID_LEVELS + 30


def _build(positions: FloatArray, triangles: IntArray, threads: int | None) -> Built:
    count = len(triangles)
    records = np.empty(count * RECORD, np.float32)
    points, corners = positions.reshape(-1), triangles.reshape(-1)
    pieces = list(ranges(0, count))
    found = np.full((len(pieces) + 1, 2 * RECORD), np.inf, np.float32)
    with crew(threads, count) as run:
        run(triangle_records, [(points, corners, records, *p, found[i]) for i, p in enumerate(pieces)])
    whole = found.min(axis=0)
    bounds = np.stack([whole[0:3], -whole[4:7]])
    blocks = -(-count // LANES)
    # Zeros cost nothing until somebody comes there: the system hands out pages when they are touched.
    rows = np.zeros(max(2 * blocks, 1) * RANGE, np.float32)
    rows[:RECORD] = whole[RECORD:]
    rows[REGION : REGION + RECORD] = whole[:RECORD]
    rows.view(np.int32)[[BEGIN, END]] = 0, count
    nodes = np.zeros(max(2 * blocks, 1) * NODE, np.float32)
    # Node 0's slab is all of x.
    nodes[SLAB : SLAB + 2] = bounds[:, 0]
    tables = BIH.pack(
        nodes=nodes,
        ranges=rows,
        records=records,
        positions=points,
        corners=corners,
        grid=_grid(bounds),
        bounds=bounds.reshape(-1),
        reach=float(np.abs(bounds).max()) if count else 0.0,
        count=count,
        split=split_node.address,
    )
    return Built(tables, np.zeros(blocks * BLOCK, np.float32), bounds)


def _grid(bounds: FloatArray) -> npt.NDArray[np.float64]:
    """Origin and cells a unit of length of the grid about everything, in twice the centres of boxes."""
    low, high = 2 * bounds.astype(np.float64)
    extent = float((high - low).max())
    return np.array([[*low, CELLS / extent if extent > 0 else 0.0]])


def finish(built: Built) -> None:
    """Split all nodes that no ray has come to yet."""
    if built.tables.arrays["count"]:
        waiting = np.empty((_MOST_LEVELS, 2), np.int64)
        split_all(built.tables.words.ctypes.data, built.blocks.ctypes.data, waiting)


def nodes_built(built: Built) -> int:
    """How many nodes have been split or made leaves so far."""
    codes = built.tables.arrays["nodes"].view(np.int32)[::NODE]
    return int(np.count_nonzero(codes != WAITING))


LAZY_BIH = Accelerator("bih", _build, closest_in_bih, any_in_bih, things_in_bih)
