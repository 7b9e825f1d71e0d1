"""What textures say at a surface that a ray met.

write_place(scene, scratch)                              once, from what `write_surface` left in the scratch
slot_value(materials, textures, slot, scratch)           then for each parameter of a material
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import affine_point
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int
from isophote.kernels.base.vec import load_vec3, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.texture import contract as texture
from isophote.kernels.trace.footprint import write_footprint
from isophote.kernels.trace.tables import SCENE

__all__ = ["colour_at", "slot_value", "write_place"]

_ZERO = np.float32(0)
_WORDS, _PLACE = np.int64(contract.WORDS), np.int64(contract.TEXTURE_PLACE)

_scene_at = opener_at(SCENE)


@device
def write_place(scene, scratch):
    """Write the record that textures are asked with."""
    for k in range(_PLACE, _PLACE + texture.WORDS):
        scratch[k] = _ZERO
    scratch[_PLACE + texture.U], scratch[_PLACE + texture.V] = scratch[contract.U], scratch[contract.V]
    place, item = load_vec3(scratch, contract.PLACE), np.int64(load_int(scratch, contract.ITEM))
    store_vec3(scratch, _PLACE + texture.WORLD, place)
    store_vec3(scratch, _PLACE + texture.OWN, affine_point(scene.textures.to_own, item, place))
    write_footprint(scene, scratch)


@device
def slot_value(materials, textures, slot, scratch):
    """Value of a material's slot at the place in the scratch, texture included."""
    value = vec3(materials.slot_values[slot, 0], materials.slot_values[slot, 1], materials.slot_values[slot, 2])
    node = np.int64(materials.slot_codes[slot, 0])
    if node < 0:
        return value
    texel, alpha = texture.look_up(textures, node, scratch, _PLACE)
    channel = materials.slot_codes[slot, 1]
    if channel >= 0:
        one = texel.x if channel == 0 else (texel.y if channel == 1 else (texel.z if channel == 2 else alpha))
        texel = vec3(one, one, one)
    return value * texel


@entry
def colour_at(scene_words, scratch_address, node):
    """Leave in VALUE what a texture, a node, says of the surface in the scratch."""
    scene, scratch = _scene_at(scene_words), floats_at(scratch_address, _WORDS)
    write_place(scene, scratch)
    colour, _ = texture.look_up(scene.textures, node, scratch, _PLACE)
    store_vec3(scratch, contract.VALUE, colour)
    return 0
