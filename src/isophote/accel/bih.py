"""Bounding interval hierarchies of triangles, finished by the rays that come: kernels/accel/bih_layout.py has what they
are. Building makes the upper part, over parts of some hundred triangles; a part becomes a tree when a ray first comes
there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Accelerator, Built
from isophote.accel.bih_parts import no_parts, sort_into_parts
from isophote.accel.crew import crew
from isophote.kernels.accel.bih_entry import any_in_bih, closest_in_bih, things_in_bih
from isophote.kernels.accel.bih_finish import finish_all, finish_part
from isophote.kernels.accel.bih_layout import BIH, BLOCK_SHARE, FINISHED, NODE_SHARE
from isophote.kernels.accel.bih_top import interval_nodes
from isophote.kernels.accel.build import RECORD
from isophote.kernels.accel.build_wide import collapse_costs, lay_out
from isophote.kernels.accel.layout import BLOCK, CHILD, LOWER, NODE, REACH, UPPER, WIDTH
from isophote.kernels.base.table import Packed

__all__ = ["LAZY_BIH", "finish", "join_blocks", "parts_finished"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]
Longs: TypeAlias = npt.NDArray[np.int64]

# Items of a leaf of the upper part, what it costs to come to one, and to go through it, where a node costs 1.
_COLLAPSE = 1, 1, np.float32(0), np.float32(8)


def _build(positions: FloatArray, triangles: IntArray, threads: int | None) -> Built:
    count = len(triangles)
    points, corners = positions.reshape(-1), triangles.reshape(-1)
    last_point = np.zeros(4, np.float32)
    last_point[: len(points[-3:])] = points[-3:]
    if count == 0:
        parts, upper, words = no_parts(), _node_without_children(), np.empty(0, np.int64)
    else:
        with crew(threads, count) as run:
            parts = sort_into_parts(points, corners, last_point, run)
        upper, words = _upper_part(parts.boxes)
    whole = parts.boxes.min(axis=0, initial=np.inf)
    bounds = np.stack([whole[0:3], -whole[4:7]])
    reach = float(np.abs(bounds).max()) if count else 0.0
    upper[REACH] = reach
    # Zeros cost nothing until somebody comes there: the system hands out pages when they are touched.
    nodes = np.zeros((len(upper) // NODE + len(parts.boxes) + count // NODE_SHARE) * NODE, np.float32)
    nodes[: len(upper)] = upper
    tables = BIH.pack(
        nodes=nodes,
        blocks=np.zeros((len(parts.boxes) + count // BLOCK_SHARE) * BLOCK, np.float32),
        first_node=len(upper) // NODE,
        parts=np.stack([parts.starts[:-1], parts.starts[1:], words], axis=1),
        states=np.zeros(len(parts.boxes), np.int32),
        order=parts.order,
        positions=points,
        corners=corners,
        last_point=last_point,
        reach=reach,
        finish=finish_part.address,
    )
    return Built(tables, tables.arrays["blocks"], bounds)


def _node_without_children() -> FloatArray:
    node = np.zeros(NODE, np.float32)
    node[LOWER:UPPER], node[UPPER:CHILD] = np.inf, -np.inf
    return node


def _upper_part(boxes: FloatArray) -> tuple[FloatArray, Longs]:
    """Nodes above parts with these boxes, (k, 8) records, and for each part the word of its code."""
    count = len(boxes)
    records = boxes.copy()
    records.view(np.int32)[:, 3] = np.arange(count)
    nodes, children = np.empty(2 * count * RECORD, np.float32), np.empty(2 * count, np.int32)
    order, costs = np.empty(count, np.int32), np.empty(2 * count * WIDTH, np.float32)
    size = interval_nodes(records.reshape(-1), nodes, children, order)
    collapse_costs(nodes, children, costs, 0, size, *_COLLAPSE)
    slots, tasks = np.empty(count, np.int32), np.empty(2, np.int64)

    def write(wide: FloatArray) -> int:
        number, _, _ = lay_out(nodes, children, costs, order, wide, slots, tasks, 0, -1, 0, 0, 0, *_COLLAPSE)
        return int(number)

    wide = np.empty(write(np.empty(0, np.float32)) * NODE, np.float32)
    write(wide)
    codes = wide.view(np.int32)
    # Leaves are slots so far, and shall be parts that wait.
    leaves = np.flatnonzero(codes.reshape(-1, NODE)[:, CHILD : CHILD + WIDTH].reshape(-1) < 0)
    at = leaves // WIDTH * NODE + CHILD + leaves % WIDTH
    parts = slots[(-1 - codes[at]) >> 3]
    codes[at] = -1 - 8 * parts
    words = np.empty(count, np.int64)
    words[parts] = at
    return wide, words


def join_blocks(objects: Sequence[Built]) -> tuple[FloatArray, list[Packed]]:
    """One array for the blocks of several hierarchies that no ray has come to yet, and tables that have it."""
    tables = [built.tables for built in objects]
    if len(objects) == 1:
        return objects[0].blocks, tables
    firsts = np.cumsum([0, *(len(built.blocks) for built in objects)])
    blocks = np.zeros(firsts[-1], np.float32)
    parts = zip(tables, firsts[:-1].tolist(), firsts[1:].tolist(), strict=True)
    return blocks, [BIH.pack(**{**one.arrays, "blocks": blocks[begin:end]}) for one, begin, end in parts]


def finish(built: Built) -> None:
    """Make trees of all parts that no ray has come to yet."""
    finish_all(built.tables.words.ctypes.data)


def parts_finished(built: Built) -> tuple[int, int]:
    """How many parts are trees so far, and of how many."""
    states = built.tables.arrays["states"]
    return int(np.count_nonzero(states == FINISHED)), len(states)


LAZY_BIH = Accelerator("bih", _build, closest_in_bih, any_in_bih, things_in_bih)
