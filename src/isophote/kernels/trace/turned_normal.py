"""Normals that textures tell, in the world."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import affine_vector
from isophote.kernels.accel.surface import FLIPPED, NORMALS, TANGENTS
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int
from isophote.kernels.base.vec import cross, dot, length, load_vec3, normalise, orthonormal, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.texture import contract as texture

__all__ = ["BUMP", "NORMAL_MAP", "normal_of_map", "upright"]

# What stands for the channel in `Materials.slot_codes` where texels are tangent-space normals, and where they are
# heights.
NORMAL_MAP, BUMP = 4, 5

_ZERO, _ONE = np.float32(0), np.float32(1)
_PLACE = np.int64(contract.TEXTURE_PLACE)
# Turned normals lean so much towards the surface's own at least: cosine of some 89 degrees.
_LEAST = np.float32(0.02)


@device
def _corner_rows(scene, scratch, item, column):
    return np.int64(scene.surfaces.items[item, column]) + np.int64(load_int(scratch, contract.TRIANGLE))


@device
def _blended(rows, corners, row, scratch):
    """Rows of three corners, blended and not brought to length 1."""
    w1, w2 = scratch[contract.WEIGHT1], scratch[contract.WEIGHT2]
    w0 = _ONE - w1 - w2
    a, b, c = corners[row, 0], corners[row, 1], corners[row, 2]
    return vec3(
        rows[a, 0] * w0 + rows[b, 0] * w1 + rows[c, 0] * w2,
        rows[a, 1] * w0 + rows[b, 1] * w1 + rows[c, 1] * w2,
        rows[a, 2] * w0 + rows[b, 2] * w1 + rows[c, 2] * w2,
    )


@device
def _resized(direction, like):
    """A direction of the length of another vector."""
    return normalise(direction) * length(like)


@device
def _mesh_frame(scene, item, shading, scratch):
    """(t, b, n) of a mesh with tangents, as blended, outward and in the world."""
    surfaces, geometry = scene.surfaces, scene.geometry
    instance = np.int64(load_int(scratch, contract.HIT_INSTANCE))
    row = _corner_rows(scene, scratch, item, TANGENTS)
    tangent = _blended(surfaces.tangents, surfaces.tangent_corners, row, scratch)
    sign = surfaces.tangents[surfaces.tangent_corners[row, 0], 3]
    normal = shading
    if surfaces.items[item, NORMALS] >= 0:
        blended = _blended(
            surfaces.normals, surfaces.normal_corners, _corner_rows(scene, scratch, item, NORMALS), scratch
        )
        # The direction is known; blending has made it shorter.
        normal = shading * length(blended)
    if geometry.identity[instance] == 0:
        tangent = _resized(affine_vector(geometry.to_world, instance, tangent), tangent)
        sign *= _handedness(geometry.to_world, instance)
    elif surfaces.items[item, FLIPPED] != 0:
        sign = -sign
    return tangent, cross(normal, tangent) * sign, normal


@device
def _handedness(matrices, k):
    """1, or −1 where a transform mirrors."""
    x = vec3(matrices[k, 0], matrices[k, 4], matrices[k, 8])
    y = vec3(matrices[k, 1], matrices[k, 5], matrices[k, 9])
    z = vec3(matrices[k, 2], matrices[k, 6], matrices[k, 10])
    return _ONE if dot(cross(x, y), z) >= _ZERO else -_ONE


@device
def _frame(scene, along, shading, scratch):
    """(t, b, n): of meshes by their tangents, of others along u; any where neither tells."""
    item = np.int64(load_int(scratch, contract.ITEM))
    if load_int(scratch, contract.HIT_SLOT) >= 0 and scene.surfaces.items[item, TANGENTS] >= 0:
        tangent, bitangent, normal = _mesh_frame(scene, item, shading, scratch)
        if dot(tangent, tangent) > _ZERO:
            return tangent, bitangent, normal
    across = along - shading * dot(along, shading)
    if dot(across, across) > _ZERO:
        tangent = normalise(across)
        return tangent, cross(shading, tangent), shading
    tangent, bitangent = orthonormal(shading)
    return tangent, bitangent, shading


@device
def upright(normal, shading):
    """A unit normal that does not lean further than it may."""
    lean = dot(normal, shading)
    return normal if lean >= _LEAST else normalise(normal + shading * (_LEAST - lean))


@device
def normal_of_map(scene, slot, along, scratch):
    """The outward normal that a slot's texture tells of the surface in the scratch, of which `along` is ∂P/∂u."""
    materials, shading = scene.materials, load_vec3(scratch, contract.SHADING)
    texel, _ = texture.look_up(scene.textures, np.int64(materials.slot_codes[slot, 0]), scratch, _PLACE)
    x = (texel.x + texel.x - _ONE) * materials.slot_values[slot, 0]
    y = (texel.y + texel.y - _ONE) * materials.slot_values[slot, 1]
    z = (texel.z + texel.z - _ONE) * materials.slot_values[slot, 2]
    if x == _ZERO and y == _ZERO:
        return shading
    tangent, bitangent, normal = _frame(scene, along, shading, scratch)
    turned = tangent * x + bitangent * y + normal * z
    size2 = dot(turned, turned)
    return upright(normalise(turned), shading) if size2 > _ZERO else shading
