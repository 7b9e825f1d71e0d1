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
    FLOAT_ROWS,
    FLOATS,
    INT,
    INT_ROWS,
    INTS,
    Table,
)
from isophote.kernels.forms.field_data import FIELD_DATA
from isophote.kernels.forms.interpreters import INTERPRETERS

__all__ = [
    "AXIS_BIT",
    "BLOCK",
    "BLOCK_SAMPLES",
    "BRICK",
    "CODE_BIT",
    "CONTOUR",
    "CROSSING",
    "ELSEWHERE",
    "MOMENTS",
    "OUTPUT",
    "PADDING",
    "PLANE",
    "POINTS",
    "ROOT_ROWS",
    "WIDTH",
    "WORK",
]

BLOCK, BRICK = 8, 32
# Instead of a component that is yet to be looked for.
ELSEWHERE = -(1 << 31)
BLOCK_SAMPLES = 9**3
# Points in a pass over a block, in vectors of sixteen, and all of a block's, rounded up to whole passes.
WIDTH = 12
POINTS = 768
# Floats of a crossing: how far along its edge it lies, in cells, and the unit normal there.
CROSSING = 4
# Numbers of a crossing's plane, and of an error function: matrix (6), right side (3), constant, sum of crossings (3),
# their number, and two more to fill two registers; see kernels/base/simd_planes.py.
PLANE, MOMENTS = 8, 16
# Lanes beyond the last sample of an axis that may be read.
PADDING = 16
# Rows of the batches that roots are sought in.
ROOT_ROWS = 16

CONTOUR = Table(
    "Contour",
    rows=INTS,
    interpreters=INTERPRETERS,
    # Coordinates of the samples along each axis, PADDING more than there are, and the cells along each.
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
    # How the surface runs through a cube: contour_cases.py.
    cases=INTS,
    component_edges=INTS,
    inner_edges=INTS,
    outer_edges=INTS,
    face_bits=INTS,
    low_faces=INTS,
    high_faces=INTS,
    # The crossings of the components of each case, 12 words a case: from a cell's sample to the edge's start in
    # `crossing_of`, times four, plus which of the four cells round the edge the cell is.
    crossings_of_cases=INTS,
    # From the number of a cell's sample in its brick to that of each of its edges.
    edge_numbers=INTS,
    # Where the cubes of 2³ cells lie in a block, in the order of their codes: x + 16 y + 256 z.
    places=INTS,
)

WORK = Table(
    "ContourWork",
    # The tapes' tables, and slots; the tapes of a brick and of a block; what intervals chose in the whole tape and in
    # one of these.
    data=FIELD_DATA,
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
    # Where the edges crossed start in the block, x + 16 y + 256 z, and 4096 times their axis.
    corners=INTS,
    # Crossings that are sought now, and those to be sought again.
    pending=INTS,
    late=INTS,
    roots=FLOATS,
    # Crossings of a block: CROSSING numbers, PLANE numbers, and the components of the four cells round its edge, or
    # ELSEWHERE for those in other blocks.
    crossings=FLOATS,
    planes=DOUBLE_BOXES,
    around=INTS,
    qefs=FLOATS,
    # Components of a brick: first those of its smallest cells, with the number of the cell's sample, then what they are
    # merged into, with the numbers of the edges crossed.
    spots=INTS,
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
    # The parts of the components that are proposed, how many each has, and what entries of a list are connected to.
    members=INTS,
    counts=INTS,
    labels=INTS,
    levels=BYTES,
    # Marks of the cells of 2, 4, 8 and 16 cells of a brick that hold something not merged that far.
    unmerged=BYTES,
)

OUTPUT = Table(
    "ContourOutput",
    # Cells that the surface crosses: code within the brick, case, first component, first edge. All numbers of edges and
    # components are counted from the brick's first.
    codes=INTS,
    cases=INTS,
    firsts=INTS,
    first_edges=INTS,
    # Edges that the surface crosses, those of each cell that start at its low corner: a word (see below); the
    # components of the four cells round it, or ELSEWHERE for those in other blocks; and CROSSING numbers.
    edges=INTS,
    rings=INT_ROWS,
    crossings=FLOAT_ROWS,
    # Components, those of a brick's smallest cells first: what each was merged into, or -1, and how far on that is in
    # the end; the level of its cell; and the place of its vertex in cells of the grid, unless it is merged and one of
    # the smallest.
    parents=INTS,
    roots=INTS,
    levels=BYTES,
    places=DOUBLE_BOXES,
    # One row for each brick: where its cells, edges and components end, and how many cells have ambiguous faces.
    ends=INT_ROWS,
)

# An edge's word: whether its start is inside, its axis from this bit on, and the code of the cell that it starts at.
AXIS_BIT, CODE_BIT = 1, 3
