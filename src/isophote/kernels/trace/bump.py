"""Normals of heights that a texture tells, as an entry that only materials with bumps call.

    n′ = n − s ∇h,    ∇h = (∂h/∂a) a + (∂h/∂b) b

a and b are unit vectors of the tangent plane, and the derivatives central differences over what the ray's cone covers,
a texel, or next to nothing, whichever is most. Nothing is asked of texture coordinates, so that textures of space
will do. (Blinn: "Simulation of Wrinkled Surfaces", SIGGRAPH 1978; the gradient in the surface after Mikkelsen: "Bump
Mapping Unparametrized Surfaces on the GPU", 2010.)
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import affine_vector
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int
from isophote.kernels.base.vec import length, load_vec3, normalise, orthonormal, store_vec3
from isophote.kernels.brdf import contract
from isophote.kernels.texture import contract as texture
from isophote.kernels.trace.footprint import write_uv_axes
from isophote.kernels.trace.tables import SCENE
from isophote.kernels.trace.textured import write_place
from isophote.kernels.trace.turned_normal import upright

__all__ = ["bump_at"]

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_WORDS, _PLACE = np.int64(contract.WORDS), np.int64(contract.TEXTURE_PLACE)
# What is next to nothing, in parts of the distance from the origin of the shape's space, and of its units.
_BESIDE = np.float32(2.0**-11)
# Columns of a slot's value.
_SCALE, _ACROSS, _DOWN = np.int64(0), np.int64(1), np.int64(2)

_scene_at = opener_at(SCENE)


@device
def _height(scene, node, scratch, uv, own, world, part):
    """The texture's first channel beside the place, by so large a part of the step."""
    record = _PLACE
    scratch[record + texture.U] += uv[0] * part
    scratch[record + texture.V] += uv[1] * part
    place, there = load_vec3(scratch, record + texture.OWN), load_vec3(scratch, record + texture.WORLD)
    store_vec3(scratch, record + texture.OWN, place + own * part)
    store_vec3(scratch, record + texture.WORLD, there + world * part)
    colour, _ = texture.look_up(scene.textures, node, scratch, record)
    store_vec3(scratch, record + texture.OWN, place)
    store_vec3(scratch, record + texture.WORLD, there)
    scratch[record + texture.U] -= uv[0] * part
    scratch[record + texture.V] -= uv[1] * part
    return colour.x


@device
def _part(uv, across, down):
    """How many steps reach over a texel, 1 at least; `across` and `down` are the sizes of a picture's texels, or 0."""
    if not across > _ZERO:
        return _ONE
    texels = max(abs(uv[0]) / across, abs(uv[1]) / down)
    return max(_ONE, _HALF / texels) if texels > _ZERO else _ONE


@device
def _slope(scene, slot, scratch, uv, world, step):
    """Derivative of the height along `world`, which is `step` long."""
    materials = scene.materials
    item = np.int64(load_int(scratch, contract.ITEM))
    own = affine_vector(scene.textures.to_own, item, world)
    part = _part(uv, materials.slot_values[slot, _ACROSS], materials.slot_values[slot, _DOWN])
    node = np.int64(materials.slot_codes[slot, 0])
    above = _height(scene, node, scratch, uv, own, world, part)
    below = _height(scene, node, scratch, uv, own, world, -part)
    return (above - below) / (step * part * (_ONE + _ONE))


@device
def _uv_steps(scene, scratch, a, b):
    """How texture coordinates change along `a` and `b`, two pairs; the record is left without a footprint."""
    first = _PLACE + texture.AXIS_A
    _clear(scratch, first, 4)
    write_uv_axes(scene, scratch, a, b)
    along_a, along_b = (scratch[first], scratch[first + 1]), (scratch[first + 2], scratch[first + 3])
    _clear(scratch, first, 4)
    # Differences are means already, and filters that average too are not even enough for them.
    _clear(scratch, _PLACE + texture.OWN_A, 6)
    _clear(scratch, _PLACE + texture.WORLD_A, 6)
    return along_a, along_b


@device
def _clear(scratch, first, count):
    for k in range(first, first + count):
        scratch[k] = _ZERO


@entry
def bump_at(scene_words, scratch_address, slot):
    """Leave in VALUE the outward normal that a slot's heights give to the surface in the scratch."""
    scene, scratch = _scene_at(scene_words), floats_at(scratch_address, _WORDS)
    shading, normal = load_vec3(scratch, contract.SHADING), load_vec3(scratch, contract.OUTWARD)
    item = np.int64(load_int(scratch, contract.ITEM))
    # Heights are told in the shape's own units.
    unit = _ONE / length(affine_vector(scene.textures.to_own, item, normal))
    near = length(load_vec3(scratch, _PLACE + texture.OWN)) + _ONE
    step = max(scratch[contract.RADIUS], near * unit * _BESIDE)
    a, b = orthonormal(normal)
    along_a, along_b = _uv_steps(scene, scratch, a * step, b * step)
    slope_a = _slope(scene, slot, scratch, along_a, a * step, step)
    slope_b = _slope(scene, slot, scratch, along_b, b * step, step)
    write_place(scene, scratch)
    scale = scene.materials.slot_values[slot, _SCALE] * unit
    turned = normalise(shading - (a * slope_a + b * slope_b) * scale)
    store_vec3(scratch, contract.VALUE, upright(turned, shading))
    return 0
