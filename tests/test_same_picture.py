"""One field in one light: sphere tracing on the processor, its GLSL by OpenGL, and its page in a browser."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import isophote as iso
from isophote.io.html import shader_of
from isophote.io.srgb import to_srgb_bytes
from shaders import picture
from test_web_page import BROWSER, browser  # noqa: F401 - a fixture

SIZE = (320, 240)
HOLE = iso.cylinder(0.5)
SHAPES = {
    "part": (iso.sphere(1) & iso.box(1.5)) - HOLE - HOLE.along("x") - HOLE.along("z"),
    "blend": iso.sphere(1).union(iso.box(1).translate((1, 0, 0)), blend=0.3),
    "several": iso.torus(1, 0.3) | iso.cone(0.4, 1.2) | iso.rounded_box(0.8, 0.1).translate((1.2, 0.3, 0)),
}


@functools.cache
def _on_the_processor(name: str) -> np.ndarray:
    image = iso.render(SHAPES[name], iso.SphereTrace(), size=SIZE)
    return to_srgb_bytes(image.channels["colour"]).astype(int)


def _uniforms(view: dict[str, Any]) -> dict[str, Any]:
    """What the page's script makes of a view."""
    (cp, sp), (cy, sy) = ((np.cos(a), np.sin(a)) for a in (view["pitch"], view["yaw"]))
    back = np.array([cp * sy, sp, cp * cy])
    return {
        "samples": 1,
        "size": SIZE,
        "eye": tuple(np.array(view["target"]) + view["distance"] * back),
        "cameraRight": (cy, 0.0, -sy),
        "cameraUp": (-sp * sy, cp, -sp * cy),
        "cameraBack": tuple(back),
        "halfHeight": np.tan(view["fov"] / 2),
    }


def _alike(found: np.ndarray, expected: np.ndarray) -> float:
    """The share of pixels within two of 255 levels."""
    return float((np.abs(found.astype(int) - expected).max(axis=2) <= 2).mean())


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_glsl_shows_what_the_processor_shows(name: str) -> None:
    source, glsl, view = shader_of(SHAPES[name], "330 core")
    found = picture(source, SIZE, grids=glsl.grids, **_uniforms(view))
    assert _alike(found, _on_the_processor(name)) > 0.998


@pytest.mark.skipif(BROWSER is None, reason="no chromium here")
@pytest.mark.xdist_group("browser")
def test_the_page_shows_what_the_processor_shows(browser: Any, tmp_path: Path) -> None:  # noqa: F811
    iso.save(SHAPES["part"], tmp_path / "part.html")
    page = browser.new_page(viewport={"width": 400, "height": 300})
    page.goto((tmp_path / "part.html").as_uri())
    page.wait_for_function("window.isophote !== undefined")
    pixels = page.evaluate(f"isophote.picture({SIZE[0]}, {SIZE[1]})")
    page.close()
    found = np.array(pixels, np.uint8).reshape(SIZE[1], SIZE[0], 4)[..., :3]
    assert _alike(found, _on_the_processor("part")) > 0.998
