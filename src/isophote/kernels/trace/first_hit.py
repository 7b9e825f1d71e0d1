"""What the camera sees first at one place in each pixel: exact, never blended."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import closest_hit
from isophote.kernels.accel.surface import PUBLIC, face_number, offset_point
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.table import FLOAT, FLOAT_ROWS, FLOATS, INT, INT_ROWS, Table
from isophote.kernels.base.vec import dot, length
from isophote.kernels.light.emitter import closest_lamp, lamp_normal
from isophote.kernels.trace.camera import camera_ray
from isophote.kernels.trace.cone import pixel_cone
from isophote.kernels.trace.direct import closest_direct, is_surface, surface_of
from isophote.kernels.trace.holes import has_holes, surface_opacity
from isophote.kernels.trace.material import turned_normal
from isophote.kernels.trace.shading import surface_colour
from isophote.kernels.trace.tables import SCENE

__all__ = ["FEATURES", "first_hits"]

_ZERO = np.float32(0)
_FAR, _NONE = np.float32(np.inf), np.int64(-1)
# What is less opaque than this is looked through, at so many surfaces at most.
_LEAST, _MOST = np.float32(0.5), np.int64(4096)

# Rows y, pixels x: `depth`, `distance`, `item`, `primitive` (height, width), the others (height, channels · width).
# `film_x`, `film_y`: the place from each pixel's corner; `lens_a`, `lens_b`: the point of the unit disk of the lens;
# `samples`: how many such places there are in all.
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
    samples=INT,
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
    unit = direction / length(direction)
    width, spread = pixel_cone(scene.camera, unit, features.samples)
    radius = width + features.distance[y, x] * spread
    normal = turned_normal(scene, surface, hit, unit, radius, features.scratch)
    _set(features.normal, y, x, _facing(normal, direction))
    _set(features.albedo, y, x, surface_colour(scene, surface, hit, unit, radius, features.scratch))
    features.uv[y, 2 * x] = surface.u
    features.uv[y, 2 * x + 1] = surface.v
    features.item[y, x] = scene.surfaces.items[surface.item, PUBLIC]
    features.primitive[y, x] = face_number(scene.surfaces, surface.item, surface.triangle)


@device
def _met(scene, start, direction, scratch):
    """(hit, t, lamp) of a ray: the first surface, and the first lamp before it, or −1."""
    hit = closest_hit(scene.geometry, start, direction, _FAR, scratch)
    hit = closest_direct(scene, start, direction, hit, scratch)
    t, lamp = closest_lamp(scene.lights, start, direction, hit.t)
    return hit, t, lamp


@device
def _seen(scene, origin, direction, scratch):
    """(start, hit, t, lamp) where a ray from `origin` first meets what can be seen; hit and t are told from `start`."""
    start = origin
    hit, t, lamp = _met(scene, start, direction, scratch)
    left = _MOST if has_holes(scene) else np.int64(0)
    while left > 0 and lamp < 0 and is_surface(hit.slot):
        surface = surface_of(scene, start, direction, hit, scratch)
        if surface_opacity(scene, surface, hit, direction / length(direction), _ZERO, scratch) >= _LEAST:
            break
        start = offset_point(surface.place, surface.normal, surface.error, direction)
        hit, t, lamp = _met(scene, start, direction, scratch)
        left -= 1
    return start, hit, t, lamp


@kernel
def first_hits(scene_words, feature_words, width, y0, y1):
    """Fill rows y0 ≤ y < y1 of the features; where nothing is met, they keep what they hold."""
    scene, features = open_scene(scene_words), open_features(feature_words)
    for y in range(y0, y1):
        for x in range(width):
            px, py = np.float32(x) + features.film_x, np.float32(y) + features.film_y
            origin, direction = camera_ray(scene.camera, px, py, features.lens_a, features.lens_b)
            start, hit, t, lamp = _seen(scene, origin, direction, features.scratch)
            if lamp < 0 and hit.slot == _NONE:
                continue
            depth = dot(start - origin, direction) / dot(direction, direction) + t
            features.depth[y, x] = depth
            features.distance[y, x] = depth * length(direction)
            if lamp >= 0:
                _write_lamp(scene, features, y, x, start, direction, t, lamp)
            else:
                _write_surface(scene, features, y, x, start, direction, hit)
