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
    "RADIUS2",
    "REACH",
    "SHARES",
    "SIDE",
]

# A node: rows of eight floats, one for each child. The ball's middle and the square of its radius, the axis, cosine and
# sine of θ_o, cosine of θ_e, I, −1 where light goes to both sides of the axis, else 1; then eight int32: the child's
# node, or ~k of light k. Lanes without a child have no intensity.
LANES = 8
MIDDLE, RADIUS2, AXIS, OPENING, REACH, INTENSITY, SIDE, CHILDREN = 0, 24, 32, 56, 72, 80, 88, 96
NODE = 104

# What is asked: a place, the normal on the side from which light counts (zero: light counts from everywhere), a number
# in [0, 1); the answer's chance; scratch for a node's eight shares.
PLACE, NORMAL, NUMBER, CHANCE, SHARES = 0, 3, 6, 7, 8
ASK_WORDS = 16

# `nodes`: NODE words each, the root first; `parents` (nodes,): node · 8 + lane that each hangs on, −1 for the root;
# `leaves` (lights,): the same for each light, −1 for those that are not in the tree; `entry`: the entry's address.
LIGHT_TREE = Table("LightTree", nodes=FLOATS, parents=INTS, leaves=INTS, entry=INT)
