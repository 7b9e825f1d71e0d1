"""What a field is inside: a form that writes its expression, and knows its bounds and how far it can be trusted."""

from __future__ import annotations

import enum
from collections.abc import Iterator
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.functions import maximum
from isophote.shapes.field.joins import STYLES

__all__ = ["Box", "Exactness", "Form", "grown", "number_spelled"]

Box: TypeAlias = npt.NDArray[np.float64]


class Exactness(enum.IntEnum):
    """How far a field's values can be trusted; forms made of several are as good as their worst.

    `EXACT`: the distance to the surface. `BOUND`: the surface is nowhere nearer than |value| / Lipschitz constant.
    `SIGN`: only the sign is meant, for no Lipschitz constant is known.
    """

    SIGN = 0
    BOUND = 1
    EXACT = 2


def grown(box: Box, by: float) -> Box:
    """A box that reaches `by` farther on all sides."""
    larger: Box = box + np.array([[-by], [by]])
    return larger


class Form:
    """A node of the tree that describes a field; negative inside. Frozen, and equal where its fields are equal."""

    dimension: ClassVar[int] = 3
    # Whether values are distances, where the form alone decides it.
    exactness: Exactness = Exactness.EXACT
    # Whether no smaller box than `bounds` holds the form; otherwise intervals may find one.
    is_tight: bool = True
    # Whether the form's faces meet at right angles.
    is_square: bool = False
    # Whether, besides, no face has an edge of its own, so that rounded edges leave distances exact.
    is_smooth: bool = False
    # Whether there are no edges to round.
    is_edgeless: bool = False
    # What messages call the form; its class's name where empty.
    title: ClassVar[str] = ""

    def expression(self, p: Point) -> Value:
        """The field's value at `p`, with its Lipschitz constant claimed by `p.bounded` where the form knows one."""
        raise NotImplementedError

    @property
    def bounds(self) -> Box:
        """(2, dimension): a box that holds all points where the field is not positive; infinite where endless."""
        raise NotImplementedError

    def bounds_at(self, level: float) -> Box:
        """(2, dimension): a box that holds all points where the field is not above `level`."""
        if level <= 0:
            return self.bounds
        return grown(self.bounds, level if self.exactness is Exactness.EXACT else np.inf)

    def faces(self, p: Point) -> list[Value]:
        """Values whose largest is the form's inside it: faces that meet in edges. One, where there are no edges.

        Raises `GeometryError` where the edges are not known.
        """
        if self.is_edgeless:
            return [self.expression(p)]
        raise GeometryError(
            f"round and chamfer: the edges of {self.name} are not known; finish what it is made of first, "
            "or take offset, which rounds edges by growing"
        )

    def finished(self, p: Point, style: str, size: Value) -> Value:
        """The form with its edges finished in a style of joins.py by `size`; nowhere below the form's own value."""
        faces = self.faces(p)
        if len(faces) == 1:
            return self.expression(p)
        value = STYLES[style](faces, size)
        if self.is_square:
            value = p.bounded(value, 1.0)
            if style == "round":
                return value
        return maximum(self.expression(p), value)

    def spelled(self) -> str:
        """Python that makes the field, given the names of `isophote`."""
        raise NotImplementedError

    def children(self) -> Iterator[Form]:
        """The forms that this one is made of."""
        for field in attrs.fields(type(self)):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if isinstance(value, Form):
                yield value
            elif isinstance(value, tuple):
                yield from (each for each in value if isinstance(each, Form))

    @property
    def name(self) -> str:
        """What messages call the form."""
        return self.title or type(self).__name__.lower()

    @cached_property
    def depth(self) -> int:
        """How deep the tree goes below this form, itself counted."""
        return 1 + max((child.depth for child in self.children()), default=0)

    @cached_property
    def is_opaque(self) -> bool:
        """Whether values come of a function that only NumPy can ask: tapes hold samples of it."""
        return any(child.is_opaque for child in self.children())

    def __repr__(self) -> str:
        return self.spelled()


def number_spelled(value: Any) -> str:
    """A number, or a tuple of them, in its shortest exact spelling."""
    if isinstance(value, tuple):
        return "(" + ", ".join(map(number_spelled, value)) + ("," if len(value) == 1 else "") + ")"
    if type(value) is float:
        return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    return repr(value)
