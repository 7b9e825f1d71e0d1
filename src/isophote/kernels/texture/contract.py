"""What a kind of texture is: an entry that is called by its address.

    look_up(textures, node, place)      leaves the linear colour and alpha of the node at a place of a surface

It takes the address of the TEXTURES table, the number of the node, and the address of the record below, which says
where the surface is looked at: in texture coordinates, in the shape's own space, in the world, and over how much of
each. The patch of surface that a pixel sees is an ellipse; of it there are the two half-axes, which are 0 where nobody
knows. A node may ask its children at the same record, or at another place if it puts back what it changed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.entry import call_entry, element_address, floats_at, opener_at, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.table import BYTE_ROWS, FLOAT_ROWS, FLOATS, INT, LONG_ROWS, Table
from isophote.kernels.base.vec import load_vec3, store_vec3

__all__ = [
    "CLAMP",
    "CODE_WORDS",
    "IN_FLOATS",
    "MIRROR",
    "NODE_WORDS",
    "PLAIN",
    "REPEAT",
    "SRGB",
    "TEXTURES",
    "WORDS",
    "Place",
    "answer",
    "look_up",
    "open_place",
]

# Columns of `Textures.nodes`: the entry, the picture's row of `codes`, first number in `data`, and nodes that it is
# made from.
LOOK_UP, PICTURE, DATA, CHILD_A, CHILD_B, CHILD_C = 0, 1, 2, 3, 4, 5
NODE_WORDS = 8

# The record. Texture coordinates and the two half-axes in them (u and v of the one, then of the other); the place in
# the shape's own space and the half-axes there; linear red, green, blue and alpha that were found; the place in the
# world and the half-axes there.
U, V, AXIS_A, AXIS_B, OWN, OWN_A, OWN_B, RESULT, ALPHA = 0, 1, 2, 4, 6, 9, 12, 16, 19
WORLD, WORLD_A, WORLD_B = 20, 23, 26
WORDS = 32

# Columns of `Textures.codes`: the first of a picture's rows of `levels` and how many there are, ways beyond the unit
# square, and how colours are encoded: the row of `decode` that bytes go through, or that texels lie in `floats`.
FIRST_LEVEL, LEVELS, WRAP_U, WRAP_V, ENCODING = 0, 1, 2, 3, 4
CODE_WORDS = 5
REPEAT, CLAMP, MIRROR = 0, 1, 2
SRGB, PLAIN, IN_FLOATS = 0, 1, 2

# `nodes` (n, 8), `codes` (pictures, 5): the columns above. `levels` (n, 3): first texel, width and height of a picture,
# or of means of it, each half as large as the one before. `bytes`, `floats` (texels, 4): red, green, blue, and alpha,
# which is never encoded. `decode` (2, 256): sRGB to linear, and plain. `data`: numbers of nodes.
# `to_own` (items, 12): rows of affine 3 × 4 matrices from the world to the space in which an item's shape is described.
# `colour`, `curvature`: the entries of trace/textured.py and trace/footprint.py.
TEXTURES = Table(
    "Textures",
    nodes=LONG_ROWS,
    codes=LONG_ROWS,
    levels=LONG_ROWS,
    bytes=BYTE_ROWS,
    floats=FLOAT_ROWS,
    decode=FLOAT_ROWS,
    data=FLOATS,
    to_own=FLOAT_ROWS,
    colour=INT,
    curvature=INT,
)

_WORDS = np.int64(WORDS)

_textures_at = opener_at(TEXTURES)


class Place(NamedTuple):
    """An entry's arguments, opened: the record, the textures, and the node."""

    record: object
    textures: object
    node: int


@device
def open_place(textures, node, place):
    """The `Place` of an entry's arguments."""
    return Place(floats_at(place, _WORDS), _textures_at(textures), node)


@device
def answer(place, colour, alpha):
    """Leave what was found."""
    store_vec3(place.record, RESULT, colour)
    place.record[ALPHA] = alpha
    return 0


@device
def look_up(textures, node, scratch, first):
    """(linear colour, alpha) of a node at the record that begins at `scratch[first]`."""
    arguments = (table_address(textures), node, element_address(scratch, first))
    call_entry(textures.nodes[node, LOOK_UP], arguments)
    return load_vec3(scratch, first + RESULT), scratch[first + ALPHA]
