"""OBJ: every form of a corner, names with blanks, every refusal with its line."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from isophote import Attribute, FaceLabels, FileError, IsophoteWarning, Mesh
from isophote.io.obj_read import parse_obj, read_obj
from isophote.io.obj_write import encode_obj
from mesh_files import at_corners, label_names, meshes, same_faces

CORNERS = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
TEXTURE = "vt 0 0\nvt 0.5 0.25\n"
NORMALS = "vn 0 0 1\nvn 0 1 0\nvn 1 0 0\n"


def read(text: str | bytes) -> Mesh:
    return read_obj("x.obj", text.encode() if isinstance(text, str) else text)


def refused(text: str | bytes) -> FileError:
    with pytest.raises(FileError) as caught:
        read(text)
    assert caught.value.path == "x.obj"
    return caught.value


@pytest.mark.filterwarnings("ignore::isophote.errors.IsophoteWarning")
@given(meshes())
def test_every_mesh_comes_back_exactly(mesh: Mesh) -> None:
    back = read(encode_obj(mesh, "x.obj"))
    assert np.array_equal(back.vertices, mesh.vertices)
    assert same_faces(back, mesh)
    for name in ("normal", "uv"):
        if name in mesh.attributes and not np.isnan(expected := at_corners(mesh, name)).all():
            assert np.array_equal(at_corners(back, name), expected, equal_nan=True)
    if mesh.colours is not None and mesh.colours.indices is None:
        assert back.colours == mesh.colours
    for name in ("material", "group"):
        assert label_names(back, name) == label_names(mesh, name)


@pytest.mark.parametrize(
    ("face", "uv", "normal"),
    [
        ("1 2 3", None, None),
        ("1/2 2/1 3/2", [1, 0, 1], None),
        ("1//3 2//2 3//1", None, [2, 1, 0]),
        ("1/2/3 2/1/2 3/2/1", [1, 0, 1], [2, 1, 0]),
        ("-4/-1/-1 -3/-2/-2 -2/-1/-3", [1, 0, 1], [2, 1, 0]),
        ("1/2/3 2//2 3/1", [1, -1, 0], [2, 1, -1]),
        ("1/ 2// 3/2/", [-1, -1, 1], None),
        ("1 2/1 3//1", [-1, 0, -1], [-1, -1, 0]),
        ("+1 +2 +3", None, None),
    ],
)
def test_every_form_of_a_corner(face: str, uv: list[int] | None, normal: list[int] | None) -> None:
    mesh = read(f"{CORNERS}{TEXTURE}{NORMALS}f {face}\n")
    assert mesh.faces.tolist() == [[0, 1, 2]]
    assert (mesh.uvs is None) == (uv is None)
    assert (mesh.normals is None) == (normal is None)
    if uv is not None:
        assert mesh.uvs == Attribute(np.array([[0, 0], [0.5, 0.25]]), np.array(uv))
    if normal is not None:
        assert mesh.normals == Attribute(np.eye(3)[::-1], np.array(normal))


def test_negative_numbers_count_back_from_the_face() -> None:
    mesh = read(CORNERS + "f -4 -3 -2\n" + CORNERS + "f -4 -3 -2\nf 5 -2 -1\n")
    assert mesh.faces.tolist() == [[0, 1, 2], [4, 5, 6], [4, 6, 7]]


def test_attributes_with_the_numbers_of_the_vertices_are_at_the_vertices() -> None:
    mesh = read("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + NORMALS + "f 1//1 2//2 3//3\n")
    assert mesh.normals == Attribute(np.eye(3)[::-1])


def test_odd_texts_mean_the_same() -> None:
    plain = read(CORNERS + TEXTURE + "g a\nf 1/1 2/2 3/1\nf 1/1 3/2 4/1\n")
    text = CORNERS + TEXTURE + "g a\nf 1/1 2/2 3/1\nf 1/1 3/2 4/1\n"
    assert read("\ufeff" + text) == plain
    assert read(text.replace("\n", "\r\n")) == plain
    assert read(text.replace("\n", "\r")) == plain
    assert read(text.replace("\n", "  \n\n\t\n")) == plain
    assert read(text.replace(" ", "\t \v\f")) == plain
    assert read(text.replace("\n", "\n  ")) == plain
    assert read(text.replace("2/2 3", "2/2 \\\n 3").replace("1 0 0", "1 \\\r\n0\\\n 0")) == plain
    assert read(text.replace("\n", " # v 9 9 9 \\\n# C:\\models\\\n")) == plain
    assert read(text.rstrip("\n")) == plain
    assert (
        read(text.replace("g a\n", "g a\ns 1\nl 1 2\np 1\nvp 0.1 0.2\ncurv 0 1 1 2\nshadow_obj x\nend\nfoo bar\nt 1\n"))
        == plain
    )


def test_materials_and_groups_label_faces() -> None:
    text = (
        CORNERS
        + "f 1 2 3\nusemtl dark wood\no Cube\nf 1 2 4\ng left arm\nf 1 3 4\nusemtl b\nusemtl\nf 2 3 4\nusemtl unused\n"
    )
    mesh = read("mtllib a b.mtl\nmtllib c.mtl # d\n" + text)
    assert mesh.labels["material"] == FaceLabels(("dark wood",), np.array([-1, 0, 0, -1]))
    assert mesh.labels["group"] == FaceLabels(("Cube", "left arm"), np.array([-1, 0, 1, 1]))
    assert parse_obj("x.obj", ("mtllib a b.mtl\nmtllib c.mtl # d\n" + text).encode()).libraries == ("a b.mtl", "c.mtl")


def test_colours_after_the_coordinates() -> None:
    mesh = read("v 0 0 0 1 0.5 0\nv 1 0 0 0 0 1\nv 0 1 0 0 0 0\nv 0 0 1 1 1 1\nf 1 2 3\n")
    assert mesh.colours is not None
    assert mesh.colours.indices is None
    # IEC 61966-2-1: ((0.5 + 0.055) / 1.055)^2.4 = 0.21404114...
    assert mesh.colours.values[0] == pytest.approx([1, 0.21404114, 0], abs=1e-7)
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    some = read("v 0 0 0\nv 1 0 0 0 0 1\nv 0 1 0 1\nv 0 0 1 1 1 1 0.5\nf 1 2 3\nf 1 2 4\n")
    expected = np.array([[np.nan] * 4, [0, 0, 1, 1], [np.nan] * 4, [np.nan] * 4, [0, 0, 1, 1], [1, 1, 1, 0.5]])
    assert np.array_equal(at_corners(some, "colour"), expected, equal_nan=True)


def test_decimal_text_becomes_the_nearest_double() -> None:
    words = ["0.1", "-1.7976931348623157e+308", "5e-324", "9007199254740993", ".5", "3.", "1E2", "0.30000000000000004"]
    mesh = read("".join(f"v {word} 0 0\n" for word in words) + "f 1 2 3\n")
    assert mesh.vertices[:, 0].tolist() == [float(word) for word in words]


@pytest.mark.parametrize(
    ("text", "place", "reason"),
    [
        ("", "", "no mesh"),
        ("f 1 2 3\n", "line 1", "vertex 1, but the file has 0"),
        (CORNERS, "", "4 points and no faces"),
        (CORNERS + "l 1 2 3\n", "", "no faces"),
        (CORNERS + "\n# c\nf 1 2 5\n", "line 7", "face 0 names vertex 5, but the file has 4"),
        (CORNERS + "f 1 2 0\n", "line 5", "vertex 0"),
        (CORNERS + "f 1 2 -5\n", "line 5", "vertex -5"),
        (CORNERS + "f 1 2 99999999999999999999\n", "line 5", "names vertex"),
        (CORNERS + "f 1 2 -99999999999999999999\n", "line 5", "names vertex"),
        (CORNERS + "f 1/1 2/1 3/1\n", "line 5", "texture coordinate 1, but the file has 0"),
        (CORNERS + NORMALS + "f 1//1 2//4 3//1\n", "line 8", "normal 4"),
        (CORNERS + "f 1 2\n", "line 5", "2 corners"),
        (CORNERS + "f\n", "line 5", "0 corners"),
        (CORNERS + "f 1 2 3\nf 1 2 x3\n", "line 6", '"x3" is not a whole number'),
        (CORNERS + "f 1/1 2.5/1 3/1\n", "line 5", '"2.5/1" is not a corner'),
        (CORNERS + NORMALS + "f 1/1/1/1 2 3\n", "line 8", '"1/1/1/1" is not a corner'),
        (CORNERS + "f /1 2 3\n" + TEXTURE, "line 5", "vertex 0"),
        (CORNERS + "f / 2 3\n", "line 5", "vertex 0"),
        ("v 0 0\n" + CORNERS + "f 1 2 3\n", "line 1", "3 numbers are due"),
        (CORNERS + "v 1 2 three\nf 1 2 3\n", "line 5", '"three" is not a number'),
        (CORNERS + "v 1 \\\n2 nan\nf 1 2 3\n", "line 5", "not finite"),
        (CORNERS + "v 1 1 -inf\nf 1 2 3\n", "line 5", "not finite"),
        (CORNERS + "vn 1 1\nf 1//1 2//1 3//1\n", "line 5", "3 numbers are due"),
        (CORNERS + "v " + "1" * 100_000 + "x 0 0\nf 1 2 3\n", "line 5", '1…" is not a number'),
    ],
)
def test_what_is_wrong_is_refused_with_its_line(text: str, place: str, reason: str) -> None:
    error = refused(text)
    assert error.place == place
    assert reason in error.reason


@pytest.mark.parametrize("name", ["two\nlines", " edge", "edge ", "a #b", "#a", "back\\"])
def test_names_that_obj_cannot_hold_are_refused(name: str) -> None:
    mesh = Mesh(np.eye(3), [[0, 1, 2]], labels={"material": FaceLabels((name,), np.zeros(1, int))})
    with pytest.raises(FileError, match="cannot hold the name"):
        encode_obj(mesh, "x.obj")


def test_what_obj_has_no_place_for_is_named_in_a_warning() -> None:
    mesh = Mesh(
        np.eye(3), [[0, 1, 2]], attributes={"flow": np.ones((3, 1)), "colour": Attribute(np.ones((1, 3)), [0, 0, 0])}
    )
    with pytest.warns(IsophoteWarning, match=r'"flow", "colour"'):
        encode_obj(mesh, "x.obj")
