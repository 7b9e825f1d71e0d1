"""What glTF says of relief and holes, written and read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import isophote as iso

_MODELS = Path(__file__).parents[1] / "../shared/models"
_GENERATOR = np.random.default_rng(5)


def _square() -> iso.Mesh:
    attributes = {
        "uv": np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32),
        "normal": np.tile(np.float32([0, 0, 1]), (4, 1)),
    }
    mesh = iso.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]], attributes=attributes)
    return mesh.with_(attributes={**mesh.attributes, "tangent": iso.tangents(mesh)})


def _texels(channels: int) -> np.ndarray:
    return _GENERATOR.integers(0, 256, (8, 8, channels)).astype(np.uint8)


def _round_trip(item: iso.Item, path: Path) -> iso.Item:
    iso.save(iso.Scene([item]), path)
    return iso.load_scene(path).items[0]


@pytest.mark.parametrize("ending", ["glb", "gltf"])
def test_a_material_with_everything_comes_back(tmp_path: Path, ending: str) -> None:
    material = iso.Principled(
        (0.5, 0.25, 1.0),
        metallic=0.25,
        roughness=0.75,
        opacity=0.5,
        alpha_mode="mask",
        alpha_cutoff=0.25,
        two_sided=True,
        colour_texture=iso.ImageTexture(_texels(4), name="colour"),
        metallic_roughness_texture=iso.ImageTexture(_texels(3), "linear", name="rough"),
        normal_texture=iso.ImageTexture(_texels(3), "linear", name="normal"),
        normal_scale=0.5,
        occlusion_texture=iso.ImageTexture(_texels(3), "linear", name="open"),
        occlusion_strength=0.5,
        emission_texture=iso.ImageTexture(_texels(3), name="glow"),
    )
    found = _round_trip(iso.Item(_square(), material), tmp_path / f"a.{ending}")
    assert found.material == material


def test_tangents_come_back(tmp_path: Path) -> None:
    mesh = _square()
    turned = np.tile(np.float32([0.6, 0.8, 0.0, -1.0]), (4, 1))
    mesh = mesh.with_(attributes={**mesh.attributes, "tangent": turned})
    found = _round_trip(iso.Item(mesh), tmp_path / "a.glb").shape
    assert isinstance(found, iso.Mesh)
    np.testing.assert_array_equal(found.attributes["tangent"].values, turned)
    # As one mesh, mirrored: the tangent goes along, and the other axis turns around.
    mirrored = iso.Item(mesh, transform=iso.Transform.identity().scale((-2, 2, 2)))
    iso.save(iso.Scene([mirrored]), tmp_path / "b.glb")
    attribute = iso.load_mesh(tmp_path / "b.glb").attributes["tangent"]
    np.testing.assert_allclose(attribute.values, np.tile([-0.6, 0.8, 0.0, 1.0], (4, 1)), atol=1e-6)


def test_tangents_of_the_file_are_what_is_drawn(tmp_path: Path) -> None:
    lean = iso.ImageTexture(np.array([[[0.8, 0.5, 0.9]]], np.float32), "linear", filter="nearest")
    mesh = _square()
    turned = mesh.with_(attributes={**mesh.attributes, "tangent": np.tile(np.float32([0, 1, 0, 1]), (4, 1))})
    camera = iso.Camera(eye=(0.5, 0.5, 3), target=(0.5, 0.5, 0), fov_degrees=10)
    for shape, expected in ((mesh, (0.6, 0, 0.8)), (turned, (0, 0.6, 0.8))):
        scene = iso.Scene([iso.Item(shape, iso.NormalMap(iso.Matte(), lean))], [iso.PointLight((0, 0, 3), 9)], camera)
        seen = iso.render(scene, iso.RayTrace(), size=(4, 3)).channels["normal"][1, 2]
        np.testing.assert_allclose(seen, expected, atol=1e-5)


def test_wrapped_materials_are_written_as_the_file_says_them(tmp_path: Path) -> None:
    normal = iso.ImageTexture(_texels(3), "linear", name="n")
    leaf = iso.ImageTexture(_texels(4), name="leaf")
    cut = iso.Cutout(iso.NormalMap(iso.Matte(leaf), normal, 0.5), leaf, mode="mask", cutoff=0.25)
    found = _round_trip(iso.Item(_square(), cut), tmp_path / "a.glb").material
    assert isinstance(found, iso.Principled)
    assert found.normal_texture == normal
    assert found.normal_scale == 0.5
    assert found.colour_texture == leaf
    assert (found.alpha_mode, found.alpha_cutoff) == ("mask", 0.25)


def test_opacity_of_its_own_is_joined_to_the_colour(tmp_path: Path) -> None:
    colour, holes = iso.ImageTexture(_texels(3)), iso.ImageTexture(_texels(1), "linear")
    for base in (iso.Matte(colour), iso.Matte("tomato")):
        found = _round_trip(iso.Item(_square(), iso.Cutout(base, holes)), tmp_path / "a.glb").material
        assert isinstance(found, iso.Principled)
        assert found.alpha_mode == "blend"
        assert isinstance(found.colour_texture, iso.ImageTexture)
        np.testing.assert_array_equal(found.colour_texture.pixels[..., 3], holes.pixels[..., 0])
    veil = _round_trip(iso.Item(_square(), iso.Cutout(iso.Matte(), 0.25)), tmp_path / "a.glb").material
    assert isinstance(veil, iso.Principled)
    assert (veil.opacity, veil.alpha_mode) == (0.25, "blend")


def test_a_real_model_keeps_its_relief(tmp_path: Path) -> None:
    path = _MODELS / "gltf/TwoSidedPlane/TwoSidedPlane.gltf"
    if not path.exists():
        pytest.skip("the model is not there")
    before = iso.load_scene(path)
    iso.save(before, tmp_path / "a.glb")
    after = iso.load_scene(tmp_path / "a.glb")
    assert after.items[0].material == before.items[0].material
    assert isinstance(before.items[0].shape, iso.Mesh)
    assert after.items[0].shape == before.items[0].shape
