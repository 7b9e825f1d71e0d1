"""`Field2`: a signed distance field in the plane, negative inside, as users hold it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from typing import ClassVar, Self

import attrs
import numpy.typing as npt

from isophote.shapes.field.field import Field
from isophote.shapes.field.flat import Arc, Circle, Polygon, Rectangle, Segment, Star
from isophote.shapes.field.image import picture_of
from isophote.shapes.field.lift import Extrude, Revolve
from isophote.shapes.field.operations import Operations
from isophote.shapes.field.place import Turn
from isophote.shapes.field.ring import RepeatAround
from isophote.shapes.field.sweep import Sweep, sampled_path
from isophote.shapes.field.text import Text

__all__ = ["Field2", "arc", "circle", "image", "polygon", "rectangle", "rounded_rectangle", "segment", "star", "text"]

PointLike = tuple[float, float]


@attrs.frozen(repr=False, slots=False)
class Field2(Operations):
    """A signed distance field in the plane; operators and methods return new ones."""

    dimension: ClassVar[int] = 2

    def rotate(self, angle: float) -> Self:
        """Turned by `angle` radians about the origin, anticlockwise."""
        return self._with(Turn(self.form, angle))

    def repeat_around(self, count: int) -> Self:
        """`count` copies about the origin, evenly round, the first where this is."""
        return self._with(RepeatAround(self.form, "z", count))

    def extrude(self, height: float) -> Field:
        """The solid that is drawn out along z, by half of `height` both ways; a distance where this one is."""
        return Field(Extrude(self.form, height))

    def revolve(self, offset: float = 0.0) -> Field:
        """The solid of what lies right of x = 0, moved by `offset` along x first, turned about the y axis.

        A distance where this one is and nothing lies left of the axis. Raises `GeometryError` where nothing lies right.
        """
        return Field(Revolve(self.form, offset))

    def sweep(self, path: npt.ArrayLike | Callable[[float], npt.ArrayLike], samples: int = 64) -> Field:
        """The solid of this form moved along a path: points (n, 3), or a function of t from 0 to 1 that gives points.

        A function is sampled at `samples` + 1 even steps. The form stands upright across the path, its x to the right
        of who looks back along it, its y up, and is carried on without twist; bends are mitred, ends are flat, and a
        path that ends where it starts is closed. Values are bounds of the distance, with exact signs.

        Raises `GeometryError` for points that are not finite or follow on themselves, and paths that turn back.
        """
        return Field(Sweep(self.form, sampled_path(path, samples)))


def circle(radius: float) -> Field2:
    """A disk about the origin."""
    return Field2(Circle(radius))


def rectangle(size: float | PointLike) -> Field2:
    """A rectangle about the origin, with full side lengths `size`."""
    return Field2(Rectangle(size))  # type: ignore[arg-type]


def rounded_rectangle(size: float | PointLike, radius: float) -> Field2:
    """A rectangle about the origin, with full side lengths `size` and its corners rounded by `radius`."""
    return Field2(Rectangle(size, radius))  # type: ignore[arg-type]


def polygon(points: npt.ArrayLike) -> Field2:
    """What a closed outline (n, 2) winds round, or a list of such outlines: nonzero winding rule.

    Outlines may cross and touch themselves and each other; a hole is an outline that runs the other way round.
    Raises `GeometryError` for coordinates that are not finite and for outlines that enclose nothing.
    """
    return Field2(Polygon(points))


def star(points: int, radius: float, inner: float) -> Field2:
    """A star about the origin with `points` tips at `radius`, the first along +y, and notches at `inner`."""
    return Field2(Star(points, radius, inner))


def segment(start: PointLike, end: PointLike, radius: float) -> Field2:
    """All within `radius` of the line segment from `start` to `end`."""
    return Field2(Segment(start, end, radius))


def arc(radius: float, thickness: float, start: float = 0.0, end: float = math.tau) -> Field2:
    """A stroke along a circle about the origin from the angle `start` to `end`, anticlockwise from +x, with round ends.

    `thickness` is its full width. Angles are in radians; `end` is above `start` by 2π at most.
    """
    return Field2(Arc(radius, thickness, start, end))


def text(
    string: str,
    font: str | os.PathLike[str] | None = None,
    *,
    size: float = 1.0,
    align: str = "left",
    leading: float = 1.2,
) -> Field2:
    """Text by its true outlines, in any TrueType or OpenType font, kerned; lines are parted by "\\n".

    `font` is a file, the name of an installed font, or None for one that most machines have. `size` is the em: capitals
    are about 0.7 of it tall. The first line stands on y = 0; "left", "centre" or "right" of its lines are at x = 0, as
    `align` says; baselines are `leading` ems apart. Quadratic outlines are kept as they are, cubic ones become
    quadratic within 1e-4 em. Characters are set one by one: there are no ligatures and no scripts that join letters.

    Raises `GeometryError` for text that draws nothing, fonts that are not installed, and characters that the font does
    not have; `FileError` for files that are no fonts.
    """
    return Field2(Text(string, font, size, align, leading))


def image(image: str | os.PathLike[str] | npt.ArrayLike, threshold: float = 0.5, pixel: float = 1.0) -> Field2:
    """What is black in a picture, a file or an array (h, w) with row 0 at the top; its middle is the origin.

    Pixels are squares with sides `pixel`; inside are those darker than `threshold`, from 0 (black) to 1 (white). Files
    count by their luma and are white where transparent; arrays of whole numbers go from 0 to 255; arrays of truth
    values are True inside. The outline is that of the squares, exactly; distances are exact at each half pixel of the
    picture and bilinear between, off by 0.36 `pixel` at most; beyond the picture they are bounds.

    Raises `FileError` for files that cannot be read, `GeometryError` for arrays of other shapes and pictures without
    an inside.
    """
    return Field2(picture_of(image, threshold, pixel))
