"""Pictures as values: checked channels, equality by content, saving and loading."""

from __future__ import annotations

import pickle
import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pillow

from isophote import FileError, Image, RenderError, load_image, save
from isophote.io.exr import write_exr

HEIGHT, WIDTH = 4, 6
RNG = np.random.default_rng(3)
CHANNELS: dict[str, Any] = {
    "colour": RNG.random((HEIGHT, WIDTH, 3)),
    "depth": np.where(RNG.random((HEIGHT, WIDTH)) < 0.2, np.inf, 3.0),
    "normal": RNG.random((HEIGHT, WIDTH, 3)),
    "uv": RNG.random((HEIGHT, WIDTH, 2)),
    "item": RNG.integers(-1, 5, (HEIGHT, WIDTH)),
    "primitive": RNG.integers(0, 2**31 - 1, (HEIGHT, WIDTH)),
    "variance": RNG.random((HEIGHT, WIDTH, 3)),
    "shadow": RNG.random((HEIGHT, WIDTH)),
}
METADATA = {"Software": "Isophote", "method": "PathTrace(samples=64)", "seed": "1"}
PICTURE = Image(CHANNELS, METADATA)


def test_channels_have_their_types() -> None:
    assert PICTURE.size == (WIDTH, HEIGHT)
    assert {array.dtype for name, array in PICTURE.channels.items() if name not in ("item", "primitive")} == {
        np.dtype(np.float32)
    }
    assert PICTURE.channels["item"].dtype == np.int32
    assert np.array_equal(PICTURE.channels["primitive"], CHANNELS["primitive"])


def test_nobody_can_change_a_picture() -> None:
    given = np.zeros((2, 2, 3), np.float32)
    thin = np.zeros((2, 2, 1), np.float32)
    picture = Image({"colour": given, "depth": thin})
    given[0], thin[0] = 1, 1
    assert picture.channels["colour"].max() == 0
    assert picture.channels["depth"].max() == 0
    with pytest.raises(ValueError, match="read-only"):
        picture.channels["colour"][0] = 1
    with pytest.raises(TypeError):
        picture.channels["colour"] = given  # type: ignore[index]


def test_pictures_are_equal_by_content() -> None:
    twin = Image({name: np.array(array) for name, array in CHANNELS.items()}, dict(METADATA))
    assert twin == PICTURE
    assert hash(PICTURE) == hash(twin)
    assert twin.with_(metadata={}) != PICTURE
    brighter = twin.with_(channels={**twin.channels, "colour": twin.channels["colour"] + 1})
    assert brighter != PICTURE
    assert pickle.loads(pickle.dumps(PICTURE)) == PICTURE
    undefined = Image({"colour": np.full((1, 1, 3), np.nan)})
    assert undefined == Image({"colour": np.full((1, 1, 3), np.nan)})


@pytest.mark.parametrize(
    ("channels", "reason"),
    [
        ({}, '"colour" in it'),
        ({"colour": np.zeros((2, 2))}, r"\(h, w, 3\)"),
        ({"colour": np.zeros((0, 2, 3))}, "one pixel or more"),
        ({"colour": np.zeros((2, 2, 3)), "depth": np.zeros((2, 3))}, "one size"),
        ({"colour": np.zeros((2, 2, 3)), "uv": np.zeros((2, 2, 3))}, r"\(h, w, 2\)"),
        ({"colour": np.zeros((2, 2, 3)), "item": np.zeros((2, 2))}, "whole numbers"),
        ({"colour": np.zeros((2, 2, 3)), "item": np.full((2, 2), 2**31)}, "32 bits"),
        ({"colour": np.zeros((2, 2, 3)), "x": np.zeros((2, 2, 5))}, "up to 4"),
        ({"colour": np.full((2, 2, 3), "a")}, "numbers"),
    ],
)
def test_what_is_no_picture_is_refused(channels: dict[str, Any], reason: str) -> None:
    with pytest.raises(RenderError, match=reason):
        Image(channels)


def test_arrays_and_notebooks_get_the_colour() -> None:
    assert np.array_equal(np.asarray(PICTURE), PICTURE.channels["colour"])
    assert np.asarray(PICTURE, dtype=np.float64).dtype == np.float64
    copy = np.array(PICTURE)
    copy[0] = 9
    assert PICTURE.channels["colour"].max() < 1
    shown = Pillow.open(BytesIO(PICTURE._repr_png_()))
    assert shown.size == (WIDTH, HEIGHT)
    assert repr(PICTURE).startswith("<Image: 6 by 4; colour, depth")


def test_an_exr_gives_everything_back(tmp_path: Path) -> None:
    save(PICTURE, tmp_path / "a.exr")
    assert load_image(tmp_path / "a.exr") == PICTURE


def test_a_png_gives_colour_and_metadata_back(tmp_path: Path) -> None:
    PICTURE.save(tmp_path / "a.png")
    first = load_image(tmp_path / "a.png")
    assert first.metadata == METADATA
    assert np.abs(np.asarray(first) - np.asarray(PICTURE)).max() < 0.005
    first.save(tmp_path / "b.png")
    assert load_image(tmp_path / "b.png") == first
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_transparency_survives_a_png(tmp_path: Path) -> None:
    alpha = np.linspace(0, 1, 256).reshape(1, 256)
    Image({"colour": np.zeros((1, 256, 3)), "alpha": alpha}).save(tmp_path / "a.png")
    assert np.allclose(load_image(tmp_path / "a.png").channels["alpha"], alpha, atol=1e-7)


@pytest.mark.parametrize("ending", [".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".PNG"])
def test_other_endings_hold_the_colour(ending: str, tmp_path: Path) -> None:
    smooth = Image({"colour": np.full((16, 16, 3), 0.2)})
    smooth.save(tmp_path / f"a{ending}")
    assert np.abs(np.asarray(load_image(tmp_path / f"a{ending}")) - 0.2).max() < 0.01


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r'"\.xyz" is no ending'):
        PICTURE.save(tmp_path / "a.xyz")
    with pytest.raises(FileError, match="without options"):
        save(PICTURE, tmp_path / "a.png", quality=3)
    with pytest.raises(FileError, match="cannot be written"):
        PICTURE.save(tmp_path / "no" / "a.jpg")
    write_exr(tmp_path / "z.exr", {"depth": np.ones((2, 2))})
    with pytest.raises(FileError, match="depth"):
        load_image(tmp_path / "z.exr")
    write_exr(tmp_path / "n.exr", {"colour": np.ones((2, 2, 3)), "item": np.ones((2, 2))})
    with pytest.raises(FileError, match="whole numbers"):
        load_image(tmp_path / "n.exr")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["n.exr", "z.exr"]


def test_the_examples_of_the_page_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (Path(__file__).parents[1] / "docs/pictures.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "docs/pictures.md", "exec"), names)
    assert len(blocks) == 4
    assert (tmp_path / "scene.glb").exists()
