"""A sensible camera, light and floor for things that come without."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.camera import Camera
from isophote.scene.fields import VectorLike
from isophote.scene.light import Light, RectLight, Sky
from isophote.scene.material import Emitter, Matte, Principled
from isophote.scene.material_base import Material, parts_of
from isophote.scene.scene import Item, Scene, Shape, is_shape
from isophote.scene.transform import unit_vector
from isophote.shapes.mesh import Mesh

__all__ = ["frame", "studio"]

# Three quarters from the front and so far above that the horizon stays out of the picture.
_VIEW = (0.453, 0.423, 0.785)
_KEY = (-0.75, 1.0, 0.4)
_KEY_DISTANCE = 5.0
_KEY_RADIANCE = 18.0
_SKY_RADIANCE = 0.25
_GROUND_REACH = 100.0
_GROUND_GAP = 1e-3
_MARGIN = 1.03
_CLAY = Matte((0.72, 0.66, 0.56))
_GROUND = Matte(0.5)


def _sphere(bounds: npt.ArrayLike) -> tuple[npt.NDArray[np.float64], float]:
    """Centre and radius of the sphere around a box; a radius above zero for a box without a size."""
    box = np.asarray(bounds, np.float64)
    if box.shape != (2, 3) or not np.isfinite(box).all() or (box[0] > box[1]).any():
        raise SceneError(
            f"only what has finite bounds can be framed, but these are {box.tolist()}; give the scene a camera"
        )
    centre = box[0] / 2 + box[1] / 2
    radius = float(np.linalg.norm(box[1] / 2 - box[0] / 2))
    if radius == 0:
        return centre, 1.0
    # A speck far from the origin is framed no closer than its coordinates can tell eye from target.
    return centre, max(radius, 1e-7 * float(np.abs(centre).max()))


def frame(
    bounds: npt.ArrayLike, direction: VectorLike = _VIEW, fov_degrees: float = 40.0, aspect: float = 1.0
) -> Camera:
    """A camera that has the whole sphere around the box `bounds`, (2, 3), in view, with some margin.

    `direction` points from the middle of the box toward the camera. `aspect` is width / height of the picture:
    of a picture below 1 the width decides. Raises `SceneError` for bounds that are not finite.
    """
    if not (math.isfinite(aspect) and aspect > 0):
        raise SceneError(f"aspect must be a finite number above 0, but is {aspect}")
    centre, radius = _sphere(bounds)
    toward = unit_vector(direction, "direction")
    probe = Camera(toward, (0, 0, 0), up=_up(toward), fov_degrees=fov_degrees)
    half = math.atan(math.tan(math.radians(probe.fov_degrees) / 2) * min(aspect, 1.0))
    distance = _MARGIN * radius / math.sin(half)
    return Camera(centre + distance * toward, centre, up=probe.up, fov_degrees=fov_degrees)


def _up(toward: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    return (0.0, 0.0, -1.0) if math.hypot(toward[0], toward[2]) < 1e-6 else (0.0, 1.0, 0.0)


def studio(subject: Shape | Item | Sequence[Shape | Item] | Scene, aspect: float = 1.0) -> Scene:
    """A scene to look at a shape, an item, or several of them.

    Adds a camera that frames them from three quarters, a little above (`aspect` is width / height of the
    picture), a large key light, a dim sky, and a grey matte ground just below; all measured by the bounds, so
    that things look the same at any scale. A bare shape becomes an item of a neutral matte colour. A `Scene`
    keeps all it has and gets only a camera, and lights, where it has none.

    Raises `SceneError` where nothing is given or the bounds are not finite.
    """
    if isinstance(subject, Scene):
        return _completed(subject, aspect)
    items = _as_items(subject)
    bounds = Scene(items).bounds
    return Scene((*items, _ground(bounds)), lights=_lights(bounds), camera=frame(bounds, aspect=aspect))


def _completed(scene: Scene, aspect: float) -> Scene:
    camera = frame(_finite_bounds(scene), aspect=aspect) if scene.camera is None else scene.camera
    lights = scene.lights if _has_light(scene) else _lights(_finite_bounds(scene))
    return scene.with_(camera=camera, lights=lights)


def _finite_bounds(scene: Scene) -> npt.NDArray[np.float64]:
    """Bounds of what is finite in a scene; of everything, which is then refused, where nothing is."""
    items = tuple(item for item in scene.items if np.isfinite(item.bounds).all())
    return Scene(items).bounds if items else scene.bounds


def _has_light(scene: Scene) -> bool:
    return bool(scene.lights) or any(_shines(item.material) for item in scene.items)


def _as_items(subject: object) -> tuple[Item, ...]:
    given = (subject,) if isinstance(subject, Item) or is_shape(subject) else subject
    if isinstance(given, str) or not isinstance(given, Sequence) or not given:
        raise SceneError(f"studio takes a shape, an Item, or a list of them, but not {subject!r}")
    return tuple(one if isinstance(one, Item) else Item(one, _CLAY) for one in given)


def _lights(bounds: npt.ArrayLike) -> tuple[Light, ...]:
    centre, radius = _sphere(bounds)
    key = np.array(_KEY)
    position = centre + _KEY_DISTANCE * radius * key / np.linalg.norm(key)
    light = RectLight(size=(2 * radius, 2 * radius), radiance=_KEY_RADIANCE)
    return light.at(position, centre), Sky("white", _SKY_RADIANCE)


def _ground(bounds: npt.NDArray[np.float64]) -> Item:
    centre, radius = _sphere(bounds)
    x, z = float(centre[0]), float(centre[2])
    y = float(bounds[0, 1]) - _GROUND_GAP * radius
    reach = _GROUND_REACH * radius
    corners = [
        (x - reach, y, z - reach),
        (x - reach, y, z + reach),
        (x + reach, y, z + reach),
        (x + reach, y, z - reach),
    ]
    return Item(Mesh(corners, [(0, 1, 2, 3)]), _GROUND, name="ground")


def _shines(material: Material) -> bool:
    return any(
        isinstance(part, Emitter) or (isinstance(part, Principled) and max(part.emission) > 0)
        for part in parts_of(material)
    )
