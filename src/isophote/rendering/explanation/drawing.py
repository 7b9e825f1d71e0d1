"""The rays of a pixel drawn into a view of the scene from aside."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.rendering.image import Image
from isophote.rendering.method import Size
from isophote.rendering.overlay import Line, overlaid
from isophote.rendering.ray_log import LoggedRay
from isophote.rendering.ray_trace import RayTrace
from isophote.rendering.render import render
from isophote.scene.camera import AnyCamera
from isophote.scene.scene import Scene
from isophote.scene.studio import frame

__all__ = ["drawn"]

Points: TypeAlias = npt.NDArray[np.float64]

_FIELD_OF_VIEW = 28.0
_COLOURS = {
    "camera": (255, 255, 255),
    "reflected": (66, 133, 244),
    "refracted": (30, 180, 90),
    "passed": (170, 170, 170),
    "seen": (255, 205, 40),
    "hidden": (220, 50, 47),
}
# How long rays that meet nothing are drawn, in parts of the finite scene's radius.
_REACH = 1.2


def drawn(scene: Scene, rays: Sequence[LoggedRay], size: Size, threads: int | None) -> Image:
    """The picture; its channel "colour" is the view with the lines."""
    lines = list(_lines(scene, rays))
    camera = _camera(scene, lines, size)
    view = render(scene.with_(camera=camera), RayTrace(samples=4, depth=4), size=size, progress=False, threads=threads)
    return overlaid(view, camera, (Line(start, end, _COLOURS[kind]) for start, end, kind in lines))


def _lines(scene: Scene, rays: Sequence[LoggedRay]) -> Iterator[tuple[Points, Points, str]]:
    """(start, end, kind) of all rays and shadow rays; those to lights first, so that others lie over them."""
    _, radius = _ball(scene)
    for ray in rays:
        for term in ray.lights:
            reach = term.distance if np.isfinite(term.distance) else _REACH * radius
            start = np.array(ray.place)
            yield start, start + reach * np.array(term.direction), "seen" if term.seen else "hidden"
    for ray in rays:
        if ray.ended is None:
            start = np.array(ray.origin)
            reach = _REACH * radius if ray.met == "nothing" else ray.distance
            yield start, start + reach * np.array(ray.direction), ray.kind


def _ball(scene: Scene) -> tuple[Points, float]:
    """Centre and radius of what is finite and no ground, as far as it can be told by size."""
    boxes = [item.bounds for item in scene.items]
    solid = [box for box in boxes if np.isfinite(box).all() and (box[1] > box[0]).all()]
    solid = solid or [box for box in boxes if np.isfinite(box).all()] or [np.array([[-1.0] * 3, [1.0] * 3])]
    low, high = np.min([b[0] for b in solid], axis=0), np.max([b[1] for b in solid], axis=0)
    return (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1e-6)


def _camera(scene: Scene, lines: Sequence[tuple[Points, Points, str]], size: Size) -> AnyCamera:
    """A camera aside of the line of sight, that sees the solid part of the scene, its camera and what lies between."""
    centre, radius = _ball(scene)
    eye = np.array(scene.camera.eye) if scene.camera is not None else centre
    ends = np.concatenate([np.stack(line[:2]) for line in lines]) if lines else np.zeros((0, 3))
    near = ends[np.linalg.norm(ends - centre, axis=1) <= max(4 * radius, 1.05 * float(np.linalg.norm(eye - centre)))]
    points = np.concatenate([near, [eye, centre - radius, centre + radius]])
    sight = centre - eye
    aside = np.cross(sight, (0.0, 1.0, 0.0))
    if np.linalg.norm(aside) < 1e-9:
        aside = np.array([1.0, 0.0, 0.0])
    aside = aside / np.linalg.norm(aside)
    toward = aside + 0.45 * np.array((0.0, 1.0, 0.0)) - 0.35 * sight / max(float(np.linalg.norm(sight)), 1e-12)
    bounds = np.stack([points.min(axis=0), points.max(axis=0)])
    # The ball around a box is larger than what is in it.
    return attrs.evolve(frame(bounds, toward, aspect=size[0] / size[1]), fov_degrees=_FIELD_OF_VIEW)
