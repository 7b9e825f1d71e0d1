"""Cut-outs in sphere tracing, as entries that only scenes with such surfaces call.

sphere_pass(scene, march, picture)          take the hits of sixteen pixels on through what is less than half there
sphere_left(scene, picture, soft)           what is left of the light of the ray in `picture.shadow`, into its word LEFT

One ray a pixel sees what is at least half there, and goes straight on through all else; shadows are lighter by 1 − α.
Where shadows are `soft`, fields that are whole dim light by how near rays pass, and do not count here.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.field_layout import FIELD
from isophote.kernels.accel.geometry import Hit, closest_hit
from isophote.kernels.accel.surface import MATERIAL, offset_point
from isophote.kernels.base.entry import entry, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, load_vec3
from isophote.kernels.trace.direct import closest_direct, is_surface, surface_of
from isophote.kernels.trace.holes import surface_opacity
from isophote.kernels.trace.sphere_packet import LANES
from isophote.kernels.trace.sphere_pixels import DIRECTION, ORIGIN, keep_hit, kept_hit, lane_vec3
from isophote.kernels.trace.sphere_tables import END, LEFT, MARCH, SHADOW_DIRECTION, SHADOW_START, SPHERE_PICTURE
from isophote.kernels.trace.tables import SCENE

__all__ = ["sphere_left", "sphere_pass"]

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_NONE, _FIRST, _FIELD = np.int64(-1), np.int64(0), np.int64(FIELD)
# Surfaces on one way at most; what lies behind so many is not seen.
_MOST = 4096

_scene_at, _march_at, _picture_at = opener_at(SCENE), opener_at(MARCH), opener_at(SPHERE_PICTURE)


@device
def _next(scene, start, direction, end, scratch):
    """The first `Hit` on anything before `end`."""
    hit = Hit(end, _ZERO, _ZERO, _NONE, _FIRST)
    if scene.geometry.blocks.rows > 0:
        hit = closest_hit(scene.geometry, start, direction, end, scratch)
    return closest_direct(scene, start, direction, hit, scratch)


@device
def _pass(scene, march, picture, lane):
    pixels, scratch = picture.pixels, picture.scratch
    origin, direction = lane_vec3(pixels, ORIGIN, lane), lane_vec3(pixels, DIRECTION, lane)
    hit, start, gone = kept_hit(pixels, lane), origin, _ZERO
    for _ in range(_MOST):
        if not is_surface(hit.slot):
            break
        surface = surface_of(scene, start, direction, hit, scratch)
        if surface_opacity(scene, surface, hit, direction, _ZERO, scratch) >= _HALF:
            break
        start = offset_point(surface.place, surface.normal, surface.error, direction)
        gone = dot(start - origin, direction)
        hit = _next(scene, start, direction, march.max_distance - gone, scratch)
    keep_hit(pixels, lane, Hit(gone + hit.t, hit.weight1, hit.weight2, hit.slot, hit.instance))


@entry
def sphere_pass(scene_words, march_words, picture_words):
    """Take the hits of sixteen pixels on through holes."""
    scene, march, picture = _scene_at(scene_words), _march_at(march_words), _picture_at(picture_words)
    for lane in range(LANES):
        if is_surface(kept_hit(picture.pixels, lane).slot):
            _pass(scene, march, picture, lane)
    return 0


@device
def _left(scene, start, direction, end, soft, scratch):
    left = _ONE
    for _ in range(_MOST):
        hit = _next(scene, start, direction, end, scratch)
        if hit.slot == _NONE:
            return left
        surface = surface_of(scene, start, direction, hit, scratch)
        if scene.materials.cuts[np.int64(scene.surfaces.items[surface.item, MATERIAL])] >= 0:
            left *= _ONE - surface_opacity(scene, surface, hit, direction, _ZERO, scratch)
        elif not (soft != 0 and hit.slot <= _FIELD):
            return _ZERO
        if left <= _ZERO:
            return _ZERO
        moved = offset_point(surface.place, surface.normal, surface.error, direction)
        end -= dot(moved - start, direction)
        start = moved
    return _ZERO


@entry
def sphere_left(scene_words, picture_words, soft):
    """What cut-outs leave of the light of a shadow ray; nothing where it is blocked."""
    scene, picture = _scene_at(scene_words), _picture_at(picture_words)
    ray = picture.shadow
    start, direction = load_vec3(ray, SHADOW_START), load_vec3(ray, SHADOW_DIRECTION)
    ray[LEFT] = _left(scene, start, direction, ray[END], soft, picture.scratch)
    return 0
