"""Textures that move a surface."""

from __future__ import annotations

from typing import Any

import attrs

from isophote.errors import SceneError
from isophote.scene.fields import as_number, finite, instance_of, optional, positive
from isophote.scene.texture import Texture

__all__ = ["MOST_TRIANGLES", "Displacement"]

# Of a mesh that was cut, unless more are wanted.
MOST_TRIANGLES = 4_000_000


def _optional_number(value: Any) -> Any:
    return value if value is None else as_number(value)


def _count(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise SceneError(f"Displacement: {attribute.name} must be a whole number above 0, but is {value!r}")


@attrs.frozen
class Displacement:
    """A mesh whose surface is moved along its normals: P + `scale` (h − `midlevel`) n, h the texture's red channel.

    The mesh is cut into triangles whose edges are `edge` long at most, in the mesh's own units as `scale` is, or, where
    that is not given, `pixels` of the picture: 2 make about one triangle a pixel. Out of the picture they are four
    times as long. More than `most` triangles are refused, with what memory they would take. n is the mesh's normal,
    blended, and one for all corners at a place, so that closed meshes stay closed across seams of texture coordinates.

    Source: Cook, Carpenter, Catmull, "The Reyes image rendering architecture", SIGGRAPH 1987.
    """

    texture: Texture = attrs.field(validator=instance_of("a Texture", Texture))
    scale: float = attrs.field(default=1.0, converter=as_number, validator=finite)
    midlevel: float = attrs.field(default=0.0, converter=as_number, validator=finite)
    edge: float | None = attrs.field(default=None, converter=_optional_number, validator=optional(positive))
    pixels: float = attrs.field(default=2.0, converter=as_number, validator=positive)
    most: int = attrs.field(default=MOST_TRIANGLES, validator=_count)

    @property
    def reach(self) -> float:
        """How far the surface moves at most where the texture is from 0 to 1."""
        return abs(self.scale) * max(abs(self.midlevel), abs(1 - self.midlevel))
