"""Shadow rays that go straight through what is clear, tinted as if nothing bent them.

An entry, so that tiles hold no more than a call of it. What is left of the light: the shares that go through each
boundary, times their colours, and exp(−σ d) of each medium on the way. Anything else in the way blocks.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import closest_hit
from isophote.kernels.accel.surface import MATERIAL, offset_point
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, length, load_vec3, maximum_component, store_vec3, vec3
from isophote.kernels.light.bsdf import LINKED
from isophote.kernels.light.emitter import lamp_blocks
from isophote.kernels.light.medium import attenuation, current_medium, medium_ior, surface_boundary
from isophote.kernels.trace.boundary import goes_smoothly, split_ray
from isophote.kernels.trace.direct import closest_direct, surface_of
from isophote.kernels.trace.holes import surface_opacity
from isophote.kernels.trace.material import branch_material, prepare_material
from isophote.kernels.trace.shading import surface_colour
from isophote.kernels.trace.tables import SCENE

__all__ = ["RAY_WORDS", "shadow_tint"]

# Floats of a ray: origin, direction, end in lengths of the direction, and what is left of its light.
ORIGIN, DIRECTION, END, LEFT = np.int64(0), np.int64(3), np.int64(6), np.int64(7)
RAY_WORDS = 10
_WORDS = np.int64(RAY_WORDS)
_ZERO, _ONE = np.float32(0), np.float32(1)
_NONE = np.int64(-1)
# Surfaces on the way at most; a ray that meets more is blocked.
_MOST = 64
# Branches that leave by less than this from straight on go through.
_STRAIGHT = np.float32(1 - 1e-4)

scene_at = opener_at(SCENE)


@device
def _through_boundary(scene, surface, hit, direction, boundary, scratch):
    """What goes through a smooth boundary of media."""
    if boundary.before == boundary.behind:
        return vec3(_ONE, _ONE, _ONE)
    ratio = medium_ior(scene.media, boundary.behind) / medium_ior(scene.media, boundary.before)
    share, _, _ = split_ray(surface, direction, ratio)
    return surface_colour(scene, surface, hit, direction, _ZERO, scratch) * (_ONE - share)


@device
def _through_any(scene, surface, hit, direction, material, scratch):
    """What a material that only branches sends straight on."""
    through = vec3(_ZERO, _ZERO, _ZERO)
    if scene.materials.kinds[material] != LINKED or scene.materials.scatters[material] != 0:
        return through
    prepare_material(scene, surface, hit, direction, _ZERO, scratch)
    for k in range(scene.materials.branches[material]):
        into, share = branch_material(scene, surface, k, scratch)
        if dot(into, direction) > _STRAIGHT:
            through = through + share
    return through


@entry
def shadow_tint(scene_address, scratch_address, words, ray_address, inside):
    """Leave in LEFT what comes through of light along a ray that begins in the media `inside`."""
    scene, scratch = scene_at(scene_address), floats_at(scratch_address, words)
    ray = floats_at(ray_address, _WORDS)
    origin, whole, end = load_vec3(ray, ORIGIN), load_vec3(ray, DIRECTION), ray[END]
    size = length(whole)
    direction, end = whole / size, end * size
    left = vec3(_ONE, _ONE, _ONE)
    for _ in range(_MOST):
        hit = closest_hit(scene.geometry, origin, direction, end, scratch)
        hit = closest_direct(scene, origin, direction, hit, scratch)
        # A lamp blocks wherever it stands.
        if lamp_blocks(scene.lights, origin, direction, hit.t):
            break
        if hit.slot == _NONE:
            left = left * attenuation(scene.media, current_medium(scene.media, inside), end)
            store_vec3(ray, LEFT, left)
            return 0
        surface = surface_of(scene, origin, direction, hit, scratch)
        material = np.int64(scene.surfaces.items[surface.item, MATERIAL])
        boundary = surface_boundary(scene.media, material, inside, dot(direction, surface.normal) < _ZERO)
        left = left * attenuation(scene.media, boundary.before, hit.t)
        if goes_smoothly(scene, material, boundary):
            left = left * _through_boundary(scene, surface, hit, direction, boundary, scratch)
        else:
            whole = surface_opacity(scene, surface, hit, direction, _ZERO, scratch)
            through = _through_any(scene, surface, hit, direction, material, scratch)
            left = left * (through * whole + vec3(_ONE, _ONE, _ONE) * (_ONE - whole))
        if maximum_component(left) <= _ZERO:
            break
        inside = boundary.inside
        origin = offset_point(surface.place, surface.normal, surface.error, direction)
        end -= hit.t
    store_vec3(ray, LEFT, vec3(_ZERO, _ZERO, _ZERO))
    return 0
