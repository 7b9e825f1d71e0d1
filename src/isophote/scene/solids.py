"""Solid textures of things that are known: marble and wood."""

from __future__ import annotations

import attrs

from isophote.scene.colour import Colour
from isophote.scene.colour import colour as as_colour
from isophote.scene.fields import Vector, as_number, finite, fraction, positive
from isophote.scene.noise import Fbm, PerlinNoise, octave_count
from isophote.scene.patterns import Waves
from isophote.scene.procedural import Composed, Stops, axis_vector, seed_number, stops
from isophote.scene.ramps import Blend, Placed, Ramp
from isophote.scene.texture import Texture
from isophote.scene.transform import Transform

__all__ = ["Marble", "Wood"]

_STONE: Stops = (
    (0.0, as_colour("#3d4249")),
    (0.06, as_colour("#7d828a")),
    (0.2, as_colour("#c9c8c6")),
    (0.55, as_colour("#efede8")),
    (1.0, as_colour("#f8f6f2")),
)
_X = (1.0, 0.0, 0.0)
_SHADE = 0.5
_EARLY, _LATE = as_colour("#d9a566"), as_colour("#8a5428")


@attrs.frozen(repr=False)
class Marble(Composed):
    """Stone with veins across `axis`, `size` metres apart, crumpled by turbulence (Perlin 1985).

    A `Ramp` with `stops`, from the veins' middle at 0 to halfway between them at 1, of triangle `Waves` that turbulence
    moves by `turbulence` periods; over it, a `Blend` towards clouds half as bright, by up to `clouds`, from 0 to 1.
    `octaves` are those of the turbulence: how fine the veins' edges are.
    """

    stops: Stops = attrs.field(default=_STONE, converter=stops)
    size: float = attrs.field(default=0.5, converter=as_number, validator=positive)
    turbulence: float = attrs.field(default=1.5, converter=as_number, validator=finite)
    clouds: float = attrs.field(default=0.4, converter=as_number, validator=fraction)
    octaves: int = attrs.field(default=7, validator=octave_count)
    axis: Vector = attrs.field(default=_X, converter=axis_vector)
    seed: int = attrs.field(default=0, validator=seed_number)

    def composed(self) -> Texture:
        """`Ramp` of `Waves` that an `Fbm` distorts, in a `Blend`."""
        crumpled = Fbm(PerlinNoise(self.size, self.seed), self.octaves, kind="turbulence")
        veins = Ramp(Waves("linear", "triangle", self.size, self.axis, crumpled, self.turbulence), self.stops)
        clouds = Ramp(Fbm(PerlinNoise(1.5 * self.size, self.seed ^ 1)), [(0.4, 0.0), (0.7, self.clouds)])
        return Blend(veins, tuple(_SHADE * channel for channel in self.stops[-1][1]), clouds)


@attrs.frozen(repr=False)
class Wood(Composed):
    """Wood of a trunk along y through the origin; `transform` takes boards from elsewhere in it.

    Each year's ring is `size` metres wide and goes from `early` to `late` wood; rings waver by `wavering` of their
    width, and fine fibres along the trunk are darker by `grain`, from 0 to 1.
    """

    early: Colour = attrs.field(default=_EARLY, converter=as_colour)
    late: Colour = attrs.field(default=_LATE, converter=as_colour)
    size: float = attrs.field(default=0.05, converter=as_number, validator=positive)
    wavering: float = attrs.field(default=1.5, converter=as_number, validator=finite)
    grain: float = attrs.field(default=0.35, converter=as_number, validator=fraction)
    seed: int = attrs.field(default=0, validator=seed_number)

    def composed(self) -> Texture:
        """Radial `Waves` in a `Ramp`, and a `Blend` towards dark where stretched noise is high."""
        wavering = Placed(
            Fbm(PerlinNoise(6 * self.size, self.seed), 3),
            transform=Transform.identity().scale((1, 8, 1)),
        )
        rings = Waves("radial", "saw", self.size, (0, 1, 0), wavering, 2 * self.wavering)
        between = tuple((a + b) / 2 for a, b in zip(self.early, self.late, strict=True))
        bands = Ramp(
            rings, [(0.0, self.early), (0.55, self.early), (0.8, between), (0.95, self.late), (1.0, self.early)]
        )
        fibres = Placed(
            Fbm(PerlinNoise(self.size / 6, self.seed ^ 1), 3),
            transform=Transform.identity().scale((1, 40, 1)),
        )
        dark = tuple(0.3 * channel for channel in self.late)
        return Blend(bands, dark, Ramp(fibres, [(0.45, 0.0), (0.7, self.grain)]))
