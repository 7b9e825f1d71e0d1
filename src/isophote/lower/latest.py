"""The scene lowered last, kept so that another view of it needs no new tree."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Hashable
from typing import Any, Generic, NamedTuple, TypeVar

from isophote.scene.camera import AnyCamera
from isophote.scene.light import Light
from isophote.scene.scene import Item, Scene

__all__ = ["Latest"]


_Tables = TypeVar("_Tables")


class _Kept(NamedTuple):
    items: tuple[weakref.ref[Item], ...]
    lights: tuple[Light, ...]
    camera: AnyCamera | None
    way: Hashable
    tables: Any


class Latest(Generic[_Tables]):
    """Tables of one scene. They are let go as soon as one of its items is: nothing is kept for nobody."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: _Kept | None = None

    def find(self, scene: Scene, way: Hashable) -> _Tables | None:
        """The tables of a scene with the very same items, equal lights, lowered in the same way, and an equal camera
        where that counts."""
        with self._lock:
            kept = self._kept
        if kept is None or len(kept.items) != len(scene.items) or kept.lights != scene.lights:
            return None
        if kept.way != way:
            return None
        if kept.camera is not None and kept.camera != scene.camera:
            return None
        same = all(ref() is item for ref, item in zip(kept.items, scene.items, strict=True))
        tables: _Tables | None = kept.tables if same else None
        return tables

    def keep(self, scene: Scene, way: Hashable, tables: _Tables, *, one_view: bool = False) -> None:
        """Remember these tables instead of the last ones; with `one_view` they are only for the scene's camera."""
        items = tuple(weakref.ref(item, self._forget) for item in scene.items)
        with self._lock:
            self._kept = _Kept(items, scene.lights, scene.camera if one_view else None, way, tables)

    def _forget(self, dead: weakref.ref[Item]) -> None:
        # No lock: a collection may call this while one is held, and setting a name is atomic.
        kept = self._kept
        if kept is not None and any(dead is ref for ref in kept.items):
            self._kept = None
