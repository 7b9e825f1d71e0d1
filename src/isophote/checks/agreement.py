"""One way against another: radiosity against path tracing, ray tracing against it, any number of threads."""

from __future__ import annotations

from functools import cache, partial
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.checks.check import Check, Effort, Measured
from isophote.checks.scenes import box, greys, picture, quad
from isophote.rendering.image import Image
from isophote.rendering.method import Method
from isophote.rendering.path_trace import PathTrace
from isophote.rendering.radiosity.method import Radiosity
from isophote.rendering.ray_trace import RayTrace
from isophote.scene.camera import Camera
from isophote.scene.light import RectLight
from isophote.scene.material import Matte
from isophote.scene.scene import Item

__all__ = ["CHECKS"]

_WAYS = "agreement: of blocks of pixels of a room, relative differences from path tracing"
_THREADS = "agreement: values of a picture that differ between one thread and two"

Floats: TypeAlias = npt.NDArray[np.float64]

_SIDE, _BLOCKS, _SAMPLES = 48, 6, 512
_CAMERA = Camera((0, 1, 4.4), (0, 1, 0), fov_degrees=34)
_WALLS = [
    Item(quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)), Matte((0.7, 0.7, 0.7))),
    Item(quad((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)), Matte((0.7, 0.7, 0.7))),
    Item(quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)), Matte((0.7, 0.7, 0.7))),
    Item(quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)), Matte((0.6, 0.1, 0.1))),
    Item(quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)), Matte((0.1, 0.5, 0.1))),
]
_BOX = Item(box(0.6), Matte((0.6, 0.6, 0.6))).rotate("y", 0.3).translate((0.3, 0.3, 0.2))
_LAMP = RectLight(size=(0.5, 0.5), radiance=15).at((0, 1.98, 0))


def _room(method: Method, effort: Effort, side: int = _SIDE) -> Image:
    return picture([*_WALLS, _BOX], [_LAMP], _CAMERA, method, effort, (side, side))


def _blocks(image: Image) -> Floats:
    """Means of 8 × 8 pixels, without those at the picture's rim, which see past the room."""
    edge = _SIDE // _BLOCKS
    means: Floats = greys(image).reshape(_BLOCKS, edge, _BLOCKS, edge).mean(axis=(1, 3))[1:-1, 1:-1]
    return means


@cache
def _traced(depth: int, effort: Effort) -> Floats:
    return _blocks(_room(PathTrace(samples=effort.samples(_SAMPLES), max_depth=depth), effort))


@cache
def _settled(effort: Effort) -> Floats:
    return _blocks(_room(Radiosity(patch=0.1 / effort.factor ** (1 / 4), error=0.005), effort))


def _radiosity(percentile: float, allowed: float, effort: Effort) -> Measured:
    found = _settled(effort)
    exact = _traced(64, effort)
    return Measured(float(np.percentile(np.abs(found - exact) / exact, percentile)), 0, allowed, at_most=True)


def _direct(effort: Effort) -> Measured:
    """Two rays a path: lamps, and what they light, which is what ray tracing shows of a matte room."""
    found = _blocks(_room(RayTrace(samples=effort.samples(64), light_samples=8), effort))
    exact = _traced(2, effort)
    return Measured(float((np.abs(found - exact) / exact).max()), 0, 0.01, at_most=True)


def _threads(method: Method, effort: Effort) -> Measured:
    one, two = (_room(method, attrs.evolve(effort, threads=threads), 24).channels["colour"] for threads in (1, 2))
    return Measured(float((one != two).sum()), 0, 0)


CHECKS = [
    Check(_WAYS, "radiosity, half of the blocks", partial(_radiosity, 50, 0.01)),
    Check(_WAYS, "radiosity, nine in ten blocks", partial(_radiosity, 90, 0.03)),
    Check(_WAYS, "ray tracing, direct light, all blocks", _direct),
    Check(_THREADS, "path tracing", partial(_threads, PathTrace(samples=16))),
    Check(_THREADS, "ray tracing", partial(_threads, RayTrace(samples=16))),
    Check(_THREADS, "radiosity", partial(_threads, Radiosity(patch=0.2, samples=4))),
]
