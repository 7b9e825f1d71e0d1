"""Textures that are formulas as nodes of the table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np

from isophote.errors import SceneError
from isophote.kernels.base.entry import Entry
from isophote.kernels.base.table import Packed
from isophote.kernels.texture import combine, fractal, periodic, worley
from isophote.kernels.texture.perlin import perlin
from isophote.kernels.texture.simplex import simplex
from isophote.kernels.texture.spread import spread
from isophote.kernels.texture.value_noise import value_noise
from isophote.scene.colour import Colour
from isophote.scene.formula import FieldTexture, Formula
from isophote.scene.image_texture import ImageTexture
from isophote.scene.noise import Fbm, Noise, PerlinNoise, SimplexNoise, ValueNoise, WorleyNoise
from isophote.scene.patterns import CheckerNumber, Coordinate, GridNumber, Waves
from isophote.scene.procedural import Composed, Procedural
from isophote.scene.ramps import Blend, Placed, Ramp
from isophote.scene.texture import Texture
from isophote.scene.transform import Transform

__all__ = ["Constant", "TextureNode", "node_of", "spread_out"]

_SPACES = {"own": combine.OF_OWN, "uv": combine.OF_UV, "world": combine.OF_WORLD}
_BETWEEN = {"linear": combine.LINEAR, "smooth": combine.SMOOTH, "constant": combine.CONSTANT}
_SHAPES = {
    "linear": periodic.LINEAR,
    "radial": periodic.RADIAL,
    "spherical": periodic.SPHERICAL,
    "angular": periodic.ANGULAR,
}
_PROFILES = {
    "sine": periodic.SINE,
    "saw": periodic.SAW,
    "triangle": periodic.TRIANGLE,
    "square": periodic.SQUARE,
}
_KINDS = {"fbm": fractal.FBM, "turbulence": fractal.TURBULENCE, "ridged": fractal.RIDGED}
_FEATURES = {"f1": worley.F1, "f2": worley.F2, "f2-f1": worley.BORDER, "cell": worley.CELL}
_METRICS = {"euclidean": worley.EUCLIDEAN, "manhattan": worley.MANHATTAN, "chebyshev": worley.CHEBYSHEV}
_NOISES: dict[type, Entry] = {ValueNoise: value_noise, PerlinNoise: perlin, SimplexNoise: simplex}

# Of noises n from −1 to 1: means of |n| and (1 − |n|)², and over how many cells a mean leaves nothing to be seen of n.
_SIGNED = {
    ValueNoise: (0.330, 0.500, 3.4),
    PerlinNoise: (0.220, 0.633, 2.5),
    SimplexNoise: (0.314, 0.526, 1.4),
    WorleyNoise: (0.282, 0.556, 2.0),
}
# Creases are finer than the noise that has them.
_CREASED = 1.5
# Means of the features of Worley's noise by metric, for jitter 1, and over how many cells a mean leaves nothing.
_MEANS = {
    "euclidean": {"f1": 0.520, "f2": 0.716, "f2-f1": 0.196, "cell": 0.5},
    "manhattan": {"f1": 0.741, "f2": 0.937, "f2-f1": 0.285, "cell": 0.5},
    "chebyshev": {"f1": 0.421, "f2": 0.579, "f2-f1": 0.159, "cell": 0.5},
}
_REACH = {"f1": 2.0, "f2": 2.4, "f2-f1": 1.4, "cell": 2.3}

_IDENTITY = Transform.identity()


@attrs.frozen
class TextureNode:
    """A node: its entry, its numbers in `data`, the textures that it is made from, and a table of its own, if it has
    one, whose address stands where pictures have their number."""

    entry: Entry
    data: tuple[float, ...] = ()
    children: tuple[Texture, ...] = ()
    table: Packed | None = None


@attrs.frozen
class Constant(Texture):
    """One colour, where a child may be any texture."""

    colour: Colour


@attrs.frozen
class _Spread(Texture):
    """A texture whose long footprints are cut."""

    texture: Texture


# Kinds that average over a footprint themselves, if what they are made of does.
_AVERAGED = (CheckerNumber, Constant, FieldTexture, Formula, GridNumber, ImageTexture)


def spread_out(texture: Texture) -> Texture:
    """A texture so that it is seen as it should be where footprints are long."""
    return texture if _is_averaged(texture) else _Spread(texture)


def _is_averaged(texture: Texture) -> bool:
    if isinstance(texture, Composed):
        return _is_averaged(texture.composed())
    if isinstance(texture, Placed):
        return _is_averaged(texture.texture)
    if isinstance(texture, Blend):
        parts = (texture.a, texture.b, texture.amount)
        return all(_is_averaged(part) for part in parts if isinstance(part, Texture))
    if isinstance(texture, Waves):
        return texture.distortion is None and texture.shape == "linear"
    return isinstance(texture, _AVERAGED)


def _child(value: Colour | Texture) -> Texture:
    return value if isinstance(value, Texture) else Constant(value)


def node_of(texture: Texture) -> TextureNode:
    """The node of a texture that is no picture. Raises `SceneError` for types that are none of Isophote's."""
    if isinstance(texture, Procedural) and (texture.space != "own" or texture.transform != _IDENTITY):
        return _placed(texture)
    if isinstance(texture, Placed):
        return TextureNode(combine.placed, _place_data("own", _IDENTITY), (texture.texture,))
    if isinstance(texture, Composed):
        return node_of(texture.composed())
    describe = _DESCRIBE.get(type(texture))
    if describe is None:
        raise SceneError(f"a {type(texture).__name__} cannot be drawn")
    return describe(texture)


def _placed(texture: Procedural) -> TextureNode:
    """A texture in another space, or moved in its own."""
    inner = texture.texture if isinstance(texture, Placed) else texture.with_(space="own", transform=_IDENTITY)
    return TextureNode(combine.placed, _place_data(texture.space, texture.transform), (inner,))


def _place_data(space: str, transform: Transform) -> tuple[float, ...]:
    rows = np.linalg.inv(transform.matrix)[:3]
    return (_SPACES[space], *rows.reshape(-1).tolist())


def _seed(seed: int) -> tuple[float, float]:
    """A seed in two halves, which floats hold exactly."""
    return float(seed & 0xFFFF), float(seed >> 16)


def _noise(texture: Noise) -> TextureNode:
    data: tuple[float, ...] = (texture.size, *_seed(texture.seed), _SIGNED[type(texture)][2])
    return TextureNode(_NOISES[type(texture)], data)


def _worley(texture: WorleyNoise) -> TextureNode:
    feature = texture.feature
    data = (texture.size, *_seed(texture.seed), _REACH[feature], _METRICS[texture.metric], _FEATURES[feature])
    return TextureNode(worley.worley, (*data, texture.jitter, _MEANS[texture.metric][feature]))


def _fbm(texture: Fbm) -> TextureNode:
    turbulent, ridged, reach = _SIGNED[type(texture.noise)]
    mean = {"fbm": 0.0, "turbulence": turbulent, "ridged": ridged}[texture.kind]
    reach /= 1 if texture.kind == "fbm" else _CREASED
    data = (texture.octaves, texture.gain, texture.lacunarity, _KINDS[texture.kind], texture.noise.size, mean, reach)
    return TextureNode(fractal.fractal, data, (texture.noise,))


def _ramp(texture: Ramp) -> TextureNode:
    data = ramp_data(texture.stops, texture.between)
    return TextureNode(combine.ramp, data, (texture.texture,))


def ramp_data(stops: Sequence[tuple[float, Colour]], between: str) -> tuple[float, ...]:
    """Numbers of a ramp as kernels take them."""
    numbers = [number for position, colour in stops for number in (position, *colour)]
    return (len(stops), _BETWEEN[between], *numbers)


def _formula(texture: Formula | FieldTexture) -> TextureNode:
    # Loaded where there is one: interpreters of tapes are compiled with it.
    from isophote.kernels.texture.formula import formula
    from isophote.lower.formulas import formula_table

    ramp = ramp_data(texture.stops, texture.between) if len(texture.forms) == 1 else ()
    return TextureNode(formula, table=formula_table(texture.forms, ramp, texture.period or 0.0))


def _blend(texture: Blend) -> TextureNode:
    return TextureNode(combine.blend, children=(_child(texture.a), _child(texture.b), _child(texture.amount)))


def _frame(axis: Sequence[float]) -> tuple[float, ...]:
    """The axis and two unit vectors across it, right-handed; around y, u of round primitives begins at the first."""
    z = np.array(axis)
    towards = np.eye(3)[0] if abs(z[0]) < 0.9 else np.eye(3)[1]
    x = towards - z * (towards @ z)
    x /= np.linalg.norm(x)
    return (*axis, *x.tolist(), *np.cross(z, x).tolist())


def _coordinate(texture: Coordinate | Waves) -> tuple[float, ...]:
    return (_SHAPES[texture.shape], texture.size, *_frame(texture.axis))


def _waves(texture: Waves) -> TextureNode:
    moved = 0.0 if texture.distortion is None else texture.amount
    data = (*_coordinate(texture), _PROFILES[texture.profile], texture.share, moved)
    return TextureNode(periodic.waves, data, () if texture.distortion is None else (texture.distortion,))


def _grid(texture: GridNumber) -> TextureNode:
    counts = [float(letter in texture.axes) for letter in "xyz"]
    return TextureNode(periodic.grid, (texture.size, texture.width, *counts))


_DESCRIBE: dict[type, Callable[[Any], TextureNode]] = {
    Constant: lambda texture: TextureNode(combine.constant, texture.colour),
    Blend: _blend,
    CheckerNumber: lambda texture: TextureNode(periodic.checker, (texture.size,)),
    Coordinate: lambda texture: TextureNode(periodic.coordinate, _coordinate(texture)),
    Fbm: _fbm,
    FieldTexture: _formula,
    Formula: _formula,
    GridNumber: _grid,
    PerlinNoise: _noise,
    Ramp: _ramp,
    SimplexNoise: _noise,
    ValueNoise: _noise,
    _Spread: lambda texture: TextureNode(spread, children=(texture.texture,)),
    Waves: _waves,
    WorleyNoise: _worley,
}
