"""A field as one web page that stands alone: WebGL 2, no network, nothing to install."""

from __future__ import annotations

import base64
import html
import json
import math
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import numpy.typing as npt

from isophote import __version__
from isophote.convert.glsl import GlslField, to_glsl
from isophote.convert.glsl_grid import GlslGrid
from isophote.errors import FileError
from isophote.io.files import StrPath, replacing
from isophote.scene.camera import Camera
from isophote.scene.light import RectLight, Sky
from isophote.scene.material import Matte
from isophote.scene.scene import Scene
from isophote.scene.studio import studio
from isophote.shapes.field.field import Field
from isophote.shapes.field.vary import with_values

__all__ = ["page_of", "shader_of", "write_html"]

# Where no Lipschitz constant is known, steps are this part of the field's value.
_CAREFUL = 2.0
# Rays enter a field so far beyond its bounds, in parts of its longest edge.
_BEYOND = 2.0**-8


def write_html(path: StrPath, shape: Field, title: str | None = None) -> None:
    """Write a web page that shows a field, to turn, zoom and move, with a slider for each of its parameters.

    `title` is the name of the file where none is given. Raises `GeometryError` for fields that are endless or hold
    tables of data, `FileError` where the file cannot be written.
    """
    text = page_of(shape, Path(path).stem if title is None else title)
    with replacing(path) as temporary:
        temporary.write_text(text, "utf-8")


def page_of(shape: Field, title: str) -> str:
    """The text of the page."""
    if not np.isfinite(shape.bounds).all():
        raise FileError(title, "an endless field has no view of its own; intersect it with a box first")
    fragment, glsl, view = shader_of(shape, "300 es")
    model = {
        "title": title,
        "view": view,
        "parameters": _sliders(glsl),
        "grids": [_texture(grid) for grid in glsl.grids],
    }
    fields = {
        "title": html.escape(title),
        "generator": f"Isophote {__version__}",
        "style": _file("page.css"),
        # "</" would end the element.
        "model": json.dumps(model).replace("</", "<\\/"),
        "vertex": _file("page.vert"),
        "fragment": fragment,
        "script": _file("page.js"),
    }
    return Template(_file("page.html")).substitute(fields)


def shader_of(shape: Field, version: str) -> tuple[str, GlslField, dict[str, Any]]:
    """The fragment shader of a field in its studio, for `#version 300 es` or `330 core`, the field's own part of it,
    and the view as an orbit: target, distance, yaw, pitch and field of view in radians."""
    box = _box(shape)
    glsl, scene = to_glsl(shape, region=_cube(box)), studio(shape)
    precision = "precision highp float;\nprecision highp int;\n" if version.endswith("es") else ""
    constants = "\n".join(f"const {kind} {name} = {value};" for kind, name, value in _constants(glsl, scene, box))
    source = f"#version {version}\n{precision}\n{constants}\n\n{glsl.source}\n{_file('sphere_trace.glsl')}"
    return source, glsl, _view(scene)


def _file(name: str) -> str:
    return resources.files("isophote.glsl").joinpath(name).read_text("utf-8").strip()


def _sliders(glsl: GlslField) -> list[dict[str, Any]]:
    pairs = zip(glsl.parameters, glsl.uniforms, strict=True)
    return [{"name": p.name, "uniform": u, "value": float(p), "low": p.low, "high": p.high} for p, u in pairs]


def _texture(grid: GlslGrid) -> dict[str, Any]:
    """A grid's samples in 16 bits each, from the lowest to the highest: base64 takes a third more than bytes."""
    low, high = float(grid.values.min()), float(grid.values.max())
    step = (high - low) / 65535 or 1.0
    levels = np.rint((grid.values - low) / step).astype("<u2")
    return {
        "name": grid.name,
        "size": grid.values.shape[::-1],
        "low": low,
        "step": step,
        "levels": base64.b64encode(levels.tobytes()).decode("ascii"),
    }


def _view(scene: Scene) -> dict[str, Any]:
    """The camera as an orbit: angles about the target, in radians."""
    camera = scene.camera
    assert isinstance(camera, Camera)  # What the studio gives.
    eye, target = np.array(camera.eye), np.array(camera.target)
    back = eye - target
    distance = float(np.linalg.norm(back))
    return {
        "target": target.tolist(),
        "distance": distance,
        "yaw": math.atan2(back[0], back[2]),
        "pitch": math.asin(back[1] / distance),
        "fov": math.radians(camera.fov_degrees),
    }


def _constants(glsl: GlslField, scene: Scene, box: npt.NDArray[np.float64]) -> list[tuple[str, str, str]]:
    """What the shader knows of the studio: type, name and value of each constant."""
    edge, diagonal = float((box[1] - box[0]).max()), float(np.linalg.norm(box[1] - box[0]))
    key = next(light for light in scene.lights if isinstance(light, RectLight))
    sky = next(light for light in scene.lights if isinstance(light, Sky))
    ground = scene.items[-1]
    low, high = np.asarray(ground.bounds)
    steps = glsl.lipschitz if math.isfinite(glsl.lipschitz) and glsl.lipschitz > 0 else _CAREFUL
    return [
        ("float", "LIPSCHITZ", _number(max(steps, 1e-6))),
        ("vec3", "BOX_LOW", _vector(box[0] - _BEYOND * edge)),
        ("vec3", "BOX_HIGH", _vector(box[1] + _BEYOND * edge)),
        ("float", "SIDE", _number(edge * (1 + 4 * _BEYOND))),
        ("float", "DETAIL", _number(float((box[1] - box[0]).min()))),
        ("float", "SURFACE", _number(diagonal * 1e-6)),
        ("float", "NORMAL_STEP", _number(diagonal * 1e-4)),
        ("float", "OCCLUSION", _number(diagonal / 12)),
        ("vec3", "ALBEDO", _vector(_albedo(scene.items[0].material))),
        ("vec3", "GROUND", _vector((low + high) / 2)),
        ("vec3", "GROUND_ALBEDO", _vector(_albedo(ground.material))),
        ("float", "GROUND_REACH", _number(float(high[0] - low[0]) / 2)),
        ("vec3", "KEY_PLACE", _vector(key.position)),
        ("vec3", "KEY_FACING", _vector(-key.transform.matrix[:3, 1])),
        ("vec3", "KEY_INTENSITY", _vector(np.array(key.radiance_rgb) * key.area)),
        ("float", "KEY_RADIUS", _number(math.sqrt(key.area / math.pi))),
        ("vec3", "SKY", _vector(np.array(sky.radiance_rgb))),
    ]


def _cube(box: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The cube about a box in which a field is traced."""
    edge = float((box[1] - box[0]).max())
    half = edge * (0.5 + 3 * _BEYOND)
    return np.stack([box.mean(axis=0) - half, box.mean(axis=0) + half])


def _box(shape: Field) -> npt.NDArray[np.float64]:
    """A box that holds the field wherever its sliders stand: at their ends, all of them or one by one."""
    parameters = {p.name: p for p in to_glsl(shape).parameters}
    ends = [{name: getattr(p, end) for name, p in parameters.items()} for end in ("low", "high")]
    ends += [{name: getattr(p, end)} for name, p in parameters.items() for end in ("low", "high")]
    boxes = np.stack([shape.bounds, *(Field(with_values(shape.form, values)).bounds for values in ends)])
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _albedo(material: object) -> tuple[float, float, float]:
    if not isinstance(material, Matte) or not isinstance(material.colour, tuple):
        return (0.7, 0.7, 0.7)
    red, green, blue = material.colour
    return (red, green, blue)


def _number(value: float) -> str:
    return f"{value:.9g}" if any(c in f"{value:.9g}" for c in ".e") else f"{value:.9g}.0"


def _vector(values: Any) -> str:
    return "vec3(" + ", ".join(_number(float(v)) for v in values) + ")"
