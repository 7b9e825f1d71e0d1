"""How a tree of planes in any direction (a BSP tree) lies in memory.

A node fills NODE words; its children lie side by side, at an even number `child` (the lower side) and the next:

    axis      position of the plane (float32), child · 8 + axis (int32)
    slanted   the plane's number (int32), child · 8 + SLANTED (int32)
    leaf      first block (int32), triangles · 8 + LEAF (int32)

So planes along axes are in the node itself. A slanted plane n · x = place is four words of `planes`: n, of length 1,
and place. The lower side is n · x < place.
"""

from __future__ import annotations

from isophote.kernels.base.table import FLOAT, FLOATS, Table

__all__ = ["BSP", "KINDS", "LEAF", "MOST_DEPTH", "NODE", "PLANE", "SHIFT", "SLANTED", "TOLERANCE", "WIDER"]

NODE, PLANE = 2, 4
LEAF, SLANTED, KINDS, SHIFT = 3, 4, 7, 3
# 8 + 1.3 log2 n for 2^28 triangles.
MOST_DEPTH = 45

# What lies no farther from a plane than this share of the largest coordinate may be on either side of it: corners of a
# face, and the numbers of its plane, are rounded. Rays make up for that: their slack (spread.py) is so many times
# wider, which also covers the roundings of n · o and n · d.
TOLERANCE = 2.0**-21
WIDER = 4

# `nodes` and `planes` as above; `bounds` (6,): least and greatest corner; `reach`: the largest coordinate's size.
BSP = Table("Bsp", nodes=FLOATS, planes=FLOATS, bounds=FLOATS, reach=FLOAT)
