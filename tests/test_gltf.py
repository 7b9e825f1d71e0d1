"""glTF and GLB: files of others, everything a scene holds there and back, and damaged files that are refused."""

from __future__ import annotations

import base64
import json
import math
import re
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import isophote as iso
import isophote.io.gltf.document as container
from isophote import (
    Error,
    FileError,
    IsophoteWarning,
    Item,
    Mesh,
    Scene,
    Texture,
    Transform,
    load_mesh,
    load_scene,
    save,
)
from isophote.io.gltf.read import read_gltf_mesh, read_gltf_scene
from isophote.io.gltf.write import encode_gltf_mesh, encode_gltf_scene
from mesh_files import MODELS, at_corners, meshes

Json = dict[str, Any]

GLTF = MODELS / "gltf"
FILES = sorted(path.relative_to(GLTF).as_posix() for path in GLTF.rglob("*.gl*"))
SOLID = [name for name in FILES if not re.search(r"Mode_0[0-3]", name)]
needs_models = pytest.mark.skipif(not MODELS.exists(), reason="the shared models are not here")
FUZZ = settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])

TRIANGLE = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
ACCESSOR = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
CHECKS = Texture(np.arange(48, dtype=np.uint8).reshape(4, 4, 3), name="checks", wrap="mirror", filter="nearest")
ROUGH = Texture(np.arange(48, dtype=np.uint8).reshape(4, 4, 3)[::-1].copy(), "linear", wrap="clamp")


def document(**parts: Any) -> Json:
    """A file of one triangle, which `parts` change."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    whole: Json = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)}],
        "buffers": [{"byteLength": len(points), "uri": data_uri(points)}],
    }
    return whole | parts


def data_uri(data: bytes) -> str:
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def read(whole: Json, **options: Any) -> Scene:
    return read_gltf_scene(Path("x.gltf"), json.dumps(whole).encode(), **options)


def with_bytes(data: bytes, views: list[Json], accessors: list[Json], **parts: Any) -> Json:
    buffers = [{"byteLength": len(data), "uri": data_uri(data)}]
    return document(
        buffers=buffers, bufferViews=[{"buffer": 0, **view} for view in views], accessors=accessors, **parts
    )


def refused(whole: Json) -> str:
    with pytest.raises(FileError) as caught:
        read(whole)
    return str(caught.value)


def there_and_back(scene: Scene, folder: Path, ending: str = ".glb") -> Scene:
    save(scene, folder / f"scene{ending}")
    return load_scene(folder / f"scene{ending}")


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


@needs_models
@pytest.mark.parametrize("name", SOLID)
@pytest.mark.parametrize("ending", [".glb", ".gltf"])
def test_files_of_others_come_back_as_they_were(name: str, ending: str, tmp_path: Path) -> None:
    scene = load_scene(GLTF / name)
    assert there_and_back(scene, tmp_path, ending) == scene


def test_every_material_comes_back(tmp_path: Path) -> None:
    materials = [
        iso.Matte((0.1, 0.2, 0.3)),
        iso.Matte(CHECKS),
        iso.Mirror((0.9, 0.8, 0.7)),
        iso.Glass(1.33, (0.9, 1.0, 0.9)),
        iso.Emitter((17.0, 12.0, 4.0), two_sided=True),
        iso.Emitter((0.5, 0.25, 0.1)),
        iso.Principled(
            (0.1, 0.5, 0.9),
            metallic=0.3,
            roughness=0.7,
            emission=(3.0, 0.1, 0.0),
            opacity=0.5,
            alpha_mode="mask",
            alpha_cutoff=0.25,
            two_sided=True,
            colour_texture=CHECKS,
            metallic_roughness_texture=ROUGH,
            normal_texture=ROUGH,
            normal_scale=2.0,
            occlusion_texture=ROUGH,
            occlusion_strength=0.5,
            emission_texture=CHECKS,
        ),
    ]
    scene = Scene([Item(TRIANGLE, material) for material in materials])
    assert there_and_back(scene, tmp_path) == scene


@pytest.mark.parametrize("shape", [(4, 5), (4, 5, 3), (4, 5, 4)])
def test_textures_come_back_bit_for_bit(shape: tuple[int, ...], tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, shape).astype(np.uint8)
    scene = Scene([Item(TRIANGLE, iso.Matte(Texture(pixels)))])
    (item,) = there_and_back(scene, tmp_path).items
    assert isinstance(item.material, iso.Matte)
    assert isinstance(item.material.colour, Texture)
    assert np.array_equal(item.material.colour.pixels, pixels)


def test_float_textures_become_the_nearest_bytes_with_a_warning(tmp_path: Path) -> None:
    scene = Scene([Item(TRIANGLE, iso.Matte(Texture(np.array([[0.0, 0.5, 2.0]], np.float32))))])
    with pytest.warns(IsophoteWarning, match="8-bit srgb"):
        (item,) = there_and_back(scene, tmp_path).items
    assert isinstance(item.material, iso.Matte)
    assert isinstance(item.material.colour, Texture)
    assert item.material.colour.pixels.tolist() == [[0, 188, 255]]


def test_cameras_and_lights_come_back(tmp_path: Path) -> None:
    camera = iso.Camera((3, 2, 4), (0, 0.5, 0), fov_degrees=35, lens_radius=0.1, focus_distance=3.0, pixel_aspect=1.25)
    lights = [iso.PointLight((1, 2, 3), 400, (1.0, 0.5, 4.0)), iso.Sun((0.3, 0.9, -0.2), 5.0), iso.Sun((0, -1, 0))]
    back = there_and_back(Scene([], lights, camera, "set"), tmp_path)
    assert back.name == "set"
    size = (64, 48)
    assert isinstance(back.camera, iso.Camera)
    for ours, theirs in zip(camera.linear_map(size), back.camera.linear_map(size), strict=True):
        assert np.allclose(ours, theirs, atol=1e-12)
    assert back.camera.target == pytest.approx(camera.target)
    point, sun, below = back.lights
    assert isinstance(point, iso.PointLight)
    assert point.position == (1, 2, 3)
    assert point.intensity_rgb == pytest.approx(lights[0].intensity_rgb)  # type: ignore[union-attr]
    for old, new in ((lights[1], sun), (lights[2], below)):
        assert isinstance(old, iso.Sun)
        assert isinstance(new, iso.Sun)
        assert new.unit_direction == pytest.approx(old.unit_direction)
        assert new.irradiance_rgb == pytest.approx(old.irradiance_rgb)


def test_parallel_cameras_come_back(tmp_path: Path) -> None:
    camera = iso.OrthographicCamera((1, 2, 3), (0, 0, 0), (0.1, 1, 0), height=4)
    back = there_and_back(Scene([], camera=camera), tmp_path).camera
    assert isinstance(back, iso.OrthographicCamera)
    for ours, theirs in zip(camera.linear_map((8, 6)), back.linear_map((8, 6)), strict=True):
        assert np.allclose(ours, theirs, atol=1e-12)


def test_other_lights_and_shapes_are_named_when_they_cannot_be_written(tmp_path: Path) -> None:
    with pytest.warns(IsophoteWarning, match="Sky"):
        save(Scene([Item(TRIANGLE)], [iso.Sky()]), tmp_path / "a.glb")

    class Ball:
        bounds = np.array([[-1, -1, -1], [1, 1, 1]])

    with pytest.raises(FileError, match=r"items\[1\].*Ball"):
        save(Scene([Item(TRIANGLE), Item(Ball())]), tmp_path / "b.glb")
    with pytest.raises(FileError, match=r"\.gltf, \.glb"):
        save(Scene([Item(TRIANGLE)]), tmp_path / "a.ply")
    with pytest.raises(FileError, match="32-bit floats"):
        save(Mesh(TRIANGLE.vertices * 1e300, [[0, 1, 2]]), tmp_path / "c.glb")
    assert [path.name for path in tmp_path.iterdir()] == ["a.glb"]


def test_a_shared_mesh_is_written_once(tmp_path: Path) -> None:
    grid = np.random.default_rng(0).random((3000, 3))
    mesh = Mesh(grid, np.arange(3000).reshape(-1, 3))
    placed = [Item(mesh, iso.Matte(0.01 * i), Transform.identity().translate((i, 0, 0))) for i in range(50)]
    save(Scene(placed[:1]), tmp_path / "one.glb")
    back = there_and_back(Scene(placed), tmp_path)
    assert len({id(item.shape) for item in back.items}) == 1
    one, fifty = (tmp_path / "one.glb").stat().st_size, (tmp_path / "scene.glb").stat().st_size
    assert fifty < one + 50 * 800


@settings(deadline=None, max_examples=60)
@pytest.mark.filterwarnings("ignore::isophote.errors.IsophoteWarning")
@given(meshes(single=True))
def test_polygons_with_attributes_at_corners_come_back_as_triangles(mesh: Mesh) -> None:
    cut = iso.triangulate(mesh)
    back = read_gltf_mesh(Path("x.glb"), encode_gltf_mesh(mesh, Path("x.glb")))
    corners = cut.corners.ravel()
    assert np.array_equal(back.vertices[back.indices], mesh.vertices[mesh.indices[corners]].astype(np.float32))
    for name, attribute in mesh.attributes.items():
        given_there = at_corners(mesh, name)[corners]
        if name not in back.attributes:
            assert name == "normal"
            assert np.isnan(given_there).any()
            continue
        neutral = {"uv": [0, 0], "colour": [1, 1, 1], "normal": [np.nan] * 3}[name]
        expected = np.where(np.isnan(given_there), neutral, given_there)
        values = at_corners(back, name)
        if name == "normal":
            lengths = np.linalg.norm(expected, axis=1, keepdims=True)
            expected = np.divide(expected, lengths, out=np.zeros_like(expected), where=lengths > 1e-30)
        assert np.allclose(values, expected, atol=1e-6)
        assert attribute.values.shape[1] == values.shape[1]


# Reading: one file for each thing that the format can say


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
    assert item.material.colour_texture == Texture.missing("none.png")


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
    assert isinstance(items[1].material, iso.Principled)
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


# Refusals


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ({"asset": {"version": "1.0"}}, "only version 2"),
        ({"asset": {}}, "no glTF"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "KHR_draco_mesh_compression"),
        ({"nodes": [{"mesh": 0, "children": [0]}]}, "two places"),
        ({"nodes": [{"children": [1]}, {"children": [2]}, {"children": [1]}]}, "two places"),
        ({"nodes": [{"mesh": 7}]}, r"no meshes\[7\]"),
        ({"nodes": [{"mesh": -1}]}, "whole number"),
        ({"nodes": [{"mesh": 0, "matrix": [1, 2]}]}, "16 finite numbers"),
        ({"nodes": [{"mesh": 0, "rotation": [0, 0, 0, 0]}]}, "quaternion"),
        ({"accessors": [{**ACCESSOR, "count": 4}]}, "needs 48 bytes"),
        ({"accessors": [{**ACCESSOR, "count": 10**12}]}, "bytes of a buffer view"),
        ({"accessors": [{**ACCESSOR, "count": 0}]}, "1 or more"),
        ({"accessors": [{**ACCESSOR, "byteOffset": 4}]}, "needs 40 bytes"),
        ({"accessors": [{**ACCESSOR, "type": "VEC2"}]}, "VEC3"),
        ({"accessors": [{**ACCESSOR, "componentType": 5124}]}, "componentType"),
        ({"accessors": [{"componentType": 5126, "count": 10**9, "type": "VEC3"}]}, "far more than the bytes"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 37}]}, "ends at byte 37"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 36, "byteStride": 4}]}, "stride of 4"),
        ({"buffers": [{"byteLength": 99, "uri": data_uri(bytes(36))}]}, "cut short"),
        ({"buffers": [{"byteLength": 36, "uri": "http://example.com/x.bin"}]}, "no file beside"),
        ({"buffers": [{"byteLength": 36, "uri": "data:,%%"}]}, "cut short"),
        ({"buffers": [{"byteLength": 36, "uri": "data:;base64,A!"}]}, "base64"),
        ({"buffers": [{"byteLength": 36, "uri": "none.bin"}]}, "no such file"),
        ({"buffers": [{"byteLength": 36}]}, "no binary chunk"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 9}]}]}, "0 to 6"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]}, r"no materials\[0\]"),
        ({"cameras": [{"perspective": {"yfov": 4}}], "nodes": [{"camera": 0}]}, "fov_degrees"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_reason(parts: Json, reason: str) -> None:
    assert re.search(reason, refused(document(**parts)))


def test_faces_out_of_range_and_endless_points_are_refused() -> None:
    points = np.zeros((3, 3), "<f4")
    accessors = [ACCESSOR, {"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}]
    views = [{"byteLength": 36}, {"byteOffset": 36, "byteLength": 3}]
    mesh_list = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    whole = with_bytes(points.tobytes() + bytes([0, 1, 9]), views, accessors, meshes=mesh_list)
    assert "names vertex 9" in refused(whole)
    points[1, 2] = np.nan
    whole = with_bytes(points.tobytes() + bytes([0, 1, 2]), views, accessors, meshes=mesh_list)
    assert "not finite" in refused(whole)


def test_many_uses_of_few_bytes_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Primitives of different corners cannot share, and a short file may ask for any number of them."""
    monkeypatch.setattr(container, "_FREE_BYTES", 1 << 20)
    monkeypatch.setattr(container, "_BYTES_PER_BYTE", 1)
    count = 3000
    accessors = [{**ACCESSOR, "count": 3 * count}]
    for i in range(200):
        indices = {"bufferView": 0, "componentType": 5125, "count": 9 * count - 3 * i, "type": "SCALAR"}
        accessors.append(indices)
    primitives = [{"attributes": {"POSITION": 0}, "indices": i + 1} for i in range(200)]
    data = bytes(36 * count)
    whole = with_bytes(data, [{"byteLength": len(data)}], accessors, meshes=[{"primitives": primitives}])
    assert "far more than the bytes" in refused(whole)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "JSON is broken"),
        (b"{", "JSON is broken"),
        (b"[]", "must be an object"),
        (b'{"asset": {"version": "2.0"}, "x": NaN}', "NaN"),
        (b"[" * 100_000, "JSON is broken"),
        (b"\xff\xfe\xff", "JSON is broken"),
        (b"glTF", "cut short"),
        (struct.pack("<4sIIII", b"glTF", 1, 20, 0, 0), "GLB 1"),
        (struct.pack("<4sIIII", b"glTF", 2, 99, 0, 0), "cut short"),
        (struct.pack("<4sIIII", b"glTF", 2, 20, 99, 0x4E4F534A), "ends beyond"),
        (struct.pack("<4sIIII", b"glTF", 2, 20, 0, 7), "must begin with"),
    ],
)
def test_broken_containers_are_refused(data: bytes, reason: str) -> None:
    with pytest.raises(FileError, match=reason):
        read_gltf_scene(Path("x.glb"), data)


def test_a_file_without_triangles_is_no_mesh() -> None:
    with pytest.raises(FileError, match="no triangles"):
        read_gltf_mesh(Path("x.gltf"), b'{"asset": {"version": "2.0"}}')


# Fuzzing: a valid file with everything in it, damaged


def _rich() -> bytes:
    corners = iso.Attribute(np.array([[0, 0], [1, 0], [0, 1.0]]), np.array([0, 1, 2, 2, 1, 0]))
    square = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], attributes={"uv": corners})
    items = [
        Item(square, iso.Matte(CHECKS), Transform.identity().rotate("x", 1), "a"),
        Item(square, iso.Principled(0.5, normal_texture=ROUGH, emission=(9, 9, 1))),
        Item(TRIANGLE, iso.Glass()),
    ]
    scene = Scene(items, [iso.PointLight((0, 1, 0)), iso.Sun((1, 1, 1))], iso.Camera((0, 0, 5), (0, 0, 0)))
    return encode_gltf_scene(scene, Path("x.glb"))


RICH = _rich()
JSON_SIZE = struct.unpack_from("<I", RICH, 12)[0]
VALUES = st.sampled_from(
    [0, 1, -1, 2, 3, 5121, 5126, 255, 2**31, 2**53, 10**12, 1.5, 1e308, None, True, "x", [], {}, [0], {"a": 1}]
)


def opened(data: bytes) -> None:
    """Reading ends in a value or in an error of this package, both ways."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for reader in (read_gltf_scene, read_gltf_mesh):
            try:
                result = reader(Path("x.glb"), data)
            except Error:
                continue
            assert isinstance(result, Scene | Mesh)


def test_the_file_that_is_damaged_below_is_whole() -> None:
    scene = read_gltf_scene(Path("x.glb"), RICH)
    assert len(scene.items) == 3
    assert len(scene.lights) == 2


@FUZZ
@given(st.data())
def test_damaged_bytes_give_a_scene_or_an_error(data: st.DataObject) -> None:
    damaged = bytearray(RICH)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(damaged) - 1))
        damaged[at : at + 2] = data.draw(st.binary(min_size=1, max_size=3))
    opened(bytes(damaged[: data.draw(st.integers(0, 3 * len(damaged)))]))


def places(value: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) within a JSON value."""
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else []
    return [(value, key) for key in keys] + [place for key in keys for place in places(value[key])]


@FUZZ
@given(st.data())
def test_inflated_and_misplaced_values_give_a_scene_or_an_error(data: st.DataObject) -> None:
    whole = json.loads(RICH[20 : 20 + JSON_SIZE])
    whole["buffers"][0]["uri"] = data_uri(RICH[28 + JSON_SIZE :])
    for _ in range(data.draw(st.integers(1, 3))):
        container, key = data.draw(st.sampled_from(places(whole)))
        container[key] = data.draw(VALUES)
    opened(json.dumps(whole).encode())


@FUZZ
@given(st.sampled_from([b"", RICH[:12], RICH[:20], b'{"asset":{"version":"2.0"},']), st.binary(max_size=200))
def test_noise_gives_a_scene_or_an_error(beginning: bytes, noise: bytes) -> None:
    opened(beginning + noise)
