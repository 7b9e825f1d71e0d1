"""How a bounding interval hierarchy lies in memory of which only the upper part is built before rays come.

Wächter, Keller: "Instant Ray Tracing: The Bounding Interval Hierarchy", EGSR 2006. Triangles are sorted into the cells
of a grid by their centres, as there before large scenes are built on demand. Above the cells, nodes part what they hold
in two intervals along an axis, at the middle between centres and at no cost's advice; then binary nodes become nodes of
eight children, with whole boxes, as in layout.py. A cell is a leaf that waits (waiting.py): it is a part, and becomes a
tree by the surface area heuristic when the first ray comes to it.

So a part knows beforehand where all that is its own will lie, and threads need not agree on who comes first:

    order      the numbers of its triangles, from `begin` to `end`
    nodes      from node    part + begin // NODE_SHARE + those above the parts
    blocks     from block   part + begin // BLOCK_SHARE

A tree of n triangles that would need more than 1 + n / BLOCK_SHARE blocks or n / NODE_SHARE nodes is made by halves
instead, which never does.
"""

from __future__ import annotations

from isophote.kernels.base.table import FLOAT, FLOATS, INT, INTS, LONG_ROWS, Table

__all__ = ["BEGIN", "BIH", "BLOCK_SHARE", "BUSY", "END", "FINISHED", "NODE_SHARE", "UNTOUCHED", "WORD"]

# Columns of a part: its range of `order`, and the word of `nodes` that has its code.
BEGIN, END, WORD = 0, 1, 2
# What a part's state says.
UNTOUCHED, BUSY, FINISHED = 0, 1, 2

NODE_SHARE, BLOCK_SHARE = 8, 2

# `nodes`, `blocks`: as in layout.py; `first_node`: the first that is not above the parts. `parts` (k, 3), `states`
# (k,): as above. `order`: numbers of triangles, which are those of `positions`, `corners` and `last_point`
# (triangle_box.py). `reach`: the largest coordinate's size. `finish`: address of the entry that finishes parts.
BIH = Table(
    "Bih",
    nodes=FLOATS,
    blocks=FLOATS,
    first_node=INT,
    parts=LONG_ROWS,
    states=INTS,
    order=INTS,
    positions=FLOATS,
    corners=INTS,
    last_point=FLOATS,
    reach=FLOAT,
    finish=INT,
)
