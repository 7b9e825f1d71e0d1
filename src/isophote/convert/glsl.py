"""A field as GLSL: one function of the point, for `#version 330` and `#version 300 es` alike."""

from __future__ import annotations

import keyword
import math
import re
from importlib import resources
from typing import Any

import attrs

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Graph, Parameter
from isophote.shapes.field.field import Field
from isophote.shapes.field.operators import OPERATORS
from isophote.shapes.field.tape import written

__all__ = ["GlslField", "to_glsl"]

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
# Expressions that are used once are put in place up to this many characters; longer ones get a name of their own.
_INLINE = 80
_LARGEST = 3.0e38


@attrs.frozen
class GlslField:
    """GLSL of a field. `str()` gives `source`, which declares the function `name` and all that it needs.

    `parameters` are those that became uniforms, by the names in `uniforms`; `lipschitz` bounds the slope of the
    function over the field's bounds, for every value of the parameters (infinite where nothing is known).
    """

    name: str
    source: str
    parameters: tuple[Parameter, ...]
    uniforms: tuple[str, ...]
    lipschitz: float

    def __str__(self) -> str:
        return self.source


def to_glsl(shape: Field, name: str = "field") -> GlslField:
    """A GLSL function `float name(vec3 p)` with the values of a field, negative inside.

    Parameters become uniforms named `u_` and their name. Raises `GeometryError` for names that GLSL does not take, and
    for fields that hold tables of data (meshes, images), which have no spelling in GLSL.
    """
    if not _NAME.fullmatch(name) or keyword.iskeyword(name) or name.startswith("gl_"):
        raise GeometryError(f"to_glsl: {name!r} is no name of a GLSL function; use letters, digits and underscores")
    graph, result = written(shape.form, shape.bounds, symbolic=True)
    live = graph.used(result)
    parameters = tuple(graph.nodes[n].constant for n in live if graph.nodes[n].name == "PARAMETER")
    uniforms = tuple(_uniform(parameter) for parameter in parameters)
    lines = [f"uniform float {uniform};" for uniform in uniforms]
    functions = resources.files("isophote.glsl").joinpath("operators.glsl").read_text("utf-8").strip()
    body = "\n".join(_body(graph, live, result))
    declared = "\n".join(lines) + "\n" if lines else ""
    source = f"{functions}\n\n{declared}float {name}(vec3 p) {{\n{body}\n}}\n"
    return GlslField(name, source, parameters, uniforms, graph.lipschitz()[result])


def _uniform(parameter: Parameter) -> str:
    return "u_" + re.sub(r"\W+", "_", parameter.name).strip("_")


def _body(graph: Graph, live: list[int], result: int) -> list[str]:
    """The lines of the function: one a named value."""
    uses: dict[int, int] = {}
    for node in live:
        for argument in graph.nodes[node].arguments:
            uses[argument] = uses.get(argument, 0) + 1
    spelled: dict[int, str] = {}
    lines = []
    for node in live:
        text = _spelled(graph, node, spelled)
        plain = graph.nodes[node].name in ("INPUT", "PARAMETER", "CONSTANT")
        if not plain and node != result and (uses.get(node, 0) > 1 or len(text) > _INLINE):
            lines.append(f"    float v{node} = {text};")
            text = f"v{node}"
        spelled[node] = text
    return [*lines, f"    return {spelled[result]};"]


def _spelled(graph: Graph, node: int, spelled: dict[int, str]) -> str:
    name, arguments, constant = graph.nodes[node]
    if name == "INPUT":
        return f"p.{constant}"
    if name == "PARAMETER":
        return _uniform(constant)
    operator = OPERATORS[name]
    if not isinstance(constant, float | int):
        raise GeometryError(
            f"to_glsl: the field holds a table of data ({type(constant).__name__}), which has no spelling in GLSL; "
            "leave out meshes, images and text, or save a mesh"
        )
    values: dict[str, Any] = dict(zip("abc", (spelled[a] for a in arguments), strict=False))
    return operator.glsl.format(**values, k=_literal(constant))


def _literal(number: float) -> str:
    """A float as GLSL spells it; infinities become the largest number."""
    finite = math.copysign(min(abs(number), _LARGEST), number)
    text = f"{finite:.9g}"
    if not any(mark in text for mark in ".e"):
        text += ".0"
    return f"({text})" if finite < 0 else text
