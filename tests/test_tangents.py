"""Tangents of meshes against those of the reference implementation of MikkTSpace, and against what they must do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso

# Triangles with the tangents that the reference implementation by M. Mikkelsen gives, as compiled to WebAssembly in
# `mikktspace` 1.1.1 of npm: random soups with triangles without area, a texture mirrored in the middle, and one that
# is collapsed to lines in places.
_REFERENCE = Path(__file__).parent / "data" / "mikktspace.npz"
_MODELS = Path(__file__).parents[1] / "../shared/models"


def _mesh(data: np.lib.npyio.NpzFile, name: str) -> iso.Mesh:
    attributes = {"normal": data[f"{name}_normals"], "uv": data[f"{name}_uvs"]}
    return iso.Mesh(data[f"{name}_vertices"], data[f"{name}_faces"], attributes=attributes)


def _at_corners(attribute: iso.Attribute) -> npt.NDArray[np.float32]:
    assert attribute.indices is not None
    return attribute.values[attribute.indices]


@pytest.mark.parametrize("name", ["soup", "soup2", "mirrored", "collapsed"])
def test_tangents_are_those_of_the_reference(name: str) -> None:
    with np.load(_REFERENCE) as data:
        found, expected = _at_corners(iso.tangents(_mesh(data, name))), data[f"{name}_tangents"].reshape(-1, 4)
    np.testing.assert_array_equal(found[:, 3], expected[:, 3])
    np.testing.assert_allclose(found[:, :3], expected[:, :3], atol=2e-5)


def _plane(uv: npt.NDArray[np.float64]) -> iso.Mesh:
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    return iso.Mesh(corners, [[0, 1, 2, 3]], attributes={"uv": uv})


_SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, -1.1])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_plane_has_the_tangent_along_which_u_grows(angle: float, mirrored: bool) -> None:
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    uv = _SQUARE @ turn.T * ([1, -1] if mirrored else [1, 1])
    found = _at_corners(iso.tangents(_plane(uv)))
    np.testing.assert_allclose(found[:, :3], np.broadcast_to([np.cos(angle), np.sin(angle), 0], (4, 3)), atol=1e-6)
    assert (found[:, 3] == (-1 if mirrored else 1)).all()


def test_tangents_turn_with_the_mesh() -> None:
    path = _MODELS / "textured/spot/spot_triangulated.obj"
    if not path.exists():
        pytest.skip("the model is not there")
    mesh = iso.load_mesh(path)
    normals = iso.analysis.vertex_normals(mesh)
    turn = iso.Transform.identity().rotate("y", 0.3).rotate("x", 1.1).matrix[:3, :3]

    def found(matrix: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
        attributes = {**mesh.attributes, "normal": normals @ matrix.T}
        return _at_corners(iso.tangents(mesh.with_(vertices=mesh.vertices @ matrix.T, attributes=attributes)))

    straight, turned = found(np.eye(3)), found(turn)
    np.testing.assert_allclose(turned[:, :3], straight[:, :3] @ turn.T, atol=1e-4)
    np.testing.assert_array_equal(turned[:, 3], straight[:, 3])


def test_tangents_are_across_the_normals() -> None:
    with np.load(_REFERENCE) as data:
        mesh = _mesh(data, "mirrored")
    assert mesh.normals is not None
    found = _at_corners(iso.tangents(mesh))
    normals = mesh.normals.values[mesh.indices]
    assert np.abs((found[:, :3] * normals).sum(axis=1)).max() < 1e-5
    np.testing.assert_allclose(np.linalg.norm(found[:, :3], axis=1), 1, atol=1e-6)


def test_a_mesh_without_texture_coordinates_is_refused() -> None:
    with pytest.raises(iso.GeometryError, match="no texture coordinates"):
        iso.tangents(iso.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
