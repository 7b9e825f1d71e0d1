"""Checks that a picture can be made and kept on this machine."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from isophote.cli.progress import progress
from isophote.rendering.image import Image, load_image
from isophote.rendering.path_trace import PathTrace
from isophote.rendering.render import render
from isophote.scene.camera import Camera
from isophote.scene.light import Sky
from isophote.scene.material import Matte
from isophote.scene.scene import Item, Scene
from isophote.shapes.mesh import Mesh

__all__ = ["check_exr", "check_render"]

_SIZE = (64, 64)
_SAMPLES = 16
_ALBEDO = 0.5


def check_exr() -> dict[str, Any]:
    """Whether an EXR file comes back as it was written."""
    return _checked(_exr)


def check_render() -> dict[str, Any]:
    """Whether a picture whose brightness is known comes out, and in what time once kernels are compiled."""
    return _checked(_picture)


def _checked(check: Callable[[], str]) -> dict[str, Any]:
    try:
        return {"ok": True, "detail": check()}
    except Exception as error:  # noqa: BLE001 - whatever goes wrong is what a check is there to tell.
        return {"ok": False, "detail": f"{type(error).__name__}: {error}"}


def _exr() -> str:
    colour = np.linspace(0, 4, 48, dtype=np.float32).reshape(4, 4, 3)
    with tempfile.TemporaryDirectory(prefix="isophote-") as folder:
        path = Path(folder) / "check.exr"
        Image({"colour": colour}).save(path)
        found = load_image(path).channels["colour"]
    if not np.array_equal(found, colour):
        raise ValueError("a picture was not read as it was written")
    return "written and read"


def _picture() -> str:
    """A wide matte floor under an even sky reflects the albedo's part of it."""
    floor = Mesh([(-9, 0, -9), (-9, 0, 9), (9, 0, 9), (9, 0, -9)], [(0, 1, 2, 3)])
    scene = Scene([Item(floor, Matte(_ALBEDO))], [Sky(1.0)], Camera((0, 3, 0.1), (0, 0, 0)))
    began = time.monotonic()
    render(scene, PathTrace(1), size=(8, 8), progress=progress())
    ready = time.monotonic()
    image = render(scene, PathTrace(_SAMPLES), size=_SIZE, seed=1, progress=False)
    seconds = time.monotonic() - ready
    level = float(image.channels["colour"].mean())
    if not abs(level - _ALBEDO) < 0.01 * _ALBEDO:
        raise ValueError(f"a picture's brightness is {level:.4f}, but should be {_ALBEDO}")
    width, height = _SIZE
    took = f"{seconds:.2f} s, after {ready - began:.1f} s to get ready"
    return f"{width} × {height} pixels, {_SAMPLES} samples each, in {took}"
