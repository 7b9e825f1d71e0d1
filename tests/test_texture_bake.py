"""Textures baked into pictures: over the unit square and over the atlas of a mesh."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso

NOISE = iso.Ramp(iso.Fbm(iso.PerlinNoise(size=0.5), 3), ["navy", "gold"])


def quad(*, scale: float = 1.0) -> iso.Mesh:
    """A square in the plane z = 0.2, whose texture coordinates are the unit square."""
    corners = np.array([[0, 0, 0.2], [2, 0, 0.2], [2, 2, 0.2], [0, 2, 0.2]]) * scale
    uv = iso.Attribute(np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32))
    return iso.Mesh(corners, [[0, 1, 2, 3]], attributes={"uv": uv})


def test_over_the_square_texels_are_means() -> None:
    stripes = iso.Stripes(1.0, 0.0, 0.4, space="uv")
    baked = iso.bake_texture(stripes, size=5)
    assert baked.colour_space == "linear"
    np.testing.assert_allclose(baked.pixels[2, :, 0], [1, 0, 1, 0, 1], atol=1e-6)
    np.testing.assert_allclose(iso.bake_texture(stripes, size=2).pixels[..., 0], [[0.6, 0.6]] * 2, atol=1e-6)


def test_on_a_mesh_texels_are_what_stands_there() -> None:
    baked = iso.bake_texture(NOISE, quad(), size=16)
    middle = (np.arange(16) + 0.5) / 16
    u, v = np.meshgrid(middle, 1 - middle)
    own = np.stack([2 * u, 2 * v, np.full_like(u, 0.2)], axis=-1).reshape(-1, 3)
    axes = np.array([[1 / 16, 0, 0], [0, 1 / 16, 0]])
    expected = iso.texture_values(NOISE, own=own, own_axes=axes)[:, :3].reshape(16, 16, 3)
    np.testing.assert_allclose(baked.pixels, expected, atol=1e-5)


def test_an_item_stands_in_the_world() -> None:
    moved = iso.Item(quad(), transform=iso.Transform.identity().rotate("x", 0.5).translate((1, 2, 3)))
    placed = quad().with_(vertices=moved.transform.apply(quad().vertices))
    world = NOISE_IN_WORLD
    np.testing.assert_allclose(
        iso.bake_texture(world, moved, size=16).pixels, iso.bake_texture(world, placed, size=16).pixels, atol=1e-4
    )


NOISE_IN_WORLD = iso.Fbm(iso.PerlinNoise(size=0.5), 3, space="world")


def test_a_picture_that_is_baked_looks_like_its_formula() -> None:
    mesh = iso.unwrap(iso.to_mesh(iso.sphere(1.0), cell=0.2))
    camera = iso.Camera((0, 1, 3), (0, 0, 0), fov_degrees=35)

    def albedo(texture: iso.Texture) -> np.ndarray:
        scene = iso.Scene([iso.Item(mesh, iso.Matte(texture))], [iso.Sky()], camera)
        return iso.render(scene, iso.PathTrace(samples=4), size=(60, 60)).channels["albedo"]

    formula, baked = albedo(NOISE), albedo(iso.bake_texture(NOISE, mesh, size=512))
    assert formula.std() > 0.05
    assert np.abs(formula - baked).mean() < 0.01


def test_colours_are_encoded_as_files_want_them() -> None:
    floats = iso.bake_texture(NOISE, quad(), size=8).pixels
    levels = iso.bake_texture(NOISE, quad(), size=8, colour_space="srgb")
    assert levels.pixels.dtype == np.uint8
    np.testing.assert_allclose(iso.texture_values(levels, uv=CENTRES)[:, :3], floats.reshape(-1, 3), atol=0.004)


CENTRES = np.stack(np.meshgrid((np.arange(8) + 0.5) / 8, 1 - (np.arange(8) + 0.5) / 8), axis=-1).reshape(-1, 2)


def test_alpha_is_kept_where_there_is_any() -> None:
    clear = iso.ImageTexture(np.full((1, 1, 4), 0.5, np.float32))
    assert iso.bake_texture(iso.Placed(clear), size=4).channels == 4


def test_what_cannot_be_baked_is_refused() -> None:
    with pytest.raises(iso.GeometryError, match="no texture coordinates"):
        iso.bake_texture(NOISE, iso.to_mesh(iso.sphere(1.0), cell=0.5))
    with pytest.raises(iso.RenderError, match="only a Mesh has an atlas"):
        iso.bake_texture(NOISE, iso.sphere(1.0))
    with pytest.raises(iso.RenderError, match="size must be a whole number"):
        iso.bake_texture(NOISE, size=0)
    with pytest.raises(iso.RenderError, match="must be a Texture"):
        iso.bake_texture("red")


def test_files_tell_how_formulas_become_pictures(tmp_path) -> None:
    scene = iso.Scene([iso.Item(quad(), iso.Matte(NOISE))])
    with pytest.warns(iso.IsophoteWarning, match="bake_texture makes one of it"):
        iso.save(scene, tmp_path / "formula.glb")
    baked = iso.Scene([iso.Item(quad(), iso.Matte(iso.bake_texture(NOISE, quad(), size=8, colour_space="srgb")))])
    iso.save(baked, tmp_path / "baked.glb")
    again = iso.load_scene(tmp_path / "baked.glb").items[0].material
    assert again.colour.size == (8, 8)
