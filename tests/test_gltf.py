"""Reading glTF and GLB: files of others, and one file for each thing that the format can say."""

from __future__ import annotations

import base64
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

import isophote as iso
from gltf_files import (
    ACCESSOR,
    GLTF,
    SOLID,
    TRIANGLE,
    document,
    needs_models,
    read,
    with_bytes,
)
from isophote import (
    FileError,
    ImageTexture,
    IsophoteWarning,
    Mesh,
    Scene,
    load_mesh,
    load_scene,
)
from isophote.io.gltf.read import read_gltf_mesh
from mesh_files import MODELS


def facts(name: str) -> tuple[int, int, int, int, int, int]:
    """Vertices, triangles, meshes, nodes, materials and images, from the table beside the files."""
    text = (MODELS / "SOURCES.md").read_text()
    row = next(line for line in text.splitlines() if line.startswith(f"| `gltf/{name}`"))
    counts = re.search(r"\| (\d+) / (\d+) tri \|", row)
    parts = re.search(r"(\d+) meshes, (\d+) nodes, (\d+) materials, (\d+) images", row)
    assert counts
    assert parts
    return (*map(int, counts.groups()), *map(int, parts.groups()))  # type: ignore[return-value]


def welded(items: list[Mesh]) -> int:
    """Distinct positions in each mesh by itself."""
    points = np.concatenate([mesh.vertices[mesh.indices] for mesh in items])
    return len(np.unique(points, axis=0))


@needs_models
@pytest.mark.parametrize("name", [name for name in SOLID if "Mode" not in name])
def test_counts_are_those_of_the_table(name: str) -> None:
    vertices, triangles, mesh_count, _, materials, images = facts(name)
    scene = load_scene(GLTF / name)
    own = list({id(item.shape): item.shape for item in scene.items}.values())
    assert all(isinstance(shape, Mesh) for shape in own)
    assert sum(shape.face_count for shape in own) == triangles
    assert welded(own) == vertices
    assert len({item.name for item in scene.items}) <= mesh_count + 2
    assert len({id(item.material) for item in scene.items}) == max(materials, 1)
    assert len(pictures(scene)) == images


def pictures(scene: Scene) -> set[bytes]:
    names = ("colour", "metallic_roughness", "normal", "occlusion", "emission")
    found = (getattr(item.material, f"{name}_texture", None) for item in scene.items for name in names)
    return {texture.pixels.tobytes() for texture in found if texture is not None}


@needs_models
@pytest.mark.parametrize("name", [name for name in SOLID if not re.search("Mode|Sparse", name)])
@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
def test_world_positions_agree_with_another_reader(name: str) -> None:
    ours = load_mesh(GLTF / name)
    theirs = trimesh.load(GLTF / name, process=False).to_geometry()
    assert ours.face_count == len(theirs.faces)
    mine = np.sort(ours.vertices[ours.indices].round(4), axis=0)
    other = np.sort(np.asarray(theirs.vertices)[theirs.faces.ravel()].round(4), axis=0)
    assert np.allclose(mine, other, atol=1e-4)
    volume = np.linalg.det(ours.vertices[ours.faces]).sum() / 6
    assert volume == pytest.approx(theirs.volume, rel=1e-4, abs=1e-9)


@needs_models
def test_placed_meshes_keep_the_volume_of_the_closed_ones() -> None:
    ours = load_mesh(GLTF / "OrientationTest.glb")
    assert np.linalg.det(ours.vertices[ours.faces]).sum() > 0


@needs_models
def test_orientation_targets_hold_what_points_at_them() -> None:
    """Every arrow's tip lies in the target of its axis: a wrong rotation moves it elsewhere."""
    boxes = {item.name: item.bounds for item in load_scene(GLTF / "OrientationTest.glb").items}
    pairs = [(f"Arrow{axis}{n}", f"Target{axis}{n}") for axis in "XYZ" for n in (1, 2)]
    for arrow, target in pairs:
        low, high = boxes[target]
        assert (boxes[arrow][0] < high + 1e-3).all(), arrow
        assert (boxes[arrow][1] > low - 1e-3).all(), arrow


@needs_models
def test_the_wheels_of_the_truck_are_one_mesh() -> None:
    items = load_scene(GLTF / "CesiumMilkTruck.glb").items
    wheels = [item for item in items if item.name == "Wheels"]
    assert len(items) == 5
    assert len(wheels) == 2
    assert wheels[0].shape is wheels[1].shape
    assert wheels[0].transform != wheels[1].transform


@needs_models
def test_a_plane_keeps_every_texture_of_its_material() -> None:
    (item,) = load_scene(GLTF / "TwoSidedPlane/TwoSidedPlane.gltf", strict=True).items
    material = item.material
    assert isinstance(material, iso.Principled)
    assert material.two_sided
    assert material.colour_texture is not None
    assert material.colour_texture.colour_space == "srgb"
    assert material.metallic_roughness_texture is not None
    assert material.metallic_roughness_texture.colour_space == "linear"
    assert material.normal_texture is not None
    assert material.normal_texture.name == "TwoSidedPlane_Normal.png"


@needs_models
@pytest.mark.parametrize("mode", range(7))
def test_every_mode_gives_the_same_square_or_is_left_out(mode: int) -> None:
    path = GLTF / f"Mesh_PrimitiveMode/Mesh_PrimitiveMode_0{mode}.gltf"
    if mode < 4:
        with pytest.warns(IsophoteWarning, match="left out"):
            assert load_scene(path).items == ()
        return
    mesh = load_mesh(path)
    corners = mesh.vertices[mesh.faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    assert mesh.face_count == 2
    assert (areas[:, 2] * areas[0, 2] > 0).all()
    assert abs(areas[:, 2].sum()) == pytest.approx(np.prod(np.ptp(mesh.vertices, axis=0)[:2]))


def test_nodes_multiply_their_transforms() -> None:
    nodes = [
        {"children": [1], "translation": [1, 2, 3], "rotation": [0, math.sqrt(0.5), 0, math.sqrt(0.5)]},
        {"mesh": 0, "name": "child", "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 5, 0, 0, 1]},
    ]
    (item,) = read(document(nodes=nodes)).items
    # A quarter about y takes x to −z.
    expected = [[0, 0, 2, 1], [0, 2, 0, 2], [-2, 0, 0, -2], [0, 0, 0, 1]]
    assert np.allclose(item.transform.matrix, expected)
    assert item.name == "child"


def test_mirrored_parts_of_a_mesh_keep_their_front() -> None:
    whole = document(nodes=[{"mesh": 0, "scale": [-1, 1, 1]}])
    mesh = read_gltf_mesh(Path("x.gltf"), json.dumps(whole).encode())
    a, b, c = mesh.vertices[mesh.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0


@pytest.mark.parametrize("scale", [[-1, 2, 1], [2, 3, 0.5], [-1, -2, -3]])
def test_normals_of_placed_parts_stand_on_their_faces(scale: list[float]) -> None:
    points = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
    normals = np.full((3, 3), math.sqrt(1 / 3), "<f4")
    whole = with_bytes(
        points.tobytes() + normals.tobytes(),
        [{"byteLength": 36}, {"byteOffset": 36, "byteLength": 36}],
        [ACCESSOR, {**ACCESSOR, "bufferView": 1}],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]}],
        nodes=[{"mesh": 0, "scale": scale, "rotation": [0.5, 0.5, -0.5, 0.5]}],
    )
    mesh = read_gltf_mesh(Path("x.gltf"), json.dumps(whole).encode())
    a, b, c = mesh.vertices[mesh.faces[0]]
    across = np.cross(b - a, c - a)
    assert mesh.normals is not None
    assert np.allclose(mesh.normals.values, across / np.linalg.norm(across), atol=1e-6)


@pytest.mark.parametrize(
    ("code", "kind", "scale"), [(5120, "i1", 127), (5121, "u1", 255), (5122, "<i2", 32767), (5123, "<u2", 65535)]
)
def test_whole_numbers_are_normalised(code: int, kind: str, scale: int) -> None:
    stored = np.array([[0, 0], [scale, scale // 2], [scale // 3, scale]], kind)
    points = np.zeros((3, 3), "<f4").tobytes()
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": code, "count": 3, "type": "VEC2", "normalized": True},
    ]
    views = [{"byteLength": 36}, {"byteOffset": 36, "byteLength": stored.nbytes}]
    mesh_list = [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}]}]
    (item,) = read(with_bytes(points + stored.tobytes(), views, accessors, meshes=mesh_list)).items
    assert isinstance(item.shape, Mesh)
    assert item.shape.uvs is not None
    # v is turned upward
    expected = np.stack([stored[:, 0] / scale, 1 - stored[:, 1] / scale], axis=1)
    assert np.allclose(item.shape.uvs.values, expected, atol=1e-7)


def test_the_least_signed_number_counts_as_minus_one() -> None:
    stored = np.array([[-128, -127, 0, 0]] * 3, "i1")
    accessors = [{"bufferView": 0, "componentType": 5120, "count": 3, "type": "VEC3", "normalized": True}]
    whole = with_bytes(stored.tobytes(), [{"byteLength": 12, "byteStride": 4}], accessors)
    (item,) = read(whole).items
    assert isinstance(item.shape, Mesh)
    assert item.shape.vertices.tolist() == [[-1, -1, 0]] * 3


def test_sparse_values_replace_zeros() -> None:
    points = np.array([[1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    sparse = {
        "count": 2,
        "indices": {"bufferView": 0, "componentType": 5121},
        "values": {"bufferView": 1},
    }
    accessors = [{"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse}]
    whole = with_bytes(points + bytes([1, 2]), [{"byteOffset": 24, "byteLength": 2}, {"byteLength": 24}], accessors)
    (item,) = read(whole).items
    assert item.shape == TRIANGLE


def test_texture_transforms_are_applied_to_the_coordinates() -> None:
    """The example of the extension: the lower left quarter of the picture, turned by a quarter."""
    uv = np.array([[0, 0], [1, 0], [1, 1]], "<f4")
    transform = {"offset": [0, 1], "rotation": math.pi / 2, "scale": [0.5, 0.5]}
    info = {"index": 0, "extensions": {"KHR_texture_transform": transform}}
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
    ]
    whole = with_bytes(
        bytes(36) + uv.tobytes(),
        [{"byteLength": 36}, {"byteOffset": 36, "byteLength": 24}],
        accessors,
        meshes=[{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": info}}],
        textures=[{"source": 0}],
        images=[{"uri": "none.png"}],
    )
    with pytest.warns(IsophoteWarning, match="magenta"):
        (item,) = read(whole).items
    assert isinstance(item.shape, Mesh)
    assert item.shape.uvs is not None
    found = item.shape.uvs.values
    assert np.allclose(found, [[0, 0], [0, 0.5], [0.5, 0.5]])
    assert isinstance(item.material, iso.Principled)
    assert item.material.colour_texture == ImageTexture.missing("none.png")


def test_missing_pictures_are_errors_when_asked_for() -> None:
    whole = document(
        meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        textures=[{"source": 0}],
        images=[{"uri": "none.png"}],
    )
    with pytest.raises(FileError, match=r"none\.png"):
        read(whole, strict=True)


def test_files_beside_it_may_have_blanks_in_their_names(tmp_path: Path) -> None:
    whole = document()
    (tmp_path / "my bytes.bin").write_bytes(base64.b64decode(whole["buffers"][0]["uri"].partition(",")[2]))
    whole["buffers"][0]["uri"] = "my%20bytes.bin"
    (tmp_path / "a.gltf").write_text(json.dumps(whole))
    assert load_mesh(tmp_path / "a.gltf") == TRIANGLE


def test_plain_glass_and_plain_lamps_are_recognised() -> None:
    glass = {
        "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.33}},
    }
    frosted = {**glass, "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.6}}
    lamp = {
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]},
        "emissiveFactor": [1, 0.5, 0],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
    }
    primitives = [{"attributes": {"POSITION": 0}, "material": i} for i in range(3)]
    items = read(document(materials=[glass, frosted, lamp], meshes=[{"primitives": primitives}])).items
    assert items[0].material == iso.Glass(1.33)
    assert items[1].material == iso.Glass(1.33, roughness=0.6)
    assert items[2].material == iso.Emitter((8, 4, 0))
    assert items[0].shape is items[2].shape


def test_a_mesh_of_many_parts_tells_their_materials() -> None:
    whole = document(
        materials=[{"name": "steel"}, {}],
        meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "material": i} for i in (0, 1)]}],
    )
    labels = read_gltf_mesh(Path("x.gltf"), json.dumps(whole).encode()).labels["material"]
    assert labels.names == ("steel", "material 1")
    assert labels.index.tolist() == [0, 1]
