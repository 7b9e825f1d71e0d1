"""What threads contour with: the packed field and grid, scratch, and room for what they put out."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.linked import address_of
from isophote.kernels.base.table import Packed
from isophote.kernels.forms import tape_linked
from isophote.kernels.forms.opcodes import INPUTS, ROW
from isophote.kernels.measure import contour_cases as cases
from isophote.kernels.measure.contour_tables import (
    BLOCK,
    BLOCK_SAMPLES,
    CONTOUR,
    CROSSING,
    MOMENTS,
    OUTPUT,
    POINTS,
    ROOT_ROWS,
    WIDTH,
    WORK,
)
from isophote.kernels.measure.qef import QEF_WORDS
from isophote.shapes.field.evaluate import scratch

__all__ = ["new_output", "new_work", "pack_contour"]


@cache
def _places() -> npt.NDArray[np.int32]:
    """Where the cell of each code lies in its block."""
    code = np.arange(BLOCK**3, dtype=np.int32)
    places = np.zeros_like(code)
    for axis in range(3):
        for bit in range(3):
            places |= (code >> (3 * bit + axis) & 1) << (4 * axis + bit)
    return places


def pack_contour(rows: Any, axes: Any, reach: float, sharp: bool) -> Packed:
    """A field on a grid: its tape's rows, and the samples' coordinates along the three axes."""
    xs, ys, zs = axes
    return CONTOUR.pack(
        rows=rows.reshape(-1),
        run_values=address_of(tape_linked.values),
        run_intervals=address_of(tape_linked.intervals),
        run_gradients=address_of(tape_linked.gradients),
        xs=xs,
        ys=ys,
        zs=zs,
        nx=len(xs) - 1,
        ny=len(ys) - 1,
        nz=len(zs) - 1,
        reach=reach,
        sharp=sharp,
        cases=cases.CASES,
        crossed=cases.CROSSED,
        face_edges=cases.FACE_EDGES,
        inner_edges=cases.INNER_EDGES,
        outer_edges=cases.OUTER_EDGES,
        places=_places(),
    )


def new_work(rows: Any, data: Packed, components: int) -> Packed:
    """Scratch of one thread, for a tape's rows, their data, and bricks of so many components."""
    clusters = 6 * components
    tape_rows = len(rows)

    def ints(count: int) -> Any:
        return np.zeros(count, np.int32)

    slots = scratch((tape_rows + INPUTS) * 16 * WIDTH)
    near, leaf, far_choices, choices = (ints((tape_rows + 1) * size) for size in (ROW, ROW, 1, 1))
    runs = [
        tape_linked.TAPE_RUN.pack(rows=tape, data=data, slots=slots, choices=chosen)
        for tape, chosen in ((rows.reshape(-1), far_choices), (near, choices), (leaf, choices))
    ]
    packed = WORK.pack(
        far_run=runs[0].words.ctypes.data,
        near_run=runs[1].words.ctypes.data,
        leaf_run=runs[2].words.ctypes.data,
        slots=slots,
        near=near,
        leaf=leaf,
        far_choices=far_choices,
        choices=choices,
        marks=ints(tape_rows + INPUTS + 1),
        points=scratch(3 * POINTS),
        values=scratch(POINTS),
        signs=ints(POINTS // 16 + 1),
        rows_of_signs=ints(81),
        crossed_cells=ints(BLOCK * BLOCK),
        crossing_of=ints(3 * BLOCK_SAMPLES),
        starts=ints(3 * BLOCK_SAMPLES),
        roots=scratch(ROOT_ROWS * 16 * WIDTH),
        crossings=np.zeros(3 * BLOCK_SAMPLES * CROSSING, np.float32),
        qefs=scratch(QEF_WORDS),
        crossed=np.zeros((clusters, 12), np.int32),
        moments=np.zeros((clusters, MOMENTS)),
        places=np.zeros((clusters, 3)),
        codes=ints(clusters),
        masks=ints(clusters),
        parents=ints(clusters),
        heads=ints(clusters),
        tails=ints(clusters),
        following=ints(components),
        list=ints(components),
        next_list=ints(components),
        members=ints(16 * 32),
        labels=ints(64),
        numbers=ints(clusters),
        levels=np.zeros(clusters, np.uint8),
        unmerged=np.zeros(16**3 + 8**3 + 4**3 + 2**3, np.uint8),
    )
    return Packed(packed.words, packed.arrays | {"runs": tuple(runs)})


def new_output(cells: int, components: int, bricks: int) -> Packed:
    """Room for what some bricks put out."""
    return OUTPUT.pack(
        codes=np.zeros(cells, np.int32),
        cases=np.zeros(cells, np.int32),
        firsts=np.zeros(cells, np.int32),
        crossings=np.zeros(3 * cells, np.float32),
        normals=np.zeros(3 * cells, np.int32),
        parents=np.zeros(components, np.int32),
        levels=np.zeros(components, np.uint8),
        places=np.zeros((components, 3)),
        ends=np.zeros((bricks, 3), np.int32),
    )
