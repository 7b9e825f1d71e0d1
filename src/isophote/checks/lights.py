"""Direct light of every kind by path tracing: the irradiance of a point of a floor, in closed form."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from isophote.checks.check import Check, Effort, Measured, mean_of
from isophote.checks.scenes import greys, picture, quad
from isophote.rendering.path_trace import PathTrace
from isophote.scene.camera import Camera
from isophote.scene.image_texture import ImageTexture
from isophote.scene.light import (
    DiskLight,
    Environment,
    Light,
    PointLight,
    RectLight,
    Sky,
    SphereLight,
    Sun,
)
from isophote.scene.material import Emitter, Matte
from isophote.scene.scene import Item
from isophote.scene.spot_light import SpotLight

__all__ = ["CHECKS", "rectangle_irradiance", "wall_irradiance"]

_TOPIC = "lights: light that leaves a point of a floor, E ρ / π"

_ALBEDO, _RADIANCE = 0.5, 4.0
_FLOOR = Item(quad((-9, 0, -9), (-9, 0, 9), (9, 0, 9), (9, 0, -9)), Matte(_ALBEDO))
# All pixels see one point of the floor, from the side.
_SPOT = Camera((0.0, 1.0, 3.0), (0, 0, 0), fov_degrees=1e-3)
_SAMPLES = 64
_ROUNDING = 2e-4


def rectangle_irradiance(a: float, b: float, h: float) -> float:
    """Of a parallel rectangle (a, b) of radiance 1 at height h above the point, four times that of its quarter."""
    x, y = a / 2 / h, b / 2 / h
    p, q = math.sqrt(1 + x * x), math.sqrt(1 + y * y)
    return 2 * (x / p * math.atan(y / p) + y / q * math.atan(x / q))


def wall_irradiance(width: float, height: float, distance: float) -> float:
    """Of a rectangle of radiance 1 that stands upright on the floor, seen from in front of its middle."""
    y, x = width / 2 / distance, height / distance
    r = math.sqrt(1 + x * x)
    return math.atan(y) - math.atan(y / r) / r


def _irradiance(items: list[Item], lights: list[Light], exact: float, effort: Effort) -> Measured:
    method = PathTrace(samples=effort.samples(_SAMPLES), max_depth=2)
    image = picture([_FLOOR, *items], lights, _SPOT, method, effort)
    wanted = _ALBEDO / math.pi * exact
    return mean_of(greys(image), wanted, _ROUNDING * wanted)


def _lit(light: Light, exact: float) -> Callable[[Effort], Measured]:
    return partial(_irradiance, [], [light], exact)


_WALL = Item(quad((-1.5, 0, -2), (1.5, 0, -2), (1.5, 1.2, -2), (-1.5, 1.2, -2)), Emitter(_RADIANCE))
_BALL = np.array((1.0, 2.0, -0.5))
_BALL_AWAY = float(np.linalg.norm(_BALL))
_PICTURE = ImageTexture(np.full((4, 8, 3), 0.8, np.float32), colour_space="linear")

CHECKS = [
    Check(
        _TOPIC,
        "rectangle overhead",
        _lit(
            RectLight(size=(1.6, 1.0), radiance=_RADIANCE).at((0, 1.2, 0)),
            _RADIANCE * rectangle_irradiance(1.6, 1.0, 1.2),
        ),
    ),
    # Of a disk overhead E = π L sin² of the half angle.
    Check(
        _TOPIC,
        "disk overhead",
        _lit(DiskLight(radius=0.8, radiance=_RADIANCE).at((0, 1.2, 0)), _RADIANCE * math.pi * 0.64 / (0.64 + 1.44)),
    ),
    # Of a ball above the horizon E = π L (r / d)² cosθ.
    Check(
        _TOPIC,
        "ball",
        _lit(
            SphereLight(radius=0.6, radiance=_RADIANCE).at(_BALL), _RADIANCE * math.pi * 0.36 * _BALL[1] / _BALL_AWAY**3
        ),
    ),
    Check(_TOPIC, "shining wall", partial(_irradiance, [_WALL], [], _RADIANCE * wall_irradiance(3.0, 1.2, 2.0))),
    # I cosθ / d².
    Check(_TOPIC, "point", _lit(PointLight(tuple(_BALL), 40), 10 / math.pi * _BALL[1] / _BALL_AWAY**3)),
    Check(
        _TOPIC,
        "spot",
        _lit(
            SpotLight.of_intensity(tuple(_BALL), 12, target=(0, 0, 0), cone_degrees=30), 12 * _BALL[1] / _BALL_AWAY**3
        ),
    ),
    Check(_TOPIC, "sun", _lit(Sun((1, 2, -2), 3), 3 * 2 / 3)),
    Check(_TOPIC, "constant sky", _lit(Sky(0.8), 0.8 * math.pi)),
    Check(_TOPIC, "picture of the sky", _lit(Environment(_PICTURE), 0.8 * math.pi)),
]
