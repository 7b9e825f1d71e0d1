"""Fields in memory: for each a tape, and a tree of regions with shortened tapes.

The root region is a cube. A node splits a cube into 4 × 4 × 4 children, numbered x + 4 y + 16 z, and fills NODE words:
first a code for each child,

    EMPTY       the field is above zero everywhere
    INSIDE      it is below zero everywhere
    code > 0    the number of another node
    code < −1   neither is proven: −2 − code is the number of a tape that gives the field there

then, for each child, the number of a tape that gives the field there, whatever the code.
"""

from __future__ import annotations

from isophote.kernels.accel.layout import STACK, WIDTH
from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT_ROWS, FLOATS, INT, INT_ROWS, INTS, LONG_ROWS, Table
from isophote.kernels.forms.interpreters import INTERPRETERS
from isophote.kernels.forms.opcodes import INPUTS

__all__ = [
    "BALL",
    "CELLS",
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
    "LEVELS",
    "LINE",
    "LOOK",
    "LOOKS",
    "LOW",
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
# field, row of the item in `Surfaces`.
ROOT_CODE, LEVELS, ROOT_TAPE, SURFACE = 0, 1, 2, 3
# Columns of `Fields.cubes`: least corner of the root region, its side, least and greatest corner of what rays are
# clipped to, how much the transform to the world stretches at most, the shortest step that positions can tell apart,
# and the size of details, by which it is told how well a crossing must be known, middle and radius of a
# ball around the field in the world.
CELLS, SIDE, LOW, HIGH, STRETCH, SHORTEST, DETAIL, BALL = 0, 3, 4, 7, 10, 11, 12, 13

# `rows`: all tapes, one after another. `tapes` (t, 2): first row and number of rows of each. `nodes`: all trees.
# `numbers` (n, 4), `cubes` (n, 17): columns above. `to_object`, `to_world` (n, 12): rows of affine 3 × 4 matrices.
# `data` (n, words): packed FIELD_DATA of each. `top_nodes`, `top_items`: tree over the boxes of the fields in the
# world. `trace`, `surface`: addresses of the entries that answer for fields (field_trace.py, field_surface.py).
# `longest`: rows of the longest tape. `interpreters`: addresses of what runs tapes.
FIELDS = Table(
    "Fields",
    rows=INTS,
    tapes=INT_ROWS,
    nodes=INTS,
    numbers=INT_ROWS,
    cubes=FLOAT_ROWS,
    to_object=DOUBLE_BOXES,
    to_world=DOUBLE_BOXES,
    data=LONG_ROWS,
    top_nodes=FLOATS,
    top_items=INTS,
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
LOOK, LOOKS = 128, 4
PLACES_AT, PLACES_WORDS = STACK_AT + STACK_WORDS, LOOKS * (LOOK + 16)
CHOICES_AT = PLACES_AT + PLACES_WORDS
SLOT = 64
# Slots begin at a cache line: vectors that lie across two take twice as long.
LINE = 64


def field_scratch_words(longest: int) -> int:
    """Words of scratch that the entries need where the longest tape has so many rows."""
    return CHOICES_AT + longest + SLOT * (longest + INPUTS) + LINE // 4
