"""What fields in the plane and in space have in common: evaluation, and operations that give new ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any, ClassVar, Self, TypeAlias, TypeVar

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field import evaluate
from isophote.shapes.field.alter import Elongate, Finished, Offset, Shell
from isophote.shapes.field.combine import Difference, Intersection, Union, combined
from isophote.shapes.field.deform import Displace
from isophote.shapes.field.form import Box, Exactness, Form
from isophote.shapes.field.intervals import tight_bounds
from isophote.shapes.field.place import Affine, Mirror, Scale, Translate
from isophote.shapes.field.repeat import Repeat
from isophote.shapes.field.tape import written

__all__ = ["Operations", "difference", "intersection", "union"]

Floats: TypeAlias = npt.NDArray[np.float64]

# Trees are walked by recursion, which Python bounds.
_DEEPEST = 200


@attrs.frozen(repr=False, slots=False)
class Operations:
    """A signed distance field; operators and methods return new ones."""

    form: Form = attrs.field()
    dimension: ClassVar[int]

    @form.validator
    def _check(self, attribute: attrs.Attribute[Form], form: Form) -> None:
        if not isinstance(form, Form):
            raise GeometryError(
                f"{type(self).__name__}: form must be a form, but is {form!r}; iso.sphere(1) is a field"
            )
        if form.depth > _DEEPEST:
            raise GeometryError(
                f"{type(self).__name__}: operations are nested {form.depth} deep, and {_DEEPEST} is the most; "
                "combine many parts at once, as iso.union(*parts, blend=0.1) does"
            )

    def __call__(self, points: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """(n,) float32 values at points (n, dimension): negative inside."""
        return evaluate.values(self.form, points)

    def gradient(self, points: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """(n, dimension) float32 derivatives of the value at points (n, dimension); outwards on the surface.

        Exact derivatives of the expression. On edges and medial axes, where there is none, that of one side.
        """
        return evaluate.gradients(self.form, points)

    @cached_property
    def bounds(self) -> Box:
        """(2, dimension): least and greatest corner of a box that is proven to hold all points that are not outside.

        Infinite where the field is endless; of no size where it is empty. Read-only.
        """
        box = np.array(tight_bounds(self.form))
        box.flags.writeable = False
        return box

    @property
    def exactness(self) -> Exactness:
        """How far the values can be trusted."""
        exactness = self.form.exactness
        return exactness if exactness is Exactness.EXACT or math.isfinite(self.lipschitz) else Exactness.SIGN

    @cached_property
    def lipschitz(self) -> float:
        """A proven Lipschitz constant of the values within the bounds; infinite where none is known."""
        graph, result = written(self.form, self.bounds)
        return graph.lipschitz()[result]

    def _with(self, form: Form) -> Self:
        return type(self)(form)

    def _combined(self, kind: Any, others: Sequence[Any], edges: dict[str, float]) -> Self:
        for other in others:
            if not isinstance(other, Operations):
                raise GeometryError(f"{kind.title}: it takes fields, but was given {other!r}")
        return self._with(combined(kind, (self.form, *(other.form for other in others)), **edges))

    def __or__(self, other: Self) -> Self:
        return self.union(other) if isinstance(other, Operations) else NotImplemented

    def __and__(self, other: Self) -> Self:
        return self.intersection(other) if isinstance(other, Operations) else NotImplemented

    def __sub__(self, other: Self) -> Self:
        return self.difference(other) if isinstance(other, Operations) else NotImplemented

    def union(self, *others: Self, blend: float = 0.0, round: float = 0.0, chamfer: float = 0.0) -> Self:
        """What is inside any of these.

        One of `blend`, `round` and `chamfer` fills the edges where parts meet: smoothly within `blend`, with a fillet
        of radius `round`, or with a flat that begins `chamfer` away.
        """
        return self._combined(Union, others, {"blend": blend, "round": round, "chamfer": chamfer})

    def intersection(self, *others: Self, blend: float = 0.0, round: float = 0.0, chamfer: float = 0.0) -> Self:
        """What is inside all of these; `blend`, `round` and `chamfer` take the edges off, as in `union`."""
        return self._combined(Intersection, others, {"blend": blend, "round": round, "chamfer": chamfer})

    def difference(self, *others: Self, blend: float = 0.0, round: float = 0.0, chamfer: float = 0.0) -> Self:
        """What is inside this one and outside the others; `blend`, `round` and `chamfer` take the edges off."""
        return self._combined(Difference, others, {"blend": blend, "round": round, "chamfer": chamfer})

    def offset(self, distance: float) -> Self:
        """The surface moved outwards by `distance`, which rounds convex edges; inwards where it is negative."""
        return self._with(Offset(self.form, distance))

    def shell(self, thickness: float) -> Self:
        """Only the surface, `thickness` thick, half of it on either side."""
        return self._with(Shell(self.form, thickness))

    def round(self, radius: float) -> Self:
        """The same size, with convex edges rounded: those of primitives and those where intersections cut."""
        return self._with(Finished(self.form, radius, "round"))

    def chamfer(self, leg: float) -> Self:
        """The same size, with convex edges cut off by flats that begin at `leg` from the edge."""
        return self._with(Finished(self.form, leg, "chamfer"))

    def elongate(self, length: Any) -> Self:
        """Cut through the origin across each axis and pulled apart by `length`, a number for each axis."""
        return self._with(Elongate(self.form, length))

    def translate(self, offset: Any) -> Self:
        """Moved by `offset`."""
        return self._with(Translate(self.form, offset))

    def scale(self, factor: Any) -> Self:
        """Scaled about the origin by a factor above 0, or by one for each axis, which makes distances bounds."""
        return self._with(Scale(self.form, factor))

    def mirror(self, axis: Any) -> Self:
        """Mirrored in the plane (the line, in 2D) through the origin across `axis`, a letter or a vector."""
        return self._with(Mirror(self.form, axis))

    def affine(self, matrix: npt.ArrayLike) -> Self:
        """Under an affine map: `matrix` is (4, 4), (3, 3) in the plane, for column vectors, its last row 0, …, 0, 1.

        Exact where all directions are scaled alike, otherwise a bound.
        """
        return self._with(Affine(self.form, matrix))

    def repeat(self, spacing: Any, count: Any = None) -> Self:
        """Copies `spacing` apart along each axis, where it is above 0: endlessly many, or `count`, about the place.

        `spacing` has a number for each axis. `count` is one for each axis, None among them for endless, or one for all
        along which there is a spacing. Copies may overlap; neighbours of a point's cell are looked at, so that a
        distance stays one where copies are apart. Raises `GeometryError` for fields that are endless along the row.
        """
        if isinstance(count, int | np.integer) and np.ndim(spacing) == 1:
            count = tuple(count if step != 0 else 1 for step in spacing)
        return self._with(Repeat(self.form, spacing, count))

    def displace(self, by: Operations, amplitude: float) -> Self:
        """The surface moved outwards by `amplitude` times the value of another field, which is held within ±1."""
        if not isinstance(by, Operations):
            raise GeometryError(f"displace: it takes a field, such as iso.waves(0.3), but was given {by!r}")
        return self._with(Displace(self.form, by.form, amplitude))

    def __repr__(self) -> str:
        return self.form.spelled()


AnyField = TypeVar("AnyField", bound=Operations)


def _first(name: str, parts: tuple[AnyField, ...]) -> AnyField:
    if not parts:
        raise GeometryError(f"{name}: it has no parts; give one field or more")
    if not isinstance(parts[0], Operations):
        raise GeometryError(f"{name}: it takes fields, one by one, but was given {parts[0]!r}; write {name}(*parts)")
    return parts[0]


def union(*parts: AnyField, blend: float = 0.0, round: float = 0.0, chamfer: float = 0.0) -> AnyField:
    """What is inside any of the parts, with edges as in the method `union`."""
    return _first("union", parts).union(*parts[1:], blend=blend, round=round, chamfer=chamfer)


def intersection(*parts: AnyField, blend: float = 0.0, round: float = 0.0, chamfer: float = 0.0) -> AnyField:
    """What is inside all of the parts, with edges as in the method `union`."""
    return _first("intersection", parts).intersection(*parts[1:], blend=blend, round=round, chamfer=chamfer)


def difference(*parts: AnyField, blend: float = 0.0, round: float = 0.0, chamfer: float = 0.0) -> AnyField:
    """What is inside the first part and outside all others, with edges as in the method `union`."""
    return _first("difference", parts).difference(*parts[1:], blend=blend, round=round, chamfer=chamfer)
