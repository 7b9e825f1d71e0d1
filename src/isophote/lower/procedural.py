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
from isophote.kernels.texture.value_noise import value_noise
from isophote.scene.colour import Colour
from isophote.scene.noise import Fbm, Noise, PerlinNoise, SimplexNoise, ValueNoise, WorleyNoise
from isophote.scene.patterns import CheckerNumber, Coordinate, GridNumber, Waves
from isophote.scene.procedural import Composed, Procedural
from isophote.scene.ramps import Blend, Placed, Ramp
from isophote.scene.texture import Texture
from isophote.scene.transform import Transform

__all__ = ["TextureNode", "node_of"]

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
_NOISES: dict[type, Entry] = {
    ValueNoise: value_noise,
    PerlinNoise: perlin,
    SimplexNoise: simplex,
    WorleyNoise: worley.worley,
}

# Mean of |n| and of (1 − |n|)² of noises n from −1 to 1, and of the features of Worley's by metric, for jitter 1: what
# is left where they are too fine to be seen.
_SIZES = {
    ValueNoise: (0.283, 0.548),
    PerlinNoise: (0.207, 0.670),
    SimplexNoise: (0.207, 0.670),
    WorleyNoise: (0.3, 0.5),
}
_MEANS = {
    "euclidean": {"f1": 0.5, "f2": 0.7, "f2-f1": 0.2, "cell": 0.5},
    "manhattan": {"f1": 0.7, "f2": 0.9, "f2-f1": 0.2, "cell": 0.5},
    "chebyshev": {"f1": 0.4, "f2": 0.6, "f2-f1": 0.2, "cell": 0.5},
}

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
class _Constant(Texture):
    colour: Colour


def _child(value: Colour | Texture) -> Texture:
    return value if isinstance(value, Texture) else _Constant(value)


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
    data: tuple[float, ...] = (texture.size, *_seed(texture.seed))
    if isinstance(texture, WorleyNoise):
        mean = _MEANS[texture.metric][texture.feature]
        data += (_METRICS[texture.metric], _FEATURES[texture.feature], texture.jitter, mean)
    return TextureNode(_NOISES[type(texture)], data)


def _fbm(texture: Fbm) -> TextureNode:
    turbulent, ridged = _SIZES[type(texture.noise)]
    mean = {"fbm": 0.0, "turbulence": turbulent, "ridged": ridged}[texture.kind]
    kind = _KINDS[texture.kind]
    data = (texture.octaves, texture.gain, texture.lacunarity, kind, texture.noise.size, mean)
    return TextureNode(fractal.fractal, data, (texture.noise,))


def _ramp(texture: Ramp) -> TextureNode:
    data = ramp_data(texture.stops, texture.between)
    return TextureNode(combine.ramp, data, (texture.texture,))


def ramp_data(stops: Sequence[tuple[float, Colour]], between: str) -> tuple[float, ...]:
    """Numbers of a ramp as kernels take them."""
    numbers = [number for position, colour in stops for number in (position, *colour)]
    return (len(stops), _BETWEEN[between], *numbers)


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
    _Constant: lambda texture: TextureNode(combine.constant, texture.colour),
    Blend: _blend,
    CheckerNumber: lambda texture: TextureNode(periodic.checker, (texture.size,)),
    Coordinate: lambda texture: TextureNode(periodic.coordinate, _coordinate(texture)),
    Fbm: _fbm,
    GridNumber: _grid,
    PerlinNoise: _noise,
    Ramp: _ramp,
    SimplexNoise: _noise,
    ValueNoise: _noise,
    Waves: _waves,
    WorleyNoise: _noise,
}
