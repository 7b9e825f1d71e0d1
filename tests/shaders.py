"""GLSL run headless, for tests; skips where there is no OpenGL."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from isophote.convert.glsl_grid import GlslGrid

VERTEX = """#version 330
void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(corner, 0.0, 1.0);
}
"""
VALUES = """#version 330
%s
uniform sampler2D points;
out float value;
void main() { value = %s(texelFetch(points, ivec2(gl_FragCoord.xy), 0).xyz); }
"""


@functools.cache
def context() -> Any:
    """An OpenGL context without a window."""
    moderngl = pytest.importorskip("moderngl")
    try:
        return moderngl.create_context(standalone=True, backend="egl")
    except Exception as error:  # noqa: BLE001 - the loader raises nothing narrower
        pytest.skip(f"no OpenGL here: {error}")


def _bind(program: Any, grids: Iterable[GlslGrid]) -> list[Any]:
    """The textures of a field, from unit 1 on; they live as long as the list does."""
    textures = []
    for unit, grid in enumerate(grids, start=1):
        make = context().texture if grid.dimension == 2 else context().texture3d
        texture = make(grid.values.shape[::-1], 1, np.ascontiguousarray(grid.values).tobytes(), dtype="f4")
        texture.filter = (context().NEAREST, context().NEAREST)
        texture.use(unit)
        program[grid.name].value = unit
        textures.append(texture)
    return textures


def values(source: str, name: str, points: np.ndarray, grids: Iterable[GlslGrid] = (), **uniforms: float) -> np.ndarray:
    """(n,) values of the GLSL function `name` at points (n, 3)."""
    gl = context()
    width = 256
    height = -(-len(points) // width)
    texels = np.zeros((height * width, 4), np.float32)
    texels[: len(points), :3] = points
    program = gl.program(vertex_shader=VERTEX, fragment_shader=VALUES % (source, name))
    texture = gl.texture((width, height), 4, texels.tobytes(), dtype="f4")
    texture.filter = (gl.NEAREST, gl.NEAREST)
    target = gl.framebuffer([gl.texture((width, height), 1, dtype="f4")])
    target.use()
    texture.use(0)
    textures = _bind(program, grids)
    for uniform, value in uniforms.items():
        program[uniform].value = value
    gl.vertex_array(program, []).render(mode=gl.TRIANGLES, vertices=3)
    del textures
    return np.frombuffer(target.read(components=1, dtype="f4"), np.float32)[: len(points)]


def picture(fragment: str, pixels: tuple[int, int], grids: Iterable[GlslGrid] = (), **uniforms: Any) -> np.ndarray:
    """(h, w, 3) bytes that a fragment shader paints, from the top."""
    gl = context()
    program = gl.program(vertex_shader=VERTEX, fragment_shader=fragment)
    target = gl.framebuffer([gl.texture(pixels, 4)])
    target.use()
    gl.viewport = (0, 0, *pixels)
    textures = _bind(program, grids)
    for uniform, value in uniforms.items():
        program[uniform].value = value
    gl.vertex_array(program, []).render(mode=gl.TRIANGLES, vertices=3)
    del textures
    return np.frombuffer(target.read(components=3), np.uint8).reshape(pixels[1], pixels[0], 3)[::-1]
