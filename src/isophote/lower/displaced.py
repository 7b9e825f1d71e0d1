"""Scenes whose displaced items are meshes that are displaced."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError, SceneError
from isophote.lower.latest import LatestScene
from isophote.scene.camera import AnyCamera
from isophote.scene.displacement import Displacement
from isophote.scene.scene import Item, Scene
from isophote.shapes.mesh import Mesh

if TYPE_CHECKING:
    from isophote.convert.dice import Measure

__all__ = ["displaced"]

Doubles: TypeAlias = npt.NDArray[np.float64]

# What is out of the picture by more than this part of it is cut into edges so many times as long.
_MARGIN, _COARSER = 0.25, 4.0

# What is lowered for no picture, is for this size.
_NO_PICTURE = (1, 1)

_latest: LatestScene[tuple[Item, ...]] = LatestScene()


def displaced(scene: Scene, size: tuple[int, int] | None = None) -> Scene:
    """The scene with meshes in the place of what is displaced, cut for its camera and a picture of `size` where that
    says how finely; the same meshes for the same scene. Raises `SceneError` naming the item where they are too large.
    """
    if all(item.displacement is None for item in scene.items):
        return scene
    size = None if size == _NO_PICTURE else size
    seen = size is not None and any(item.displacement and item.displacement.edge is None for item in scene.items)
    items = _latest.find(scene, size if seen else None)
    if items is None:
        items = _displaced_items(scene, size)
        _latest.keep(scene, size if seen else None, items, one_view=seen)
    return scene.with_(items=items)


def _displaced_items(scene: Scene, size: tuple[int, int] | None) -> tuple[Item, ...]:
    """Items that share a mesh and its displacement share the mesh that comes of it."""
    camera = scene.still(scene.shutter[0]).camera
    found: dict[tuple[int, Displacement], Mesh] = {}
    items = []
    for number, item in enumerate(scene.items):
        settings, mesh = item.displacement, item.shape
        if settings is None:
            items.append(item)
            continue
        assert isinstance(mesh, Mesh)
        key = id(mesh), settings
        if key not in found:
            matrices = [i.transform.matrix for i in scene.items if i.shape is mesh and i.displacement == settings]
            found[key] = _displaced(mesh, settings, _measure(mesh, settings, matrices, camera, size), number)
        items.append(item.with_(shape=found[key], displacement=None))
    return tuple(items)


def _displaced(mesh: Mesh, settings: Displacement, measure: Measure, number: int) -> Mesh:
    # Loaded where something is displaced.
    from isophote.lower.displace import displaced_mesh

    try:
        return displaced_mesh(mesh, settings, measure)
    except GeometryError as error:
        raise SceneError(f"items[{number}]: {error}") from error


def _measure(
    mesh: Mesh, settings: Displacement, matrices: list[Doubles], camera: AnyCamera | None, size: tuple[int, int] | None
) -> Measure:
    # As in _displaced.
    from isophote.lower.displace import edge_measure

    if settings.edge is not None or camera is None or size is None:
        return edge_measure(mesh, settings.edge)
    seen, pixels = camera, settings.pixels
    rays = camera.linear_map(size)
    # A pixel is so wide where rays begin, and so much wider after 1.
    near, spread = float(np.linalg.norm(rays.ox)), float(np.linalg.norm(rays.dx))
    eye, picture = np.asarray(seen.eye, np.float64), size

    def in_pixels(a: Doubles, b: Doubles) -> Doubles:
        """The longest that any item of the mesh shows of edges, in parts of what is wanted."""
        longest = np.zeros(len(a))
        for matrix in matrices:
            start, end = (points @ matrix[:3, :3].T + matrix[:3, 3] for points in (a, b))
            length, middle = np.linalg.norm(end - start, axis=1), (start + end) / 2
            # Of an edge around the eye no more than its own length away counts.
            away = np.maximum(np.linalg.norm(middle - eye, axis=1), length)
            width = np.maximum(near + spread * away, 1e-300)
            coarser = np.where(_is_near_picture(seen, middle, picture), 1.0, _COARSER)
            longest = np.maximum(longest, length / (width * pixels * coarser))
        return longest

    return in_pixels


def _is_near_picture(camera: AnyCamera, points: Doubles, size: tuple[int, int]) -> npt.NDArray[np.bool_]:
    """Whether points are seen in the picture, or next to it."""
    film, _ = camera.project(points, size)
    across, down = film[:, 0] / size[0], film[:, 1] / size[1]
    with np.errstate(invalid="ignore"):
        inside = (np.abs(across - 0.5) < 0.5 + _MARGIN) & (np.abs(down - 0.5) < 0.5 + _MARGIN)
    return np.asarray(inside, bool)
