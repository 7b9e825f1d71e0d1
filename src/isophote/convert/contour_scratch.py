"""What threads contour with: the packed field and grid, scratch, and room for what they put out."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.forms.opcodes import INPUTS, ROW
from isophote.kernels.forms.tape_entries import pack_interpreters
from isophote.kernels.measure import contour_cases as cases
from isophote.kernels.measure.contour_groups import MOST
from isophote.kernels.measure.contour_tables import (
    BLOCK,
    BLOCK_SAMPLES,
    BRICK,
    CONTOUR,
    CROSSING,
    MOMENTS,
    OUTPUT,
    PADDING,
    PLANE,
    POINTS,
    ROOT_ROWS,
    WIDTH,
    WORK,
)
from isophote.kernels.measure.contour_vertices import VERTICES
from isophote.kernels.measure.qef import QEF_WORDS
from isophote.shapes.field.evaluate import scratch

__all__ = ["new_output", "new_work", "pack_contour"]

# Of the edges that start at a block's samples.
_MOST_CROSSINGS = 3 * BLOCK_SAMPLES


@cache
def _places() -> npt.NDArray[np.int32]:
    """Where the cubes of 2³ cells lie in a block, in the order of their codes."""
    code = 8 * np.arange(BLOCK**3 // 8, dtype=np.int32)
    places = np.zeros_like(code)
    for axis in range(3):
        for bit in range(3):
            places |= (code >> (3 * bit + axis) & 1) << (4 * axis + bit)
    return places


@cache
def _crossings_of_cases() -> npt.NDArray[np.int32]:
    """For each case, its components' edges one after another; see CONTOUR."""
    starts = cases.edge_starts(BLOCK + 1)
    table = np.zeros((256, 12), np.int32)
    for signs in range(256):
        components = cases.COMPONENT_EDGES[4 * signs : 4 * signs + 4].tolist()
        edges = [edge for component in components for edge in range(12) if component >> edge & 1]
        table[signs, : len(edges)] = [4 * (edge // 4 * BLOCK_SAMPLES + starts[edge]) + edge % 4 for edge in edges]
    return table.reshape(-1)


@cache
def _edge_numbers() -> npt.NDArray[np.int32]:
    """From the number of a cell's sample in its brick to that of each of its edges."""
    side = BRICK + 1
    starts = cases.edge_starts(side)
    return np.array([edge // 4 * side**3 + starts[edge] for edge in range(12)], np.int32)


def pack_contour(rows: Any, axes: Any, reach: float, sharp: bool) -> Packed:
    """A field on a grid: its tape's rows, and the samples' coordinates along the three axes."""
    xs, ys, zs = (np.concatenate([axis, np.full(PADDING, axis[-1])]) for axis in axes)
    nx, ny, nz = (len(axis) - 1 for axis in axes)
    return CONTOUR.pack(
        rows=rows.reshape(-1),
        interpreters=pack_interpreters(),
        xs=xs,
        ys=ys,
        zs=zs,
        nx=nx,
        ny=ny,
        nz=nz,
        reach=reach,
        sharp=sharp,
        cases=cases.CASES,
        component_edges=cases.COMPONENT_EDGES,
        inner_edges=cases.INNER_EDGES,
        outer_edges=cases.OUTER_EDGES,
        face_bits=cases.FACE_BITS,
        low_faces=cases.LOW_FACES,
        high_faces=cases.HIGH_FACES,
        crossings_of_cases=_crossings_of_cases(),
        edge_numbers=_edge_numbers(),
        places=_places(),
    )


def _ints(*shape: int) -> npt.NDArray[np.int32]:
    return np.empty(shape, np.int32)


def _rows(count: int, size: int) -> npt.NDArray[np.float64]:
    """Rows of so many doubles, each on its own cache lines."""
    return scratch(2 * size * count).view(np.float64).reshape(count, size)


def new_work(rows: Any, data: Packed, components: int) -> Packed:
    """Scratch of one thread, for a tape's rows, their data, and bricks of so many components."""
    clusters = 6 * components
    tape_rows = len(rows)
    slots = scratch((tape_rows + INPUTS) * 16 * WIDTH)
    near, leaf, far_choices, choices = (np.zeros((tape_rows + 1) * size, np.int32) for size in (ROW, ROW, 1, 1))
    return WORK.pack(
        data=data,
        slots=slots,
        near=near,
        leaf=leaf,
        far_choices=far_choices,
        choices=choices,
        marks=_ints(tape_rows + INPUTS + 1),
        points=scratch(3 * POINTS),
        values=scratch(POINTS),
        signs=np.zeros(POINTS // 16 + 1, np.int32),
        rows_of_signs=_ints(81),
        crossed_cells=_ints(BLOCK * BLOCK),
        crossing_of=_ints(_MOST_CROSSINGS),
        starts=_ints(_MOST_CROSSINGS),
        corners=_ints(_MOST_CROSSINGS),
        pending=_ints(_MOST_CROSSINGS),
        late=_ints(_MOST_CROSSINGS),
        roots=scratch(ROOT_ROWS * 16 * WIDTH),
        crossings=np.empty(_MOST_CROSSINGS * CROSSING, np.float32),
        planes=_rows(_MOST_CROSSINGS, PLANE),
        around=_ints(4 * _MOST_CROSSINGS),
        qefs=np.zeros(QEF_WORDS, np.float32),
        spots=_ints(components),
        crossed=_ints(clusters, 12),
        moments=_rows(clusters, MOMENTS),
        places=np.empty((clusters, 3)),
        codes=_ints(clusters),
        masks=_ints(clusters),
        parents=_ints(clusters),
        heads=_ints(clusters),
        tails=_ints(clusters),
        following=_ints(components),
        list=_ints(components),
        next_list=_ints(components),
        members=_ints(VERTICES * MOST),
        counts=_ints(VERTICES),
        labels=_ints(2 * MOST),
        levels=np.empty(clusters, np.uint8),
        unmerged=np.empty(16**3 + 8**3 + 4**3 + 2**3, np.uint8),
    )


def new_output(cells: int, components: int, bricks: int) -> Packed:
    """Room for what some bricks put out."""
    edges = 3 * cells
    return OUTPUT.pack(
        codes=_ints(cells),
        cases=_ints(cells),
        firsts=_ints(cells),
        first_edges=_ints(cells),
        edges=_ints(edges),
        rings=_ints(edges, 4),
        crossings=np.empty((edges, CROSSING), np.float32),
        parents=_ints(components),
        roots=_ints(components),
        levels=np.empty(components, np.uint8),
        places=np.empty((components, 3)),
        ends=_ints(bricks, 4),
    )
