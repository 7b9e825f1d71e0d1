"""What a field is inside: a form that writes its expression, and knows its bounds and how far it can be trusted."""

from __future__ import annotations

import enum
from typing import Any, ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.shapes.field.expression import Point, Value

__all__ = ["Box", "Exactness", "Form"]

Box: TypeAlias = npt.NDArray[np.float64]


class Exactness(enum.IntEnum):
    """How far a field's values can be trusted; forms made of several are as good as their worst.

    `EXACT`: the distance to the surface. `BOUND`: the surface is nowhere nearer than |value| / Lipschitz constant.
    `SIGN`: only the sign is meant, for no Lipschitz constant is known.
    """

    SIGN = 0
    BOUND = 1
    EXACT = 2


class Form:
    """A node of the tree that describes a field; negative inside. Frozen, and equal where its fields are equal."""

    dimension: ClassVar[int] = 3
    # Whether values are distances, where the form alone decides it.
    exactness: Exactness = Exactness.EXACT

    def expression(self, p: Point) -> Value:
        """The field's value at `p`, with its Lipschitz constant claimed by `p.bounded` where the form knows one."""
        raise NotImplementedError

    @property
    def bounds(self) -> Box:
        """(2, dimension): a box that holds all points where the field is not positive; infinite where endless."""
        raise NotImplementedError

    def spelled(self) -> str:
        """Python that makes the field, given the names of `isophote`."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return self.spelled()


def number_spelled(value: Any) -> str:
    """A number, or a tuple of them, in its shortest exact spelling."""
    if isinstance(value, tuple):
        return "(" + ", ".join(map(number_spelled, value)) + ("," if len(value) == 1 else "") + ")"
    if type(value) is float:
        return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    return repr(value)
