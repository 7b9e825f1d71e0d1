"""What was made last of some objects, kept as long as these live."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Sequence
from typing import Any, Generic, NamedTuple, TypeVar

__all__ = ["Latest"]

_Made = TypeVar("_Made")


class _Kept(NamedTuple):
    objects: tuple[weakref.ref[Any], ...]
    made: Any


class Latest(Generic[_Made]):
    """What was made last. It is let go as soon as one of the objects is of which it was made."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: _Kept | None = None

    def find(self, objects: Sequence[Any]) -> _Made | None:
        """What was made last, if of these very objects."""
        with self._lock:
            kept = self._kept
        if kept is None or len(kept.objects) != len(objects):
            return None
        same = all(ref() is one for ref, one in zip(kept.objects, objects, strict=True))
        made: _Made | None = kept.made if same else None
        return made

    def keep(self, objects: Sequence[Any], made: _Made) -> None:
        """Remember this instead."""
        refs = tuple(weakref.ref(one, self._forget) for one in objects)
        with self._lock:
            self._kept = _Kept(refs, made)

    def _forget(self, dead: weakref.ref[Any]) -> None:
        # No lock: a collection may call this while one is held, and setting a name is atomic.
        kept = self._kept
        if kept is not None and any(dead is ref for ref in kept.objects):
            self._kept = None
