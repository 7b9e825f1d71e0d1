"""PLY: every layout read, every column kept, every refusal with its place."""

from __future__ import annotations

import struct
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isophote import Attribute, FaceLabels, FileError, IsophoteWarning, Mesh, load_mesh, save
from isophote.io.ply_read import read_ply
from isophote.io.ply_write import encode_ply
from mesh_files import at_corners, meshes, same_faces

HEAD = "ply\nformat ascii 1.0\n"
XYZ = "property float x\nproperty float y\nproperty float z\n"
CORNERS = "property list uchar int vertex_indices\n"
TRIANGLE = (
    HEAD + "element vertex 3\n" + XYZ + "element face 1\n" + CORNERS + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
)


def read(text: str | bytes) -> Mesh:
    return read_ply("x.ply", text.encode() if isinstance(text, str) else text)


def refused(text: str | bytes) -> FileError:
    with pytest.raises(FileError) as caught:
        read(text)
    assert caught.value.path == "x.ply"
    return caught.value


@pytest.mark.filterwarnings("ignore::isophote.errors.IsophoteWarning")
@given(meshes(), st.booleans(), st.sampled_from(["little", "big"]))
def test_every_mesh_comes_back_exactly(mesh: Mesh, binary: bool, endian: str) -> None:
    plain = mesh.with_(labels={})
    data = encode_ply(plain, "x.ply", binary=binary, endian=endian)  # type: ignore[arg-type]
    back = read(data)
    assert np.array_equal(back.vertices, mesh.vertices)
    assert same_faces(back, mesh)
    for name, attribute in mesh.attributes.items():
        expected = at_corners(mesh, name)
        if np.isnan(expected).all():
            continue
        assert np.array_equal(at_corners(back, name), expected, equal_nan=True)
        if attribute.indices is None:
            assert back.attributes[name] == attribute


@pytest.mark.parametrize("dtype", ["i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"])
@pytest.mark.parametrize("binary", [False, True])
def test_columns_keep_their_name_type_and_width(dtype: str, binary: bool) -> None:
    values = np.array([[1, 2], [3, 100], [5, 0]], dtype)
    mesh = Mesh(np.eye(3), [[0, 1, 2]], attributes={"flow": values, "quality": values[:, :1]})
    back = read(encode_ply(mesh, "x.ply", binary=binary))
    assert back.attributes["flow"] == Attribute(values)
    assert back.attributes["flow"].values.dtype == dtype
    assert back.attributes["quality"] == Attribute(values[:, :1])


def test_all_256_levels_of_a_colour_come_back_as_the_same_bytes() -> None:
    levels = np.arange(256)
    rows = "".join(f"{i} 0 0 {i} {255 - i} 7 {i}\n" for i in levels)
    colours = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue", "alpha"))
    text = HEAD + "element vertex 256\n" + XYZ + colours + "element face 1\n" + CORNERS + "end_header\n" + rows
    mesh = read(text + "3 0 1 2\n")
    assert mesh.colours is not None
    # IEC 61966-2-1 at 0.5 and at the ends; alpha has no curve.
    assert mesh.colours.values[[0, 255], 0].tolist() == [0, 1]
    assert mesh.colours.values[188, 0] == pytest.approx(((188 / 255 + 0.055) / 1.055) ** 2.4, rel=1e-6)
    assert mesh.colours.values[51, 3] == pytest.approx(0.2)
    written = encode_ply(mesh, "x.ply", binary=False).decode()
    assert "property uchar red" in written
    body = written.split("end_header\n")[1].splitlines()[:256]
    assert [line.split()[3:] for line in body] == [[str(i), str(255 - i), "7", str(i)] for i in levels]


def test_elements_and_properties_stand_in_any_order() -> None:
    data = (
        b"ply\r\nformat binary_big_endian 1.0\r\nobj_info any\r\nelement face 2\r\nproperty uchar flag\r\n"
        b"property list uint ushort vertex_index\r\nproperty short weight\r\nelement edge 1\r\nproperty int a\r\n"
        b"property list uchar double w\r\nelement vertex 4\r\nproperty double z\r\nproperty list char int ring\r\n"
        b"property double x\r\nproperty uchar y\r\nend_header\r\n"
    )
    data += b"\x07" + (3).to_bytes(4) + b"\0\0\0\1\0\2" + (-5).to_bytes(2, signed=True)
    data += b"\x08" + (4).to_bytes(4) + b"\0\3\0\2\0\1\0\0" + (6).to_bytes(2)
    data += (9).to_bytes(4) + b"\x01" + np.array(0.5, ">f8").tobytes()
    for i in range(4):
        data += struct.pack(">d", i + 0.25) + bytes([i]) + bytes(4 * i) + struct.pack(">dB", i / 3, 10 + i)
    mesh = read(data)
    assert np.array_equal(mesh.vertices, [[i / 3, 10 + i, i + 0.25] for i in range(4)])
    assert [face.tolist() for face in mesh.faces] == [[0, 1, 2], [3, 2, 1, 0]]
    assert mesh.attributes["flag"].values[:, 0].tolist() == [7, 8]
    assert mesh.attributes["weight"].values[:, 0].tolist() == [-5, 6]
    assert mesh.attributes["weight"].indices.tolist() == [0, 0, 0, 1, 1, 1, 1]  # type: ignore[union-attr]


def test_text_with_wrapped_rows_odd_blanks_and_other_line_ends() -> None:
    head, body = TRIANGLE.split("end_header\n")
    expected = read(TRIANGLE)
    assert read(head + "end_header\n" + body.replace(" ", "\t \v").replace("\n", "  \n\n")) == expected
    assert read(TRIANGLE.replace("\n", "\r\n")) == expected
    assert read(TRIANGLE.replace("\n", "\r")) == expected
    assert read(head + "end_header\n" + body.replace(" ", "\n")) == expected
    assert read(head + "end_header\n" + " ".join(body.split())) == expected


def test_mixed_sizes_over_one_long_line() -> None:
    text = HEAD + "element face 3\n" + CORNERS + "element vertex 4\n" + XYZ + "end_header\n"
    mesh = read(text + "3 0 1 2 4 3 2 1 0 3 1 2 3 " + "0 1 2 3 4 5 6 7 8 9 10 11")
    assert mesh.face_sizes.tolist() == [3, 4, 3]
    assert mesh.indices.tolist() == [0, 1, 2, 3, 2, 1, 0, 1, 2, 3]
    assert mesh.vertices.ravel().tolist() == list(range(12))


def test_decimal_text_becomes_the_nearest_double() -> None:
    numbers = [
        "0.1",
        "1e-5",
        "123456789.123456789",
        "-4.9406564584124654e-324",
        "9007199254740993",
        "1.7976931348623157e308",
    ]
    rows = "".join(f"{number} {number} 0\n" for number in numbers)
    mesh = read(TRIANGLE.replace("vertex 3", "vertex 6").replace("0 0 0\n1 0 0\n0 1 0\n", rows))
    assert mesh.vertices[:, 0].tolist() == [float(number) for number in numbers]


def test_rows_that_hold_more_than_declared_are_read_with_a_warning() -> None:
    with pytest.warns(IsophoteWarning, match=r"line 13.*row 0"):
        mesh = read(TRIANGLE.replace("3 0 1 2\n", "3 0 1 2 9 9\n"))
    assert mesh.faces.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("text", "place", "reason"),
    [
        ("", "line 1", "not a PLY"),
        ("plywood", "line 1", "not a PLY"),
        ("ply\nformat ascii 1.0\n", "line 3", "end_header"),
        (TRIANGLE.replace("ascii", "utf"), "line 2", "binary_little_endian"),
        (TRIANGLE.replace("format ascii 1.0\n", ""), "line 8", "format"),
        (TRIANGLE.replace("element vertex 3", "element vertex -3"), "line 3", '"-3"'),
        (TRIANGLE.replace("element vertex 3", "element vertex 9" + "9" * 5000), "line 3", "rows"),
        (TRIANGLE.replace("float y", "floot y"), "line 5", "floot"),
        (TRIANGLE.replace("float y", "float x"), "line 5", "two properties"),
        (TRIANGLE.replace("list uchar", "list float"), "line 8", "whole number"),
        (TRIANGLE.replace("float y", "float why"), "", "x, y and z"),
        (TRIANGLE.replace("element vertex", "element point"), "", '"point"'),
        (TRIANGLE.replace("vertex_indices", "corners"), "", "vertex_indices"),
        (TRIANGLE.replace("1 0 0\n", "1 O 0\n"), "line 11", '"O" in row 1'),
        (TRIANGLE.replace("1 0 0\n", "1 nan 0\n"), "line 11", "not finite"),
        (TRIANGLE.replace("1 0 0\n", "1 1e999 0\n"), "line 11", "not finite"),
        (TRIANGLE.replace("3 0 1 2", "3 0 1 3"), "line 13", "face 0 names vertex 3"),
        (TRIANGLE.replace("3 0 1 2", "3 0 1 -1"), "line 13", "names vertex -1"),
        (TRIANGLE.replace("3 0 1 2", "3 0 1 99999999999999999999"), "line 13", "face 0 names vertex"),
        (TRIANGLE.replace("3 0 1 2", "3 0 1 0.5"), "line 13", "0.5"),
        (TRIANGLE.replace("3 0 1 2", "2 0 1"), "line 13", "2 corners"),
        (TRIANGLE.replace("3 0 1 2", "-3 0 1 2"), "line 13", "-3"),
        (TRIANGLE.replace("3 0 1 2", "4 0 1 2"), "line 13", "list of 4"),
        (TRIANGLE.replace("3 0 1 2\n", ""), "line 13", "cut short"),
        (TRIANGLE.replace("vertex 3", "vertex 999999999999"), "", "cut short"),
        (TRIANGLE.replace("face 1", "face 999999999999"), "", "cut short"),
    ],
)
def test_what_is_wrong_is_refused_with_its_place(text: str, place: str, reason: str) -> None:
    error = refused(text)
    assert place in error.place
    assert reason in error.reason


def test_a_binary_file_cut_anywhere_is_refused() -> None:
    mesh = Mesh(np.random.default_rng(1).random((5, 3)), [[0, 1, 2], [0, 2, 3, 4]])
    data = encode_ply(mesh, "x.ply")
    assert read(data) == mesh
    for size in range(len(data)):
        refused(data[:size])


@pytest.mark.parametrize("count", [2**31, 10**17])
def test_a_count_beyond_the_data_is_refused_before_anything_is_allocated(count: int) -> None:
    data = encode_ply(Mesh(np.eye(3), [[0, 1, 2]]), "x.ply")
    for element in (b"vertex 3", b"face 1"):
        error = refused(data.replace(b"element " + element, b"element %s %d" % (element.split()[0], count)))
        assert "cut short" in error.reason
        assert error.place.startswith("byte ")


def test_points_alone_are_refused_with_their_number() -> None:
    for cloud in (TRIANGLE.replace("face 1", "face 0"), TRIANGLE.split("element face")[0] + "end_header\n0 0 0\n" * 1):
        text = cloud if "face 0" in cloud else cloud.replace("end_header\n", "end_header\n0 0 0\n1 1 1\n")
        assert "3 points and no faces" in refused(text).reason


@pytest.mark.parametrize("name", ["a b", "", "größe", "x"])
def test_attributes_that_ply_cannot_name_are_refused(name: str, tmp_path: Path) -> None:
    mesh = Mesh(np.eye(3), [[0, 1, 2]], attributes={name: np.ones(3)})
    with pytest.raises(FileError, match="attribute"):
        save(mesh, tmp_path / "a.ply")
    assert list(tmp_path.iterdir()) == []


def test_labels_are_left_out_with_a_warning(tmp_path: Path) -> None:
    mesh = Mesh(np.eye(3), [[0, 1, 2]], labels={"material": FaceLabels(("oak",), np.zeros(1, int))})
    with pytest.warns(IsophoteWarning, match="material"):
        save(mesh, tmp_path / "a.ply")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load_mesh(tmp_path / "a.ply") == mesh.with_(labels={})
