"""Spots: lights that shine from one point into a cone."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.colour import WHITE, Colour
from isophote.scene.colour import colour as as_colour
from isophote.scene.fields import (
    Vector,
    VectorLike,
    as_number,
    as_optional_number,
    as_vector,
    finite,
    non_negative,
    optional,
    vector,
)

__all__ = ["SpotLight"]

_WHOLE_CONE = 180.0


def _cone(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    finite(instance, attribute, value)
    if not 0 < value <= _WHOLE_CONE:
        raise SceneError(
            f"SpotLight: {attribute.name} is the cone's full angle, above 0 and at most 180 degrees, not {value!r}; "
            "a PointLight shines to all sides"
        )


@cache
def _gauss_legendre() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Places and weights of Gauss's quadrature from −1 to 1."""
    places, weights = np.polynomial.legendre.leggauss(64)
    return places, weights


@attrs.frozen
class SpotLight:
    """Shines from one point into a cone around the line to `target`, or straight down without one.

    `cone_degrees`, at most 180, is the full angle of the cone outside which nothing shines. The edge is hard unless
    `inner_degrees`, the full angle of an inner cone, is smaller: between the two light falls smoothly. Within the cones
    it falls with the angle θ from the axis by the power m, the `exponent`:

        I(θ) = I₀ cosᵐθ s(u),  u = (cosθ − cos outer) / (cos inner − cos outer), cut to 0 … 1,  s(u) = 3u² − 2u³,

    with half the angles given as "inner" and "outer". `power` is the emitted flux in W, from which I₀ follows: a
    narrower cone is brighter. `SpotLight.of_intensity` takes I₀ instead. Source of the smooth edge: Pharr, Jakob,
    Humphreys, "Physically Based Rendering", 4th edition, section 12.2.1.
    """

    position: Vector = attrs.field(converter=as_vector, validator=vector)
    power: float = attrs.field(default=1.0, converter=as_number, validator=non_negative)
    colour: Colour = attrs.field(default=WHITE, converter=as_colour)
    target: Vector | None = attrs.field(default=None, converter=attrs.converters.optional(as_vector))
    cone_degrees: float = attrs.field(default=45.0, converter=as_number, validator=_cone)
    inner_degrees: float | None = attrs.field(
        default=None, converter=as_optional_number, validator=optional(non_negative)
    )
    exponent: float = attrs.field(default=0.0, converter=as_number, validator=non_negative)

    def __attrs_post_init__(self) -> None:
        if self.inner_degrees is not None and self.inner_degrees > self.cone_degrees:
            raise SceneError(
                f"SpotLight: inner_degrees, {self.inner_degrees:g}, must not be above cone_degrees, "
                f"{self.cone_degrees:g}"
            )
        if self.target is not None:
            vector(self, attrs.fields(SpotLight).target, self.target)
            if self.target == self.position:
                raise SceneError(f"SpotLight: target must not be the position itself, {self.position}")

    @classmethod
    def of_intensity(cls, position: VectorLike, intensity: float, **rest: Any) -> SpotLight:
        """The spot with a radiant intensity of `intensity` W/sr on its axis; `rest` as for `SpotLight`."""
        if "power" in rest:
            raise SceneError("SpotLight: give power or intensity, not both")
        unit = cls(position, 1.0, **rest)
        return attrs.evolve(unit, power=intensity * unit._solid_angle)

    @property
    def unit_axis(self) -> Vector:
        """Direction of length 1 into which the spot shines."""
        if self.target is None:
            return 0.0, -1.0, 0.0
        x, y, z = (b - a for a, b in zip(self.position, self.target, strict=True))
        length = math.hypot(x, y, z)
        return x / length, y / length, z / length

    @property
    def cosines(self) -> tuple[float, float]:
        """Cosines of half the inner and half the outer cone's angle; equal where the edge is hard."""
        outer = math.cos(math.radians(self.cone_degrees / 2))
        if self.inner_degrees is None:
            return outer, outer
        return math.cos(math.radians(self.inner_degrees / 2)), outer

    @property
    def intensity(self) -> float:
        """Radiant intensity in W/sr on the axis, to be multiplied by the colour."""
        return self.power / self._solid_angle

    @property
    def intensity_rgb(self) -> Colour:
        """Radiant intensity in W/sr on the axis, by channels."""
        intensity = self.intensity
        r, g, b = (channel * intensity for channel in self.colour)
        return r, g, b

    @property
    def _solid_angle(self) -> float:
        """2π ∫ I(θ) / I₀ d cosθ: the inner cone in closed form, its edge by quadrature."""
        inner, outer = self.cosines
        m = self.exponent + 1
        # 1 − cosᵐ without cancelling, for narrow cones.
        whole = -math.expm1(m * math.log(inner)) / m if inner > 0 else 1 / m
        nodes, weights = _gauss_legendre()
        u = (nodes + 1) / 2
        edge = (outer + (inner - outer) * u) ** self.exponent * u * u * (3 - 2 * u)
        return 2 * math.pi * (whole + (inner - outer) / 2 * float(weights @ edge))
