"""What rays visit on their way to their first triangle."""

from __future__ import annotations

from isophote.kernels.accel.contract import DEPTH, NODES, PRIMITIVES, RAY_WORDS, clear_counts
from isophote.kernels.accel.geometry import RAY, closest_hit
from isophote.kernels.base.entry import element_address, floats_at
from isophote.kernels.base.jit import kernel
from isophote.kernels.base.simd import load_int
from isophote.kernels.base.vec import vec3
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.rays import first_fault, open_query
from isophote.kernels.trace.tables import SCENE

__all__ = ["count_rays"]

open_scene, open_wave = SCENE.open, rows.WAVE.open


@kernel
def count_rays(scene_words, query_words, wave_words, counts, first, last):
    """Nodes visited, triangles tested and deepest level of rays first ≤ i < last into rows 0 to 2 of `counts`, (3, n)
    int32, over a geometry of entries; `query` gives origins, directions and limits. Returns as closest_rays does."""
    scene, query, wave = open_scene(scene_words), open_query(query_words), open_wave(wave_words)
    fault = first_fault(query, first, last)
    if fault[0] != 0:
        return fault
    scratch = wave.scratch
    ray = floats_at(element_address(scratch, RAY), RAY_WORDS)
    o, d = query.origins, query.directions
    for i in range(first, last):
        clear_counts(ray)
        origin, direction = vec3(o[i, 0], o[i, 1], o[i, 2]), vec3(d[i, 0], d[i, 1], d[i, 2])
        closest_hit(scene.geometry, origin, direction, query.limit[i], scratch)
        counts[0, i], counts[1, i], counts[2, i] = load_int(ray, NODES), load_int(ray, PRIMITIVES), load_int(ray, DEPTH)
    return fault
