"""What has been made of forms, kept as long as the forms live."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

from isophote.shapes.field.form import Form

__all__ = ["Kept"]

Made = TypeVar("Made")

# Of one form this much is kept: that it was looked at in one more region should not hold memory.
_MOST = 4


class Kept(Generic[Made]):
    """Things made of forms and of something else, by the forms' identity; the last few for each form."""

    def __init__(self) -> None:
        self._made: dict[int, tuple[weakref.ref[Form], dict[Hashable, Made]]] = {}

    def __contains__(self, form: Form) -> bool:
        found = self._made.get(id(form))
        return found is not None and found[0]() is form

    def __len__(self) -> int:
        return len(self._made)

    def get(self, form: Form, key: Hashable, make: Callable[[], Made]) -> Made:
        """What was made of a form and a key, or what `make` makes now."""
        number = id(form)
        found = self._made.get(number)
        if found is None or found[0]() is not form:
            found = weakref.ref(form, lambda _: self._made.pop(number, None)), {}
            self._made[number] = found
        known = found[1]
        if key not in known:
            made = make()
            while len(known) >= _MOST:
                known.pop(next(iter(known)), None)
            known[key] = made
            return made
        return known[key]
