"""A picture of what is wrong with meshes: their defects marked, from before and behind."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.topology import topology
from isophote.cli.progress import progress
from isophote.convert.markers import balls, tubes
from isophote.errors import IsophoteWarning, SceneError
from isophote.rendering.image import Image
from isophote.rendering.path_trace import PathTrace
from isophote.rendering.render import render
from isophote.scene.camera import Camera
from isophote.scene.material import Emitter, Matte
from isophote.scene.scene import Item, Scene
from isophote.scene.studio import frame, studio
from isophote.shapes.mesh import Mesh

__all__ = ["COLOURS", "draw_defects"]

COLOURS = {
    "boundary_edges": "blue",
    "non_manifold_edges": "red",
    "turned_edges": "lime",
    "non_manifold_vertices": "magenta",
}
"""What is marked, and the colour that it has in the picture."""

_CLAY = Matte((0.72, 0.66, 0.56))
_VIEWS = ((0.453, 0.423, 0.785), (-0.453, 0.423, -0.785))
_MARGIN = 1.05
# How much of a hidden marker's colour is seen.
_THROUGH = np.float32(0.5)
# Of the size of what is shown.
_TUBE = 0.003
_BALL = 0.009
_MOST = 50_000
_SAMPLES = 32


def draw_defects(scene: Scene, path: Path, size: tuple[int, int]) -> None:
    """Write a picture of the meshes of a scene, their defects marked in `COLOURS`, from two sides.

    `size` is that of each of the two views, which stand side by side.
    """
    meshes = [item for item in scene.items if isinstance(item.shape, Mesh)]
    if not meshes:
        raise SceneError("a picture of defects shows meshes, and this scene has none")
    bounds = Scene(meshes).bounds
    reach = float(np.linalg.norm(bounds[1] - bounds[0])) or 1.0
    markers = [marker for item in meshes for marker in _markers(item, reach)]
    shown = studio([*(item.with_(material=_CLAY) for item in meshes), *markers])
    cameras = [_close_up(meshes, direction, size[0] / size[1]) for direction in _VIEWS]
    Image({"colour": np.concatenate([_view(shown, markers, camera, size) for camera in cameras], axis=1)}).save(path)


def _view(shown: Scene, markers: list[Item], camera: Camera, size: tuple[int, int]) -> npt.NDArray[np.float32]:
    """(h, w, 3) the scene, with markers that something hides shining through."""
    picture = render(shown.with_(camera=camera), PathTrace(_SAMPLES), size=size, progress=progress())
    colour: npt.NDArray[np.float32] = picture.channels["colour"]
    if not markers:
        return colour
    bright = Scene([marker.with_(material=Emitter(COLOURS[str(marker.name)], two_sided=True)) for marker in markers])
    alone = render(bright.with_(camera=camera), PathTrace(_SAMPLES // 2, max_depth=1), size=size, progress=progress())
    # Before black, a colour whose largest channel is 1 tells how much of a pixel it covers.
    light = alone.channels["colour"]
    mixed: npt.NDArray[np.float32] = colour * (1 - _THROUGH * light.max(axis=2, keepdims=True)) + _THROUGH * light
    return mixed


def _close_up(items: list[Item], direction: tuple[float, float, float], aspect: float) -> Camera:
    """A camera as near as the boxes of all items fit into the picture."""
    camera = frame(Scene(items).bounds, direction, aspect=aspect)
    eye, target = np.array(camera.eye), np.array(camera.target)
    distance = float(np.linalg.norm(eye - target))
    toward = (eye - target) / distance
    right = np.cross(camera.up, toward) / np.linalg.norm(np.cross(camera.up, toward))
    corners = np.concatenate([list(product(*item.bounds.T)) for item in items]) - target
    slope = math.tan(math.radians(camera.fov_degrees) / 2)
    across = np.abs(corners @ right) / (slope * aspect)
    upward = np.abs(corners @ np.cross(toward, right)) / slope
    nearest = float((corners @ toward + np.maximum(across, upward)).max())
    # Flat things that lie in the line of sight need some distance all the same.
    position = target + toward * max(_MARGIN * nearest, 0.1 * distance)
    return Camera(position, camera.target, up=camera.up, fov_degrees=camera.fov_degrees)


def _markers(item: Item, reach: float) -> Iterator[Item]:
    mesh = item.shape
    assert isinstance(mesh, Mesh)
    found = topology(mesh)
    points = mesh.vertices @ item.transform.matrix[:3, :3].T + item.transform.matrix[:3, 3]
    for name, colour in COLOURS.items():
        where = _first(getattr(found, name), name)
        if len(where) == 0:
            continue
        if where.ndim == 2:
            shape = tubes(points[where[:, 0]], points[where[:, 1]], _TUBE * reach)
        else:
            shape = balls(points[where], _BALL * reach)
        yield Item(shape, Matte(colour), name=name)


def _first(where: npt.NDArray[np.integer], name: str) -> npt.NDArray[np.integer]:
    if len(where) > _MOST:
        text = f"the picture marks the first {_MOST:,} of {len(where):,} {name.replace('_', ' ')}"
        warnings.warn(text, IsophoteWarning, stacklevel=2)
    return where[:_MOST]
