"""A material asked for many directions at once: what plots, tables and tests are made of.

Directions are local, (n, 3) float32; an `out` with a negative z looks from inside. The material is the table's first.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.vec import load_vec3, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.light.bsdf import MATERIALS
from isophote.kernels.texture import contract as texture
from isophote.kernels.texture.contract import TEXTURES
from isophote.kernels.trace.textured import slot_value

__all__ = ["branch_many", "evaluate_many", "sample_many"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_LEAST = np.float32(1e-6)
_START, _MATERIAL = np.int64(0), np.int64(0)
_ROOT, _FIRST, _COUNT = np.int64(0), np.int64(1), np.int64(2)

open_materials, open_textures = MATERIALS.open, TEXTURES.open


@device
def _prepare(materials, textures, u, v, scratch):
    """Write the parameters at a place of the textures; returns the root node."""
    for k in range(contract.TEXTURE_PLACE, contract.WORDS):
        scratch[k] = _ZERO
    scratch[contract.TEXTURE_PLACE + texture.U], scratch[contract.TEXTURE_PLACE + texture.V] = u, v
    first = np.int64(materials.spans[_MATERIAL, _FIRST])
    for k in range(materials.spans[_MATERIAL, _COUNT]):
        store_vec3(scratch, contract.PARAMETERS + 3 * k, slot_value(materials, textures, first + k, scratch))
    return np.int64(materials.spans[_MATERIAL, _ROOT])


@device
def _set_out(scratch, outs, i):
    """Write a direction; returns the side that it looks from."""
    x, y, z = outs[i, 0], outs[i, 1], outs[i, 2]
    side = _ONE if z >= _ZERO else -_ONE
    scratch[contract.SIDE] = side
    store_vec3(scratch, contract.OUT, vec3(x, y, max(z * side, _LEAST)))
    return side


@device
def _set_row(rows, i, v):
    rows[i, 0], rows[i, 1], rows[i, 2] = v.x, v.y, v.z


@device
def _leave(scratch, i, side, found, intos, values, densities):
    into, value = load_vec3(scratch, contract.INTO), load_vec3(scratch, contract.VALUE)
    _set_row(intos, i, vec3(into.x, into.y, into.z * side))
    _set_row(values, i, value if found != 0 else value * _ZERO)
    densities[i] = scratch[contract.DENSITY]


@kernel
def evaluate_many(material_words, texture_words, u, v, outs, intos, values, densities, scratch):
    """f |cosθ| and the density of every pair of directions."""
    materials, textures = open_materials(material_words), open_textures(texture_words)
    root = _prepare(materials, textures, u, v, scratch)
    address = materials.nodes[root, contract.EVALUATE]
    arguments = (table_address(materials), root, element_address(scratch, _START))
    for i in range(len(outs)):
        side = _set_out(scratch, outs, i)
        store_vec3(scratch, contract.INTO, vec3(intos[i, 0], intos[i, 1], intos[i, 2] * side))
        _leave(scratch, i, side, call_entry(address, arguments), intos, values, densities)


@kernel
def sample_many(material_words, texture_words, u, v, outs, points, intos, weights, densities, scratch):
    """Directions for `points` (n, 3) of the unit disk and [0, 1), with f |cosθ| / density and the density."""
    materials, textures = open_materials(material_words), open_textures(texture_words)
    root = _prepare(materials, textures, u, v, scratch)
    address = materials.nodes[root, contract.SAMPLE]
    arguments = (table_address(materials), root, element_address(scratch, _START))
    for i in range(len(outs)):
        side = _set_out(scratch, outs, i)
        scratch[contract.X], scratch[contract.Y] = points[i, 0], points[i, 1]
        scratch[contract.PICK] = points[i, 2]
        _leave(scratch, i, side, call_entry(address, arguments), intos, weights, densities)


@kernel
def branch_many(material_words, texture_words, u, v, outs, k, intos, shares, densities, scratch):
    """The k-th single direction, and its share, of every `out`."""
    materials, textures = open_materials(material_words), open_textures(texture_words)
    root = _prepare(materials, textures, u, v, scratch)
    address = materials.nodes[root, contract.BRANCH]
    arguments = (table_address(materials), root, element_address(scratch, _START), np.int64(k))
    for i in range(len(outs)):
        side = _set_out(scratch, outs, i)
        _leave(scratch, i, side, call_entry(address, arguments), intos, shares, densities)
