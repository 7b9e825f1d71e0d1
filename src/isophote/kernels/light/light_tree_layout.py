"""A light tree in memory, and what it is asked with."""

from __future__ import annotations

from isophote.kernels.base.table import FLOATS, INT, INTS, Table

__all__ = [
    "ASK_WORDS",
    "AXIS",
    "CHANCE",
    "CHILDREN",
    "INTENSITY",
    "LANES",
    "LIGHT_TREE",
    "MIDDLE",
    "NODE",
    "NORMAL",
    "NUMBER",
    "OPENING",
    "PLACE",
    "RADIUS",
    "REACH",
    "SHARES",
    "SUMS",
]

# A node: rows of eight floats, one for each child. The middle and the radius of a ball around its lights, their axis,
# cosines of θ_o and θ_e, I, negative where light goes to both sides of the axis; then eight int32: the child's node, or
# ~k of light k. Lanes without a child have no intensity.
LANES = 8
MIDDLE, RADIUS, AXIS, OPENING, REACH, INTENSITY, CHILDREN = 0, 24, 32, 56, 64, 72, 80
NODE = 88

# What is asked: a place, the normal on the side from which light counts (zero: light counts from everywhere), a number
# in [0, 1); the answer's chance; scratch for a node's eight shares, and for their sums as doubles.
PLACE, NORMAL, NUMBER, CHANCE, SHARES, SUMS = 0, 3, 6, 7, 8, 16
ASK_WORDS = 32

# `nodes`: NODE words each, the root first; `parents` (nodes,): node · 8 + lane that each hangs on, −1 for the root;
# `leaves` (lights,): the same for each light, −1 for those that are not in the tree; `entry`: the entry's address.
LIGHT_TREE = Table("LightTree", nodes=FLOATS, parents=INTS, leaves=INTS, entry=INT)
