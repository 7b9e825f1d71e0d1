"""A triangle mesh made ready for the questions "how far" and "inside or outside", as one table.

All of it is in the mesh's frame: coordinates multiplied by a power of two that brings the mesh's size to about 1, which
rounds nothing. The tree is in single precision, over coordinates relative to the middle of the mesh; it finds what may
matter, and double precision decides. Taking the middle away and rounding to single precision never change the order
of two coordinates, so an axis-parallel ray through rounded boxes misses nothing.
"""

from __future__ import annotations

import numpy as np
from numba import types

from isophote.kernels.accel.layout import SCRATCH
from isophote.kernels.base.jit import device
from isophote.kernels.base.table import FLOATS, INT, Table, ViewType

__all__ = ["FURTHEST", "MESH_DISTANCE", "RIM_GROUP", "RIM_LANES", "STACK_WORDS", "open_mesh", "to_single"]

# float32 scratch of a query.
STACK_WORDS = SCRATCH
# Edges of the rim that are looked at together, and how many of these follow each other at a step.
RIM_LANES = 8
RIM_GROUP = 4
# Coordinates beyond this, in the mesh's frame, would overflow when products of them are multiplied.
FURTHEST = 2.0**200

_DOUBLE_ROWS = ViewType(types.float64, 2)
# Single-precision coordinates are clamped to this: their squares stay finite, and clamping brings a point nearer to
# everything in the mesh, so bounds of distances stay bounds.
_CLAMP = np.float64(2.0**60)

# `nodes`, `blocks`: the tree (accel/layout.py). `corners` (slots, 9): x, y, z of the three corners of the triangle in
# each slot of `blocks`. `frame` (1, 4): middle of the mesh, and the power of two that coordinates are multiplied by.
# `rim`: the directed edges that triangles run along in one direction more often than in the other, as rim.py has them;
# nothing where the mesh is closed. `closed`: whether there are none.
MESH_DISTANCE = Table(
    "MeshDistance", nodes=FLOATS, blocks=FLOATS, corners=_DOUBLE_ROWS, frame=_DOUBLE_ROWS, rim=_DOUBLE_ROWS, closed=INT
)
open_mesh = MESH_DISTANCE.open


@device
def to_single(x, middle):
    """A coordinate of the mesh's frame as the tree has it."""
    return np.float32(max(-_CLAMP, min(_CLAMP, x - middle)))
