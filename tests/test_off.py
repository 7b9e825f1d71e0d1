"""OFF: headers of all kinds, colours, comments, every refusal with its line."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from isophote import Attribute, FileError, IsophoteWarning, Mesh
from isophote.io.off_read import read_off
from isophote.io.off_write import encode_off
from mesh_files import at_corners, meshes, same_faces

ROWS = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
FACES = "3 0 1 2\n4 0 1 2 3\n"
PLAIN = "OFF\n4 2 0\n" + ROWS + FACES


def read(text: str | bytes) -> Mesh:
    return read_off("x.off", text.encode() if isinstance(text, str) else text)


@pytest.mark.filterwarnings("ignore::isophote.errors.IsophoteWarning")
@given(meshes())
def test_every_mesh_comes_back_exactly(mesh: Mesh) -> None:
    back = read(encode_off(mesh, "x.off"))
    assert np.array_equal(back.vertices, mesh.vertices)
    assert same_faces(back, mesh)
    for name, attribute in mesh.attributes.items():
        if attribute.indices is None:
            width = attribute.values.shape[1]
            assert np.array_equal(at_corners(back, name)[:, :width], at_corners(mesh, name))


@pytest.mark.parametrize(
    "text",
    [
        "OFF 4 2 0\n" + ROWS + FACES,
        "OFF\n4 2\n" + ROWS + FACES,
        "4 2 0\n" + ROWS + FACES,
        "off\r\n" + PLAIN[4:].replace("\n", "\r\n"),
        PLAIN.replace("\n", "\r"),
        "# a\n#b\nOFF # c\n\n  4 2 0 # d\n" + ROWS.replace("\n", " # e 5 6\n\n") + "#\n" + FACES,
        PLAIN.replace(" ", "\t\t"),
        PLAIN.replace("\n", " "),
        PLAIN.replace(" ", "\n"),
        "OFF 4 2 0 " + ROWS + FACES,
        PLAIN + "\n# the end",
        PLAIN.rstrip(),
        "\ufeff" + PLAIN,
    ],
)
def test_every_spelling_of_one_mesh(text: str) -> None:
    assert read(text) == read(PLAIN)


def test_a_plain_mesh() -> None:
    assert read(PLAIN) == Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 1, 2, 3]])


def test_attributes_of_vertices_stand_in_the_order_of_the_format() -> None:
    rows = "".join(f"{i} 0 {i}  0 0 1  {i} 255 0 51  0.5 0.{i}\n" for i in range(3))
    mesh = read("STCNOFF\n3 1 0\n" + rows + "3 0 1 2\n")
    assert mesh.normals == Attribute(np.array([[0, 0, 1.0]] * 3))
    assert mesh.uvs == Attribute(np.array([[0.5, 0], [0.5, 0.1], [0.5, 0.2]]))
    assert mesh.colours is not None
    assert mesh.colours.values[:, 1].tolist() == [1, 1, 1]
    assert mesh.colours.values[2] == pytest.approx([2 / 255 / 12.92, 1, 0, 0.2])


def test_colours_are_integers_to_255_or_numbers_to_1() -> None:
    of = {
        text: read(f"COFF\n3 1 0\n0 0 0 {text}\n1 0 0 {text}\n0 1 0 {text}\n3 0 1 2\n").colours
        for text in ("1 1 1 1", "1.0 1 1 1")
    }
    integers, numbers = of.values()
    assert integers is not None
    assert numbers is not None
    assert integers.values[0] == pytest.approx([1 / 255 / 12.92] * 3 + [1 / 255])
    assert numbers.values.tolist() == [[1, 1, 1, 1]] * 3


def test_colours_of_faces() -> None:
    mesh = read("OFF\n4 4 0\n" + ROWS + "3 0 1 2 255 0 0\n3 0 1 3 7\n3 0 2 3\n4 0 1 2 3 0 255 0 51\n")
    expected = np.repeat([[1, 0, 0, 1], [np.nan] * 4, [np.nan] * 4, [0, 1, 0, 0.2]], [3, 3, 3, 4], axis=0)
    assert np.allclose(at_corners(mesh, "colour"), expected, equal_nan=True)
    assert read(encode_off(mesh, "x.off")).colours == mesh.colours
    both = read("COFF\n3 1 0\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2 0.5 0.5 0.5\n")
    assert set(both.attributes) == {"colour", "face_colour"}
    assert read(encode_off(both, "x.off")) == both


@pytest.mark.parametrize(
    ("text", "place", "reason"),
    [
        ("", "", "cut short"),
        ("OFF", "", "cut short"),
        ("GIF89a\n", "line 1", "is no OFF file"),
        ("4OFF\n4 2 0\n", "line 1", "three dimensions"),
        ("OFF BINARY\n4 2 0\n", "line 1", "export it as text"),
        ("OFF\n-4 2 0\n", "line 2", '"-4"'),
        ("OFF\n4 0 0\n" + ROWS, "", "4 points and no faces"),
        ("OFF\n0 0 0\n", "", "no mesh"),
        ("OFF\n999999999999999999 2 0\n" + ROWS, "line 6", "cut short"),
        ("OFF\n4 999999999999999999 0\n" + ROWS, "line 6", "cut short"),
        (PLAIN.replace("1 0 0", "1 zero 0"), "line 4", '"zero" is not a number'),
        (PLAIN.replace("1 0 0", "1 nan 0"), "line 4", "not finite"),
        (PLAIN.replace("3 0 1 2\n", "3 0 1 4\n"), "line 7", "face 0 names vertex 4"),
        (PLAIN.replace("3 0 1 2\n", "3 0 1 -1\n"), "line 7", "names vertex -1"),
        (PLAIN.replace("3 0 1 2\n", "3 0 1 1.5\n"), "line 7", "1.5"),
        (PLAIN.replace("3 0 1 2\n", "5 0 1 2\n"), "line 7", "declares 5 corners"),
        (PLAIN.replace("3 0 1 2\n", "2 0 1\n"), "line 7", "2 corners"),
        (
            PLAIN.replace("\n3 0 1 2", " 9\n3 0 1 2").replace("0 0\n", "0 0 9\n").replace("1 0\n", "1 0 9\n"),
            "line 3",
            "hold 4",
        ),
    ],
)
def test_what_is_wrong_is_refused_with_its_line(text: str, place: str, reason: str) -> None:
    with pytest.raises(FileError) as caught:
        read(text)
    assert caught.value.place == place
    assert reason in caught.value.reason


def test_what_off_has_no_place_for_is_named_in_a_warning() -> None:
    mesh = Mesh(np.eye(3), [[0, 1, 2]], attributes={"uv": Attribute(np.ones((1, 2)), [0, 0, 0])})
    with pytest.warns(IsophoteWarning, match='"uv"'):
        encode_off(mesh, "x.off")
