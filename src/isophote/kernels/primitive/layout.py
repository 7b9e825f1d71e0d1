"""Primitives in memory: for each a kind, numbers of its own, and where it stands.

A kind is entries, found by their addresses in a primitive's row, so that no kernel knows which kinds there are. They
take the address of the primitive's numbers and that of WORDS doubles, all in the primitive's own space.

`meet` finds where the line from ORIGIN along DIRECTION crosses the surface at LOW < t < HIGH: it writes the first MOST
crossings, t and part of the surface one after the other from FOUND on, t not decreasing, and returns how many there
are. The words before FOUND stay.

`describe` is given a point of the surface, but for rounding, at PLACE, the part at PART, and at SLACK how far from the
edge of its part a place must stay. It writes the place on the surface, the outward normal, which is not a unit vector,
and texture coordinates.

Kinds that rays meet by few operations have a third one, which takes sixteen rays at once (lanes.py); others have 0 for
its address.
"""

from __future__ import annotations

from isophote.kernels.accel.layout import STACK, WIDTH
from isophote.kernels.accel.things import BOXES
from isophote.kernels.base.doubles import DOUBLES
from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT_ROWS, FLOATS, INT, INT_ROWS, INTS, LONG_ROWS, Table
from isophote.kernels.primitive.lanes import LANES

__all__ = [
    "BALL",
    "DESCRIBE",
    "DIRECTION",
    "ERROR",
    "FIRST",
    "FOUND",
    "HIGH",
    "LINE_AT",
    "LOW",
    "MEET",
    "MEET_LANES",
    "MOST",
    "NORMAL",
    "ORIGIN",
    "OWN_AT",
    "PART",
    "PARTS",
    "PLACE",
    "PRIMITIVES",
    "RAYS_AT",
    "RAY_WORDS",
    "SLACK",
    "SLOT",
    "STACK_AT",
    "STACK_WORDS",
    "STRETCH",
    "SURFACE",
    "UV",
    "WORDS",
]

# Words of `meet`.
ORIGIN, DIRECTION, LOW, HIGH, MOST, FOUND = 0, 3, 6, 7, 8, 9
# Words of `describe`; PLACE and what follows is written.
PART, SLACK, PLACE, NORMAL, UV = 0, 1, 2, 5, 8
WORDS = 20

# Slots of hits on primitives: SLOT − part, of which there are PARTS.
SLOT, PARTS = -3, 12

# Columns of `Primitives.numbers`: row of the item in `Surfaces`, first of its numbers in `values`.
SURFACE, FIRST = 0, 1
# Columns of `Primitives.entries`.
MEET, DESCRIBE, MEET_LANES = 0, 1, 2
# Columns of `Primitives.reach`: middle and radius of a ball around it in the world (infinite where endless), what
# rounding in its own space and on the way there and back adds to a place's error, and how much the way to its own
# space stretches.
BALL, ERROR, STRETCH = 0, 4, 5

# `numbers` (n, 2), `entries` (n, 3), `reach` (n, 6): columns above. `values`: numbers of all primitives' own.
# `to_object`, `to_world` (n, 12): rows of affine 3 × 4 matrices. `alone`: primitives that every ray asks, because they
# are endless or there are few. `top_nodes`, `top_items`: tree over the boxes of the others in the world, which `trace`
# goes through itself, unless `boxes` is another accelerator over them (accel/things.py), of which `boxed` tells the
# primitive of each box. `trace`, `trace_lanes`, `surface`: addresses of the entries that answer for all (trace.py,
# trace_lanes.py, surface.py).
PRIMITIVES = Table(
    "Primitives",
    numbers=INT_ROWS,
    entries=LONG_ROWS,
    reach=FLOAT_ROWS,
    values=DOUBLES,
    to_object=DOUBLE_BOXES,
    to_world=DOUBLE_BOXES,
    alone=INTS,
    top_nodes=FLOATS,
    top_items=INTS,
    boxes=BOXES,
    boxed=INTS,
    trace=INT,
    trace_lanes=INT,
    surface=INT,
)

# Scratch of the entries: words of a ray or a surface, doubles for a kind, a block of sixteen rays in the world, with t
# in its row T and what was met in its row PART; then a stack for the tree with a row of distances, or, before the tree
# is asked, a block of a kind's own and doubles behind it. It lies where trees of triangles have theirs, which have been
# asked by then.
RAY_WORDS = 16
LINE_AT = RAY_WORDS
# Blocks begin where lines of the processor's memory do, which vectors of eight doubles then never cross.
_LINE = 16
RAYS_AT = -(-(LINE_AT + 2 * WORDS) // _LINE) * _LINE
STACK_AT, STACK_WORDS = RAYS_AT + 2 * 9 * LANES, STACK + WIDTH
OWN_AT = STACK_AT
