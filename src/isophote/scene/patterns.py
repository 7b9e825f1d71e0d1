"""Patterns that are told by a few numbers: checkers, stripes, grids, waves and gradients."""

from __future__ import annotations

from typing import Any

import attrs

from isophote.errors import SceneError
from isophote.scene.colour import WHITE
from isophote.scene.fields import Vector, as_number, finite, fraction, one_of, positive
from isophote.scene.material_base import ColourParameter, colour_or_texture
from isophote.scene.procedural import (
    Composed,
    Procedural,
    Stops,
    axis_vector,
    stops,
    texture_or_none,
)
from isophote.scene.ramps import Blend, Ramp
from isophote.scene.texture import Texture

__all__ = ["Checker", "CheckerNumber", "Coordinate", "Gradient", "Grid", "GridNumber", "Stripes", "Waves"]

_BLACK = (0.0, 0.0, 0.0)
_X, _Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
_SHAPES = ("linear", "radial", "spherical", "angular")


@attrs.frozen(repr=False)
class CheckerNumber(Procedural):
    """0 and 1 in cubes of edge `size` by turns."""

    size: float = attrs.field(default=1.0, converter=as_number, validator=positive)


@attrs.frozen(repr=False)
class Checker(Composed):
    """Cubes of edge `size`, in metres, of `a` and `b` by turns, `a` at the origin: squares on flat ground.

    `a` and `b` are colours, numbers or textures. What a pixel sees of both is their exact mix, for footprints along the
    axes. Borders lie 1/1024 of `size` below whole multiples of it, so that faces of solids that lie there have one
    colour.
    """

    a: ColourParameter = attrs.field(default=WHITE, converter=colour_or_texture)
    b: ColourParameter = attrs.field(default=_BLACK, converter=colour_or_texture)
    size: float = attrs.field(default=1.0, converter=as_number, validator=positive)

    def composed(self) -> Texture:
        """`Blend` of both by a number that is 0 or 1."""
        return Blend(self.a, self.b, CheckerNumber(self.size))


@attrs.frozen(repr=False)
class Waves(Procedural):
    """A number from 0 to 1 that goes up and down with a period of `size` metres.

    `shape` says along what: "linear", along `axis`; "radial", away from the axis; "spherical", away from the origin; or
    "angular", around the axis, `size` in turns. `profile`: "sine", "saw" (from 0 up to 1, then anew), "triangle" or
    "square" (1 over the first `share` of a period, then 0). `distortion`, a texture, moves the waves by up to `amount`
    periods: by amount (2 t − 1) where its red channel is t. Profiles are averaged exactly over what a pixel sees, as
    far as the coordinate is straight there.
    """

    shape: str = attrs.field(default="linear", validator=one_of(*_SHAPES))
    profile: str = attrs.field(default="sine", validator=one_of("sine", "saw", "triangle", "square"))
    size: float = attrs.field(default=1.0, converter=as_number, validator=positive)
    axis: Vector = attrs.field(default=_X, converter=axis_vector)
    distortion: Texture | None = attrs.field(default=None, validator=texture_or_none)
    amount: float = attrs.field(default=1.0, converter=as_number, validator=finite)
    share: float = attrs.field(default=0.5, converter=as_number, validator=fraction)


@attrs.frozen(repr=False)
class Stripes(Composed):
    """Stripes of `a` and `b`, colours, numbers or textures, across `axis`; each pair is `size` metres wide, and `a` has
    the first `share` of it."""

    a: ColourParameter = attrs.field(default=WHITE, converter=colour_or_texture)
    b: ColourParameter = attrs.field(default=_BLACK, converter=colour_or_texture)
    size: float = attrs.field(default=1.0, converter=as_number, validator=positive)
    axis: Vector = attrs.field(default=_X, converter=axis_vector)
    share: float = attrs.field(default=0.5, converter=as_number, validator=fraction)

    def composed(self) -> Texture:
        """`Blend` of both by square `Waves`."""
        return Blend(self.b, self.a, Waves("linear", "square", self.size, self.axis, share=self.share))


def _axes(instance: Any, attribute: attrs.Attribute[str], value: Any) -> None:
    if not isinstance(value, str) or not value or len(set(value)) < len(value) or not set(value) <= set("xyz"):
        raise SceneError(f"{type(instance).__name__}: axes must be some of the letters 'xyz', but is {value!r}")


@attrs.frozen(repr=False)
class GridNumber(Procedural):
    """1 on the lines of a grid, 0 between."""

    size: float = attrs.field(default=1.0, converter=as_number, validator=positive)
    width: float = attrs.field(default=0.05, converter=as_number, validator=fraction)
    axes: str = attrs.field(default="xz", validator=_axes)


@attrs.frozen(repr=False)
class Grid(Composed):
    """Lines of colour `lines` on `ground`, around all places where a coordinate is a multiple of `size`.

    `width` is that of a line, in parts of `size`; `axes` are the coordinates that count: "xz", the default, rules the
    ground, "xy" texture coordinates. What a pixel sees is averaged exactly, for footprints along the axes.
    """

    lines: ColourParameter = attrs.field(default=_BLACK, converter=colour_or_texture)
    ground: ColourParameter = attrs.field(default=WHITE, converter=colour_or_texture)
    size: float = attrs.field(default=1.0, converter=as_number, validator=positive)
    width: float = attrs.field(default=0.05, converter=as_number, validator=fraction)
    axes: str = attrs.field(default="xz", validator=_axes)

    def composed(self) -> Texture:
        """`Blend` of both by a number that is 0 or 1."""
        return Blend(self.ground, self.lines, GridNumber(self.size, self.width, self.axes))


@attrs.frozen(repr=False)
class Coordinate(Procedural):
    """How far it is along an axis, away from it or from the origin, in sizes, or around the axis, in turns."""

    shape: str = attrs.field(default="linear", validator=one_of(*_SHAPES))
    size: float = attrs.field(default=1.0, converter=as_number, validator=positive)
    axis: Vector = attrs.field(default=_Y, converter=axis_vector)


@attrs.frozen(repr=False)
class Gradient(Composed):
    """Colours along a line: those of `stops`, as of a `Ramp`, from the origin to `size` metres along `axis`.

    `shape` "linear"; "radial", away from the axis; "spherical", away from the origin; or "angular", around the axis,
    right-handed, `size` then in turns.
    """

    stops: Stops = attrs.field(default=("black", "white"), converter=stops)
    shape: str = attrs.field(default="linear", validator=one_of(*_SHAPES))
    axis: Vector = attrs.field(default=_Y, converter=axis_vector)
    size: float = attrs.field(default=1.0, converter=as_number, validator=positive)
    between: str = attrs.field(default="linear", validator=one_of("linear", "smooth", "constant"))

    def composed(self) -> Texture:
        """`Ramp` over a coordinate."""
        return Ramp(Coordinate(self.shape, self.size, self.axis), self.stops, self.between)
