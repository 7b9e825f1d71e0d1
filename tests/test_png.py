"""PNG: the rounding of the sRGB curve, the texts, and files that are whole or not there."""

from __future__ import annotations

import struct
from decimal import Decimal, getcontext
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image as Pillow

from isophote import FileError, IsophoteWarning
from isophote.io.png import display_bytes, encode_png, write_png
from isophote.scene.colour import linear_to_srgb, srgb_to_linear

GREY = np.full((2, 3, 3), 0.5, np.float32)


def decoded(data: bytes) -> Pillow.Image:
    picture = Pillow.open(BytesIO(data))
    picture.load()
    return picture


def chunks(data: bytes) -> list[tuple[bytes, bytes]]:
    found, at = [], 8
    while at < len(data):
        (size,) = struct.unpack_from(">I", data, at)
        found.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + size]))
        at += 12 + size
    return found


def exact_level(value: float) -> int:
    """The nearest level, by 50 digits."""
    getcontext().prec = 50
    x = Decimal(value)
    encoded = x * Decimal("12.92") if x <= Decimal("0.0031308") else Decimal("1.055") * x ** (1 / Decimal("2.4"))
    encoded -= 0 if x <= Decimal("0.0031308") else Decimal("0.055")
    return int((encoded * 255 + Decimal("0.5")).to_integral_value("ROUND_FLOOR"))


def test_levels_change_at_the_very_float_where_the_curve_says() -> None:
    edges = srgb_to_linear((np.arange(255) + 0.5) / 255).astype(np.float32)
    values = np.concatenate([np.nextafter(edges, 0), edges, np.nextafter(edges, 1)]).astype(np.float32)
    levels = display_bytes(np.repeat(values[None, :, None], 3, axis=2))[0, :, 0]
    assert levels.tolist() == [exact_level(float(value)) for value in values]


def test_every_level_survives_decoding_and_encoding() -> None:
    linear = srgb_to_linear(np.arange(256) / 255).astype(np.float32)
    levels = display_bytes(np.repeat(linear[None, :, None], 3, axis=2))
    assert levels[0, :, 1].tolist() == list(range(256))


@given(st.floats(0, 1), st.floats(0, 1))
def test_the_curve_rises_and_is_undone(a: float, b: float) -> None:
    low, high = sorted((a, b))
    encoded = linear_to_srgb(np.array([low, high]))
    assert encoded[0] <= encoded[1]
    assert np.allclose(srgb_to_linear(encoded), [low, high], rtol=1e-6, atol=1e-9)


def test_values_beyond_the_range_are_clipped() -> None:
    levels = display_bytes(np.array([[[-1.0, 2.0, np.inf], [-np.inf, 0.0, 1.0]]]))
    assert levels.tolist() == [[[0, 255, 255], [0, 0, 255]]]


def test_what_is_no_number_shows_as_magenta_and_warns() -> None:
    colour = GREY.copy()
    colour[1, 2, 0] = np.nan
    with pytest.warns(IsophoteWarning, match=r"1 pixels .* x=2, y=1"):
        levels = display_bytes(colour)
    assert levels[1, 2].tolist() == [255, 0, 255]
    assert levels[0, 0].tolist() == [188, 188, 188]


def test_alpha_is_stored_without_the_curve() -> None:
    picture = decoded(encode_png(np.full((1, 1, 4), 0.5)))
    assert picture.mode == "RGBA"
    assert picture.getpixel((0, 0)) == (188, 188, 188, 128)


def test_texts_and_colour_space_stand_before_the_pixels() -> None:
    texts = {"Software": "Isophote", "method": "PathTrace(samples=64)", "title": "größe", "note": "球"}
    data = encode_png(GREY, texts)
    assert decoded(data).text == texts
    kinds = [kind for kind, _ in chunks(data)]
    assert kinds.index(b"sRGB") < kinds.index(b"IDAT")
    assert kinds.count(b"tEXt") == 3
    assert kinds.count(b"iTXt") == 1


@given(
    st.dictionaries(
        st.text(st.characters(codec="latin-1", exclude_characters="\0"), min_size=1, max_size=79),
        st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=40),
    )
)
def test_all_texts_that_are_accepted_come_back(texts: dict[str, str]) -> None:
    assert decoded(encode_png(GREY, texts)).text == texts


@pytest.mark.parametrize("key", ["", "x" * 80, "球", "a\0b"])
def test_keys_that_png_cannot_hold_are_refused(key: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="metadata"):
        write_png(tmp_path / "a.png", GREY, {key: "x"})
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("shape", [(2, 3), (2, 3, 1), (2, 3, 5), (0, 3, 3), (2, 0, 3), (3,)])
def test_other_shapes_are_refused(shape: tuple[int, ...], tmp_path: Path) -> None:
    with pytest.raises(FileError, match="picture"):
        write_png(tmp_path / "a.png", np.zeros(shape))


def test_a_file_is_replaced_and_nothing_else_is_left(tmp_path: Path) -> None:
    target = tmp_path / "a.png"
    target.write_bytes(b"old")
    (tmp_path / "link.png").symlink_to(target)
    write_png(tmp_path / "link.png", GREY)
    assert decoded(target.read_bytes()).size == (3, 2)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.png", "link.png"]
    assert (tmp_path / "link.png").is_symlink()


def test_places_that_cannot_be_written_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "no" / "a.png", tmp_path, Path("/dev/full"), "a\0b.png"):
        with pytest.raises(FileError, match="cannot be written"):
            write_png(path, GREY)
