"""Textures that lie nowhere or reflect more light than comes are told, with what mends them; others are not."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from command_line import run
from isophote.errors import IsophoteWarning
from isophote.rendering.oddities import warn_of_oddities
from scenes import plane

PICTURE = iso.ImageTexture(np.random.default_rng(1).random((4, 4, 3)).astype(np.float32))
BRIGHT = iso.ImageTexture(np.full((2, 2, 3), 2.5, np.float32))
UVS = ((0, 0), (0, 1), (1, 1), (1, 0))
WITH_UVS = plane(2).with_(attributes={"uv": UVS})
CAMERA = iso.Camera((0, 3, 0.1), (0, 0, 0))


def scene(*items: iso.Item) -> iso.Scene:
    return iso.Scene(items, [iso.Sky(1.0)], CAMERA)


@pytest.mark.parametrize(
    "item",
    [
        iso.Item(plane(2), iso.Matte(PICTURE)),
        iso.Item(iso.sphere(1) | iso.box(1), iso.Matte(PICTURE)),
        iso.Item(plane(2), iso.Principled(normal_texture=iso.ImageTexture(PICTURE.pixels, "linear"))),
        iso.Item(plane(2), iso.Mix(iso.Matte(), iso.Coated(iso.Metal("gold", (0.2, PICTURE))))),
        iso.Item(plane(2), iso.Matte(iso.Checker(space="uv"))),
        iso.Item(plane(2), iso.Matte(iso.Placed(PICTURE, space="uv"))),
        iso.Item(plane(2), iso.Emitter(1, body=iso.Matte(PICTURE))),
    ],
)
def test_textures_without_coordinates_are_told(item: iso.Item) -> None:
    with pytest.warns(IsophoteWarning, match=r'items\[1\] has a texture .* "uv", which iso.unwrap'):
        warn_of_oddities(scene(iso.Item(WITH_UVS, iso.Matte(PICTURE)), item))


@pytest.mark.parametrize(
    "material",
    [
        iso.Matte(BRIGHT),
        iso.Phong(0.2, BRIGHT),
        iso.Mix(iso.Matte(0.2), iso.Plastic(BRIGHT)),
        iso.Principled(colour_texture=BRIGHT),
        iso.Emitter(1, body=iso.OrenNayar(BRIGHT)),
    ],
)
def test_textures_that_reflect_too_much_are_told(material: iso.Material) -> None:
    with pytest.warns(IsophoteWarning, match=r"values up to 2(\.5)?, which reflects more light than comes: scale it"):
        warn_of_oddities(scene(iso.Item(WITH_UVS, material)))


def test_several_are_one_warning_that_names_the_first() -> None:
    items = [iso.Item(plane(2), iso.Matte(PICTURE), name=f"number {k}") for k in range(3)]
    with pytest.warns(IsophoteWarning) as told:
        warn_of_oddities(scene(*items))
    assert [str(warning.message)[:51] for warning in told] == ["items[0], 'number 0', and 2 others have a texture t"]


@pytest.mark.parametrize(
    "item",
    [
        iso.Item(WITH_UVS, iso.Matte(PICTURE)),
        iso.Item(iso.sphere(1), iso.Matte(PICTURE)),
        iso.Item(plane(2), iso.Matte(iso.ImageTexture.missing("gone.png"))),
        iso.Item(plane(2), iso.Matte(iso.Checker())),
        iso.Item(plane(2), iso.Matte(iso.Placed(PICTURE))),
        iso.Item(WITH_UVS, iso.Principled(0.4, colour_texture=BRIGHT)),
        iso.Item(WITH_UVS, iso.Principled(emission=3, emission_texture=BRIGHT)),
        iso.Item(plane(2), iso.Matte("tomato")),
    ],
)
def test_what_is_well_is_not_told(item: iso.Item) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", IsophoteWarning)
        warn_of_oddities(scene(item))


@pytest.mark.parametrize(
    "method",
    [iso.PathTrace(samples=1), iso.RayTrace(samples=1), iso.SphereTrace(), iso.Radiosity(patch=1.0, samples=1)],
)
def test_every_method_that_shows_materials_tells(method: object) -> None:
    with pytest.warns(IsophoteWarning, match="texture coordinates") as told:
        iso.render(scene(iso.Item(plane(2), iso.Matte(PICTURE))), method, size=(2, 2), progress=False)
    here = [warning for warning in told if "texture coordinates" in str(warning.message)]
    assert len(here) == 1
    assert here[0].filename == __file__


def test_on_the_command_line_it_is_one_line(tmp_path: Path) -> None:
    text = (
        "import isophote as iso, numpy as np\n"
        "mesh = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])\n"
        "shape = iso.Item(mesh, iso.Matte(iso.ImageTexture(np.ones((4, 4, 3), np.float32))))\n"
    )
    (tmp_path / "bare.py").write_text(text)
    for method in ("path", "ray"):
        made = run(
            "render",
            tmp_path / "bare.py",
            "-o",
            tmp_path / "out.png",
            "--size",
            "4x4",
            "--samples",
            1,
            "--method",
            method,
        )
        assert made.exit_code == 0
        assert made.stderr.count("isophote: warning: items[0] has a texture") == 1
