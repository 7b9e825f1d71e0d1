"""What the kernels of contouring share: the grid and its field, the scratch of a thread, and what a thread puts out.

The grid is cut into bricks of 32³ cells and these into blocks of 8³. A block is what is sampled at once; a brick is
what cells are merged within. Cells of a brick are numbered by Morton's code: bits of x, y, z in turns, so that the
cells of every cube of 2ⁿ cells lie side by side.
"""

from __future__ import annotations

from isophote.kernels.base.table import (
    BYTES,
    DOUBLE_BOXES,
    FLOAT,
    FLOATS,
    INT,
    INT_ROWS,
    INTS,
    Table,
)

__all__ = [
    "BLOCK",
    "BLOCK_SAMPLES",
    "BRICK",
    "CONTOUR",
    "CROSSING",
    "MOMENTS",
    "OUTPUT",
    "POINTS",
    "ROOT_ROWS",
    "WIDTH",
    "WORK",
]

BLOCK, BRICK = 8, 32
BLOCK_SAMPLES = 9**3
# Points in a pass over a block, in vectors of sixteen, and all of a block's, rounded up to whole passes.
WIDTH = 12
POINTS = 768
# Floats of a crossing: its place in the brick, in cells, and the unit normal there.
CROSSING = 6
# Numbers of a component's error function: matrix (6), right side (3), constant, sum of crossings (3), their number.
MOMENTS = 14
# Rows of the batches that roots are sought in.
ROOT_ROWS = 13

CONTOUR = Table(
    "Contour",
    rows=INTS,
    # Addresses of the interpreters: values, intervals, gradients.
    run_values=INT,
    run_intervals=INT,
    run_gradients=INT,
    # Coordinates of the samples along each axis, and the cells along each.
    xs=FLOATS,
    ys=FLOATS,
    zs=FLOATS,
    nx=INT,
    ny=INT,
    nz=INT,
    # Distance that a merged vertex may have from the surface, in cells; below 0, nothing is merged.
    reach=FLOAT,
    # Whether vertices lie on sharp edges (dual contouring) or in the middle of their crossings (surface nets).
    sharp=INT,
    cases=INTS,
    crossed=INTS,
    face_edges=INTS,
    inner_edges=INTS,
    outer_edges=INTS,
    # Where the cell of each code lies in its block: x + 16 y + 256 z.
    places=INTS,
)

WORK = Table(
    "ContourWork",
    # Addresses of what runs of the whole tape, of a brick's and of a block's read and write.
    far_run=INT,
    near_run=INT,
    leaf_run=INT,
    slots=FLOATS,
    near=INTS,
    leaf=INTS,
    far_choices=INTS,
    choices=INTS,
    marks=INTS,
    points=FLOATS,
    values=FLOATS,
    signs=INTS,
    rows_of_signs=INTS,
    crossed_cells=INTS,
    crossing_of=INTS,
    starts=INTS,
    roots=FLOATS,
    crossings=FLOATS,
    qefs=FLOATS,
    # Components of a brick, and what they are merged into.
    crossed=INT_ROWS,
    moments=DOUBLE_BOXES,
    places=DOUBLE_BOXES,
    codes=INTS,
    masks=INTS,
    parents=INTS,
    heads=INTS,
    tails=INTS,
    following=INTS,
    list=INTS,
    next_list=INTS,
    members=INTS,
    labels=INTS,
    numbers=INTS,
    levels=BYTES,
    # Marks of the cells of 2, 4, 8 and 16 cells of a brick that hold something not merged that far.
    unmerged=BYTES,
)

OUTPUT = Table(
    "ContourOutput",
    # Cells that the surface crosses: code within the brick, case, first component; and where it crosses the three edges
    # that start at the cell's low corner, with the normals there, ten bits a coordinate.
    codes=INTS,
    cases=INTS,
    firsts=INTS,
    crossings=FLOATS,
    normals=INTS,
    # Components, those of a brick's smallest cells first: what each was merged into, or -1, the level of its cell, and
    # the place of its vertex in cells of the grid.
    parents=INTS,
    levels=BYTES,
    places=DOUBLE_BOXES,
    # One row for each brick: where its cells and components end, and how many edges it owns.
    ends=INT_ROWS,
)
