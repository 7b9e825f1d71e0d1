"""What a material's entries are given: the frame of the surface and its parameters, with textures looked up.

An entry itself, so that tiles hold no look-up but that of the colours of matte surfaces.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.field_layout import FIELD
from isophote.kernels.accel.geometry import affine_vector
from isophote.kernels.accel.layout import BLOCK, LANES
from isophote.kernels.accel.surface import UVS
from isophote.kernels.base.entry import call_entry, entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int
from isophote.kernels.base.vec import cross, dot, load_vec3, normalise, orthonormal, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.trace.tables import SCENE
from isophote.kernels.trace.textured import slot_value, write_place
from isophote.kernels.trace.turned_normal import BUMP, NORMAL_MAP, normal_of_map

__all__ = ["prepare"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_LEAST = np.float32(1e-6)
_WORDS, _FIELD = np.int64(contract.WORDS), np.int64(FIELD)
# Columns of `Materials.spans`.
_ROOT, _FIRST, _COUNT, _TANGENT = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
# Column of `Materials.slot_codes`.
_CHANNEL = np.int64(1)

_scene_at = opener_at(SCENE)


@device
def _corner(blocks, at, k):
    at += 3 * LANES * k
    return vec3(blocks[at], blocks[at + LANES], blocks[at + 2 * LANES])


@device
def _upright(matrices, k):
    """The second axis of a shape's own space, in the world."""
    return vec3(np.float32(matrices[k, 1]), np.float32(matrices[k, 5]), np.float32(matrices[k, 9]))


@device
def _around_upright(scene, slot, instance, normal):
    """The way around the second axis of a primitive or a field, along which u of round primitives grows."""
    if slot > _FIELD:
        return cross(_upright(scene.primitives.to_world, instance), normal)
    return cross(_upright(scene.fields.to_world, instance), normal)


@device
def _along_u(scene, normal, scratch):
    """∂P/∂u of what was hit, or about that; zero where texture coordinates do not tell."""
    geometry, surfaces = scene.geometry, scene.surfaces
    slot = np.int64(load_int(scratch, contract.HIT_SLOT))
    instance = np.int64(load_int(scratch, contract.HIT_INSTANCE))
    nowhere = vec3(_ZERO, _ZERO, _ZERO)
    if slot < 0:
        return _around_upright(scene, slot, instance, normal)
    at = slot // LANES * BLOCK + slot % LANES
    blocks = geometry.blocks
    a = _corner(blocks, at, 0)
    edge1, edge2 = _corner(blocks, at, 1) - a, _corner(blocks, at, 2) - a
    if geometry.identity[instance] == 0:
        edge1 = affine_vector(geometry.to_world, instance, edge1)
        edge2 = affine_vector(geometry.to_world, instance, edge2)
    first = surfaces.items[np.int64(load_int(scratch, contract.ITEM)), UVS]
    if first < 0:
        return edge1
    row = first + np.int64(load_int(scratch, contract.TRIANGLE))
    p, q, r = surfaces.uv_corners[row, 0], surfaces.uv_corners[row, 1], surfaces.uv_corners[row, 2]
    uvs = surfaces.uvs
    u1, v1 = uvs[q, 0] - uvs[p, 0], uvs[q, 1] - uvs[p, 1]
    u2, v2 = uvs[r, 0] - uvs[p, 0], uvs[r, 1] - uvs[p, 1]
    area = u1 * v2 - u2 * v1
    if area == _ZERO:
        return nowhere
    along = edge1 * v2 - edge2 * v1
    return along if area > _ZERO else -along


@device
def _write_frame(scene, material, scratch):
    """The frame: z the shading normal on the side that is looked from, unless it and the true one disagree."""
    direction = load_vec3(scratch, contract.DIRECTION)
    true, shading = load_vec3(scratch, contract.OUTWARD), load_vec3(scratch, contract.SHADING)
    outside = dot(direction, true) < _ZERO
    side = _ONE if outside else -_ONE
    normal = (shading if (dot(direction, shading) < _ZERO) == outside else true) * side
    tangent, bitangent = orthonormal(normal)
    if scene.materials.spans[material, _TANGENT] != 0:
        along = _along_u(scene, true, scratch)
        along = along - normal * dot(along, normal)
        size2 = dot(along, along)
        if size2 > _ZERO:
            tangent = normalise(along)
            bitangent = cross(normal, tangent)
    store_vec3(scratch, contract.TANGENT, tangent)
    store_vec3(scratch, contract.BITANGENT, bitangent)
    store_vec3(scratch, contract.NORMAL, normal)
    store_vec3(scratch, contract.TRUE_NORMAL, true * side)
    scratch[contract.SIDE] = side
    # Not quite along the surface, so that nothing is divided by zero.
    out = vec3(-dot(direction, tangent), -dot(direction, bitangent), max(-dot(direction, normal), _LEAST))
    store_vec3(scratch, contract.OUT, out)


@entry
def prepare(scene_words, scratch_address):
    """Write frame, `out` and parameters of the surface in the scratch."""
    scene, scratch = _scene_at(scene_words), floats_at(scratch_address, _WORDS)
    material = np.int64(load_int(scratch, contract.MATERIAL))
    _write_frame(scene, material, scratch)
    if scene.textures.nodes.rows > 0:
        write_place(scene, scratch)
    first = np.int64(scene.materials.spans[material, _FIRST])
    for k in range(scene.materials.spans[material, _COUNT]):
        channel = scene.materials.slot_codes[first + k, _CHANNEL]
        if channel == NORMAL_MAP:
            value = normal_of_map(
                scene, first + k, _along_u(scene, load_vec3(scratch, contract.OUTWARD), scratch), scratch
            )
        elif channel == BUMP:
            call_entry(scene.materials.bump, (scene_words, scratch_address, np.int64(first + k)))
            value = load_vec3(scratch, contract.VALUE)
        else:
            value = slot_value(scene.materials, scene.textures, first + k, scratch)
        store_vec3(scratch, contract.PARAMETERS + 3 * k, value)
    return 0
