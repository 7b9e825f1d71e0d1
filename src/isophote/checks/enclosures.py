"""Closed rooms that shine and reflect: B = E / (1 − ρ) everywhere; white bodies under a white sky are not seen."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from isophote.checks.check import Check, Effort, Measured, mean_of
from isophote.checks.materials import WHITE, WHITE_PLACES
from isophote.checks.scenes import box, greys, picture, sphere_mesh
from isophote.rendering.path_trace import PathTrace
from isophote.rendering.radiosity.method import Radiosity, radiosity
from isophote.scene.camera import Camera
from isophote.scene.light import Sky
from isophote.scene.material import Emitter, Matte
from isophote.scene.scene import Item, Scene
from isophote.shapes.mesh import Mesh

__all__ = ["CHECKS"]

_CLOSED = "enclosures: radiance within walls that shine with 1 and reflect ρ, 1 / (1 − ρ)"
_OPEN = "enclosures: white bodies under a white sky of 1, by path tracing"

_INSIDE = Camera((0.5, 0.1, 0.2), (-1, 0.3, -1), fov_degrees=90)
_OUTSIDE = Camera((0, 0, 4), (0, 0, 0), fov_degrees=40)
# Paths so long that what is cut off does not count.
_ENDLESS = 256
_SAMPLES = 256
_ROUNDING, _TABLES = 2e-4, 3e-3
_BODIES = WHITE | WHITE_PLACES


def _furnace(mesh: Mesh, albedo: float, effort: Effort) -> Measured:
    item = Item(mesh, Emitter(1.0, two_sided=True, body=Matte(albedo)))
    method = PathTrace(samples=effort.samples(_SAMPLES), max_depth=_ENDLESS)
    image = picture([item], [], _INSIDE, method, effort)
    return mean_of(greys(image), 1 / (1 - albedo), _ROUNDING / (1 - albedo))


def _balance(albedo: float, effort: Effort) -> Measured:
    """The mean of what arrives within, by area."""
    item = Item(box(2.0, inward=True), Emitter(1.0, body=Matte(albedo)))
    error = 0.01 / math.sqrt(effort.factor)
    found = radiosity(Scene([item]), Radiosity(residual=1e-6, error=error), progress=False, threads=effort.threads)
    inside = found.form_factor_sums > 0.5
    light = np.average(found.irradiance[inside].mean(axis=1), weights=found.areas[inside]) / np.pi
    exact = 1 / (1 - albedo)
    # A form factor that is off by so much is off in every bounce.
    return Measured(float(light), exact, 0.005 * exact)


def _vanishes(name: str, effort: Effort) -> Measured:
    method = PathTrace(samples=effort.samples(_SAMPLES), max_depth=_ENDLESS)
    image = picture([Item(sphere_mesh(16), _BODIES[name])], [Sky(1.0)], _OUTSIDE, method, effort)
    return mean_of(greys(image)[image.channels["item"] == 0], 1, _TABLES)


CHECKS = [
    Check(_CLOSED, "cube, ρ = 0.2, path tracing", partial(_furnace, box(4, inward=True), 0.2)),
    Check(_CLOSED, "cube, ρ = 0.8, path tracing", partial(_furnace, box(4, inward=True), 0.8)),
    Check(_CLOSED, "ball, ρ = 0.8, path tracing", partial(_furnace, sphere_mesh(16), 0.8)),
    Check(_CLOSED, "cube, ρ = 0.5, radiosity", partial(_balance, 0.5)),
    Check(_CLOSED, "cube, ρ = 0.8, radiosity", partial(_balance, 0.8)),
    *(Check(_OPEN, name, partial(_vanishes, name)) for name in _BODIES),
]
