"""`Field`: a signed distance field, negative inside, as users hold it."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.shapes.field import evaluate
from isophote.shapes.field.combine import Difference, Intersection, Union
from isophote.shapes.field.form import Box, Exactness, Form
from isophote.shapes.field.place import Translate
from isophote.shapes.field.solids import BoxForm, Cylinder, Sphere

__all__ = ["Field", "box", "cylinder", "sphere", "union"]

Floats: TypeAlias = npt.NDArray[np.float64]


@attrs.frozen(repr=False)
class Field:
    """A signed distance field; operators and methods return new ones."""

    form: Form

    def __call__(self, points: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """(n,) float32 values at points (n, 3): negative inside."""
        return evaluate.values(self.form, points)

    @property
    def bounds(self) -> Box:
        """(2, 3): a box that holds all points where the field is not positive."""
        return self.form.bounds

    @property
    def exactness(self) -> Exactness:
        """How far the values can be trusted."""
        return self.form.exactness

    def __or__(self, other: Field) -> Field:
        return self.union(other)

    def __and__(self, other: Field) -> Field:
        return self.intersection(other)

    def __sub__(self, other: Field) -> Field:
        return self.difference(other)

    def union(self, *others: Field, blend: float = 0.0) -> Field:
        """What is inside any of these."""
        return Field(Union((self.form, *(o.form for o in others)), blend))

    def intersection(self, *others: Field, blend: float = 0.0) -> Field:
        """What is inside all of these."""
        return Field(Intersection((self.form, *(o.form for o in others)), blend))

    def difference(self, *others: Field, blend: float = 0.0) -> Field:
        """What is inside this one and outside the others."""
        return Field(Difference((self.form, *(o.form for o in others)), blend))

    def translate(self, offset: npt.ArrayLike) -> Field:
        """The field moved by `offset`."""
        return Field(Translate(self.form, offset))  # type: ignore[arg-type]

    def __repr__(self) -> str:
        return self.form.spelled()


def sphere(radius: float) -> Field:
    """A ball about the origin."""
    return Field(Sphere(radius))


def box(size: float | tuple[float, float, float]) -> Field:
    """A box about the origin, with full edge lengths `size`."""
    return Field(BoxForm(size))  # type: ignore[arg-type]


def cylinder(radius: float, height: float | None = None) -> Field:
    """A cylinder along y, endless without a height."""
    return Field(Cylinder(radius, height))


def union(first: Field, *others: Field, blend: float = 0.0) -> Field:
    """What is inside any of these."""
    return first.union(*others, blend=blend)
