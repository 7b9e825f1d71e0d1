"""How a bounding interval hierarchy lies in memory, built or not.

Wächter, Keller: "Instant Ray Tracing: The Bounding Interval Hierarchy", EGSR 2006. A node parts its triangles in two
along an axis: those of the lower side end at one plane, those of the upper side begin at another, and the planes may
lie either way about each other. Of what else bounds its triangles a node knows one interval, on the axis where it cuts
off most of the space that the planes above leave: its slab. A node fills NODE words, the planes from word PLANES on:

    code (int32), end of the lower side, begin of the upper side, least and greatest coordinate on the slab's axis
    (float32), that axis (int32), two unused

Code WAITING: nobody has come here. BUSY: a thread is splitting it. Else (number + 1) · 4 + axis, or + LEAF. The slab is
written when the parent is split.

Triangles stand in an order of their own, and a node has a range of it. Ranges are cut at multiples of LANES, and no two
at the same place. So the place of the cut numbers a node's children: the cut before triangle 4 k has the nodes 2 k and
2 k + 1; and a leaf, which is four triangles from 4 k on, has block k. Threads need not agree on who comes first, and
all blocks are full. The root is node 0, and node 1 is none.

For each node there is a row of RANGE words, which is read when it is split and written when its parent is: bounds of
(c, −c), c twice the centres of its triangles' boxes, as in build.py, with its first triangle in lane 3 and its end in
lane 7 (int32); then the space that planes and slabs leave it, (lower, −upper).
"""

from __future__ import annotations

from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT, FLOATS, INT, INTS, Table

__all__ = [
    "BEGIN",
    "BIH",
    "BUSY",
    "CELLS",
    "END",
    "LEAF",
    "MOST_GRID_LEVELS",
    "NODE",
    "PLANES",
    "RANGE",
    "REGION",
    "SLAB",
    "SLAB_AXIS",
    "WAITING",
]

NODE = 8
PLANES = 1
SLAB, SLAB_AXIS = 3, 5
WAITING, BUSY = 0, -1
LEAF = 3

RANGE = 16
REGION = 8
BEGIN, END = 3, 7

# Cells of the grid along the longest side of everything; nodes are split at its planes, the coarsest first. Below so
# many levels, ranges are halved as they stand.
CELLS = 2.0**24
MOST_GRID_LEVELS = 160

# `nodes`, `ranges` as above; `records`: boxes and numbers of triangles (build.py), in the order that ranges are of;
# `positions`, `corners`: what blocks are filled from; `grid` (1, 4): origin and cells a unit of length, for twice the
# centres; `bounds` (6,): least and greatest corner; `reach`: the largest coordinate's size; `count`: triangles;
# `split`: address of the entry that splits nodes.
BIH = Table(
    "Bih",
    nodes=FLOATS,
    ranges=FLOATS,
    records=FLOATS,
    positions=FLOATS,
    corners=INTS,
    grid=DOUBLE_BOXES,
    bounds=FLOATS,
    reach=FLOAT,
    count=INT,
    split=INT,
)
