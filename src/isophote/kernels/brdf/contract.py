"""What a kind of material is: two or three entries that tiles call by their address.

    evaluate(materials, node, scratch)         f(out, into) |cosθ| and the density with which `sample` goes there
    sample(materials, node, scratch)           a direction, f |cosθ| / density, and the density
    branch(materials, node, scratch, k)        the k-th of the single directions that light is sent to, and its share

All take the address of the MATERIALS table, the node of theirs, and the address of the scratch below. There they leave
what they find, and return 1 if that is light, else 0. Directions are local: z is the shading normal on the side that is
looked from, x the tangent along which texture coordinate u grows; `out` leaves the surface towards where the path came
from, `into` is where it goes on, with a negative z through the surface. Densities are per steradian; 0 means a single
direction, and the weight is then f |cosθ| integrated over it, divided by the chance of picking it. What `sample` leaves
in VALUE is divided by DENSITY.

A material is a tree of nodes, one unless it mixes or coats others. A node's parameters are slots: three floats each,
textures included, which lie in the scratch when an entry is called.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.entry import floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import load_vec3, store_vec3, vec3
from isophote.kernels.light.bsdf import MATERIALS
from isophote.kernels.texture import contract as texture

__all__ = [
    "MOST_SLOTS",
    "NODE_WORDS",
    "WORDS",
    "Lobe",
    "answer",
    "answer_branch",
    "answer_sample",
    "colour_slot",
    "cosine_direction",
    "datum",
    "into_of",
    "no_sample",
    "number_slot",
    "open_lobe",
    "out_of",
    "point_of",
    "share_of",
]

# Columns of `Materials.nodes`: entries, first slot counted from the material's, first number in `data`, nodes of what
# is mixed or coated, and how many branches there are.
EVALUATE, SAMPLE, BRANCH, FIRST_SLOT, DATA, CHILD_A, CHILD_B, BRANCHES = 0, 1, 2, 3, 4, 5, 6, 7
NODE_WORDS = 8

# Scratch. Local directions; f |cosθ|, or that over the density; the density; 1 where the surface is seen from outside,
# −1 from inside; a point of the unit disk and a number in [0, 1) to sample from.
OUT, INTO, VALUE, DENSITY, SIDE, X, Y, PICK = 0, 3, 6, 9, 10, 11, 12, 13
# The frame in the world, and the true normal on the same side.
TANGENT, BITANGENT, NORMAL, TRUE_NORMAL = 16, 19, 22, 25
# The surface, for trace/prepare.py: place, true and shading normals outward, the ray's direction, texture coordinates;
# slot, instance and item of the hit, its triangle and the material as int32; after the parameters, the record that
# textures are asked with (texture/contract.py).
PLACE, OUTWARD, SHADING, DIRECTION, U, V = 28, 31, 34, 37, 40, 41
# Half-width of the ray's cone where it met the surface, 0 where nobody knows, and what trace/footprint.py leaves.
RADIUS, CURVATURE = 47, 14
HIT_SLOT, HIT_INSTANCE, ITEM, TRIANGLE, MATERIAL = 42, 43, 44, 45, 46
PARAMETERS = 48
MOST_SLOTS = 48
TEXTURE_PLACE = PARAMETERS + 3 * MOST_SLOTS
# The weights of the second and the third corner of the triangle that was hit.
WEIGHT1, WEIGHT2 = TEXTURE_PLACE + texture.WORDS, TEXTURE_PLACE + texture.WORDS + 1
WORDS = TEXTURE_PLACE + texture.WORDS + 8

_WORDS = np.int64(WORDS)
_ZERO, _ONE = np.float32(0), np.float32(1)

_materials_at = opener_at(MATERIALS)


class Lobe(NamedTuple):
    """An entry's arguments, opened: the scratch, where the node's slots begin, the materials, and the node."""

    scratch: object
    first: int
    materials: object
    node: int


@device
def open_lobe(materials, node, scratch):
    """The `Lobe` of an entry's arguments."""
    table = _materials_at(materials)
    return Lobe(floats_at(scratch, _WORDS), PARAMETERS + 3 * table.nodes[node, FIRST_SLOT], table, node)


@device
def colour_slot(lobe, k):
    """Parameter `k` of the node, three floats."""
    return load_vec3(lobe.scratch, lobe.first + 3 * k)


@device
def number_slot(lobe, k):
    """Parameter `k` of the node, one float."""
    return lobe.scratch[lobe.first + 3 * k]


@device
def datum(lobe, k):
    """Number `k` of the node's data."""
    return lobe.materials.data[lobe.materials.nodes[lobe.node, DATA] + k]


@device
def out_of(lobe):
    """The direction that is looked along, z > 0."""
    return load_vec3(lobe.scratch, OUT)


@device
def into_of(lobe):
    """The direction asked for."""
    return load_vec3(lobe.scratch, INTO)


@device
def point_of(lobe):
    """(x, y, pick) to sample from."""
    return lobe.scratch[X], lobe.scratch[Y], lobe.scratch[PICK]


@device
def answer(lobe, value, density):
    """Leave what `evaluate` found; returns 1 where it is light."""
    store_vec3(lobe.scratch, VALUE, value)
    lobe.scratch[DENSITY] = density
    return np.int64(value.x + value.y + value.z > _ZERO)


@device
def answer_sample(lobe, into, value, density):
    """Leave what `sample` found: value / density, or the value itself where the density is 0: a single direction."""
    store_vec3(lobe.scratch, INTO, into)
    return answer(lobe, value * (_ONE / density if density > _ZERO else _ONE), density)


@device
def answer_branch(lobe, into, share):
    """Leave what `branch` found."""
    store_vec3(lobe.scratch, INTO, into)
    return answer(lobe, share, _ZERO)


@device
def no_sample(lobe):
    """Leave that `sample` found nothing."""
    return answer(lobe, vec3(_ZERO, _ZERO, _ZERO), _ONE)


@device
def cosine_direction(x, y):
    """The direction over a point of the unit disk: density cosθ / π."""
    return vec3(x, y, math.sqrt(max(_ZERO, _ONE - x * x - y * y)))


@device
def share_of(first, second):
    """The chance of picking a lobe that carries `first`, colours both, beside one that carries `second`."""
    a, b = first.x + first.y + first.z, second.x + second.y + second.z
    return a / (a + b) if a + b > _ZERO else _ONE
