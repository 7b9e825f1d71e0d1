"""Textures from files: every kind of pixel, Radiance in all its codes, and damaged files that are refused."""

from __future__ import annotations

import struct
import time
import zlib
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image as Pillow

from isophote import Error, FileError, ImageTexture, IsophoteWarning, SceneError, load_texture
from isophote.io.exr import write_exr
from isophote.io.radiance import decode_radiance
from isophote.io.texture_file import decode_picture
from mesh_files import MODELS

Bytes = np.ndarray[Any, np.dtype[np.uint8]]
HEAD = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"
needs_models = pytest.mark.skipif(not MODELS.exists(), reason="the shared models are not here")
FUZZ = settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def stored(picture: Pillow.Image, kind: str = "PNG", **options: Any) -> bytes:
    buffer = BytesIO()
    picture.save(buffer, kind, **options)
    return buffer.getvalue()


def encoded(pixels: Bytes, runs: bool) -> bytes:
    """A Radiance file of pixels (h, w, 4), by scanlines in the new run-length code, or flat."""
    height, width = pixels.shape[:2]
    body = HEAD + f"-Y {height} +X {width}\n".encode()
    if not runs:
        return body + pixels.tobytes()
    for row in pixels:
        body += bytes([2, 2, width >> 8, width & 255])
        for plane in row.T:
            body += _packed(plane.tobytes())
    return body


def _packed(plane: bytes) -> bytes:
    packed, at = b"", 0
    while at < len(plane):
        end = at
        while end < len(plane) and end - at < 127 and plane[end] == plane[at]:
            end += 1
        packed += bytes([128 + end - at, plane[at]]) if end - at > 1 else bytes([1, plane[at]])
        at = end
    return packed


def colours(pixels: Bytes) -> Any:
    """The definition: mantissas times a power of two; exponent 0 is black."""
    exponents = pixels[..., 3:].astype(float)
    return np.where(exponents > 0, pixels[..., :3] * 2.0 ** (exponents - 136), 0)


rgbe = st.tuples(st.integers(1, 5), st.integers(1, 20)).flatmap(
    lambda size: st.binary(min_size=4 * size[0] * size[1], max_size=4 * size[0] * size[1]).map(
        lambda data: np.frombuffer(data, np.uint8).reshape(*size, 4).copy()
    )
)


@given(rgbe, st.booleans())
def test_radiance_pixels_are_what_their_definition_says(pixels: Bytes, runs: bool) -> None:
    # A flat pixel of ones is no pixel but a repeat, and one that starts 2, 2 begins a scanline.
    pixels[..., 0] |= 4
    runs = runs and pixels.shape[1] >= 8
    assert np.array_equal(decode_radiance(encoded(pixels, runs)), colours(pixels))


def test_old_runs_repeat_the_pixel_before() -> None:
    data = HEAD + b"-Y 2 +X 150\n" + bytes([9, 8, 7, 128, 1, 1, 1, 42, 1, 1, 1, 1, 5, 5, 5, 136])
    pixels = decode_radiance(data)
    assert pixels.shape == (2, 150, 3)
    flat = pixels.reshape(-1, 3)
    assert (flat[:299] == np.array([9, 8, 7]) / 256).all()
    assert (flat[299] == 5).all()


def test_exposures_are_divided_out() -> None:
    data = b"#?RGBE\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\nEXPOSURE= 4.0\n\n-Y 1 +X 1\n" + bytes([8, 16, 24, 136])
    assert decode_radiance(data).tolist() == [[[1, 2, 3]]]


@pytest.mark.parametrize(
    ("line", "rows"),
    [
        ("-Y 2 +X 3", [[0, 1, 2], [3, 4, 5]]),
        ("+Y 2 +X 3", [[3, 4, 5], [0, 1, 2]]),
        ("-Y 2 -X 3", [[2, 1, 0], [5, 4, 3]]),
        ("+X 2 -Y 3", [[0, 3], [1, 4], [2, 5]]),
        ("-X 2 +Y 3", [[5, 2], [4, 1], [3, 0]]),
    ],
)
def test_pictures_stand_upright_whatever_their_order(line: str, rows: list[list[int]]) -> None:
    pixels = np.zeros((6, 4), np.uint8)
    pixels[:, 0], pixels[:, 3] = np.arange(6) + 10, 136
    data = HEAD + line.encode() + b"\n" + pixels.tobytes()
    assert (decode_radiance(data)[..., 0] - 10).tolist() == rows


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"#?RADIANCE\n", "no start or no end"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n" + bytes(4), "32-bit_rle_xyze"),
        (HEAD + b"-Y 1 -Y 1\n" + bytes(4), "no resolution"),
        (HEAD + b"-Y 0 +X 1\n", "1 by 0"),
        (HEAD + b"-Y 999999999 +X 999999999\n", "more than its"),
        (HEAD + b"-Y 2 +X 2\n" + bytes(15), "holds 3 of 4 pixels"),
        (HEAD + b"-Y 1 +X 2\n" + bytes([1, 1, 1, 2]), "before there is one"),
        (HEAD + b"-Y 1 +X 8\n" + bytes([2, 2, 0, 8, 0, 0]), "empty run"),
        (HEAD + b"-Y 1 +X 8\n" + bytes([2, 2, 0, 8, 255, 7]), "beyond the end"),
        (HEAD + b"-Y 1 +X 8\n" + bytes([2, 2, 0, 8, 136, 7]), "ends within"),
        (b"#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\n" + bytes(4), "exposure"),
    ],
)
def test_damaged_radiance_pictures_are_refused(data: bytes, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        decode_radiance(data)


@needs_models
def test_a_studio_of_half_a_million_pixels_is_read_fast() -> None:
    start = time.perf_counter()
    studio = load_texture(MODELS / "env/studio.hdr")
    assert time.perf_counter() - start < 0.5
    assert (studio.size, studio.channels, studio.colour_space) == ((1024, 512), 3, "linear")
    assert studio.pixels.dtype == np.float32


@needs_models
@pytest.mark.parametrize(
    ("name", "size", "channels"),
    [
        ("env/OrientationLatLong.exr", (1024, 512), 4),
        ("env/GammaChart.exr", (800, 800), 3),
        ("textured/fuze uv.jpg", (1024, 1024), 3),
        ("textured/normalmap_0006.jpg", (236, 236), 3),
        ("textured/spot/spot_texture.png", (1024, 1024), 3),
        ("gltf/TwoSidedPlane/TwoSidedPlane_Normal.png", (256, 256), 4),
    ],
)
def test_files_of_others_are_read(name: str, size: tuple[int, int], channels: int) -> None:
    texture = load_texture(MODELS / name, wrap="clamp")
    assert (texture.size, texture.channels) == (size, channels)
    assert texture.colour_space == ("linear" if name.endswith(".exr") else "srgb")
    assert texture.name == Path(name).name
    assert texture.wrap == "clamp"


def test_every_kind_of_png_pixel() -> None:
    grey = np.arange(12, dtype=np.uint8).reshape(3, 4) * 20
    colour = np.stack([grey, grey + 1, grey + 2], axis=2)
    alpha = np.dstack([colour, grey])
    for pixels in (grey, colour, alpha):
        found, space, _ = decode_picture(stored(Pillow.fromarray(pixels)), "x.png")
        assert np.array_equal(found, pixels)
        assert (found.dtype, space) == (np.uint8, "srgb")


def test_palettes_become_colours_and_transparency_a_fourth_channel() -> None:
    picture = Pillow.new("P", (2, 1))
    picture.putpalette([255, 0, 0, 0, 0, 255])
    picture.putpixel((1, 0), 1)
    assert decode_picture(stored(picture), "x.png").pixels.tolist() == [[[255, 0, 0], [0, 0, 255]]]
    clear = decode_picture(stored(picture, transparency=1), "x.png").pixels
    assert clear.tolist() == [[[255, 0, 0, 255], [0, 0, 255, 0]]]
    both = Pillow.fromarray(np.array([[[200, 100]]], np.uint8), "LA")
    assert decode_picture(stored(both), "x.png").pixels.tolist() == [[[200, 200, 200, 100]]]
    bits = Pillow.fromarray(np.array([[0, 255]], np.uint8)).convert("1")
    assert decode_picture(stored(bits), "x.png").pixels.tolist() == [[0, 255]]


def test_grey_of_16_bits_keeps_its_levels() -> None:
    levels = np.array([[0, 1, 40000, 65535]], np.uint16)
    pixels, space, _ = decode_picture(stored(Pillow.fromarray(levels)), "x.png")
    assert (pixels.dtype, space) == (np.float32, "srgb")
    assert np.array_equal(np.rint(pixels * 65535), levels)


def test_floats_are_linear_and_the_colour_space_can_be_said(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    Pillow.fromarray(np.array([[0.25, 7.5]], np.float32)).save(path)
    assert load_texture(path) == ImageTexture(np.array([[0.25, 7.5]], np.float32), "linear", name="a.tif")
    (tmp_path / "n.png").write_bytes(stored(Pillow.new("RGB", (1, 1), (128, 128, 255))))
    assert load_texture(tmp_path / "n.png", colour_space="linear").colour_space == "linear"
    with pytest.raises(SceneError, match="wrap"):
        load_texture(path, wrap="tile")


def test_values_that_are_not_finite_are_replaced_with_a_warning(tmp_path: Path) -> None:
    colour = np.array([[[np.nan, np.inf, 3.0], [-np.inf, 1.0, 2.0]]], np.float32)
    write_exr(tmp_path / "a.exr", {"colour": colour})
    with pytest.warns(IsophoteWarning, match="3 values"):
        texture = load_texture(tmp_path / "a.exr")
    assert texture.pixels.tolist() == [[[0, 3, 3], [-3, 1, 2]]]


def test_an_exr_without_colour_is_refused_unless_it_has_one_channel(tmp_path: Path) -> None:
    write_exr(tmp_path / "z.exr", {"depth": np.ones((2, 2))})
    assert load_texture(tmp_path / "z.exr").channels == 1
    write_exr(tmp_path / "n.exr", {"normal": np.ones((2, 2, 3)), "depth": np.ones((2, 2))})
    with pytest.raises(FileError, match="depth, normal"):
        load_texture(tmp_path / "n.exr")


def png_header(width: int, height: int) -> bytes:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


@pytest.mark.parametrize("size", [(9000, 9000), (30000, 30000), (2**31 - 1, 2**31 - 1)])
def test_declared_sizes_are_checked_against_the_bytes(size: tuple[int, int], tmp_path: Path) -> None:
    (tmp_path / "bomb.png").write_bytes(png_header(*size))
    with pytest.raises(FileError):
        load_texture(tmp_path / "bomb.png")


def test_what_is_no_picture_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("hello")
    for path in (tmp_path / "a.png", tmp_path / "none.png", tmp_path):
        with pytest.raises(FileError):
            load_texture(path)
    with pytest.raises(FileError, match=r"images\[3\]"):
        decode_picture(b"hello", "a.glb", "images[3]")


SEEDS = [
    stored(Pillow.effect_noise((9, 7), 50)),
    stored(Pillow.effect_noise((9, 7), 50).convert("RGB"), "JPEG"),
    stored(Pillow.effect_noise((9, 7), 50).convert("P"), "GIF"),
    stored(Pillow.effect_noise((9, 7), 50).convert("RGB"), "TIFF"),
    stored(Pillow.effect_noise((9, 7), 50).convert("RGB"), "WEBP"),
    encoded(np.full((3, 9, 4), 130, np.uint8), runs=True),
    encoded(np.full((3, 9, 4), 130, np.uint8), runs=False),
]


@FUZZ
@given(seed=st.sampled_from(SEEDS), data=st.data())
@pytest.mark.filterwarnings("ignore")
def test_damaged_files_give_a_texture_or_an_error(seed: bytes, data: st.DataObject, tmp_path: Path) -> None:
    damaged = bytearray(seed)
    for _ in range(data.draw(st.integers(1, 5))):
        at = data.draw(st.integers(0, len(damaged) - 1))
        damaged[at : at + 4] = data.draw(st.binary(max_size=5))
    path = tmp_path / "fuzz"
    path.write_bytes(damaged[: data.draw(st.integers(0, 2 * len(seed)))])
    try:
        texture = load_texture(path)
    except Error:
        return
    assert texture.pixels.size


@FUZZ
@given(
    magic=st.sampled_from([b"", HEAD, b"#?RGBE\n\n", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"II*\0"]),
    noise=st.binary(max_size=200),
)
@pytest.mark.filterwarnings("ignore")
def test_noise_gives_a_texture_or_an_error(magic: bytes, noise: bytes, tmp_path: Path) -> None:
    path = tmp_path / "fuzz.tga"
    path.write_bytes(magic + noise)
    try:
        texture = load_texture(path)
    except Error:
        return
    assert texture.pixels.size
