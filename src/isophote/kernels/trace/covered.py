"""Which parts of patches lie within solids, where no light is: those under a box that stands on a floor."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import Hit
from isophote.kernels.base.double3 import row3
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.vec import dot, vec3
from isophote.kernels.light.form_factor import on_patch
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import trace_rays
from isophote.kernels.trace.direct import surface_of
from isophote.kernels.trace.exchange import open_patches
from isophote.kernels.trace.tables import SCENE
from isophote.kernels.trace.wave import row_vec3, set_row_vec3

__all__ = ["find_covered", "leaves_solid"]

_GRID, _CELLS = 4, 16
_FAR, _ZERO = np.float32(np.inf), np.float32(0)

open_scene, open_wave = SCENE.open, rows.WAVE.open


@device
def leaves_solid(scene, wave, solid, i):
    """Whether the ray of column i first meets a solid from within."""
    slot = wave.longs[rows.HIT_SLOT, i]
    if slot < 0:
        return False
    floats = wave.floats
    origin, direction = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i)
    t, w1, w2 = floats[rows.HIT_T, i], floats[rows.HIT_W1, i], floats[rows.HIT_W2, i]
    hit = Hit(t, w1, w2, slot, wave.longs[rows.HIT_INSTANCE, i])
    surface = surface_of(scene, origin, direction, hit, wave.scratch)
    return solid[surface.item] != 0 and dot(surface.normal, direction) > _ZERO


@kernel
def find_covered(scene_words, patch_words, wave_words, nodes, solid, found, first, last):
    """For patches nodes[first ≤ i < last], a bit for each cell of a grid of 4 × 4 whose middle lies within a solid:
    a ray from there along the normal leaves it. `solid` (items,): which items are."""
    scene, patches, wave = open_scene(scene_words), open_patches(patch_words), open_wave(wave_words)
    for i in range(first, last):
        node = np.int64(nodes[i])
        normal = row3(patches.normals, node)
        for cell in range(_CELLS):
            place = on_patch(
                patches.corners, patches.sides, node, (cell % _GRID + 0.5) / _GRID, (cell // _GRID + 0.5) / _GRID
            )
            start = vec3(
                np.float32(place.x + patches.bias * normal.x),
                np.float32(place.y + patches.bias * normal.y),
                np.float32(place.z + patches.bias * normal.z),
            )
            set_row_vec3(wave.floats, rows.ORIGIN, cell, start)
            up = vec3(np.float32(normal.x), np.float32(normal.y), np.float32(normal.z))
            set_row_vec3(wave.floats, rows.DIRECTION, cell, up)
            wave.floats[rows.HIT_T, cell] = _FAR
        trace_rays(scene, wave, _CELLS, True)
        bits = np.int32(0)
        for cell in range(_CELLS):
            if leaves_solid(scene, wave, solid, cell):
                bits |= np.int32(1 << cell)
        found[i] = bits
