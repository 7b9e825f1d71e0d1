"""Noise: numbers from 0 to 1 that vary by chance over space, the same on every machine."""

from __future__ import annotations

import attrs

from isophote.errors import SceneError
from isophote.scene.fields import as_number, fraction, one_of, positive
from isophote.scene.procedural import Procedural, seed_number

__all__ = ["Fbm", "Noise", "PerlinNoise", "SimplexNoise", "ValueNoise", "WorleyNoise", "octave_count"]

_MOST_OCTAVES = 32


@attrs.frozen(repr=False)
class Noise(Procedural):
    """A number from 0 to 1, as a grey, for every place: the type of all noises.

    `size` is the edge of a cell of the lattice that it is made on, in metres: about the size of what is seen. Another
    `seed` gives another pattern. There is no period. Where a pixel sees more than a cell, noise fades to its mean.
    """

    size: float = attrs.field(default=1.0, converter=as_number, validator=positive)
    seed: int = attrs.field(default=0, validator=seed_number)


@attrs.frozen(repr=False)
class ValueNoise(Noise):
    """Random numbers at the points of a lattice, and between them smoothly, by 6 t⁵ − 15 t⁴ + 10 t³ along each axis.

    Mean 1/2.

    `size` is the edge of a cell of its lattice in metres, another `seed` another pattern; `space` and `transform` are
    those of `Placed`.
    """


@attrs.frozen(repr=False)
class PerlinNoise(Noise):
    """1/2 + n/2 of gradient noise n: random ramps through the points of a lattice, and between them as in `ValueNoise`.

    1/2 at all points of the lattice, and in the mean. Source: Perlin, "Improving Noise", SIGGRAPH 2002; with a hash in
    place of its table, which repeats after 256 cells.

    `size` is the edge of a cell of its lattice in metres, another `seed` another pattern; `space` and `transform` are
    those of `Placed`.
    """


@attrs.frozen(repr=False)
class SimplexNoise(Noise):
    """1/2 + n/2 of simplex noise n: random ramps under bumps around the points of a lattice of tetrahedra.

    It favours no axis, as lattices of cubes do. Mean 1/2. Source: Perlin, "Noise Hardware", 2001, with bumps that end
    before they leave their tetrahedra, so that all derivatives are continuous.

    `size` is the edge of a cell of its lattice in metres, another `seed` another pattern; `space` and `transform` are
    those of `Placed`.
    """


@attrs.frozen(repr=False)
class WorleyNoise(Noise):
    """Cells around scattered points, one point in each cell of the lattice.

    `feature`: "f1", the distance to the nearest point, in sizes; "f2", that to the second nearest; "f2-f1", which is 0
    at the borders of cells; or "cell", a random number for each cell. Distances above 1 count as 1. `metric`:
    "euclidean", "manhattan" (the sum of the coordinates) or "chebyshev" (the largest of them). `jitter`: 1 scatters
    points all over their cells, 0 leaves them in the middle. Source: Worley, "A Cellular Texture Basis Function",
    SIGGRAPH 1996.

    `size` is the edge of a cell of its lattice in metres, another `seed` another pattern; `space` and `transform` are
    those of `Placed`.
    """

    feature: str = attrs.field(default="f1", validator=one_of("f1", "f2", "f2-f1", "cell"))
    metric: str = attrs.field(default="euclidean", validator=one_of("euclidean", "manhattan", "chebyshev"))
    jitter: float = attrs.field(default=1.0, converter=as_number, validator=fraction)


def _noise(instance: object, attribute: attrs.Attribute[Noise], value: object) -> None:
    if not isinstance(value, Noise):
        raise SceneError(f"Fbm: noise must be a PerlinNoise or another noise, but is {value!r}")
    if value.space != "own":
        raise SceneError(
            f"Fbm: give space={value.space!r} to the Fbm, not to its noise, which is scaled for each octave"
        )


def octave_count(instance: object, attribute: attrs.Attribute[int], value: object) -> None:
    """A whole number from 1 to 32."""
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= _MOST_OCTAVES:
        name = f"{type(instance).__name__}: {attribute.name}"
        raise SceneError(f"{name} must be a whole number from 1 to {_MOST_OCTAVES}, but is {value!r}")


@attrs.frozen(repr=False)
class Fbm(Procedural):
    """Noise of many sizes added up: octave i is `noise` with cells `lacunarity`ⁱ times smaller, times `gain`ⁱ.

    With n from −1 to 1 for each octave, and all divided by the sum of `gain`ⁱ, `kind` is
    "fbm": 1/2 + Σ gainⁱ nᵢ / 2, fractional Brownian motion, as of hills and clouds;
    "turbulence": Σ gainⁱ |nᵢ|, with creases, as of flames and veins (Perlin 1985);
    "ridged": Σ gainⁱ wᵢ (1 − |nᵢ|)², with ridges, where wᵢ is twice the term before, at most 1 (Musgrave 2003).
    Octaves finer than a pixel sees are replaced by their mean.
    """

    noise: Noise = attrs.field(factory=PerlinNoise, validator=_noise)
    octaves: int = attrs.field(default=6, validator=octave_count)
    gain: float = attrs.field(default=0.5, converter=as_number, validator=fraction)
    lacunarity: float = attrs.field(default=2.0, converter=as_number, validator=positive)
    kind: str = attrs.field(default="fbm", validator=one_of("fbm", "turbulence", "ridged"))
