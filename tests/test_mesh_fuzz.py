"""Every mesh reader on damaged and invented files: a mesh or an Isophote error, in little memory."""

from __future__ import annotations

import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from isophote import Attribute, Error, FaceLabels, FileError, Mesh
from isophote.io.obj_read import read_obj
from isophote.io.obj_write import encode_obj
from isophote.io.off_read import read_off
from isophote.io.off_write import encode_off
from isophote.io.ply_read import read_ply
from isophote.io.ply_write import encode_ply
from isophote.io.stl_read import read_stl
from isophote.io.stl_write import encode_stl

READERS = {".obj": read_obj, ".off": read_off, ".ply": read_ply, ".stl": read_stl}

_RICH = Mesh(
    np.arange(18).reshape(6, 3) / 7,
    [[0, 1, 2], [2, 3, 4, 5], [0, 2, 4, 3, 1]],
    attributes={
        "normal": Attribute(np.eye(3), np.arange(12) % 3),
        "uv": Attribute(np.arange(12).reshape(6, 2) / 12),
        "colour": Attribute(np.full((6, 3), 0.25, np.float32)),
    },
    labels={
        "material": FaceLabels(("a", "b c"), np.array([0, 1, -1])),
        "group": FaceLabels(("g",), np.array([0, 0, 0])),
    },
)


def _valid() -> dict[str, list[bytes]]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        ply = [
            encode_ply(_RICH, "x", binary=binary, endian=endian)
            for binary in (True, False)
            for endian in ("little", "big")
        ]
        return {
            ".obj": [encode_obj(_RICH, "x")],
            ".off": [encode_off(_RICH, "x")],
            ".ply": ply,
            ".stl": [encode_stl(_RICH, "x", binary=True), encode_stl(_RICH, "x", binary=False)],
        }


VALID = _valid()
# Words that change what the words after them mean, and numbers at the edges.
_WORDS = [
    *(b"v", b"f", b"vt", b"vn", b"g", b"usemtl", b"\\\n", b"#", b"/", b"//", b"\n", b" ", b"\r", b"\0", b"\xff"),
    *(b"OFF", b"COFF", b"STCNOFF", b"ply\n", b"end_header\n", b"element vertex ", b"element face ", b"property list "),
    *(b"property uchar red\n", b"property double x\n", b"format ascii 1.0\n", b"list uchar int vertex_index\n"),
    *(b"solid ", b"facet normal", b"vertex", b"endloop", b"endsolid"),
    *(
        b"0",
        b"-1",
        b"1e309",
        b"nan",
        b"inf",
        b"0.5",
        b"-0",
        b"1e-400",
        b"99999999999999999999",
        b"4294967295",
        b"1" * 400,
    ),
]


@st.composite
def _damaged(draw: st.DrawFn, ending: str) -> bytes:
    """A valid file with bytes changed, taken out, put in, repeated and cut, and with its numbers inflated."""
    data = bytearray(draw(st.sampled_from(VALID[ending])))
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(data)))
        match draw(st.sampled_from(["flip", "cut", "insert", "drop", "repeat", "inflate"])):
            case "flip" if at < len(data):
                data[at] = draw(st.integers(0, 255))
            case "cut":
                del data[at:]
            case "insert":
                data[at:at] = draw(st.sampled_from(_WORDS) | st.binary(max_size=8))
            case "drop":
                del data[at : at + draw(st.integers(1, 20))]
            case "repeat":
                data[at:at] = data[at : at + draw(st.integers(1, 40))] * draw(st.integers(1, 3))
            case "inflate":
                digits = [i for i, byte in enumerate(data) if chr(byte).isdigit()]
                if digits:
                    place = draw(st.sampled_from(digits))
                    data[place : place + 1] = draw(st.sampled_from([b"9" * n for n in (1, 5, 9, 12, 17, 30)]))
    return bytes(data)


def _outcome(ending: str, data: bytes) -> Mesh | Error:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return READERS[ending](Path("x"), data)
        except Error as error:
            return error


def _reads_or_refuses(ending: str, data: bytes) -> None:
    tracemalloc.start()
    try:
        outcome = _outcome(ending, data)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    # The mesh's own checks know no place in the file: readers must have found everything before.
    assert isinstance(outcome, Mesh | FileError)
    assert peak < 1_000_000 + 200 * len(data)


_SETTINGS = settings(max_examples=300, deadline=2000, suppress_health_check=[HealthCheck.too_slow])


@pytest.mark.parametrize("ending", READERS)
@_SETTINGS
@given(data=st.data())
def test_damaged_files(ending: str, data: st.DataObject) -> None:
    _reads_or_refuses(ending, data.draw(_damaged(ending)))


@pytest.mark.parametrize("ending", READERS)
@_SETTINGS
@given(data=st.data())
def test_files_of_known_words_in_any_order(ending: str, data: st.DataObject) -> None:
    own = sorted({word for valid in VALID[ending] for word in valid.split()[:60]})
    words = st.lists(st.sampled_from([*_WORDS, *own]) | st.binary(max_size=4), max_size=60)
    blank = data.draw(st.sampled_from([b" ", b"\n", b"\r\n", b""]))
    start = data.draw(
        st.sampled_from([b"", VALID[ending][0][:60], VALID[ending][-1][:200], b"ply\nformat ascii 1.0\n"])
    )
    _reads_or_refuses(ending, start + blank.join(data.draw(words)))


@pytest.mark.parametrize("ending", READERS)
@_SETTINGS
@given(data=st.binary(max_size=400))
def test_files_of_any_bytes(ending: str, data: bytes) -> None:
    _reads_or_refuses(ending, data)


@pytest.mark.parametrize("ending", READERS)
def test_valid_files_are_read(ending: str) -> None:
    for data in VALID[ending]:
        assert READERS[ending](Path("x"), data).face_count in (3, 6)


@pytest.mark.parametrize("ending", READERS)
@pytest.mark.parametrize(
    "unit", [b"1 ", b"#\n", b"\\\n", b"/", b"v 1 2 3\n", b"g a\n", b"facet normal ", b"3 0 1 2\n", b"\r"]
)
def test_long_files_of_one_thing(ending: str, unit: bytes) -> None:
    for start in (b"", b"OFF\n", b"solid x\n", VALID[".ply"][-1], VALID[".obj"][0]):
        _reads_or_refuses(ending, start + unit * 20_000)
