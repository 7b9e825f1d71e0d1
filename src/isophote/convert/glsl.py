"""A field as GLSL: one function of the point, for `#version 330` and `#version 300 es` alike."""

from __future__ import annotations

import keyword
import math
import re
from importlib import resources
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from isophote.convert.glsl_grid import GlslGrid, grid_of
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
# Between samples, and beyond them, slopes are up to √2 of what they are of.
_SAMPLED = math.sqrt(2)


@attrs.frozen
class GlslField:
    """GLSL of a field. `str()` gives `source`, which declares the function `name` and all that it needs.

    `parameters` are those that became uniforms, by the names in `uniforms`; `grids` are the textures that it reads.
    `lipschitz` bounds the slope of the function over the field's bounds, for every value of the parameters (infinite
    where nothing is known).
    """

    name: str
    source: str
    parameters: tuple[Parameter, ...]
    uniforms: tuple[str, ...]
    grids: tuple[GlslGrid, ...]
    lipschitz: float

    def __str__(self) -> str:
        return self.source


def to_glsl(shape: Field, name: str = "field", region: npt.ArrayLike | None = None) -> GlslField:
    """A GLSL function `float name(vec3 p)` with the values of a field, negative inside.

    Parameters become uniforms named `u_` and their name. Outlines, images and meshes become textures with samples of
    them, `grid0` and so on, so that what is finer than 1/512 of an outline or 1/96 of a mesh is lost. `lipschitz` holds
    in `region`, (2, 3), the field's bounds if it is None. Raises `GeometryError` for names that GLSL does not take.
    """
    if not _NAME.fullmatch(name) or keyword.iskeyword(name) or name.startswith("gl_"):
        raise GeometryError(f"to_glsl: {name!r} is no name of a GLSL function; use letters, digits and underscores")
    box = shape.bounds if region is None else np.asarray(region, np.float64)
    graph, result = written(shape.form, box, symbolic=True)
    live = graph.used(result)
    parameters = tuple(graph.nodes[n].constant for n in live if graph.nodes[n].name == "PARAMETER")
    uniforms = tuple(_uniform(parameter) for parameter in parameters)
    grids = _grids(graph, live)
    functions = resources.files("isophote.glsl").joinpath("operators.glsl").read_text("utf-8").strip()
    parts = [
        functions,
        *(f"uniform float {uniform};" for uniform in uniforms),
        *(grid.source for grid in grids.values()),
        "\n".join([f"float {name}(vec3 p) {{", *_body(graph, live, result, grids), "}"]),
    ]
    slope = graph.lipschitz()[result] * (_SAMPLED if grids else 1.0)
    return GlslField(name, "\n\n".join(parts) + "\n", parameters, uniforms, tuple(grids.values()), slope)


def _grids(graph: Graph, live: list[int]) -> dict[int, GlslGrid]:
    """A grid for each table of data, by the table's identity."""
    grids: dict[int, GlslGrid] = {}
    for node in live:
        constant = graph.nodes[node].constant
        if graph.nodes[node].name in OPERATORS and not isinstance(constant, float | int) and id(constant) not in grids:
            grids[id(constant)] = grid_of(f"grid{len(grids)}", constant)
    return grids


def _uniform(parameter: Parameter) -> str:
    return "u_" + re.sub(r"\W+", "_", parameter.name).strip("_")


def _body(graph: Graph, live: list[int], result: int, grids: dict[int, GlslGrid]) -> list[str]:
    """The lines of the function: one a named value."""
    uses: dict[int, int] = {}
    for node in live:
        for argument in graph.nodes[node].arguments:
            uses[argument] = uses.get(argument, 0) + 1
    spelled: dict[int, str] = {}
    lines = []
    for node in live:
        text = _spelled(graph, node, spelled, grids)
        plain = graph.nodes[node].name in ("INPUT", "PARAMETER", "CONSTANT")
        if not plain and node != result and (uses.get(node, 0) > 1 or len(text) > _INLINE):
            lines.append(f"    float v{node} = {text};")
            text = f"v{node}"
        spelled[node] = text
    return [*lines, f"    return {spelled[result]};"]


def _spelled(graph: Graph, node: int, spelled: dict[int, str], grids: dict[int, GlslGrid]) -> str:
    name, arguments, constant = graph.nodes[node]
    if name == "INPUT":
        return f"p.{constant}"
    if name == "PARAMETER":
        return _uniform(constant)
    parts = [spelled[a] for a in arguments]
    if id(constant) in grids:
        return f"{grids[id(constant)].name}At(vec{len(parts)}({', '.join(parts)}))"
    values: dict[str, Any] = dict(zip("abc", parts, strict=False))
    return OPERATORS[name].glsl.format(**values, k=_literal(constant))


def _literal(number: float) -> str:
    """A float as GLSL spells it; infinities become the largest number."""
    finite = math.copysign(min(abs(number), _LARGEST), number)
    text = f"{finite:.9g}"
    if not any(mark in text for mark in ".e"):
        text += ".0"
    return f"({text})" if finite < 0 else text
