"""What all textures that are formulas share: the space that they lie in, and where they stand there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, TypeAlias

import attrs

from isophote.errors import SceneError
from isophote.scene.colour import Colour, ColourLike
from isophote.scene.colour import colour as as_colour
from isophote.scene.fields import instance_of, one_of
from isophote.scene.texture import Texture
from isophote.scene.transform import Transform, unit_vector

__all__ = ["Composed", "Procedural", "Stops", "StopsLike", "axis_vector", "seed_number", "stops", "texture_or_none"]

Stops: TypeAlias = tuple[tuple[float, Colour], ...]
StopsLike: TypeAlias = Iterable[ColourLike | tuple[float, ColourLike]]

_MOST_SEEDS = 2**32


@attrs.frozen(kw_only=True, repr=False)
class Procedural(Texture):
    """A texture that is a formula of the place.

    `space` says which place: "own", the default, the space in which the item's shape is described, so that the pattern
    goes with the item as if it were carved from a block (Perlin, "An Image Synthesizer", SIGGRAPH 1985); "uv", texture
    coordinates (u, v, 0); "world", that of the scene. `transform` places the pattern there, as an item's places a
    shape: `Transform.identity().scale(0.1)` makes it ten times smaller.
    """

    space: str = attrs.field(default="own", validator=one_of("own", "uv", "world"))
    transform: Transform = attrs.field(factory=Transform.identity, validator=instance_of("a Transform", Transform))

    def with_(self, **changes: Any) -> Any:
        """The texture with other fields."""
        return attrs.evolve(self, **changes)

    def __repr__(self) -> str:
        told = [f"{a.name}={getattr(self, a.name)!r}" for a in attrs.fields(type(self)) if not _is_default(self, a)]
        return f"{type(self).__name__}({', '.join(told)})"


def _is_default(instance: Procedural, attribute: attrs.Attribute[Any]) -> bool:
    default: Any = attribute.default
    if default is attrs.NOTHING:
        return False
    value = default.factory() if isinstance(default, attrs.Factory) else default  # type: ignore[arg-type]
    if attribute.converter is not None:
        value = attribute.converter(value)  # type: ignore[operator]
    return bool(getattr(instance, attribute.name) == value)


class Composed(Procedural, ABC):
    """A texture that is made of simpler ones."""

    __slots__ = ()

    @abstractmethod
    def composed(self) -> Texture:
        """The simpler textures that it is, in its own space: a start for variations."""


def stops(value: StopsLike) -> Stops:
    """Pairs (position, colour) of a colour ramp; colours alone are spread evenly from 0 to 1.

    Raises `SceneError` unless there is one or more, and positions ascend.
    """
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):
        raise SceneError(f"stops must be a list of colours or of pairs (position, colour), but are {value!r}")
    given = list(value)
    if not given:
        raise SceneError("stops must be one colour or more, but there are none")
    paired = [isinstance(stop, tuple | list) and len(stop) == 2 for stop in given]
    if not any(paired):
        last = max(len(given) - 1, 1)
        return tuple((k / last, as_colour(stop)) for k, stop in enumerate(given))  # type: ignore[arg-type]
    if not all(paired):
        raise SceneError(f"stops must be all colours or all pairs (position, colour), but are {given!r}")
    found = tuple((_position(stop[0]), as_colour(stop[1])) for stop in given)  # type: ignore[index]
    places = [position for position, _ in found]
    if places != sorted(places):
        raise SceneError(f"the positions of stops must ascend, but are {places}")
    return found


def _position(value: Any) -> float:
    try:
        position = float(value)
    except (TypeError, ValueError):
        position = float("nan")
    if not abs(position) < 1e30:
        raise SceneError(f"the position of a stop must be a finite number, but is {value!r}")
    return position


def seed_number(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A whole number from 0, below 2³²."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < _MOST_SEEDS:
        raise SceneError(
            f"{type(instance).__name__}: {attribute.name} must be a whole number from 0 to 2³² − 1, but is {value!r}"
        )


def texture_or_none(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A texture, or None."""
    if value is not None and not isinstance(value, Texture):
        raise SceneError(f"{type(instance).__name__}: {attribute.name} must be a Texture or None, but is {value!r}")


def axis_vector(value: Any) -> tuple[float, float, float]:
    """The unit vector of "x", "y", "z" or a direction."""
    x, y, z = unit_vector(value, "axis").tolist()
    return x, y, z
