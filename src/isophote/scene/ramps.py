"""Textures made of others: colour ramps, mixtures, and textures that are placed elsewhere."""

from __future__ import annotations

from typing import Any

import attrs

from isophote.errors import SceneError
from isophote.scene.colour import WHITE
from isophote.scene.fields import instance_of, one_of
from isophote.scene.material_base import ColourParameter, colour_or_texture
from isophote.scene.procedural import Procedural, Stops, stops
from isophote.scene.texture import Texture

__all__ = ["Blend", "Placed", "Ramp"]

_BLACK, _GREY = (0.0, 0.0, 0.0), (0.5, 0.5, 0.5)
_texture = instance_of("a Texture", Texture)


@attrs.frozen
class Ramp(Texture):
    """A colour for every number: that of `stops` at the red channel of `texture`.

    `stops` are colours, spread evenly over 0 to 1, or pairs (position, colour) with ascending positions; numbers are
    greys. Between them lies a straight line ("linear"), one that is flat at the stops ("smooth"), or the colour of the
    stop before ("constant"). What is beyond the first or last has its colour.

    Where a texture is seen from afar, the ramp has the colour of the mean, which need not be the mean colour.
    """

    texture: Texture = attrs.field(validator=_texture)
    stops: Stops = attrs.field(default=("black", "white"), converter=stops)
    between: str = attrs.field(default="linear", validator=one_of("linear", "smooth", "constant"))


def _share(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    if isinstance(value, tuple) and max(value) > 1:
        raise SceneError(f"Blend: amount must be a number from 0 to 1 or a texture, but is {value[0]!r}")


@attrs.frozen
class Blend(Texture):
    """a (1 − t) + b t, where t is the red channel of `amount`, from 0 to 1; all three colours, numbers or textures."""

    a: ColourParameter = attrs.field(default=_BLACK, converter=colour_or_texture)
    b: ColourParameter = attrs.field(default=WHITE, converter=colour_or_texture)
    amount: ColourParameter = attrs.field(default=_GREY, converter=colour_or_texture, validator=_share)


@attrs.frozen(repr=False)
class Placed(Procedural):
    """A texture of any kind, pictures too, moved to another place: in the space of another by `transform`.

    `space` is "own", the space in which the item's shape is described, so that a pattern goes with the item as if
    carved from a block; "uv", texture coordinates (u, v, 0); or "world". `transform` places the pattern there, as an
    item's places a shape. All formulas of the place (`Checker`, `Marble`, ...) have both themselves.

    Below it, both the shape's own space and texture coordinates (x, y) are those of the moved space. So
    `Placed(picture, space="own")` projects a picture along z onto a shape, and
    `Placed(picture, space="uv", transform=Transform.identity().scale(0.1))` repeats it ten times along u and v.
    """

    texture: Texture = attrs.field(validator=_texture)
