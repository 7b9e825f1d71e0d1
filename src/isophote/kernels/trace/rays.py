"""The tree's queries over arrays of rays."""

from __future__ import annotations

from isophote.kernels.accel.geometry import closest_hit, occluded
from isophote.kernels.accel.surface import PUBLIC, face_number, surface_at
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.table import BYTES, FLOAT_ROWS, FLOATS, INTS, Table
from isophote.kernels.base.vec import vec3
from isophote.kernels.trace.tables import SCENE

__all__ = ["QUERY", "closest_rays", "occluded_rays"]

# Rays and what is found, one row each: `limit` is the largest distance in lengths of the direction.
QUERY = Table(
    "Query",
    origins=FLOAT_ROWS,
    directions=FLOAT_ROWS,
    limit=FLOATS,
    distance=FLOATS,
    uv=FLOAT_ROWS,
    normal=FLOAT_ROWS,
    item=INTS,
    primitive=INTS,
    blocked=BYTES,
    scratch=FLOATS,
)

open_scene, open_query = SCENE.open, QUERY.open


@device
def _row(rows, i):
    return vec3(rows[i, 0], rows[i, 1], rows[i, 2])


@device
def _write(scene, query, i, hit):
    surface = surface_at(scene.geometry, scene.surfaces, hit)
    query.distance[i] = hit.t
    query.uv[i, 0] = hit.weight1
    query.uv[i, 1] = hit.weight2
    query.normal[i, 0] = surface.normal.x
    query.normal[i, 1] = surface.normal.y
    query.normal[i, 2] = surface.normal.z
    query.item[i] = scene.surfaces.items[surface.item, PUBLIC]
    query.primitive[i] = face_number(scene.surfaces, surface.item, surface.triangle)


@kernel
def closest_rays(scene_words, query_words, first, last):
    """The first hit of rays first ≤ i < last; rows of rays that meet nothing keep what they hold."""
    scene, query = open_scene(scene_words), open_query(query_words)
    for i in range(first, last):
        hit = closest_hit(
            scene.geometry, _row(query.origins, i), _row(query.directions, i), query.limit[i], query.scratch
        )
        if hit.slot >= 0:
            _write(scene, query, i, hit)


@kernel
def occluded_rays(scene_words, query_words, first, last):
    """Whether rays first ≤ i < last meet anything before their limit."""
    scene, query = open_scene(scene_words), open_query(query_words)
    for i in range(first, last):
        origin, direction = _row(query.origins, i), _row(query.directions, i)
        query.blocked[i] = occluded(scene.geometry, origin, direction, query.limit[i], query.scratch)
