"""Writing glTF and GLB: everything a scene holds, there and back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings

import isophote as iso
from gltf_files import (
    CHECKS,
    GLTF,
    ROUGH,
    SOLID,
    TRIANGLE,
    needs_models,
    there_and_back,
)
from isophote import (
    FileError,
    ImageTexture,
    IsophoteWarning,
    Item,
    Mesh,
    Scene,
    Transform,
    load_mesh,
    load_scene,
    save,
)
from isophote.io.gltf.read import read_gltf_mesh
from isophote.io.gltf.write import encode_gltf_mesh
from mesh_files import at_corners, meshes


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
    scene = Scene([Item(TRIANGLE, iso.Matte(ImageTexture(pixels)))])
    (item,) = there_and_back(scene, tmp_path).items
    assert isinstance(item.material, iso.Matte)
    assert isinstance(item.material.colour, ImageTexture)
    assert np.array_equal(item.material.colour.pixels, pixels)


def test_float_textures_become_the_nearest_bytes_with_a_warning(tmp_path: Path) -> None:
    scene = Scene([Item(TRIANGLE, iso.Matte(ImageTexture(np.array([[0.0, 0.5, 2.0]], np.float32))))])
    with pytest.warns(IsophoteWarning, match="8-bit srgb"):
        (item,) = there_and_back(scene, tmp_path).items
    assert isinstance(item.material, iso.Matte)
    assert isinstance(item.material.colour, ImageTexture)
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
            # The file holds single precision, however short; what is left of each normal has length 1 then.
            held = expected.astype(np.float32).astype(np.float64)
            lengths = np.linalg.norm(held, axis=1, keepdims=True)
            expected = np.divide(held, lengths, out=np.zeros_like(held), where=lengths > 0)
        assert np.allclose(values, expected, atol=1e-6)
        assert attribute.values.shape[1] == values.shape[1]


@needs_models
@pytest.mark.parametrize("ending", [".glb", ".gltf"])
def test_another_reader_finds_the_same_triangles(ending: str, tmp_path: Path) -> None:
    scene = load_scene(GLTF / "CesiumMilkTruck.glb")
    save(scene, tmp_path / f"truck{ending}")
    theirs = trimesh.load(tmp_path / f"truck{ending}", process=False).to_geometry()
    ours = load_mesh(GLTF / "CesiumMilkTruck.glb")
    mine = np.sort(ours.vertices[ours.indices], axis=0)
    assert np.allclose(mine, np.sort(np.asarray(theirs.vertices)[theirs.faces.ravel()], axis=0), atol=1e-5)
