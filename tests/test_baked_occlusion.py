"""Occlusion in textures: against points, closed forms and the faces it belongs to; its files; what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pillow

import isophote as iso
from command_line import misused, refuses, succeeds
from isophote.errors import FileError, GeometryError, RenderError
from isophote.kernels.light.uv_cover import cover_texels
from isophote.rendering.occlusion.atlas import atlas_of
from scenes import icosphere

CORNERS = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
# A right angle: a floor, and a wall at its side x = 1, each with half of the atlas.
FOLD = iso.Mesh(
    [(0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 0, 0), (1, 1, 0), (1, 1, 1)],
    [(0, 1, 2, 3), (3, 2, 5, 4)],
    attributes={
        "uv": iso.Attribute(
            np.array([(0, 0), (0, 1), (0.45, 1), (0.45, 0), (0.55, 0), (0.55, 1), (1, 1), (1, 0)], float), np.arange(8)
        )
    },
)


def ground(half: float = 1.0) -> iso.Mesh:
    """A square on the ground whose u runs along x and v along −z, once over the atlas."""
    x = 2 * CORNERS[:, 0] - 1
    z = 1 - 2 * CORNERS[:, 1]
    return iso.Mesh(half * np.stack([x, 0 * x, z], axis=1), [(0, 1, 2, 3)], attributes={"uv": CORNERS})


def test_a_ground_beside_a_wall() -> None:
    height, far = 0.8, 300.0
    wall = iso.Mesh([(1, 0, -far), (1, 0, far), (1, height, far), (1, height, -far)], [(0, 1, 2, 3)])
    floor = iso.Item(ground())
    found = iso.bake_occlusion(floor, size=32, samples=256, among=iso.Scene([floor, iso.Item(wall)]), bias=1e-4)
    distance = 1 - (-1 + 2 * (np.arange(32) + 0.5) / 32)
    exact = 1 - 0.5 * (1 - distance / np.hypot(distance, height))
    assert found.coverage.all()
    np.testing.assert_allclose(found.visibility.mean(axis=0), exact, atol=0.01)
    short = iso.bake_occlusion(floor, size=32, samples=64, among=iso.Scene([floor, iso.Item(wall)]), max_distance=0.5)
    assert (short.visibility[:, distance > 0.5] == 1).all()
    assert (short.visibility[:, distance < 0.4].mean(axis=0) < 1).all()


def test_rows_begin_at_the_top() -> None:
    # A wall at the far side, z = −1, where v = 1.
    wall = iso.Mesh([(-9, 0, -1), (9, 0, -1), (9, 1, -1), (-9, 1, -1)], [(0, 1, 2, 3)])
    floor = iso.Item(ground())
    rows = iso.bake_occlusion(floor, size=16, among=iso.Scene([floor, iso.Item(wall)])).visibility.mean(axis=1)
    assert rows[0] < 0.6
    assert (np.diff(rows) > -0.02).all()
    assert rows[-1] > 0.9


@pytest.mark.parametrize("placed", [False, True])
def test_texels_are_what_points_are_told(placed: bool) -> None:
    item = iso.Item(FOLD)
    if placed:
        item = item.scale((1, 2, 0.5)).rotate("x", 0.4).translate((3, 1, -2))
    size, samples = 24, 256
    found = iso.bake_occlusion(item, size=size, samples=samples, seed=5)
    atlas = atlas_of(FOLD, size)
    points, normals = atlas.places(0, len(atlas.triangle))
    matrix = item.transform.matrix
    points, normals = points @ matrix[:3, :3].T + matrix[:3, 3], normals @ np.linalg.inv(matrix[:3, :3])
    told = iso.ambient_occlusion(item, points, normals, samples=4096, seed=9).visibility
    sigma = np.sqrt(np.maximum(told * (1 - told), 1e-3) * (1 / samples + 1 / 4096))
    off = np.abs(found.visibility[found.coverage] - told) / sigma
    # Owen–Sobol samples are better than independent ones, whose three sigmas these are.
    assert np.mean(off < 3) > 0.995
    assert off.max() < 5
    assert 0.4 < told.min() < 0.6 < 0.9 < told.max()


def test_every_touched_texel_has_a_place_on_its_face() -> None:
    rng = np.random.default_rng(4)
    triangles = rng.uniform(1, 31, (40, 3, 2))
    triangles[::4, 2] = triangles[::4, 1] + rng.uniform(-0.02, 0.02, (10, 2))
    for triangle in triangles:
        owner, distance = np.full((32, 32), -1, np.int32), np.full((32, 32), np.inf, np.float32)
        weights, crowded = np.zeros((32, 32, 2), np.float32), np.zeros((32, 32), np.uint8)
        cover_texels(triangle[None].copy(), owner, distance, weights, crowded)
        w = rng.dirichlet((0.5, 0.5, 0.5), 20_000)
        inside = (w @ triangle).astype(int)
        assert (owner[inside[:, 1], inside[:, 0]] == 0).all()
        rows, columns = np.nonzero(owner == 0)
        v, u = weights[rows, columns].T
        places = (1 - v - u)[:, None] * triangle[0] + v[:, None] * triangle[1] + u[:, None] * triangle[2]
        assert min(v.min(), u.min(), (1 - v - u).min()) > -1e-5
        centres = np.stack([columns, rows], axis=1) + 0.5
        far = np.linalg.norm(places - centres, axis=1)
        np.testing.assert_allclose(far, np.maximum(distance[rows, columns], 0), atol=1e-4)
        # No sampled place of the triangle is nearer to a centre than the one found.
        sampled = np.linalg.norm((w[:2000] @ triangle)[None] - centres[:, None], axis=2).min(axis=1)
        assert (far <= sampled + 1e-4).all()
        assert not crowded.any()


def test_gutters_repeat_the_nearest_texel_and_leave_faces_alone() -> None:
    bare, wide = (iso.bake_occlusion(FOLD, size=128, samples=8, gutter=g) for g in (0, 3))
    np.testing.assert_array_equal(bare.coverage, wide.coverage)
    np.testing.assert_array_equal(bare.visibility[bare.coverage], wide.visibility[bare.coverage])
    assert (bare.visibility[~bare.coverage] == 1).all()
    # Charts are columns: 0 to 0.45 and 0.55 to 1.
    last, first = (int(f(np.flatnonzero(~bare.coverage[0]))) for f in (np.min, np.max))
    for step in range(3):
        np.testing.assert_array_equal(wide.visibility[:, last + step], bare.visibility[:, last - 1])
        np.testing.assert_array_equal(wide.visibility[:, first - step], bare.visibility[:, first + 1])


def test_any_number_of_threads_gives_the_same() -> None:
    one, two, other = (
        iso.bake_occlusion(FOLD, size=48, threads=t, seed=s).visibility for t, s in ((1, 1), (2, 1), (2, 2))
    )
    np.testing.assert_array_equal(one, two)
    assert (one != other).any()


def test_an_unwrapped_ball_is_open() -> None:
    pytest.importorskip("xatlas")
    found = iso.bake_occlusion(iso.unwrap(icosphere(2), size=128), size=128, samples=16)
    assert 0.3 < found.coverage.mean() < 1
    np.testing.assert_array_equal(found.visibility, 1)


def test_rays_from_higher_up_clear_the_faces_around_that_normals_between_corners_reach_below() -> None:
    pytest.importorskip("xatlas")
    ball = icosphere(1)
    smooth = iso.unwrap(ball.with_(attributes={"normal": ball.vertices}), size=64)
    low, high = (iso.bake_occlusion(smooth, size=64, bias=bias).visibility.min() for bias in (None, 0.03))
    assert low < high == 1


def test_a_glb_keeps_the_texture_in_its_slot(tmp_path: Path) -> None:
    baked = iso.bake_occlusion(FOLD, size=32, samples=32)
    material = iso.Principled("tomato", occlusion_texture=baked.texture, occlusion_strength=0.5)
    iso.save(iso.Scene([iso.Item(FOLD, material)]), tmp_path / "fold.glb")
    data = (tmp_path / "fold.glb").read_bytes()
    (stored,) = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])["materials"]
    assert stored["occlusionTexture"] == {"index": 0, "strength": 0.5}
    (item,) = iso.load_scene(tmp_path / "fold.glb").items
    assert isinstance(item.material, iso.Principled)
    kept = item.material.occlusion_texture
    assert kept is not None
    assert (kept.colour_space, kept.wrap, item.material.occlusion_strength) == ("linear", "clamp", 0.5)
    pixels = kept.pixels.reshape(32, 32, -1)[..., 0]
    np.testing.assert_array_equal(pixels, baked.texture.pixels)
    np.testing.assert_allclose(pixels / 255, baked.visibility, atol=0.5 / 255 + 1e-6)


def test_the_command_bakes(tmp_path: Path) -> None:
    model = tmp_path / "fold.glb"
    iso.save(iso.Scene([iso.Item(FOLD, iso.Matte("tomato"))]), model)
    settings = ("--size", "32", "--samples", "32", "--max-distance", "0.5")
    succeeds("bake", model, "-o", tmp_path / "out.glb", *settings)
    told = json.loads(succeeds("bake", model, "-o", tmp_path / "ao.png", *settings, "--json"))
    (one,) = told["maps"]
    assert one["size"] == 32
    assert 0 < one["covered texels"] <= 32 * 32
    assert 0.3 < one["mean visibility"] < 1
    (item,) = iso.load_scene(tmp_path / "out.glb").items
    assert isinstance(item.material, iso.Principled)
    assert item.material.occlusion_texture is not None
    held = item.material.occlusion_texture.pixels.reshape(32, 32, -1)[..., 0]
    with Pillow.open(tmp_path / "ao.png") as picture:
        assert picture.mode == "L"
        np.testing.assert_array_equal(np.asarray(picture), held)
    baked = iso.bake_occlusion(FOLD, size=32, samples=32, max_distance=0.5)
    assert np.abs(held / 255 - baked.visibility).mean() < 0.05
    assert held.min() < 200


def test_the_command_unwraps_and_refuses(tmp_path: Path) -> None:
    pytest.importorskip("xatlas")
    iso.save(icosphere(1), tmp_path / "ball.ply")
    succeeds("bake", tmp_path / "ball.ply", "-o", tmp_path / "ball.glb", "--size", "64", "--samples", "4")
    (item,) = iso.load_scene(tmp_path / "ball.glb").items
    assert isinstance(item.shape, iso.Mesh)
    assert item.shape.uvs is not None
    assert isinstance(item.material, iso.Principled)
    assert item.material.occlusion_texture is not None
    two = iso.Scene([iso.Item(FOLD), iso.Item(FOLD).translate((3, 0, 0))])
    iso.save(two, tmp_path / "two.glb")
    assert "2 meshes" in refuses("bake", tmp_path / "two.glb", "-o", tmp_path / "ao.png")
    (tmp_path / "field.py").write_text("import isophote as iso\nshape = iso.sphere(1)\n")
    assert "no mesh" in refuses("bake", tmp_path / "field.py", "-o", tmp_path / "ao.glb")
    assert "--output" in misused("bake", tmp_path / "two.glb", "-o", tmp_path / "ao.jpg")
    assert not (tmp_path / "ao.png").exists()


def test_the_command_makes_new_coordinates_where_it_may(tmp_path: Path) -> None:
    pytest.importorskip("xatlas")
    tiled = ground().with_(attributes={"uv": CORNERS * 3})
    model, out = tmp_path / "tiled.glb", tmp_path / "out.glb"
    settings = ("-o", out, "--size", "32", "--samples", "4")
    iso.save(iso.Scene([iso.Item(tiled, name="floor")]), model)
    said = refuses("bake", model, *settings)
    assert "floor" in said
    assert "--unwrap" in said
    succeeds("bake", model, *settings, "--unwrap")
    (item,) = iso.load_scene(out).items
    assert isinstance(item.shape, iso.Mesh)
    assert item.shape.uvs is not None
    assert 0 <= item.shape.uvs.values.min() < item.shape.uvs.values.max() <= 1
    out.unlink()
    checker = iso.ImageTexture(np.array([[0, 255], [255, 0]], np.uint8))
    iso.save(iso.Scene([iso.Item(tiled, iso.Principled("white", colour_texture=checker))]), model)
    assert "textures" in refuses("bake", model, *settings, "--unwrap")
    assert not out.exists()


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"size": 0}, "size"),
        ({"size": 60_000}, "GiB"),
        ({"samples": 1.5}, "samples"),
        ({"gutter": -1}, "gutter"),
        ({"max_distance": 0}, "max_distance"),
        ({"bias": -1.0}, "bias"),
        ({"seed": "x"}, "seed"),
    ],
)
def test_numbers_without_meaning_are_refused(change: dict[str, object], word: str) -> None:
    with pytest.raises(RenderError, match=word):
        iso.bake_occlusion(FOLD, **{"size": 16, **change})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("mesh", "word"),
    [
        (icosphere(1), "no texture coordinates.*unwrap"),
        (ground().with_(attributes={"uv": CORNERS * 2}), "within 0 and 1.*unwrap"),
        (ground().with_(attributes={"uv": CORNERS * np.nan}), "within 0 and 1"),
        (iso.Mesh(ground().vertices, [(0, 1, 2, 3)] * 2, attributes={"uv": CORNERS}), "overlap.*unwrap"),
        (iso.Mesh(ground().vertices, [(0, 1, 2, 3)] * 2, attributes={"uv": CORNERS / 2}), "overlap.*unwrap"),
        (iso.Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)], attributes={"uv": CORNERS[:3]}), "no face"),
    ],
)
def test_atlases_that_hold_nothing_are_refused(mesh: iso.Mesh, word: str) -> None:
    with pytest.raises(GeometryError, match=word):
        iso.bake_occlusion(mesh, size=32)


def test_only_meshes_are_baked_and_only_pngs_written(tmp_path: Path) -> None:
    with pytest.raises(RenderError, match="only a Mesh"):
        iso.bake_occlusion(iso.sphere(1))  # type: ignore[arg-type]
    with pytest.raises(FileError, match="png"):
        iso.bake_occlusion(ground(), size=4, samples=1).save(tmp_path / "ao.jpg")
