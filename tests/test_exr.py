"""EXR: channels under the names that other programs know, exact ids, and damaged files that are refused."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from isophote import Error, FileError, IsophoteWarning
from isophote.io.exr import read_exr, write_exr
from isophote.io.exr_names import joined, split
from mesh_files import MODELS

HEIGHT, WIDTH = 5, 7
RNG = np.random.default_rng(7)
CHANNELS: dict[str, np.ndarray[Any, Any]] = {
    "colour": RNG.random((HEIGHT, WIDTH, 3)).astype(np.float32) * 1e5,
    "depth": RNG.random((HEIGHT, WIDTH)).astype(np.float32),
    "distance": np.where(RNG.random((HEIGHT, WIDTH)) < 0.3, np.inf, 2.5).astype(np.float32),
    "normal": RNG.random((HEIGHT, WIDTH, 3)).astype(np.float32),
    "albedo": RNG.random((HEIGHT, WIDTH, 3)).astype(np.float32),
    "uv": RNG.random((HEIGHT, WIDTH, 2)).astype(np.float32),
    "item": RNG.integers(-1, 9, (HEIGHT, WIDTH)).astype(np.int32),
    "primitive": RNG.integers(2**24, 2**31 - 1, (HEIGHT, WIDTH)).astype(np.int32),
    "variance": RNG.random((HEIGHT, WIDTH, 3)).astype(np.float32),
}
NAMES = (
    "A B G R Z albedo.B albedo.G albedo.R distance item normal.X normal.Y normal.Z primitive uv.U uv.V"
    " variance.B variance.G variance.R"
)
# The package's own library says on stderr what is wrong with a file; that is not the tests' matter.
FUZZ = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture
def valid(tmp_path: Path) -> bytes:
    write_exr(tmp_path / "valid.exr", CHANNELS, {"method": "path"})
    return (tmp_path / "valid.exr").read_bytes()


def same(a: dict[str, Any], b: dict[str, Any]) -> bool:
    return a.keys() == b.keys() and all(
        a[k].dtype == b[k].dtype and np.array_equal(a[k], b[k], equal_nan=a[k].dtype.kind == "f") for k in a
    )


def test_everything_comes_back_bit_for_bit(tmp_path: Path) -> None:
    metadata = {
        "method": "PathTrace(samples=64)",
        "seed": "1",
        "type": "final",
        "name": "x",
        "note": "größe 球",
        "e": "",
    }
    write_exr(tmp_path / "a.exr", CHANNELS, metadata)
    back = read_exr(tmp_path / "a.exr")
    assert same(back.channels, CHANNELS)
    assert back.metadata == metadata


def test_other_programs_find_the_usual_names_and_types(tmp_path: Path) -> None:
    write_exr(tmp_path / "a.exr", {**CHANNELS, "alpha": np.ones((HEIGHT, WIDTH))})
    found = OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True).channels()
    assert sorted(found) == sorted(NAMES.split())
    assert found["R"].pixels.dtype == np.float32
    assert found["item"].pixels.dtype == np.uint32
    assert np.array_equal(found["G"].pixels, CHANNELS["colour"][..., 1])
    assert np.array_equal(found["primitive"].pixels, CHANNELS["primitive"])
    assert (found["item"].pixels[CHANNELS["item"] == -1] == 2**32 - 1).all()


def test_half_floats_keep_finite_values_finite(tmp_path: Path) -> None:
    colour = np.array([[[1e9, 0.1, -1e9], [np.inf, np.nan, 65504.0]]], np.float32)
    write_exr(tmp_path / "a.exr", {"colour": colour, "depth": np.array([[1e9, 0.1]])}, half=True)
    back = read_exr(tmp_path / "a.exr").channels
    assert back["colour"][0, 0].tolist() == [65504.0, float(np.float16(0.1)), -65504.0]
    assert np.array_equal(back["colour"][0, 1], [np.inf, np.nan, 65504.0], equal_nan=True)
    assert back["depth"].tolist() == np.array([[1e9, 0.1]], np.float32).tolist()


@given(st.dictionaries(st.sampled_from([*CHANNELS, "alpha", "shadow", "light.key", "a.b.c"]), st.integers(1, 4)))
def test_names_are_undone_wherever_they_are_given(wanted: dict[str, int]) -> None:
    fixed = {"colour": 3, "alpha": 1, "depth": 1, "uv": 2, "normal": 3}
    channels = {
        name: np.zeros((1, 2) if fixed.get(name, count) == 1 else (1, 2, fixed.get(name, count)))
        for name, count in wanted.items()
    }
    back = joined(split(channels))
    assert {name: array.shape for name, array in back.items()} == {
        name: array.shape for name, array in channels.items()
    }


@pytest.mark.parametrize(
    ("channels", "reason"),
    [
        ({}, "one size"),
        ({"colour": np.zeros((2, 3, 4))}, '"colour" must be'),
        ({"colour": np.zeros((2, 3, 3)), "depth": np.zeros((3, 2))}, "one size"),
        ({"depth": np.zeros((0, 3))}, "needs pixels"),
        ({"x": np.zeros((2, 3, 5))}, '"x" must be'),
        ({"x": np.zeros(3)}, '"x" must be'),
        ({"x": np.zeros((2, 2), complex)}, "must hold numbers"),
        ({"item": np.full((2, 2), 2**32)}, "whole numbers outside"),
        ({"item": np.full((2, 2), -2)}, "whole numbers outside"),
        ({"R": np.zeros((2, 2)), "colour": np.zeros((2, 2, 3))}, 'both be called "R"'),
        ({"": np.zeros((2, 2))}, "1 to 255 bytes"),
    ],
)
def test_what_cannot_be_stored_is_refused(channels: dict[str, Any], reason: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=reason):
        write_exr(tmp_path / "a.exr", channels)
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be written"):
        write_exr(tmp_path / "no" / "a.exr", CHANNELS)


@pytest.mark.skipif(not MODELS.exists(), reason="the shared models are not here")
def test_tiled_and_compressed_files_of_others_are_read_at_full_resolution() -> None:
    latlong = read_exr(MODELS / "env/OrientationLatLong.exr")
    assert latlong.channels["colour"].shape == (512, 1024, 3)
    assert latlong.channels["alpha"].min() == 1
    assert latlong.metadata["owner"] == "Copyright 2005 Industrial Light & Magic"
    chart = read_exr(MODELS / "env/GammaChart.exr").channels["colour"]
    assert chart.shape == (800, 800, 3)
    assert chart.min() == 0
    assert chart.max() == 1


def test_luminance_alone_is_a_grey_colour(tmp_path: Path) -> None:
    write_exr(tmp_path / "a.exr", {"Y": CHANNELS["depth"]})
    assert np.array_equal(read_exr(tmp_path / "a.exr").channels["colour"][..., 2], CHANNELS["depth"])


def test_only_the_first_of_several_parts_is_read(tmp_path: Path) -> None:
    parts = [OpenEXR.Part({}, {"Z": np.full((2, 2), float(i), np.float32)}, f"part{i}") for i in range(2)]
    OpenEXR.File(parts).write(str(tmp_path / "a.exr"))
    with pytest.warns(IsophoteWarning, match="first of its 2 parts"):
        assert read_exr(tmp_path / "a.exr").channels["depth"].max() == 0


def test_subsampled_channels_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    write_exr(path, {"RY": np.zeros((4, 4), np.float32)})
    entry = b"RY\0" + struct.pack("<iBBBB", 2, 0, 0, 0, 0)
    path.write_bytes(path.read_bytes().replace(entry + struct.pack("<ii", 1, 1), entry + struct.pack("<ii", 2, 2)))
    with pytest.raises(FileError, match="subsampled"):
        read_exr(path)


@pytest.mark.parametrize("corner", [(2**31 - 2, 4), (6, 2**31 - 2), (10**6, 10**6), (-5, 4)])
def test_declared_sizes_are_checked_against_the_bytes(valid: bytes, corner: tuple[int, int], tmp_path: Path) -> None:
    at = valid.index(b"dataWindow\0box2i\0") + 17 + 4
    path = tmp_path / "a.exr"
    path.write_bytes(valid[: at + 8] + struct.pack("<ii", *corner) + valid[at + 16 :])
    with pytest.raises(FileError):
        read_exr(path)


def test_a_file_cut_short_is_refused_and_nothing_is_printed(
    valid: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.exr"
    for size in (0, 3, 4, 100, len(valid) // 2, len(valid) - 1):
        path.write_bytes(valid[:size])
        with pytest.raises(FileError):
            read_exr(path)
    assert capsys.readouterr().out == ""


@FUZZ
@given(data=st.data())
def test_damaged_files_give_a_picture_or_an_error(valid: bytes, data: st.DataObject, tmp_path: Path) -> None:
    damaged = bytearray(valid)
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, len(damaged) - 1))
        number = st.sampled_from([0, 1, -1, 2**31 - 1, -(2**31), 2**24, 10**5])
        damaged[at : at + 4] = data.draw(st.binary(min_size=1, max_size=4) | number.map(lambda n: struct.pack("<i", n)))
    path = tmp_path / "fuzz.exr"
    path.write_bytes(damaged[: data.draw(st.integers(0, 2 * len(damaged)))])
    try:
        picture = read_exr(path)
    except Error:
        return
    assert all(array.size for array in picture.channels.values())


@FUZZ
@given(noise=st.binary(max_size=400))
def test_noise_is_refused(noise: bytes, tmp_path: Path) -> None:
    path = tmp_path / "fuzz.exr"
    path.write_bytes(b"\x76\x2f\x31\x01" + noise)
    with pytest.raises(FileError):
        read_exr(path)
