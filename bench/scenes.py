"""The scenes of the path tracing benchmark, for both renderers from one description."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

import isophote as iso
from common import Floats, Ints, bumpy_sphere
from peers import mitsuba_mesh

WHITE, RED, GREEN = (0.725, 0.71, 0.68), (0.63, 0.065, 0.05), (0.14, 0.45, 0.091)


class Thing(NamedTuple):
    """A diffuse mesh: vertices, triangles or quadrilaterals, albedo."""

    vertices: Floats
    faces: Ints
    albedo: tuple[float, float, float]


class Lamp(NamedTuple):
    """A rectangle that shines downward: size along x and z, centre, radiance."""

    size: tuple[float, float]
    centre: tuple[float, float, float]
    radiance: tuple[float, float, float]


class View(NamedTuple):
    """A pinhole camera; `fov` in degrees, of a square picture."""

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    fov: float


class Description(NamedTuple):
    """A scene; `sky` is the radiance of a constant surrounding, 0 for none."""

    things: list[Thing]
    lamps: list[Lamp]
    sky: float
    view: View


def _quads(*quads: Any, albedo: tuple[float, float, float]) -> Thing:
    vertices = np.array(quads, np.float32).reshape(-1, 3)
    return Thing(vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 4), albedo)


def _block(footprint: list[tuple[float, float]], height: float) -> Thing:
    low = [(x, 0, z) for x, z in footprint]
    high = [(x, height, z) for x, z in footprint]
    sides = [(low[i - 1], low[i], high[i], high[i - 1]) for i in range(4)]
    return _quads(*sides, high, albedo=WHITE)


def cornell_box() -> Description:
    """The box as Cornell measured it; the lamp fills a hole of the ceiling, so that only one side of it is seen."""
    x1, y1, z1 = 556.0, 548.8, 559.2
    left, right, near, far = 213.0, 343.0, 227.0, 332.0

    def ceiling(a: float, b: float, c: float, d: float) -> list[tuple[float, float, float]]:
        return [(a, y1, c), (b, y1, c), (b, y1, d), (a, y1, d)]

    white = _quads(
        [(0, 0, 0), (0, 0, z1), (x1, 0, z1), (x1, 0, 0)],
        [(0, 0, z1), (0, y1, z1), (x1, y1, z1), (x1, 0, z1)],
        ceiling(0, x1, 0, near),
        ceiling(0, x1, far, z1),
        ceiling(0, left, near, far),
        ceiling(right, x1, near, far),
        albedo=WHITE,
    )
    red = _quads([(x1, 0, 0), (x1, 0, z1), (x1, y1, z1), (x1, y1, 0)], albedo=RED)
    green = _quads([(0, 0, 0), (0, y1, 0), (0, y1, z1), (0, 0, z1)], albedo=GREEN)
    low = _block([(130, 65), (82, 225), (240, 272), (290, 114)], 165)
    high = _block([(423, 247), (265, 296), (314, 456), (472, 406)], 330)
    lamp = Lamp((right - left, far - near), ((left + right) / 2, y1, (near + far) / 2), (17, 12, 4))
    return Description([white, red, green, low, high], [lamp], 0, View((278, 273, -800), (278, 273, 0), 39.3077))


def bumpy_on_ground(frequency: int = 224) -> Description:
    """A bumpy sphere (1,003,520 triangles) on a ground, under a constant sky."""
    ground = _quads([(-20, -1.1, -20), (-20, -1.1, 20), (20, -1.1, 20), (20, -1.1, -20)], albedo=(0.5, 0.5, 0.5))
    sphere = Thing(*bumpy_sphere(frequency), (0.8, 0.8, 0.8))
    return Description([sphere, ground], [], 1, View((0, 0.9, 3.6), (0, -0.1, 0), 40))


SCENES: dict[str, Callable[[], Description]] = {
    "cornell": cornell_box,
    "bumpy1M": bumpy_on_ground,
    "bumpy20": lambda: bumpy_on_ground(1),
}
GOALS = {"cornell": 1.2, "bumpy1M": 2.0, "bumpy20": 0.0}
REFERENCE_SAMPLES = {"cornell": 4096, "bumpy1M": 1024, "bumpy20": 64}


def isophote_scene(description: Description) -> iso.Scene:
    """The scene for Isophote."""
    items = [iso.Item(iso.Mesh(t.vertices, t.faces), iso.Matte(t.albedo)) for t in description.things]
    lamps = [iso.RectLight(size=lamp.size, radiance=lamp.radiance).at(lamp.centre) for lamp in description.lamps]
    skies = [iso.Sky((description.sky,) * 3)] if description.sky else []
    view = description.view
    return iso.Scene(items, lights=[*lamps, *skies], camera=iso.Camera(view.eye, view.target, fov_degrees=view.fov))


def mitsuba_scene(mitsuba: ModuleType, description: Description, *, lamps_as_meshes: bool = False) -> Any:
    """The scene for Mitsuba, loaded; lamps are its rectangles, or two triangles, which it samples less evenly."""
    transform = mitsuba.ScalarTransform4f
    loaded: dict[str, Any] = {"type": "scene"}
    for number, thing in enumerate(description.things):
        quads = thing.faces.shape[1] == 4
        triangles = thing.faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3) if quads else thing.faces
        diffuse = {"type": "diffuse", "reflectance": _rgb(thing.albedo)}
        loaded[f"thing{number}"] = mitsuba_mesh(mitsuba, thing.vertices, triangles, bsdf=diffuse)
    for number, lamp in enumerate(description.lamps):
        emitter = {"type": "area", "radiance": _rgb(lamp.radiance)}
        black = {"type": "diffuse", "reflectance": _rgb((0, 0, 0))}
        if lamps_as_meshes:
            corners = np.array(_corners(lamp), np.float32)
            triangles = np.array([(0, 1, 2), (0, 2, 3)], np.int32)
            loaded[f"lamp{number}"] = mitsuba_mesh(mitsuba, corners, triangles, bsdf=black, emitter=emitter)
            continue
        place = transform().translate(lamp.centre).rotate([1, 0, 0], 90).scale([lamp.size[0] / 2, lamp.size[1] / 2, 1])
        loaded[f"lamp{number}"] = {"type": "rectangle", "to_world": place, "emitter": emitter, "bsdf": black}
    if description.sky:
        loaded["sky"] = {"type": "constant", "radiance": _rgb((description.sky,) * 3)}
    return mitsuba.load_dict(loaded)


def _corners(lamp: Lamp) -> list[tuple[float, float, float]]:
    (x, y, z), (width, depth) = lamp.centre, lamp.size
    return [(x + a * width / 2, y, z + b * depth / 2) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def mitsuba_sensor(mitsuba: ModuleType, view: View, size: int, sampler: str, samples: int) -> Any:
    """A camera with one of Mitsuba's samplers, a film of size × size pixels and a box filter."""
    place = mitsuba.ScalarTransform4f().look_at(list(view.eye), list(view.target), [0, 1, 0])
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    return mitsuba.load_dict(
        {
            "type": "perspective",
            "fov": view.fov,
            "to_world": place,
            "film": film,
            "sampler": {"type": sampler, "sample_count": samples},
        }
    )


def _rgb(colour: tuple[float, float, float]) -> dict[str, Any]:
    return {"type": "rgb", "value": list(colour)}
