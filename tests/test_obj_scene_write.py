"""Scenes written as OBJ come back with their shapes in place, their materials and their textures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import isophote as iso

QUAD = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def square(**attributes: object) -> iso.Mesh:
    return iso.Mesh(QUAD, [(0, 1, 2, 3)], attributes=attributes)  # type: ignore[arg-type]


def test_materials_names_and_polygons_come_back(tmp_path: Path) -> None:
    picture = iso.ImageTexture(np.arange(48, dtype=np.uint8).reshape(4, 4, 3), wrap="clamp")
    uv = np.array(QUAD, float)[:, :2]
    items = [
        iso.Item(square(), iso.Matte((0.1, 0.25, 0.7)), name="wall"),
        iso.Item(square(uv=uv), iso.Matte(picture), name="picture on it"),
        iso.Item(square(), iso.Mirror((0.5, 0.75, 1.0))),
        iso.Item(square(), iso.Glass(1.33, (0.5, 1.0, 0.5)), name="wall"),
        iso.Item(square(), iso.Emitter((17, 12, 4)), name="lamp"),
    ]
    iso.save(iso.Scene(items), tmp_path / "room.obj")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["room.mtl", "room.obj", "room_0.png"]
    back = iso.load_scene(tmp_path / "room.obj", strict=True)
    assert [item.name for item in back.items] == ["wall", "picture on it", "item 2", "wall 2", "lamp"]
    for item, given in zip(back.items, items, strict=True):
        mesh = item.shape
        assert isinstance(mesh, iso.Mesh)
        assert mesh.vertices[mesh.indices].tolist() == square().vertices.tolist()
        if given.name != "picture on it":
            assert item.material == given.material
    texture = back.items[1].material.colour  # type: ignore[union-attr]
    assert isinstance(texture, iso.ImageTexture)
    assert np.array_equal(texture.pixels, picture.pixels)
    assert texture.wrap == "clamp"


def test_items_are_placed_and_mirrored_ones_keep_their_front(tmp_path: Path) -> None:
    normals = np.tile([0.0, 0.0, 1.0], (4, 1))
    mesh = square(normal=normals)
    items = [
        iso.Item(mesh, name="moved").scale((2, 3, 1)).rotate("x", np.pi / 2).translate((5, 0, 0)),
        iso.Item(mesh, name="mirrored", transform=iso.Transform.identity().mirror("z")),
    ]
    iso.save(iso.Scene(items), tmp_path / "placed.obj")
    for item, given in zip(iso.load_scene(tmp_path / "placed.obj").items, items, strict=True):
        back = item.shape
        assert isinstance(back, iso.Mesh)
        matrix = given.transform.matrix
        assert np.allclose(np.sort(back.vertices, axis=0), np.sort(given.transform.apply(mesh.vertices), axis=0))
        a, b, c = back.vertices[back.indices[:3]]
        front = np.cross(b - a, c - a)
        outward = np.linalg.inv(matrix[:3, :3]).T @ [0.0, 0.0, 1.0]
        assert front @ outward > 0
        held = back.normals
        assert held is not None
        assert np.allclose(held.values, outward / np.linalg.norm(outward))


def test_what_obj_has_no_place_for_is_told(tmp_path: Path) -> None:
    scene = iso.Scene([iso.Item(square())], lights=[iso.Sky()], camera=iso.Camera((0, 0, 3), (0, 0, 0)))
    with pytest.warns(iso.IsophoteWarning, match="no place for Sky, Camera"):
        iso.save(scene, tmp_path / "a.obj")


def test_a_scene_without_items_is_refused(tmp_path: Path) -> None:
    with pytest.raises(iso.FileError, match="no items"):
        iso.save(iso.Scene([]), tmp_path / "a.obj")
    assert not list(tmp_path.iterdir())
