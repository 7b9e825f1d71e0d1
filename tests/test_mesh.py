"""Meshes as values: what they keep, what they refuse."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isophote import Attribute, FaceLabels, GeometryError, Mesh

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def test_faces_of_one_size_are_an_array_and_mixed_ones_a_tuple() -> None:
    assert Mesh(SQUARE, [(0, 1, 2), (0, 2, 3)]).faces.shape == (2, 3)
    mixed = Mesh([*SQUARE, (0, 0, 1)], [(0, 1, 2, 3), (0, 1, 4)]).faces
    assert [face.tolist() for face in mixed] == [[0, 1, 2, 3], [0, 1, 4]]


def test_nothing_given_is_changed_and_nothing_kept_can_be() -> None:
    vertices, faces = np.array(SQUARE, float), np.array([[0, 1, 2]])
    mesh = Mesh(vertices, faces)
    vertices[0] = 9
    faces[0] = 3
    assert mesh.vertices[0].tolist() == [0, 0, 0]
    assert mesh.faces.tolist() == [[0, 1, 2]]
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 1


def test_bounds_are_of_the_vertices_that_faces_use() -> None:
    mesh = Mesh([*SQUARE, (50, 50, 50)], [(0, 1, 2, 3)])
    assert mesh.bounds.tolist() == [[0, 0, 0], [1, 1, 0]]


def test_equal_descriptions_are_equal_and_hash_alike() -> None:
    uv = Attribute(np.zeros((2, 2)), np.array([0, 1, 1]))
    labels = {"material": FaceLabels(("red",), np.array([0]))}
    one = Mesh(SQUARE, [(0, 1, 2)], attributes={"uv": uv}, labels=labels)
    two = Mesh(SQUARE, [(0, 1, 2)], attributes={"uv": uv}, labels=labels)
    assert one == two
    assert hash(one) == hash(two)
    assert one != one.with_(attributes={})
    assert one != Mesh(SQUARE, [(0, 2, 1)])


def test_a_small_mesh_prints_what_makes_it_again() -> None:
    mesh = Mesh(SQUARE, [(0, 1, 2, 3)])
    assert eval(repr(mesh), {"Mesh": Mesh}) == mesh


def test_meshes_can_be_copied_and_sent_to_other_processes() -> None:
    mesh = Mesh(SQUARE, [(0, 1, 2)], attributes={"colour": np.ones((4, 3), np.float32)})
    assert pickle.loads(pickle.dumps(mesh)) == mesh
    assert copy.deepcopy(mesh) == mesh


@pytest.mark.parametrize(
    ("vertices", "faces", "reason"),
    [
        (SQUARE, [], "no faces"),
        (SQUARE, np.zeros((0, 3), int), "no faces"),
        (SQUARE, [(0, 1)], "2 corners"),
        (SQUARE, [(0, 1, 4)], "face 0 names vertex 4"),
        (SQUARE, [(0, 1, 2), (0, -1, 2)], "face 1 names vertex -1"),
        (SQUARE, [(0.5, 1, 2)], "whole numbers"),
        ([(0, 0), (1, 0), (1, 1)], [(0, 1, 2)], r"\(n, 3\)"),
        ([(0, 0, 0), (1, np.nan, 0), (1, 1, 0)], [(0, 1, 2)], "vertex 1 is not finite"),
        ([(0, 0, 0), (np.inf, 0, 0), (1, 1, 0)], [(0, 1, 2)], "vertex 1 is not finite"),
        ([("a", "b", "c")], [(0, 0, 0)], "numbers"),
    ],
)
def test_what_is_no_mesh_is_refused_with_its_place(vertices: object, faces: object, reason: str) -> None:
    with pytest.raises(GeometryError, match=reason):
        Mesh(vertices, faces)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "attribute",
    [
        np.zeros((3, 2)),
        Attribute(np.zeros((1, 2)), np.array([0, 0])),
        Attribute(np.zeros((1, 2)), np.array([0, 0, 1])),
        np.zeros((2, 2, 2)),
    ],
)
def test_attributes_that_do_not_fit_are_refused(attribute: object) -> None:
    with pytest.raises(GeometryError, match="uv"):
        Mesh(SQUARE, [(0, 1, 2)], attributes={"uv": attribute})  # type: ignore[dict-item]


@given(st.lists(st.lists(st.integers(0, 3), min_size=3, max_size=6), min_size=1, max_size=8))
def test_faces_come_back_as_they_were_given(faces: list[list[int]]) -> None:
    mesh = Mesh(SQUARE, faces)
    assert [list(face) for face in mesh.faces] == faces
    assert mesh.face_sizes.tolist() == [len(face) for face in faces]
    assert mesh == Mesh.from_polygons(SQUARE, mesh.indices, mesh.offsets)
