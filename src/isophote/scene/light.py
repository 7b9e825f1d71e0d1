"""Lights: points, suns, rectangles, disks and spheres that shine, and the sky around everything."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, TypeAlias, TypeVar

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.colour import WHITE, Colour, ColourLike
from isophote.scene.colour import colour as as_colour
from isophote.scene.fields import (
    Vector,
    VectorLike,
    as_flag,
    as_number,
    as_optional_number,
    as_pair,
    as_vector,
    finite,
    instance_of,
    non_negative,
    non_zero,
    optional,
    pair,
    positive,
    vector,
)
from isophote.scene.image_texture import ImageTexture
from isophote.scene.spot_light import SpotLight
from isophote.scene.transform import Transform

__all__ = [
    "AreaLight",
    "DiskLight",
    "Environment",
    "Light",
    "PointLight",
    "RectLight",
    "Sky",
    "SphereLight",
    "Sun",
    "direction_to_uv",
    "uv_to_direction",
]

Points: TypeAlias = npt.NDArray[np.float64]
_Placed = TypeVar("_Placed", "RectLight", "DiskLight")

_NEARLY_VERTICAL = 1e-9


def _scaled(tint: Colour, factor: float) -> Colour:
    return tint[0] * factor, tint[1] * factor, tint[2] * factor


@attrs.frozen
class PointLight:
    """Shines from one point evenly to all sides.

    `power` is the emitted flux in W, 0 or above, so the radiant intensity is power / 4π W/sr, times `colour`, from
    `position`, in metres. Raises `SceneError` for other values.
    """

    position: Vector = attrs.field(converter=as_vector, validator=vector)
    power: float = attrs.field(default=1.0, converter=as_number, validator=non_negative)
    colour: Colour = attrs.field(default=WHITE, converter=as_colour)

    @property
    def intensity_rgb(self) -> Colour:
        """Radiant intensity in W/sr, by channels."""
        return _scaled(self.colour, self.power / (4 * math.pi))


@attrs.frozen
class Sun:
    """Shines from infinitely far away, out of one direction.

    `direction` points toward the sun and may have any length; `irradiance`, W/m², is what falls on a surface
    that faces it, times `colour`.
    """

    direction: Vector = attrs.field(converter=as_vector, validator=non_zero)
    irradiance: float = attrs.field(default=1.0, converter=as_number, validator=non_negative)
    colour: Colour = attrs.field(default=WHITE, converter=as_colour)

    @property
    def unit_direction(self) -> Vector:
        """Direction toward the sun, of length 1."""
        largest = max(abs(component) for component in self.direction)
        x, y, z = (component / largest for component in self.direction)
        length = math.sqrt(x * x + y * y + z * z)
        return x / length, y / length, z / length

    @property
    def irradiance_rgb(self) -> Colour:
        """Irradiance in W/m² on a surface that faces the sun, by channels."""
        return _scaled(self.colour, self.irradiance)


def _optional_colour(value: ColourLike | None) -> Colour | None:
    return None if value is None else as_colour(value)


def _rigid(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    instance_of("a Transform", Transform)(instance, attribute, value)
    if not value.is_rigid:
        raise SceneError(
            f"{type(instance).__name__}: transform may only turn and move; give the light its size "
            f"instead of scaling it by {value!r}"
        )


# W/(m² sr).
_BRIGHTEST = 1e37


@attrs.frozen
class AreaLight(ABC):
    """What lights with an area share: `power` or `radiance`, `colour`, and a rigid `transform`.

    `power` is the emitted flux in W, `radiance` (a number or a triple) is in W/(m² sr); give one of them, or
    none for 1 W. Either is multiplied by `colour`. Radiance is the same to all sides: power / (π area), where
    a light that shines on both sides has twice the area.
    """

    power: float | None = attrs.field(
        default=None, kw_only=True, converter=as_optional_number, validator=optional(non_negative)
    )
    radiance: Colour | None = attrs.field(default=None, kw_only=True, converter=_optional_colour)
    colour: Colour = attrs.field(default=WHITE, kw_only=True, converter=as_colour)
    transform: Transform = attrs.field(factory=Transform.identity, kw_only=True, validator=_rigid)

    def __attrs_post_init__(self) -> None:
        if self.power is not None and self.radiance is not None:
            raise SceneError(f"{type(self).__name__}: give power or radiance, not both")
        # What cannot be told in single precision would be dark, or not a number, in pictures.
        if not self.emitting_area > 0 or not max(self.radiance_rgb) <= _BRIGHTEST:
            raise SceneError(
                f"{type(self).__name__}: so much light from an area of {self.emitting_area:.3g} m² is more than single "
                "precision holds; make the light larger or weaker, or use a PointLight"
            )

    @property
    @abstractmethod
    def area(self) -> float:
        """Area in m² of one side."""

    @property
    def emitting_area(self) -> float:
        """Area in m² of all that shines."""
        return self.area

    @property
    def position(self) -> Vector:
        """Centre of the light."""
        x, y, z = self.transform.matrix[:3, 3].tolist()
        return x, y, z

    @property
    def radiance_rgb(self) -> Colour:
        """Radiance in W/(m² sr), by channels."""
        if self.radiance is not None:
            r, g, b = (a * b for a, b in zip(self.radiance, self.colour, strict=True))
            return r, g, b
        power = 1.0 if self.power is None else self.power
        return _scaled(self.colour, power / (math.pi * self.emitting_area))


def _facing(position: VectorLike, target: VectorLike | None) -> Transform:
    """Placement of a light that shines along its −Y: at `position`, toward `target` or straight down."""
    if target is None:
        return Transform.identity().translate(position)
    look = Transform.look_at(position, target, _up_for(position, target)).matrix
    matrix = look.copy()
    # The look frame's axes are right, up, back: the light's x is right, its −Y looks where −back does.
    matrix[:3, 1] = look[:3, 2]
    matrix[:3, 2] = -look[:3, 1]
    return Transform(matrix)


def _up_for(position: VectorLike, target: VectorLike) -> Vector:
    """World up; for a vertical line of sight the direction that keeps the light's x on the world's X."""
    x, y, z = (float(b) - float(a) for a, b in zip(position, target, strict=True))
    if math.hypot(x, z) > _NEARLY_VERTICAL * abs(y):
        return 0.0, 1.0, 0.0
    return 0.0, 0.0, -1.0 if y < 0 else 1.0


def _placed(light: _Placed, position: VectorLike, target: VectorLike | None) -> _Placed:
    return attrs.evolve(light, transform=_facing(position, target))


def _positive_pair(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    pair(instance, attribute, value)
    for length in value:
        positive(instance, attribute, length)


@attrs.frozen
class RectLight(AreaLight):
    """A rectangle that shines, the same to all sides.

    `power` is its flux in W (1 if nothing is given), `radiance`, instead, in W/(m² sr): radiance = power / (π area),
    times `colour`. `transform` places it without changing its size, as `at` does.

    In its own frame it lies in the plane y = 0 around the origin and shines toward −Y, so that it faces
    straight down as it is made; `size` is (width along its x, depth along its z), full lengths. With
    `two_sided` it shines to +Y too.
    """

    size: tuple[float, float] = attrs.field(default=(1.0, 1.0), converter=as_pair, validator=_positive_pair)
    two_sided: bool = attrs.field(default=False, kw_only=True, converter=as_flag)

    @property
    def area(self) -> float:
        """Area in m² of one side: width times depth."""
        return self.size[0] * self.size[1]

    @property
    def emitting_area(self) -> float:
        """Area in m² of the side or sides that shine."""
        return self.area * (2 if self.two_sided else 1)

    def at(self, position: VectorLike, target: VectorLike | None = None) -> RectLight:
        """The light with its centre at `position`, facing `target`, or straight down without one.

        Its x is kept horizontal: to the right for who looks from the light to the target with +Y up; where
        that line is vertical, along the world's X. Replaces the transform.
        """
        return _placed(self, position, target)


@attrs.frozen
class DiskLight(AreaLight):
    """A disk that shines, the same to all sides; `radius` in metres.

    `power` is its flux in W (1 if nothing is given), `radiance`, instead, in W/(m² sr): radiance = power / (π area),
    times `colour`. `transform` places it without changing its size, as `at` does.

    In its own frame it lies in the plane y = 0 around the origin and shines toward −Y, so that it faces
    straight down as it is made. With `two_sided` it shines to +Y too.
    """

    radius: float = attrs.field(default=0.5, converter=as_number, validator=positive)
    two_sided: bool = attrs.field(default=False, kw_only=True, converter=as_flag)

    @property
    def area(self) -> float:
        """Area in m² of one side: π radius²."""
        return math.pi * self.radius**2

    @property
    def emitting_area(self) -> float:
        """Area in m² of the side or sides that shine."""
        return self.area * (2 if self.two_sided else 1)

    def at(self, position: VectorLike, target: VectorLike | None = None) -> DiskLight:
        """The light with its centre at `position`, facing `target`, or straight down without one."""
        return _placed(self, position, target)


@attrs.frozen
class SphereLight(AreaLight):
    """A sphere that shines outward, the same to all sides; `radius` in metres.

    `power` is its flux in W (1 if nothing is given), `radiance`, instead, in W/(m² sr): radiance = power / (π area),
    times `colour`. `transform` places it without changing its size, as `at` does.
    """

    radius: float = attrs.field(default=0.5, converter=as_number, validator=positive)

    @property
    def area(self) -> float:
        """Area in m²: 4π radius²."""
        return 4 * math.pi * self.radius**2

    def at(self, position: VectorLike) -> SphereLight:
        """The light with its centre at `position`."""
        return attrs.evolve(self, transform=Transform.identity().translate(position))


@attrs.frozen
class Sky:
    """The same radiance from everywhere around: `strength` W/(m² sr), 0 or above, times `colour`."""

    colour: Colour = attrs.field(default=WHITE, converter=as_colour)
    strength: float = attrs.field(default=1.0, converter=as_number, validator=non_negative)

    @property
    def radiance_rgb(self) -> Colour:
        """Radiance in W/(m² sr), by channels."""
        return _scaled(self.colour, self.strength)


def _sky_texture(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    instance_of("an ImageTexture", ImageTexture)(instance, attribute, value)
    if value.pixels.min() < 0:
        raise SceneError("Environment: no light is negative, but some pixels are; np.maximum(pixels, 0) mends that")


@attrs.frozen
class Environment:
    """A picture of all that is around, as light: a latitude-longitude map, usually an HDR image.

    A pixel's linear value times `strength` is the radiance in W/(m² sr) out of its direction. The top row is
    +Y (up); unrotated, the middle of the picture is +Z, the middle of its left half +X, of its right half
    −X, and its left and right edges meet at −Z. With longitude λ and latitude φ of a direction (x, y, z) of
    length 1,

        λ = atan2(x, z) − rotation,  φ = asin(y),  u = 1/2 − λ / 2π,  v = 1/2 + φ / π,

    in texture coordinates from the lower left. `rotation` turns the surroundings by so many radians about +Y,
    as `Transform.rotate("y", rotation)` would. Source: OpenEXR, latitude-longitude environment maps.
    """

    texture: ImageTexture = attrs.field(validator=_sky_texture)
    strength: float = attrs.field(default=1.0, converter=as_number, validator=non_negative)
    rotation: float = attrs.field(default=0.0, converter=as_number, validator=finite)


def direction_to_uv(directions: npt.ArrayLike, rotation: float = 0.0) -> Points:
    """Texture coordinates (..., 2), in [0, 1), of directions (..., 3) of any length, as `Environment` has them."""
    x, y, z = np.moveaxis(np.asarray(directions, np.float64), -1, 0)
    u = (0.5 - (np.arctan2(x, z) - rotation) / (2 * np.pi)) % 1.0
    # The remainder of a tiny negative number rounds to 1, which is the same place as 0.
    u = np.where(u == 1.0, 0.0, u)
    v = 0.5 + np.arctan2(y, np.hypot(x, z)) / np.pi
    return np.stack([u, v], axis=-1)


def uv_to_direction(uv: npt.ArrayLike, rotation: float = 0.0) -> Points:
    """Unit directions (..., 3) of texture coordinates (..., 2), as `Environment` has them."""
    u, v = np.moveaxis(np.asarray(uv, np.float64), -1, 0)
    longitude = (0.5 - u) * 2 * np.pi + rotation
    latitude = (v - 0.5) * np.pi
    across = np.cos(latitude)
    return np.stack([across * np.sin(longitude), np.sin(latitude), across * np.cos(longitude)], axis=-1)


Light: TypeAlias = PointLight | SpotLight | Sun | RectLight | DiskLight | SphereLight | Sky | Environment
