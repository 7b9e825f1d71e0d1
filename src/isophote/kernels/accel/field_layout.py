"""Fields in memory: for each a tape, and a tree of regions with shortened tapes.

The root region is a cube. A node splits a cube into 4 × 4 × 4 children, numbered x + 4 y + 16 z, and fills NODE words:
first a code for each child,

    EMPTY       the field is above zero everywhere
    INSIDE      it is below zero everywhere
    code > 0    the number of another node
    code < −1   neither is proven: −2 − code is the number of a tape that gives the field there

then, for each child, the number of a tape that gives the field there, whatever the code. Beside the nodes, `finer` has
for each child a set of 4 × 4 × 4 cells, as 64 bits: those in which it is not proven that the field is above zero. For a
child with a node of its own these are the children that are not EMPTY; rays need not look at the node to pass it by.
"""

from __future__ import annotations

from isophote.kernels.accel.layout import STACK, WIDTH
from isophote.kernels.accel.things import BOXES
from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT_ROWS, FLOATS, INT, INT_ROWS, INTS, LONG_ROWS, LONGS, Table
from isophote.kernels.forms.interpreters import INTERPRETERS
from isophote.kernels.forms.opcodes import INPUTS

__all__ = [
    "ABOVE",
    "BALL",
    "CELLS",
    "CELLS_AT",
    "CELLS_WORDS",
    "CHILDREN",
    "CHOICES_AT",
    "DETAIL",
    "EMPTY",
    "FIELD",
    "FIELDS",
    "FIRST_TAPE",
    "HIGH",
    "INPUTS",
    "INSIDE",
    "KEPT_AT",
    "LEAVES_AT",
    "LEVELS",
    "LEVEL_WORDS",
    "LINE",
    "LOOK",
    "LOOKS",
    "LOW",
    "MOST_LEVELS",
    "NODE",
    "PLACES_AT",
    "PLACES_WORDS",
    "RAY_WORDS",
    "ROOT_CODE",
    "ROOT_TAPE",
    "SHORTEST",
    "SIDE",
    "SLOT",
    "STACK_AT",
    "STACK_WORDS",
    "STRETCH",
    "SURFACE",
    "field_scratch_words",
]

CHILDREN = 64
NODE = 2 * CHILDREN
EMPTY, INSIDE, FIRST_TAPE = 0, -1, -2

# Slots of hits on fields: FIELD − number of the tape.
FIELD = -16

# Columns of `Fields.numbers`: code of the root (as a child's; node 0 is none), levels of nodes, tape of the whole
# field, row of the item in `Surfaces`, the node whose child 0 is the root.
ROOT_CODE, LEVELS, ROOT_TAPE, SURFACE, ABOVE = 0, 1, 2, 3, 4
# Columns of `Fields.cubes`: least corner of the root region, its side, least and greatest corner of what rays are
# clipped to, how much the transform to the world stretches at most, the shortest step that positions can tell apart,
# and the size of details, by which it is told how well a crossing must be known, middle and radius of a
# ball around the field in the world.
CELLS, SIDE, LOW, HIGH, STRETCH, SHORTEST, DETAIL, BALL = 0, 3, 4, 7, 10, 11, 12, 13

# `rows`: all tapes, one after another. `tapes` (t, 2): first row and number of rows of each. `nodes`, `finer`: all
# trees. `numbers` (n, 5), `cubes` (n, 17): columns above. `to_object`, `to_world` (n, 12): rows of affine 3 × 4
# matrices. `data` (n, words): packed FIELD_DATA of each. `top_nodes`, `top_items`: tree over the boxes of the fields in
# the world, where there are several, or `boxes`, another accelerator over them (things.py). `trace`, `surface`:
# addresses of the entries that answer for fields (field_trace.py, field_surface.py). `longest`: rows of the longest
# tape. `interpreters`: addresses of what runs tapes.
FIELDS = Table(
    "Fields",
    rows=INTS,
    tapes=INT_ROWS,
    nodes=INTS,
    finer=LONGS,
    numbers=INT_ROWS,
    cubes=FLOAT_ROWS,
    to_object=DOUBLE_BOXES,
    to_world=DOUBLE_BOXES,
    data=LONG_ROWS,
    top_nodes=FLOATS,
    top_items=INTS,
    boxes=BOXES,
    trace=INT,
    surface=INT,
    longest=INT,
    interpreters=INTERPRETERS,
)

# Scratch of the entries: words of a ray or a surface, a stack for the tree over boxes with a row of distances, places
# and values along a ray, a choice for each row of the longest tape, and slots for it.
RAY_WORDS = 16
STACK_AT, STACK_WORDS = RAY_WORDS, STACK + WIDTH
# Looks at 64 points each: places and values, a number, and room to the next.
LOOK, LOOKS = 128, 7
PLACES_AT, PLACES_WORDS = STACK_AT + STACK_WORDS, LOOKS * (LOOK + 16)
# For each level that a ray is in, with the one above the root and the cells within a region: where the ray enters 64
# cells, from LEAVES_AT on where it leaves them, and from KEPT_AT on what is kept of the node.
LEAVES_AT, KEPT_AT, LEVEL_WORDS, MOST_LEVELS = 64, 128, 144, 4
CELLS_AT, CELLS_WORDS = PLACES_AT + PLACES_WORDS, (MOST_LEVELS + 2) * LEVEL_WORDS
CHOICES_AT = CELLS_AT + CELLS_WORDS
SLOT = 64
# Slots begin at a cache line: vectors that lie across two take twice as long.
LINE = 64


def field_scratch_words(longest: int) -> int:
    """Words of scratch that the entries need where the longest tape has so many rows."""
    return CHOICES_AT + longest + SLOT * (longest + INPUTS) + LINE // 4
