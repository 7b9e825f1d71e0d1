"""What all materials share: their type, and the parameters that a number, a colour or a picture can give."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import attrs

from isophote.errors import SceneError
from isophote.scene.colour import Colour, ColourLike
from isophote.scene.colour import colour as as_colour
from isophote.scene.texture import Texture

__all__ = [
    "ColourParameter",
    "Material",
    "NumberParameter",
    "albedo",
    "colour_or_texture",
    "number_or_texture",
    "parts_of",
    "roughness",
    "roughness_pair",
    "textures_of",
]

ColourParameter: TypeAlias = Colour | Texture
NumberParameter: TypeAlias = float | Texture


class Material:
    """What a surface does with light: the type of all materials, which are frozen values."""

    __slots__ = ()


def parts_of(material: Material) -> list[Material]:
    """A material and all those inside it."""
    found = [material]
    for field in attrs.fields(type(material)):  # type: ignore[arg-type]
        value = getattr(material, field.name)
        if isinstance(value, Material):
            found += parts_of(value)
    return found


def textures_of(material: Material) -> list[Texture]:
    """All textures that a material uses, those of materials inside it included."""
    found: list[Texture] = []
    for field in attrs.fields(type(material)):  # type: ignore[arg-type]
        value = getattr(material, field.name)
        for part in value if isinstance(value, tuple) else (value,):
            if isinstance(part, Texture):
                found.append(part)
            elif isinstance(part, Material):
                found += textures_of(part)
    return found


def colour_or_texture(value: ColourLike | Texture) -> ColourParameter:
    """A texture as it is, anything else as a colour."""
    return value if isinstance(value, Texture) else as_colour(value)


def number_or_texture(value: float | Texture) -> NumberParameter:
    """A texture as it is, anything else as a float."""
    if isinstance(value, Texture | str | bytes):
        return value
    try:
        return float(value)
    except (TypeError, ValueError):
        return value


def roughness_pair(value: Any) -> tuple[NumberParameter, NumberParameter]:
    """Roughness along and across: two numbers or textures, or one for both."""
    if isinstance(value, tuple | list) and len(value) == 2:
        return number_or_texture(value[0]), number_or_texture(value[1])
    one = number_or_texture(value)
    return one, one


def albedo(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A colour whose channels are 1 or less, or a texture, which is taken as it is."""
    if isinstance(value, tuple) and max(value) > 1:
        raise SceneError(
            f"{type(instance).__name__}: {attribute.name} is the reflected part of the light, from 0 to 1 in each "
            f"channel, but is {value!r}; use an Emitter for what shines"
        )


def _is_fraction(value: Any) -> bool:
    if isinstance(value, Texture):
        return True
    return isinstance(value, float) and math.isfinite(value) and 0 <= value <= 1


def roughness(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A number from 0 to 1 or a texture; or a pair of them, where it was made one."""
    parts = value if isinstance(value, tuple) else (value,)
    if not all(_is_fraction(part) for part in parts):
        shown = value[0] if isinstance(value, tuple) and value[0] == value[1] else value
        raise SceneError(
            f"{type(instance).__name__}: {attribute.name} must be a number from 0 to 1 or a Texture"
            f"{', or two of them (along, across)' if isinstance(value, tuple) else ''}, but is {shown!r}"
        )
