"""Materials that hardly are what was meant: told before a picture is made."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import attrs
import numpy as np

from isophote.errors import IsophoteWarning
from isophote.lower.primitive_table import primitive_of
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Principled
from isophote.scene.material_base import Material, albedo, textures_of
from isophote.scene.procedural import Procedural
from isophote.scene.ramps import Placed
from isophote.scene.scene import Item, Scene
from isophote.scene.texture import Texture
from isophote.shapes.mesh import Mesh

__all__ = ["warn_of_oddities"]

_COLOURS = 3


def warn_of_oddities(scene: Scene) -> None:
    """Warn with an `IsophoteWarning` of textures that lie nowhere, since a shape has no texture coordinates, and of
    textures that make surfaces reflect more light than comes, saying what mends that."""
    bare = [_name(scene, number) for number, item in enumerate(scene.items) if _lacks_coordinates(item)]
    if bare:
        _warn(
            f"{_listed(bare)} a texture that lies by texture coordinates, but no such coordinates: give the mesh the "
            'attribute "uv", which iso.unwrap(mesh) makes (of fields, iso.to_mesh first), or use a texture that lies '
            "in space, as iso.Checker does"
        )
    bright = [
        (_name(scene, number), most)
        for number, item in enumerate(scene.items)
        if (most := max(_brightest(item.material), default=0.0)) > 1
    ]
    if bright:
        _warn(
            f"{_listed([name for name, _ in bright])} a texture for the reflected part of the light with values up to "
            f"{max(most for _, most in bright):.3g}, which reflects more light than comes: scale it to 1 at most, or "
            "use an Emitter for what shines"
        )


def _warn(text: str) -> None:
    # At the call of iso.render.
    warnings.warn(text, IsophoteWarning, stacklevel=5)


def _name(scene: Scene, number: int) -> str:
    name = scene.items[number].name
    return f"items[{number}]" if name is None else f"items[{number}], {name!r},"


def _listed(names: list[str]) -> str:
    """The subject of a sentence, with its verb."""
    rest = len(names) - 1
    return f"{names[0]} has" if rest == 0 else f"{names[0]} and {rest} other{'s' if rest > 1 else ''} have"


# --- texture coordinates --------------------------------------------------------------------------


def _lacks_coordinates(item: Item) -> bool:
    """Whether a texture lies by coordinates that the shape has none of; primitives have some."""
    relief = [] if item.displacement is None else [item.displacement.texture]
    if not any(_lies_by_coordinates(texture) for texture in (*textures_of(item.material), *relief)):
        return False
    if isinstance(item.shape, Mesh):
        return item.shape.uvs is None
    return primitive_of(item.shape) is None


def _lies_by_coordinates(texture: Texture) -> bool:
    if isinstance(texture, ImageTexture):
        # One pixel is the same everywhere.
        return texture.size != (1, 1)
    if isinstance(texture, Placed):
        # What lies below it has the coordinates of the space that it is placed in.
        return texture.space == "uv"
    if isinstance(texture, Procedural) and texture.space == "uv":
        return True
    inside = (getattr(texture, field.name) for field in attrs.fields(type(texture)))  # type: ignore[arg-type]
    return any(_lies_by_coordinates(part) for part in inside if isinstance(part, Texture))


# --- energy ---------------------------------------------------------------------------------------


def _brightest(material: Material) -> Iterator[float]:
    """The most of each picture that tells what part of the light is reflected, those of materials inside included."""
    for field in attrs.fields(type(material)):  # type: ignore[arg-type]
        value = getattr(material, field.name)
        if isinstance(value, Material):
            yield from _brightest(value)
        elif isinstance(value, ImageTexture) and value.pixels.dtype != np.uint8:
            if field.validator is albedo:
                yield float(_colours(value).max())
            elif isinstance(material, Principled) and field.name == "colour_texture":
                yield float((_colours(value) * np.array(material.colour)).max())


def _colours(texture: ImageTexture) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """(h, w, 1 or 3): without the channel of opacity."""
    pixels = texture.pixels.reshape(*texture.pixels.shape[:2], -1)
    return pixels[..., :_COLOURS]
