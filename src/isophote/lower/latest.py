"""The scene lowered last, kept so that another view of it needs no new tree."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Generic, NamedTuple, TypeVar

from isophote.latest import Latest
from isophote.scene.camera import AnyCamera
from isophote.scene.light import Light
from isophote.scene.scene import Scene

__all__ = ["LatestScene"]

_Made = TypeVar("_Made")


class _Tables(NamedTuple):
    lights: tuple[Light, ...]
    camera: AnyCamera | None
    way: Hashable
    tables: Any


class LatestScene(Generic[_Made]):
    """Tables of one scene, of its very items."""

    def __init__(self) -> None:
        self._latest: Latest[_Tables] = Latest()

    def find(self, scene: Scene, way: Hashable) -> _Made | None:
        """The tables of a scene with the very same items, equal lights, lowered in the same way, and an equal camera
        where that counts."""
        kept = self._latest.find(scene.items)
        if kept is None or kept.lights != scene.lights or kept.way != way:
            return None
        if kept.camera is not None and kept.camera != scene.camera:
            return None
        tables: _Made = kept.tables
        return tables

    def keep(self, scene: Scene, way: Hashable, tables: _Made, *, one_view: bool = False) -> None:
        """Remember these tables instead of the last ones; with `one_view` they are only for the scene's camera."""
        camera = scene.camera if one_view else None
        self._latest.keep(scene.items, _Tables(scene.lights, camera, way, tables))
