"""Procedural textures as GLSL: the same formulas and the same lattice, for `#version 330` and `#version 300 es`."""

from __future__ import annotations

import keyword
import re
from collections.abc import Callable, Sequence
from importlib import resources
from itertools import pairwise
from typing import Any

import attrs
import numpy as np

from isophote.convert.glsl import to_glsl
from isophote.errors import SceneError
from isophote.kernels.texture.combine import OF_OWN, OF_UV
from isophote.lower.procedural import Constant, node_of
from isophote.scene.formula import FieldTexture, Formula
from isophote.scene.noise import Fbm, PerlinNoise, SimplexNoise, ValueNoise, WorleyNoise
from isophote.scene.patterns import CheckerNumber, Coordinate, GridNumber, Waves
from isophote.scene.procedural import Composed, Procedural, Stops
from isophote.scene.ramps import Blend, Placed, Ramp
from isophote.scene.texture import Texture
from isophote.scene.transform import Transform
from isophote.shapes.field.field import Field

__all__ = ["GlslTexture", "texture_glsl"]

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
# What a GLSL function cannot be called, of the names that come to mind.
_TAKEN = {"main", "texture", "float", "int", "bool", "void", "vec2", "vec3", "vec4", "mat3", "mat4", "const", "uniform"}
_TAKEN |= {
    "in",
    "out",
    "inout",
    "struct",
    "switch",
    "case",
    "default",
    "do",
    "discard",
    "noise",
    "mix",
    "step",
    "clamp",
}
_IDENTITY = Transform.identity()
_REGION = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))


@attrs.frozen
class GlslTexture:
    """GLSL of a texture. `str()` gives `source`, which declares `vec4 name(vec3 own, vec2 uv, vec3 world)` and all that
    it needs."""

    name: str
    source: str

    def __str__(self) -> str:
        return self.source


def texture_glsl(texture: Texture, name: str = "texture_at") -> GlslTexture:
    """A GLSL function `vec4 name(vec3 own, vec2 uv, vec3 world)` with a procedural texture's linear colour and alpha.

    It takes a place in the shape's own space, texture coordinates, and the place in the world, and looks the texture up
    at that place alone, without averaging. Raises `SceneError` for pictures, which have no formula, for fields of
    meshes, images or parameters, and for names that GLSL does not take.
    """
    if not _NAME.fullmatch(name) or keyword.iskeyword(name) or name.startswith("gl_") or name in _TAKEN:
        raise SceneError(f"texture_glsl: {name!r} is no name of a GLSL function; use letters, digits and underscores")
    writer = _Writer(name)
    top = writer.function(texture)
    last = f"vec4 {name}(vec3 own, vec2 uv, vec3 world) {{ return {top}(Where(own, uv, world)); }}"
    return GlslTexture(name, "\n\n".join([_shared("textures"), *writer.parts, last]) + "\n")


def _shared(name: str) -> str:
    return resources.files("isophote.glsl").joinpath(f"{name}.glsl").read_text("utf-8").strip()


def _number(value: float) -> str:
    """A float32 as GLSL spells it."""
    text = f"{np.float32(value):.9g}"
    text = text if any(mark in text for mark in ".en") else text + ".0"
    return f"({text})" if text.startswith("-") else text


def _vector(values: Sequence[float]) -> str:
    return f"vec{len(values)}({', '.join(map(_number, values))})"


class _Writer:
    """Functions of textures, one for each that is different, in an order in which callees come first."""

    def __init__(self, name: str) -> None:
        self.parts: list[str] = []
        self._prefix = name
        self._names: dict[Texture, str] = {}
        self._has_operators = False

    def function(self, texture: Texture) -> str:
        """Name of a function `vec4 f(Where w)` of a texture, which is written if it was not yet."""
        if texture not in self._names:
            body = self._body(texture)
            self._names[texture] = f"{self._prefix}_{len(self._names)}"
            self.parts.append(f"vec4 {self._names[texture]}(Where w) {{\n    {body}\n}}")
        return self._names[texture]

    def _body(self, texture: Texture) -> str:
        if isinstance(texture, Placed):
            return self._placed(texture, texture.texture)
        if isinstance(texture, Procedural) and (texture.space != "own" or texture.transform != _IDENTITY):
            return self._placed(texture, texture.with_(space="own", transform=_IDENTITY))
        if isinstance(texture, Composed):
            return f"return {self.function(texture.composed())}(w);"
        write = _WRITE.get(type(texture))
        if write is None:
            raise SceneError(f"texture_glsl: a {type(texture).__name__} has no formula")
        return write(self, texture)

    def _placed(self, texture: Procedural, inner: Texture) -> str:
        space, *rows = node_of(Placed(inner, space=texture.space, transform=texture.transform)).data
        given = "w.own" if space == OF_OWN else ("vec3(w.uv, 0.0)" if space == OF_UV else "w.world")
        matrix = np.array(rows).reshape(3, 4)
        # Columns first.
        turned = ", ".join(map(_number, matrix[:, :3].T.reshape(-1)))
        moved = f"vec3 q = mat3({turned}) * {given} + {_vector(matrix[:, 3].tolist())};"
        return f"{moved}\n    return {self.function(inner)}(Where(q, q.xy, w.world));"

    def blend(self, texture: Blend) -> str:
        a, b, amount = (self.function(child) for child in node_of(texture).children)
        return f"return mix({a}(w), {b}(w), clamp({amount}(w).r, 0.0, 1.0));"

    def ramp(self, texture: Ramp) -> str:
        child = self.function(texture.texture)
        return (
            f"vec4 found = {child}(w);\n    float t = found.r;\n    {_stops(texture.stops, texture.between, 'found.a')}"
        )

    def fbm(self, texture: Fbm) -> str:
        octaves, gain, lacunarity, kind, size, *_ = node_of(texture).data
        child = self.function(texture.noise)
        lines = [
            "float total = 0.0, whole = 0.0, amplitude = 1.0, weight = 1.0, scale = 1.0;",
            f"for (int k = 0; k < {octaves}; k++) {{",
            f"    vec3 q = w.own * scale + vec3(19.1875, 7.3125, 31.6875) * {_number(size)} * float(k);",
            f"    float term = octave({kind}, {child}(Where(q, w.uv, w.world)).r);",
            *(["    term *= weight;", "    weight = min(2.0 * term, 1.0);"] if texture.kind == "ridged" else []),
            "    total += amplitude * term;",
            "    whole += amplitude;",
            f"    amplitude *= {_number(gain)};",
            f"    scale *= {_number(lacunarity)};",
            "}",
            "float mean = total / whole;",
            f"return vec4(vec3({'0.5 + 0.5 * mean' if texture.kind == 'fbm' else 'mean'}), 1.0);",
        ]
        return "\n    ".join(lines)

    def waves(self, texture: Waves) -> str:
        data = node_of(texture).data
        lines = [f"float x = {_coordinate(data)};"]
        if texture.distortion is not None:
            child = self.function(texture.distortion)
            lines.append(f"x += {_number(texture.amount)} * (2.0 * {child}(w).r - 1.0);")
        lines.append(f"return vec4(vec3(wave({data[11]}, x, {_number(data[12])})), 1.0);")
        return "\n    ".join(lines)

    def formula(self, texture: Formula | FieldTexture) -> str:
        names = [self._expression(Field(form)) for form in texture.forms]
        if len(names) == 3:
            return f"return vec4(max(vec3({', '.join(f'{name}(w.own)' for name in names)}), 0.0), 1.0);"
        value = f"float t = {names[0]}(w.own);"
        if texture.period:
            value += f"\n    t /= {_number(texture.period)};\n    t -= floor(t);"
        return f"{value}\n    {_stops(texture.stops, texture.between, '1.0')}"

    def _expression(self, field: Field) -> str:
        name = f"{self._prefix}_value_{len(self.parts)}"
        written = to_glsl(field, name, np.array(_REGION))
        if written.grids or written.parameters:
            raise SceneError("texture_glsl: a field of a mesh, an image, an outline or a Parameter is no mere formula")
        operators = _shared("operators")
        source = written.source.removeprefix(operators).strip()
        self.parts.append(source if self._has_operators else f"{operators}\n\n{source}")
        self._has_operators = True
        return name


def _stops(stops: Stops, between: str, alpha: str) -> str:
    """Statements that return the colour of a ramp at `t`."""
    lines = [f"if (!(t > {_number(stops[0][0])})) return vec4({_vector(stops[0][1])}, {alpha});"]
    for (low, first), (high, second) in pairwise(stops):
        if high == low:
            continue
        share = {
            "linear": f"(t - {_number(low)}) / ({_number(high)} - {_number(low)})",
            "smooth": f"smoothstep({_number(low)}, {_number(high)}, t)",
            "constant": "0.0",
        }[between]
        mixed = f"mix({_vector(first)}, {_vector(second)}, {share})"
        lines.append(f"if (t < {_number(high)}) return vec4({mixed}, {alpha});")
    lines.append(f"return vec4({_vector(stops[-1][1])}, {alpha});")
    return "\n    ".join(lines)


def _coordinate(data: Sequence[float]) -> str:
    axes = ", ".join(_vector(data[k : k + 3]) for k in (2, 5, 8))
    return f"coordinate({data[0]}, w.own, {axes}) / {_number(data[1])}"


def _grey(number: str) -> str:
    return f"return vec4(vec3({number}), 1.0);"


def _in_cells(size: float) -> str:
    return f"w.own * {_number(float(np.float32(1) / np.float32(size)))}"


def _lattice(name: str) -> Callable[[_Writer, Any], str]:
    return lambda _, texture: _grey(f"{name}({_in_cells(texture.size)}, {texture.seed}u)")


def _worley(_: _Writer, texture: WorleyNoise) -> str:
    data = node_of(texture).data
    call = f"vec3 f = worleyNoise({_in_cells(texture.size)}, {texture.seed}u, {data[4]}, {_number(texture.jitter)});"
    value = {"f1": "f.x", "f2": "f.y", "f2-f1": "f.y - f.x", "cell": "f.z"}[texture.feature]
    return f"{call}\n    {_grey(f'min({value}, 1.0)')}"


def _checker(_: _Writer, texture: CheckerNumber) -> str:
    cells = f"vec3 cell = floor({_in_cells(texture.size)} + 0.0009765625);"
    return f"{cells}\n    {_grey('2.0 * fract(0.5 * (cell.x + cell.y + cell.z))')}"


def _grid(_: _Writer, texture: GridNumber) -> str:
    lines = f"vec3 line = fract({_in_cells(texture.size)} + {_number(0.5 * texture.width)});"
    on = " || ".join(f"line.{axis} < {_number(texture.width)}" for axis in texture.axes)
    return f"{lines}\n    {_grey(f'{on} ? 1.0 : 0.0')}"


_WRITE: dict[type, Callable[[_Writer, Any], str]] = {
    Blend: _Writer.blend,
    CheckerNumber: _checker,
    Constant: lambda _, texture: f"return vec4({_vector(texture.colour)}, 1.0);",
    Coordinate: lambda _, texture: _grey(_coordinate(node_of(texture).data)),
    Fbm: _Writer.fbm,
    FieldTexture: _Writer.formula,
    Formula: _Writer.formula,
    GridNumber: _grid,
    PerlinNoise: _lattice("perlinNoise"),
    Ramp: _Writer.ramp,
    SimplexNoise: _lattice("simplexNoise"),
    ValueNoise: _lattice("valueNoise"),
    Waves: _Writer.waves,
    WorleyNoise: _worley,
}
