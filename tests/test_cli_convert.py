"""`isophote convert`: fields to meshes and pages, meshes from format to format, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from command_line import facts, misused, refuses, run, succeeds, written

PART = """import isophote as iso
hole = iso.cylinder(0.25)
part = iso.box(1.0) - hole
"""
SQUARE = iso.Mesh([(0, 0, 0), (2, 0, 0), (2, 3, 0), (0, 3, 0)], [(0, 1, 2, 3)])


@pytest.fixture
def part(tmp_path: Path) -> Path:
    return written(tmp_path, "part.py", PART)


@pytest.mark.parametrize("ending", ["stl", "ply", "obj", "glb", "3mf", "off.gz"])
def test_a_field_becomes_a_mesh_of_any_format(part: Path, ending: str) -> None:
    target = part.with_name(f"part.{ending}")
    told = facts("convert", part, target, "--cell", "0.05")
    mesh = iso.load_mesh(target)
    assert told["cell"] == 0.05
    assert told["triangles"] == mesh.face_count
    assert told["bytes"] == target.stat().st_size
    np.testing.assert_allclose(mesh.bounds, [[-0.5] * 3, [0.5] * 3], atol=1e-6)


def test_the_part_is_taken_among_several_shapes_and_any_name_for_a_single_one(tmp_path: Path) -> None:
    for text in (PART, "import isophote as iso\nball = iso.box(1)\nsame = ball\n"):
        source = written(tmp_path, "shapes.py", text)
        assert facts("convert", source, tmp_path / "out.ply", "--cell", "0.2")["faces"] > 0


def test_without_a_cell_one_is_chosen_and_told(part: Path) -> None:
    result = run("convert", part, part.with_name("part.ply"))
    assert result.exit_code == 0
    assert "cell 0.007812" in result.stderr
    assert result.stdout == ""


def test_a_tolerance_is_kept(part: Path) -> None:
    target = part.with_name("part.ply")
    succeeds("convert", part, target, "--tolerance", "0.01")
    radius = np.linalg.norm(iso.load_mesh(target).vertices[:, [0, 2]], axis=1)
    assert radius.min() > 0.25 - 0.01


def test_a_mesh_goes_from_format_to_format(tmp_path: Path) -> None:
    iso.save(SQUARE, tmp_path / "square.obj")
    told = facts("convert", tmp_path / "square.obj", tmp_path / "square.ply")
    assert (told["vertices"], told["faces"], told["triangles"]) == (4, 1, 2)
    assert iso.load_mesh(tmp_path / "square.ply") == SQUARE
    succeeds("convert", tmp_path / "square.ply", tmp_path / "up.ply", "--up", "z", "--scale", "2")
    assert iso.load_mesh(tmp_path / "up.ply").bounds.tolist() == [[0, 0, -6], [4, 0, 0]]


def test_a_field_becomes_a_page(part: Path) -> None:
    told = facts("convert", part, part.with_name("part.html"))
    assert told["bytes"] > 1000
    assert part.with_name("part.html").read_text().startswith("<!")


def test_the_unit_of_a_3mf_is_passed_on(part: Path) -> None:
    succeeds("convert", part, part.with_name("part.3mf"), "--cell", "0.2", "--unit", "inch")
    assert "no option" in refuses("convert", part, part.with_name("part.ply"), "--cell", "0.2", "--unit", "inch")


def test_options_of_the_other_kind_are_misuse(part: Path, tmp_path: Path) -> None:
    iso.save(SQUARE, tmp_path / "square.obj")
    assert "--cell is for a field" in misused("convert", tmp_path / "square.obj", tmp_path / "a.ply", "--cell", "1")
    assert "--scale is for a mesh" in misused("convert", part, tmp_path / "a.ply", "--scale", "2")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("x = 1\n", "defines no shape"),
        ("import isophote as iso\na = iso.box(1)\nb = iso.sphere(1)\n", "several shapes (a, b)"),
        ("part = 3\n", "`part` must be a shape, but is a int"),
        ("import isophote as iso\npart = iso.plane()\n", "the shape is endless"),
        ("import isophote as iso\npart = iso.sphere(1) & iso.sphere(1).translate((3, 0, 0))\n", "no surface found"),
    ],
)
def test_what_cannot_be_converted_is_refused_and_nothing_written(tmp_path: Path, text: str, reason: str) -> None:
    source = written(tmp_path, "bad.py", text)
    assert reason in refuses("convert", source, tmp_path / "out.ply")
    assert not (tmp_path / "out.ply").exists()


def test_an_ending_is_refused_before_the_work(part: Path) -> None:
    assert "is not known" in refuses("convert", part, part.with_name("part.xyz"), "--cell", "1e-4")
