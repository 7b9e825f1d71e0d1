"""`isophote info`: topology and defects as a table, as JSON and in a picture; and the marks of the picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from command_line import facts, misused, refuses, succeeds, written
from isophote.analysis import mass_properties, topology
from isophote.cli.defect_picture import COLOURS
from isophote.convert.markers import balls, tubes
from surfaces import CUBE, cube, mesh_of, plate_with_holes, together


def saved(folder: Path, mesh: iso.Mesh, name: str = "mesh.obj") -> Path:
    path = folder / name
    iso.save(mesh, path)
    return path


def test_a_solid(tmp_path: Path) -> None:
    path = saved(tmp_path, plate_with_holes(2))
    found = facts("info", path)
    judged = found["topology"]
    assert (judged["closed"], judged["manifold"], judged["oriented"], judged["genus"]) == (True, True, True, 2)
    assert judged["V"] - judged["E"] + judged["F"] == judged["euler"] == -2
    assert found["solid"]["volume"] == pytest.approx(13)
    assert found["components"] is None
    assert found["defects"] == {}
    page = succeeds("info", path)
    assert "genus: 2" in page
    assert "closed: yes" in page
    assert "defects" not in page


def test_what_is_wrong(tmp_path: Path) -> None:
    faces = [(0, 1, 2), (1, 0, 3), (0, 1, 4), (5, 6, 7), (6, 5, 8), (9, 10, 11), (9, 10, 12)]
    path = saved(tmp_path, mesh_of([*faces, (10, 9, 10)]))
    found = facts("info", path)
    defects = found["defects"]
    assert defects["non_manifold_edges"] == {"count": 1, "first": [[0, 1]]}
    assert defects["turned_edges"] == {"count": 1, "first": [[9, 10]]}
    assert defects["degenerate_faces"] == {"count": 1, "first": [7]}
    assert found["topology"]["components"] == len(found["components"]) == 3
    assert found["components"]["component 0"]["genus"] is None
    assert list(found["solid"]) == ["area"]
    page = succeeds("info", path)
    assert "non-manifold edges: count 1, first [[0, 1]]" in page
    assert "closed: no" in page
    assert "component 1: V 4, E 5, F 2, closed no, manifold yes, boundary loops 1, genus 0" in page


def test_long_lists_are_cut_short_and_counted(tmp_path: Path) -> None:
    triangles = iso.Mesh(np.random.default_rng(0).random((3600, 3)), np.arange(3600).reshape(-1, 3))
    path = saved(tmp_path, triangles)
    found = facts("info", path)
    assert found["topology"]["components"] == 1200
    assert len(found["components"]) == 1000
    assert found["defects"]["boundary_edges"]["count"] == 3600
    assert len(found["defects"]["boundary_edges"]["first"]) == 1000
    assert len(succeeds("info", path).splitlines()) < 40


def test_stl_triangles_are_joined_and_others_on_demand(tmp_path: Path) -> None:
    stl = saved(tmp_path, cube(), "cube.stl")
    found = facts("info", stl)
    assert (found["vertices"], found["topology"]["V"], found["topology"]["closed"]) == (36, 8, True)
    apart = iso.load_mesh(stl)
    obj = saved(tmp_path, iso.Mesh(apart.vertices + np.linspace(0, 1e-4, 36)[:, None], apart.faces))
    assert facts("info", obj)["topology"]["components"] == 12
    assert facts("info", obj, "--weld", 0)["topology"]["components"] == 12
    assert facts("info", obj, "--weld", 1e-3)["topology"]["genus"] == 0
    assert "weld must be" in refuses("info", obj, "--weld", -1)


SCENE = """import isophote as iso
corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
cube, box = iso.Mesh(corners, faces), iso.Mesh(corners, faces[1:])
scene = iso.Scene([iso.Item(cube), iso.Item(box).translate((3, 0, 0)), iso.Item(cube).translate((0, 3, 0))])
"""


def test_a_scene_mesh_by_mesh(tmp_path: Path) -> None:
    told = facts("info", written(tmp_path, "scene.py", SCENE))["topology"]
    assert list(told) == ["mesh 0", "mesh 1"]
    assert told["mesh 0"] == {"closed": True, "manifold": True, "oriented": True, "components": 1, "genus": 0}
    assert told["mesh 1"]["boundary_edges"] == 4


def marked(picture: np.ndarray, colour: str) -> np.ndarray:
    """The pixels where a marker's colour outweighs all others."""
    lit = np.array(iso.Matte(colour).colour) > 0.5
    others = picture[..., ~lit].max(axis=-1)
    return np.argwhere(picture[..., lit].min(axis=-1) > 1.5 * others + 0.02)


def test_the_picture_marks_defects(tmp_path: Path) -> None:
    two = together(cube(), cube(offset=(1, 1, 1)), iso.Mesh(cube(offset=(-2, 0, 0)).vertices, CUBE[1:]))
    pinched = iso.Mesh(two.vertices, [tuple(7 if v == 8 else int(v) for v in face) for face in two.faces])
    sound, broken = tmp_path / "sound.exr", tmp_path / "broken.exr"
    assert f"{broken}" in succeeds("info", saved(tmp_path, pinched), "--picture", broken, "--size", "200x160")
    succeeds("info", saved(tmp_path, cube(), "cube.obj"), "--picture", sound, "--size", "200x160")
    picture, clean = (iso.load_image(path).channels["colour"] for path in (broken, sound))
    assert picture.shape == (160, 400, 3)
    for colour in COLOURS.values():
        assert len(marked(clean, colour)) == 0
    assert len(marked(picture, COLOURS["boundary_edges"])) > 10
    assert len(marked(picture, COLOURS["non_manifold_vertices"])) > 2
    assert len(marked(picture, COLOURS["turned_edges"])) == 0


def test_hidden_defects_shine_through(tmp_path: Path) -> None:
    # The bottom is missing, and stands on the ground.
    faces = [face for face in CUBE if face != (0, 4, 5, 1)]
    out = tmp_path / "out.exr"
    succeeds("info", saved(tmp_path, iso.Mesh(cube().vertices, faces)), "--picture", out, "--size", "100x100")
    blue = marked(iso.load_image(out).channels["colour"], "blue")
    left = blue[blue[:, 1] < 100]
    # All four edges of the bottom, two of which are behind the box: the farthest corner is above the nearest by far.
    assert len(left) > 60
    assert np.ptp(left[:, 0]) > 15


def test_pictures_of_scenes_and_bad_requests(tmp_path: Path) -> None:
    scene = written(tmp_path, "scene.py", SCENE)
    out = tmp_path / "out.exr"
    succeeds("info", scene, "--picture", out, "--size", "60x60")
    assert len(marked(iso.load_image(out).channels["colour"], "blue")) > 5
    assert "size" in misused("info", scene, "--size", "big")
    assert "refused.xyz" in refuses("info", scene, "--picture", tmp_path / "refused.xyz")


def test_marks_are_closed_solids_around_what_they_mark() -> None:
    ball = balls([(0, 0, 0), (5, 0, 0)], 2.0)
    assert topology(ball).components.genus.tolist() == [0, 0]
    assert np.linalg.norm(ball.vertices[:12], axis=1) == pytest.approx(np.full(12, 2.0))
    # An icosahedron's volume by its circumradius.
    assert mass_properties(balls([(1, 2, 3)], 1.0)).volume == pytest.approx(2.536150710)
    ends = np.random.default_rng(0).normal(size=(2, 5, 3))
    ends[1, 0] = ends[0, 0] + (0, 0, 1)
    tube = tubes(*ends, 0.01)
    assert topology(tube).components.genus.tolist() == [0] * 5
    length = np.linalg.norm(ends[1] - ends[0], axis=1) + 0.02
    assert mass_properties(tube).volume == pytest.approx(length.sum() * 1.5 * 3**0.5 * 0.01**2)
    assert topology(tubes([(1, 1, 1)], [(1, 1, 1)], 0.5)).genus == 0
