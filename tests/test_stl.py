"""STL: both kinds told apart by their content, triangles as stored, every refusal with its place."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from isophote import FaceLabels, FileError, IsophoteWarning, Mesh
from isophote.io.stl_read import read_stl
from isophote.io.stl_write import encode_stl
from mesh_files import meshes

FACET = "facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1 0\n endloop\nendfacet\n"
TETRAHEDRON = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def refused(data: bytes) -> FileError:
    with pytest.raises(FileError) as caught:
        read_stl("x.stl", data)
    return caught.value


@pytest.mark.filterwarnings("ignore::isophote.errors.IsophoteWarning")
@given(meshes(single=True))
def test_triangles_come_back_exactly_from_binary(mesh: Mesh) -> None:
    triangles = Mesh(mesh.vertices, mesh.indices[: len(mesh.indices) // 3 * 3].reshape(-1, 3))
    back = read_stl("x.stl", encode_stl(triangles, "x.stl"))
    assert np.array_equal(back.vertices, triangles.vertices[triangles.indices])
    assert np.array_equal(back.faces, np.arange(len(triangles.indices)).reshape(-1, 3))


@pytest.mark.filterwarnings("ignore::isophote.errors.IsophoteWarning")
@given(meshes())
def test_triangles_come_back_exactly_from_text(mesh: Mesh) -> None:
    triangles = Mesh(mesh.vertices, mesh.indices[: len(mesh.indices) // 3 * 3].reshape(-1, 3))
    back = read_stl("x.stl", encode_stl(triangles, "x.stl", binary=False))
    assert np.array_equal(back.vertices, triangles.vertices[triangles.indices])


@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
def test_stored_normals_are_those_of_the_planes(scale: float) -> None:
    data = encode_stl(TETRAHEDRON.with_(vertices=TETRAHEDRON.vertices * scale), "x.stl")
    facets = np.frombuffer(data, [("n", "<f4", 3), ("v", "<f4", 9), ("a", "<u2")], 4, 84)
    expected = [[0, 0, -1], [0, -1, 0], [-1, 0, 0], np.ones(3) / np.sqrt(3)]
    assert np.allclose(facets["n"], expected, atol=1e-6)


def test_a_triangle_without_area_has_normal_zero() -> None:
    data = encode_stl(Mesh(np.ones((3, 3)), [[0, 1, 2]]), "x.stl")
    assert np.frombuffer(data, "<f4", 3, 84).tolist() == [0, 0, 0]


def test_polygons_are_cut_into_triangles_of_the_same_area() -> None:
    square = Mesh([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    corners = read_stl("x.stl", encode_stl(square, "x.stl")).vertices.reshape(-1, 3, 3)
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] / 2
    assert len(corners) == 2
    assert areas.sum() == 2
    assert (areas > 0).all()


def test_a_binary_file_may_begin_with_solid_and_end_with_more() -> None:
    data = encode_stl(TETRAHEDRON, "x.stl")
    expected = read_stl("x.stl", data)
    named = b"solid facet vertex".ljust(80, b"\0") + data[80:]
    assert read_stl("x.stl", named) == expected
    assert read_stl("x.stl", named + b"trailing bytes") == expected
    assert read_stl("x.stl", b"solid part".ljust(80) + data[80:]) == expected


def test_several_solids_of_a_text_are_groups() -> None:
    text = f"solid left wing\n{FACET}{FACET}endsolid left wing\n\n SOLID\r\n{FACET.upper()}endsolid\nsolid c\n{FACET}"
    mesh = read_stl("x.stl", text.encode())
    assert mesh.face_count == 4
    assert mesh.labels["group"] == FaceLabels(("left wing", "", "c"), np.array([0, 0, 1, 2]))
    assert read_stl("x.stl", encode_stl(mesh, "x.stl", binary=False)) == mesh
    with pytest.warns(IsophoteWarning, match="group"):
        encode_stl(mesh, "x.stl")


def test_names_of_solids_may_hold_any_words() -> None:
    text = f"solid of solid facets\n{FACET}endsolid vertex 1\n\t solid solid\n{FACET}\tendsolid"
    assert read_stl("x.stl", text.encode()).labels["group"].names == ("of solid facets", "solid")


@pytest.mark.parametrize("blank", ["\r\n", "\r", "\t", " \v\f "])
def test_any_white_space_parts_the_words(blank: str) -> None:
    text = "solid\n" + FACET.replace("\n", blank).replace(" ", blank)
    assert read_stl("x.stl", text.encode()).vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_stored_normals_may_be_no_numbers_at_all() -> None:
    text = "solid\n" + FACET.replace("normal 0 0 1", "normal -nan(ind) nan nan")
    assert read_stl("x.stl", text.encode()).face_count == 1


@pytest.mark.parametrize(
    ("text", "place", "reason"),
    [
        ("solid\nendsolid\n", "", "no mesh"),
        ("solid\n" + FACET.replace("endloop", "vertex 1 1 1\nendloop"), "line 7", '"endloop" is due'),
        ("solid\n" + FACET.replace("vertex 1 0 0", "vertex 1 0 zero"), "line 5", '"zero" is not a number'),
        ("solid\n" + FACET.replace("vertex 1 0 0", "vertex 1 0"), "line 6", '"vertex" where a number is due'),
        ("solid\n" + FACET.replace("vertex 1 0 0", "vertex 1 0 inf"), "line 5", "not finite"),
        ("solid\n" + FACET + FACET[:30], "line 10", "cut short"),
        ("solid\n" + FACET + "end", "line 9", '"end" where "facet" is due'),
        ("solid of words and nothing else", "", "no mesh"),
        ("hello", "", "5 bytes"),
        ("h" * 100, "byte 100", "triangles are declared"),
        ("", "", "0 bytes"),
    ],
)
def test_what_is_wrong_is_refused_with_its_place(text: str, place: str, reason: str) -> None:
    error = refused(text.encode())
    assert place in error.place
    assert reason in str(error)


def test_a_binary_file_cut_short_is_refused() -> None:
    data = encode_stl(TETRAHEDRON, "x.stl")
    for size in range(len(data)):
        refused(data[:size])
    assert "4,294,967,295 triangles" in refused(data[:80] + b"\xff" * 4 + data[84:]).reason


def test_a_coordinate_that_is_not_finite_is_refused_with_its_triangle() -> None:
    data = bytearray(encode_stl(TETRAHEDRON, "x.stl"))
    data[84 + 50 * 2 + 12 : 84 + 50 * 2 + 16] = np.array(np.nan, "<f4").tobytes()
    assert refused(bytes(data)).place == "triangle 2, byte 184"


def test_coordinates_beyond_32_bits_are_refused() -> None:
    with pytest.raises(FileError, match="beyond binary STL"):
        encode_stl(TETRAHEDRON.with_(vertices=TETRAHEDRON.vertices * 1e39), "x.stl")
