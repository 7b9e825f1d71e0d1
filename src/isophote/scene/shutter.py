"""The time of a picture: when a shutter is open, and cameras that move meanwhile."""

from __future__ import annotations

import math
from typing import Any, Protocol, TypeVar

import attrs
import numpy as np

from isophote.errors import SceneError
from isophote.scene.fields import Vector, pair
from isophote.scene.motion import Motion

__all__ = ["moved_camera", "rigid_motion", "shutter_times"]


class _Moving(Protocol):
    @property
    def eye(self) -> Vector: ...
    @property
    def target(self) -> Vector: ...
    @property
    def motion(self) -> Motion | None: ...


_Camera = TypeVar("_Camera", bound=_Moving)


def shutter_times(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """Two finite numbers of seconds, the first not after the second."""
    pair(instance, attribute, value)
    if value[0] > value[1]:
        raise SceneError(
            f"{type(instance).__name__}: shutter must open before it closes, (opening, closing) in seconds, but is "
            f"{value!r}"
        )


def rigid_motion(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A motion without stretch and mirrors."""
    name = f"{type(instance).__name__}: {attribute.name}"
    if not isinstance(value, Motion):
        raise SceneError(f"{name} must be a Motion or None, but is {value!r}")
    for time, transform in value.placements:
        if not transform.is_rigid:
            raise SceneError(f"{name} must only turn and move, but the placement at {time} is {transform!r}")


def moved_camera(camera: _Camera, time: float) -> _Camera:
    """The camera where its motion has it at a time, without the motion; itself where it has none."""
    if camera.motion is None:
        return camera
    frame = camera.motion.at(time).matrix
    eye = frame[:3, 3]
    ahead = math.dist(camera.eye, camera.target)
    back, up = frame[:3, 2] / np.linalg.norm(frame[:3, 2]), frame[:3, 1]
    return attrs.evolve(camera, eye=eye, target=eye - ahead * back, up=up, motion=None)  # type: ignore[misc]
