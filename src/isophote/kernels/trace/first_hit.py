"""What the camera sees first at one place in each pixel: exact, never blended."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import closest_hit
from isophote.kernels.accel.surface import PUBLIC, face_number
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.table import FLOAT, FLOAT_ROWS, FLOATS, INT_ROWS, Table
from isophote.kernels.base.vec import dot, length
from isophote.kernels.light.emitter import closest_lamp, lamp_normal
from isophote.kernels.trace.camera import camera_ray
from isophote.kernels.trace.direct import closest_direct, surface_of
from isophote.kernels.trace.shading import surface_colour
from isophote.kernels.trace.tables import SCENE

__all__ = ["FEATURES", "first_hits"]

_ZERO = np.float32(0)
_FAR, _NONE = np.float32(np.inf), np.int64(-1)

# Rows y, pixels x: `depth`, `distance`, `item`, `primitive` (height, width), the others (height, channels · width).
# `film_x`, `film_y`: the place from each pixel's corner; `lens_a`, `lens_b`: the point of the unit disk of the lens.
FEATURES = Table(
    "Features",
    depth=FLOAT_ROWS,
    distance=FLOAT_ROWS,
    normal=FLOAT_ROWS,
    albedo=FLOAT_ROWS,
    uv=FLOAT_ROWS,
    item=INT_ROWS,
    primitive=INT_ROWS,
    scratch=FLOATS,
    film_x=FLOAT,
    film_y=FLOAT,
    lens_a=FLOAT,
    lens_b=FLOAT,
)

open_scene, open_features = SCENE.open, FEATURES.open


@device
def _set(rows, y, x, v):
    rows[y, 3 * x] = v.x
    rows[y, 3 * x + 1] = v.y
    rows[y, 3 * x + 2] = v.z


@device
def _facing(normal, direction):
    return normal if dot(normal, direction) < _ZERO else -normal


@device
def _write_lamp(scene, features, y, x, origin, direction, t, lamp):
    normal = lamp_normal(scene.lights, lamp, origin + t * direction)
    _set(features.normal, y, x, _facing(normal, direction))
    features.item[y, x] = scene.lights.numbers[lamp]
    features.primitive[y, x] = 0


@device
def _write_surface(scene, features, y, x, origin, direction, hit):
    surface = surface_of(scene, origin, direction, hit, features.scratch)
    _set(features.normal, y, x, _facing(surface.shading, direction))
    _set(features.albedo, y, x, surface_colour(scene, surface, hit, direction, features.scratch))
    features.uv[y, 2 * x] = surface.u
    features.uv[y, 2 * x + 1] = surface.v
    features.item[y, x] = scene.surfaces.items[surface.item, PUBLIC]
    features.primitive[y, x] = face_number(scene.surfaces, surface.item, surface.triangle)


@kernel
def first_hits(scene_words, feature_words, width, y0, y1):
    """Fill rows y0 ≤ y < y1 of the features; where nothing is met, they keep what they hold."""
    scene, features = open_scene(scene_words), open_features(feature_words)
    for y in range(y0, y1):
        for x in range(width):
            px, py = np.float32(x) + features.film_x, np.float32(y) + features.film_y
            origin, direction = camera_ray(scene.camera, px, py, features.lens_a, features.lens_b)
            hit = closest_hit(scene.geometry, origin, direction, _FAR, features.scratch)
            hit = closest_direct(scene, origin, direction, hit, features.scratch)
            t, lamp = closest_lamp(scene.lights, origin, direction, hit.t)
            if lamp < 0 and hit.slot == _NONE:
                continue
            features.depth[y, x] = t
            features.distance[y, x] = t * length(direction)
            if lamp >= 0:
                _write_lamp(scene, features, y, x, origin, direction, t, lamp)
            else:
                _write_surface(scene, features, y, x, origin, direction, hit)
