"""Lights whose radiance a texture varies, as those who aim at them see them."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import call_entry, element_address, entry, floats_at, opener_at, table_address
from isophote.kernels.base.jit import device, exact_apart
from isophote.kernels.base.vec import cross, dot, load_vec3, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.texture import contract as texture
from isophote.kernels.trace.tables import SCENE

__all__ = ["light_tint", "tint_of_light"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_START, _WORDS, _RECORD = np.int64(0), np.int64(contract.WORDS), np.int64(contract.TEXTURE_PLACE)
# Columns of `Lights.values` and of `Lights.paint`.
_PLACE, _EDGE1, _EDGE2 = np.int64(0), np.int64(3), np.int64(6)
_OWN = np.int64(6)

_scene_at = opener_at(SCENE)


@exact_apart
def _ask(scene, k, place, scratch):
    store_vec3(scratch, _RECORD + texture.WORLD, place)
    call_entry(scene.lights.tint, (table_address(scene), element_address(scratch, _START), np.int64(k)))
    return load_vec3(scratch, _RECORD + texture.RESULT)


@device
def tint_of_light(scene, k, place, scratch):
    """What the texture of light `k` says of a place on it, white without one. The record that textures are asked with,
    in the scratch, is used anew; parameters of a surface stay."""
    lights = scene.lights
    if lights.painted.rows == 0 or lights.painted[k] < 0:
        return vec3(_ONE, _ONE, _ONE)
    return _ask(scene, k, place, scratch)


@device
def _row(rows, k, first):
    return vec3(rows[k, first], rows[k, first + 1], rows[k, first + 2])


@device
def _to_own(paint, row, p):
    at = _OWN
    return vec3(
        paint[row, at] * p.x + paint[row, at + 1] * p.y + paint[row, at + 2] * p.z + paint[row, at + 3],
        paint[row, at + 4] * p.x + paint[row, at + 5] * p.y + paint[row, at + 6] * p.z + paint[row, at + 7],
        paint[row, at + 8] * p.x + paint[row, at + 9] * p.y + paint[row, at + 10] * p.z + paint[row, at + 11],
    )


@entry
def light_tint(scene_words, scratch_address, k):
    """Leave in the record what the texture of light `k` says of the place in the world that the record holds."""
    scene, scratch = _scene_at(scene_words), floats_at(scratch_address, _WORDS)
    lights, place = scene.lights, load_vec3(scratch, _RECORD + texture.WORLD)
    row = np.int64(lights.painted[k])
    for word in range(_RECORD, _RECORD + texture.WORDS):
        scratch[word] = _ZERO
    edge1, edge2 = _row(lights.values, k, _EDGE1), _row(lights.values, k, _EDGE2)
    normal, beside = cross(edge1, edge2), place - _row(lights.values, k, _PLACE)
    inverse, paint = _ONE / dot(normal, normal), lights.paint
    a, b = dot(cross(beside, edge2), normal) * inverse, dot(cross(edge1, beside), normal) * inverse
    scratch[_RECORD + texture.U] = paint[row, 0] + a * paint[row, 2] + b * paint[row, 4]
    scratch[_RECORD + texture.V] = paint[row, 1] + a * paint[row, 3] + b * paint[row, 5]
    store_vec3(scratch, _RECORD + texture.WORLD, place)
    store_vec3(scratch, _RECORD + texture.OWN, _to_own(paint, row, place))
    node = np.int64(scene.materials.emission_textures[np.int64(lights.paint_materials[row])])
    texture.look_up(scene.textures, node, scratch, _RECORD)
    return 0
