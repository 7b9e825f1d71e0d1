"""How a tree of planes in any direction (a BSP tree) lies in memory.

Rays go through treelets of seven planes n · x = place, |n| = 1 (treelet.py), which fill TREELET words:

    words 0–6, 8–14, 16–22    x, y, z of the planes' n
    words 24–30               places; those of planes that are missing are +inf, and their n is 0
    word 7                    bits 0–7: children that there are; bit 30 is set, so that the word is a float of common
                              size beside the planes'
    words 32–39               codes of children, int32

While it is built, a node has one plane and fills NODE words; its children lie side by side, at an even number `child`
(the lower side) and the next:

    axis      position of the plane (float32), child · 8 + axis (int32)
    slanted   the plane's number (int32), child · 8 + SLANTED (int32)
    leaf      first block (int32), triangles · 8 + LEAF (int32)

So planes along axes are in the node itself. A slanted plane is four words of `planes`: n and place. The lower side is
n · x < place.
"""

from __future__ import annotations

from isophote.kernels.base.table import FLOAT, FLOATS, INTS, Table

__all__ = [
    "BSP",
    "CODES",
    "COMMON",
    "KINDS",
    "LEAF",
    "NODE",
    "PLACES",
    "PLANE",
    "PRESENT",
    "SHIFT",
    "SLANTED",
    "TOLERANCE",
    "TREELET",
    "WIDER",
]

NODE, PLANE = 2, 4
LEAF, SLANTED, KINDS, SHIFT = 3, 4, 7, 3
TREELET, PRESENT, PLACES, CODES = 40, 7, 24, 32
COMMON = 1 << 30

# What lies no farther from a plane than this share of the largest coordinate may be on either side of it: corners of a
# face, and the numbers of its plane, are rounded. Rays make up for that: their slack (spread.py) is so many times
# wider, which also covers the roundings of n · o and n · d.
TOLERANCE = 2.0**-21
WIDER = 4

# `nodes`: treelets as above; `leaves` of two words (treelet.py); `bounds` (6,): least and greatest corner; `reach`: the
# largest coordinate's size.
BSP = Table("Bsp", nodes=FLOATS, leaves=INTS, bounds=FLOATS, reach=FLOAT)
