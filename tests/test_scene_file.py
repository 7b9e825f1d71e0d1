"""Scenes from mesh files: one item for each material of an OBJ, one item for other meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image as Pillow

import isophote as iso
from isophote import FileError, ImageTexture, IsophoteWarning, Mesh, load_mesh, load_scene, save
from isophote.io.mtl import MtlMaterial, parse_mtl
from mesh_files import MODELS

needs_models = pytest.mark.skipif(not MODELS.exists(), reason="the shared models are not here")

OBJ = """mtllib my materials.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
usemtl {0}
f 1/1 2/2 3/3
usemtl {1}
f 1/1 3/3 4/2
usemtl {0}
f 4/1 3/3 2/2
"""


def obj_scene(folder: Path, mtl: str, names: tuple[str, str] = ("a", "b"), strict: bool = False) -> iso.Scene:
    (folder / "x.obj").write_text(OBJ.format(*names))
    (folder / "my materials.mtl").write_text(mtl)
    return load_scene(folder / "x.obj", strict=strict)


def material(folder: Path, mtl: str) -> object:
    return obj_scene(folder, f"newmtl a\n{mtl}\nnewmtl b\n").items[0].material


def test_each_material_gets_its_faces_vertices_and_corners(tmp_path: Path) -> None:
    first, second = obj_scene(tmp_path, "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 0 1\n").items
    assert (first.name, second.name) == ("a", "b")
    assert first.material == iso.Matte((1, 0, 0))
    assert second.material == iso.Matte((0, 0, 1))
    assert isinstance(first.shape, Mesh)
    assert isinstance(second.shape, Mesh)
    whole = load_mesh(tmp_path / "x.obj")
    for part, faces in ((first.shape, [0, 2]), (second.shape, [1])):
        assert part.face_count == len(faces)
        corners = np.concatenate([np.arange(*whole.offsets[[f, f + 1]]) for f in faces])
        assert np.array_equal(part.vertices[part.indices], whole.vertices[whole.indices[corners]])
        assert part.uvs is not None
        assert whole.uvs is not None
        ours = part.uvs.values[part.indices if part.uvs.indices is None else part.uvs.indices]
        theirs = whole.uvs.values[whole.indices if whole.uvs.indices is None else whole.uvs.indices]
        assert np.array_equal(ours, theirs[corners])
    assert len(second.shape.vertices) == 3


def test_parts_lack_the_attributes_that_none_of_their_corners_has(tmp_path: Path) -> None:
    text = OBJ.format("a", "b").replace("f 1/1 3/3 4/2", "f 1 3 4")
    (tmp_path / "x.obj").write_text(text)
    (tmp_path / "my materials.mtl").write_text("newmtl a\nnewmtl b\n")
    first, second = load_scene(tmp_path / "x.obj").items
    assert isinstance(first.shape, Mesh)
    assert isinstance(second.shape, Mesh)
    assert first.shape.uvs is not None
    assert second.shape.uvs is None


@pytest.mark.parametrize(
    ("mtl", "expected"),
    [
        ("Kd 0.5 0.25 0.125", iso.Matte((0.5, 0.25, 0.125))),
        ("Kd 0.5", iso.Matte(0.5)),
        ("Kd spectral x.rfl 1", iso.Matte()),
        ("Kd -1 0 0", iso.Matte(0)),
        ("", iso.Matte()),
        ("Kd 0 0 0\nKe 17 12 4", iso.Emitter((17, 12, 4))),
        ("Kd 1 1 1\nKe 0 0 0", iso.Matte(1)),
        ("illum 3\nKs 0.9 0.8 0.7", iso.Mirror((0.9, 0.8, 0.7))),
        ("illum 5", iso.Mirror()),
        ("illum 7\nNi 1.5\nTf 0.9 1 0.9", iso.Glass(1.5, (0.9, 1, 0.9))),
        ("illum 4\nd 0.1\nNi 1", iso.Glass(1.5)),
        ("illum 6\nTr 0.9", iso.Glass(1.5)),
        ("illum 9\nNi 1\nd 1\nKd 1 0 0", iso.Matte((1, 0, 0))),
        ("illum 2\nNi 1.45\nKd 1 0 0", iso.Matte((1, 0, 0))),
        ("\tKd\t1 0\t0 # red", iso.Matte((1, 0, 0))),
        ("KD 1 0 0\nillum x\nNi nan\nfoo 3", iso.Matte((1, 0, 0))),
    ],
)
def test_materials_become_the_nearest_of_ours(mtl: str, expected: object, tmp_path: Path) -> None:
    assert material(tmp_path, mtl) == expected


@pytest.mark.parametrize(
    "options", ["", "-clamp on ", "-s 2 2 2 ", "-o 0.5 -clamp on -s 2 ", "-mm 0 1 -bm 1.5 ", "-t 1 2 -blendu off "]
)
def test_names_of_textures_follow_their_options_and_may_have_blanks(options: str, tmp_path: Path) -> None:
    Pillow.new("RGB", (2, 1), (10, 20, 30)).save(tmp_path / "my picture.png")
    found = material(tmp_path, f"map_Kd {options}my picture.png")
    assert isinstance(found, iso.Matte)
    assert isinstance(found.colour, ImageTexture)
    assert found.colour.pixels.tolist() == [[[10, 20, 30]] * 2]
    assert found.colour.wrap == ("clamp" if "-clamp" in options else "repeat")


def test_what_is_missing_is_told_and_replaced(tmp_path: Path) -> None:
    with pytest.warns(IsophoteWarning, match=r"none\.png.*magenta"):
        found = material(tmp_path, "map_Kd none.png")
    assert found == iso.Matte(ImageTexture.missing("none.png"))
    with pytest.warns(IsophoteWarning, match='no material "b"'):
        assert obj_scene(tmp_path, "newmtl a\n").items[1].material == iso.Matte()
    (tmp_path / "y.obj").write_text("mtllib none.mtl\n" + OBJ.partition("\n")[2].format("a", "a"))
    with pytest.warns(IsophoteWarning) as told:
        (item,) = load_scene(tmp_path / "y.obj").items
    assert any("none.mtl" in str(warning.message) for warning in told)
    assert item.material == iso.Matte()
    for path in ("x.obj", "y.obj"):
        with pytest.raises(FileError):
            load_scene(tmp_path / path, strict=True)


def test_several_libraries_may_stand_on_one_line(tmp_path: Path) -> None:
    text = OBJ.format("a", "b").replace("my materials.mtl", "one.mtl two.mtl")
    (tmp_path / "x.obj").write_text(text)
    (tmp_path / "one.mtl").write_text("newmtl a\nKd 1 0 0\n")
    (tmp_path / "two.mtl").write_text("newmtl b\nKd 0 1 0\n")
    assert [item.material for item in load_scene(tmp_path / "x.obj").items] == [
        iso.Matte((1, 0, 0)),
        iso.Matte((0, 1, 0)),
    ]


@given(st.binary(max_size=300) | st.text(max_size=200).map(str.encode))
def test_any_bytes_are_materials_of_some_kind(data: bytes) -> None:
    for prefix in (b"", b"newmtl a\n", b"newmtl a\nmap_Kd "):
        assert all(isinstance(found, MtlMaterial) for found in parse_mtl(prefix + data).values())


@needs_models
def test_the_cornell_box_has_its_lamp_and_coloured_walls() -> None:
    scene = load_scene(MODELS / "scene/CornellBox-Original.obj", strict=True)
    named = {item.name: item.material for item in scene.items}
    assert len(scene.items) == 8
    assert named["light"] == iso.Emitter((17, 12, 4))
    assert named["leftWall"] == iso.Matte((0.63, 0.065, 0.05))
    assert named["rightWall"] == iso.Matte((0.14, 0.45, 0.091))
    assert sum(item.shape.face_count for item in scene.items if isinstance(item.shape, Mesh)) == 18
    assert (scene.camera, scene.lights) == (None, ())


@needs_models
def test_a_texture_with_a_blank_in_its_name_is_found() -> None:
    (item,) = load_scene(MODELS / "textured/fuze.obj", strict=True).items
    assert isinstance(item.material, iso.Matte)
    assert isinstance(item.material.colour, ImageTexture)
    assert item.material.colour.size == (1024, 1024)
    assert item.shape.face_count == 1000  # type: ignore[attr-defined]


@needs_models
@pytest.mark.parametrize(
    "name", ["closed/fox.ply", "textured/spot/spot_triangulated.obj", "formats/comments.off", "broken/soup.stl"]
)
def test_other_mesh_files_are_one_item(name: str, tmp_path: Path) -> None:
    (item,) = load_scene(MODELS / name).items
    assert item.shape == load_mesh(MODELS / name)
    assert item.name == Path(name).stem


@needs_models
def test_an_obj_with_materials_survives_a_glb(tmp_path: Path) -> None:
    scene = load_scene(MODELS / "scene/CornellBox-Original.obj")
    with pytest.warns(IsophoteWarning, match='labels "group"'):
        save(scene, tmp_path / "box.glb")
    back = load_scene(tmp_path / "box.glb")
    assert [item.material for item in back.items] == [item.material for item in scene.items]
    assert np.allclose(back.bounds, scene.bounds, atol=1e-6)


def test_unknown_endings_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_bytes(b"1 2 3")
    for name in ("a.xyz", "a", "none.glb"):
        with pytest.raises(FileError):
            load_scene(tmp_path / name)
