"""The way of rays through cut-outs, as entries that only scenes with such surfaces call.

opacity_at(scene, scratch)             α of the surface in the scratch, in VALUE
pass_holes(scene, wave, count)         see holes.py
shade_holes(scene, wave, count)        see holes.py
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import Hit, closest_hit
from isophote.kernels.accel.surface import MATERIAL, item_of, offset_point, triangle_number
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int
from isophote.kernels.base.vec import dot, length, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.light.emitter import closest_lamp, lamp_blocks
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import LAMP
from isophote.kernels.trace.cone import cone_radius
from isophote.kernels.trace.direct import closest_direct, direct_item, is_surface, surface_of
from isophote.kernels.trace.holes import surface_opacity
from isophote.kernels.trace.tables import SCENE
from isophote.kernels.trace.textured import slot_value, write_place
from isophote.kernels.trace.wave import hit_of, row_vec3

__all__ = ["next_hit", "opacity_at", "pass_holes", "shade_holes"]

_ZERO, _ONE, _FAR = np.float32(0), np.float32(1), np.float32(np.inf)
_NONE, _WORDS = np.int64(-1), np.int64(contract.WORDS)
# Surfaces on one way at most; what lies behind so many is not seen.
_MOST = 4096

_scene_at, _wave_at = opener_at(SCENE), opener_at(rows.WAVE)


@entry
def opacity_at(scene_words, scratch_address):
    """α: the first slot's value; or, where the second, the cut-off, is not negative, 1 from there on and else 0."""
    scene, scratch = _scene_at(scene_words), floats_at(scratch_address, _WORDS)
    materials = scene.materials
    slot = np.int64(materials.cuts[np.int64(load_int(scratch, contract.MATERIAL))])
    cutoff = materials.slot_values[slot + 1, 0]
    if cutoff >= _ZERO:
        # A mean of what is there and what is not says neither.
        scratch[contract.RADIUS] = _ZERO
    if materials.slot_codes[slot, 0] >= 0:
        write_place(scene, scratch)
    alpha = slot_value(materials, scene.textures, slot, scratch).x
    if cutoff >= _ZERO:
        alpha = _ONE if alpha >= cutoff else _ZERO
    alpha = min(max(alpha, _ZERO), _ONE)
    store_vec3(scratch, contract.VALUE, vec3(alpha, alpha, alpha))
    return 0


@device
def _is_cut(scene, hit):
    """Whether what was hit may have holes."""
    if hit.slot >= 0:
        item = item_of(scene.surfaces, hit.instance, triangle_number(scene.geometry, hit.slot))
    else:
        item = direct_item(scene, hit)
    return scene.materials.cuts[np.int64(scene.surfaces.items[item, MATERIAL])] >= 0


@device
def next_hit(scene, start, direction, end, scratch):
    """The first `Hit` from `start`, lamps included."""
    hit = closest_hit(scene.geometry, start, direction, end, scratch)
    hit = closest_direct(scene, start, direction, hit, scratch)
    t, lamp = closest_lamp(scene.lights, start, direction, hit.t)
    return Hit(t, _ZERO, _ZERO, LAMP, lamp) if lamp >= 0 else hit


@device
def _pass(scene, wave, i):
    """Take the hit of ray `i` on."""
    floats, longs, scratch = wave.floats, wave.longs, wave.scratch
    origin, direction = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i)
    hit = hit_of(wave, i)
    start, gone, u = origin, _ZERO, floats[rows.PICK_U, i]
    for _ in range(_MOST):
        if not (is_surface(hit.slot) and _is_cut(scene, hit)):
            break
        surface = surface_of(scene, start, direction, hit, scratch)
        alpha = surface_opacity(scene, surface, hit, direction, cone_radius(wave, i, gone + hit.t), scratch)
        if alpha > u:
            break
        u = min((u - alpha) / (_ONE - alpha), _ONE)
        start = offset_point(surface.place, surface.normal, surface.error, direction)
        gone = dot(start - origin, direction)
        hit = next_hit(scene, start, direction, _FAR, scratch)
    floats[rows.HIT_T, i] = gone + hit.t
    floats[rows.HIT_W1, i], floats[rows.HIT_W2, i] = hit.weight1, hit.weight2
    longs[rows.HIT_SLOT, i], longs[rows.HIT_INSTANCE, i] = hit.slot, hit.instance


@entry
def pass_holes(scene_words, wave_words, count):
    """Take the hits of a wave's rays, of unit direction, on through holes."""
    scene, wave = _scene_at(scene_words), _wave_at(wave_words)
    for i in range(count):
        if is_surface(wave.longs[rows.HIT_SLOT, i]):
            _pass(scene, wave, i)
    return 0


@device
def _left(scene, wave, i):
    """What comes through of the light of shadow ray `i`: Π (1 − α) over all that is cut out, 0 where anything else is
    in the way."""
    floats, scratch = wave.floats, wave.scratch
    start, whole = row_vec3(floats, rows.SHADOW_ORIGIN, i), row_vec3(floats, rows.SHADOW_DIRECTION, i)
    size = length(whole)
    direction, end = whole / size, floats[rows.SHADOW_END, i] * size
    left = _ONE
    for _ in range(_MOST):
        hit = closest_hit(scene.geometry, start, direction, end, scratch)
        hit = closest_direct(scene, start, direction, hit, scratch)
        if lamp_blocks(scene.lights, start, direction, hit.t):
            return _ZERO
        if hit.slot == _NONE:
            return left
        if not _is_cut(scene, hit):
            return _ZERO
        surface = surface_of(scene, start, direction, hit, scratch)
        left *= _ONE - surface_opacity(scene, surface, hit, direction, _ZERO, scratch)
        if left <= _ZERO:
            return _ZERO
        moved = offset_point(surface.place, surface.normal, surface.error, direction)
        end -= dot(moved - start, direction)
        start = moved
    return _ZERO


@entry
def shade_holes(scene_words, wave_words, count):
    """Free shadow rays of a wave that only cut-outs block."""
    scene, wave = _scene_at(scene_words), _wave_at(wave_words)
    for i in range(count):
        left = _ONE
        if wave.ints[rows.BLOCKED, i] != 0:
            left = _left(scene, wave, i)
            wave.ints[rows.BLOCKED, i] = left <= _ZERO
        wave.floats[rows.LEFT, i] = left
    return 0
