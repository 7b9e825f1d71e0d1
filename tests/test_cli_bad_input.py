"""Bad input at the command line: a message and status 1, never a traceback or a half-written file."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from command_line import QUICK, SCENE, TRIANGLE, refuses, run, written

PLY = "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
PLY += "property list uchar int vertex_indices\nend_header\n"
GARBAGE = np.random.default_rng(5).integers(0, 256, 3000, dtype=np.uint8).tobytes()

BAD_MODELS: dict[str, tuple[str | bytes, str]] = {
    "nan.obj": (TRIANGLE.replace("1 0 0", "nan 0 0"), "not finite"),
    "infinite.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\ninf 1 0\n3 0 1 2\n", "not finite"),
    "infinite.ply": (PLY.format("ascii", 3) + "0 0 0\n1 0 0\n0 -inf 0\n3 0 1 2\n", "not finite"),
    "range.obj": (TRIANGLE.replace("f 1 2 3", "f 1 2 4"), "names vertex 4"),
    "range.ply": (PLY.format("ascii", 3) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -2\n", "names vertex -2"),
    "empty.obj": ("", "no mesh in the file"),
    "empty.stl": (b"", ""),
    "empty.glb": (b"", ""),
    "no_faces.obj": ("v 0 0 0\n", "point cloud"),
    "cut.ply": ((PLY.format("binary_little_endian", 3)).encode() + bytes(20), ""),
    "huge.ply": ((PLY.format("binary_little_endian", 2**40)).encode() + bytes(100), ""),
    "huge.stl": (bytes(80) + b"\xff\xff\xff\xff" + bytes(100), ""),
    "garbage.obj": (GARBAGE, ""),
    "garbage.ply": (GARBAGE, ""),
    "garbage.stl": (GARBAGE, ""),
    "garbage.off": (GARBAGE, ""),
    "garbage.glb": (GARBAGE, ""),
    "garbage.gltf": (GARBAGE, ""),
    "garbage.ply.gz": (GARBAGE, ""),
    "unknown.xyz": (TRIANGLE, 'the ending ".xyz" is not known'),
    "unnamed": (TRIANGLE, "the name has no ending"),
}

BAD_PYTHON: dict[str, tuple[str | bytes, str]] = {
    "nothing": ("x = 1\n", "defines neither `scene` nor `shape`"),
    "number": ("scene = 5\n", "`scene` must be a Scene, an Item or a shape, but is a int"),
    "syntax": ("\n\nscene = (\n", ", line 3: SyntaxError"),
    "bytes": (b"\x00\xff\xfe", "Error"),
    "raises": (
        "def broken():\n    return 1 / 0\n\nscene = broken()\n",
        ", line 2: ZeroDivisionError: division by zero",
    ),
    "silent": ("raise ValueError\n", ", line 1: ValueError"),
    "lines": ("raise ValueError('one\\ntwo')\n", "ValueError: one two"),
    "import": ("import no_such_module\n", ", line 1: ModuleNotFoundError"),
    "exits": ("import sys\nsys.exit(0)\n", ", line 2: stops with SystemExit(0)"),
    "ours": ("import isophote as iso\nscene = iso.Scene([5])\n", ", line 2: Scene: items[0] must be an Item"),
    "nan": ("import isophote as iso\nshape = iso.Mesh([(float('nan'), 0, 0)] * 3, [(0, 1, 2)])\n", "line 2: vertex 0"),
    "absent": ("import isophote as iso\nshape = iso.load_mesh('no.obj')\n", "no.obj: there is no such file"),
}


def check_refused(folder: Path, path: Path, message: str) -> None:
    """Both verbs refuse the file; what was there stays, and nothing else comes."""
    out = written(folder, "out.png", "precious")
    before = sorted(os.listdir(folder))
    for arguments in (("info", path), ("render", path, "-o", out, *QUICK), ("render", path, "-o", folder / "new.exr")):
        said = refuses(*arguments)
        assert str(path) in said
        assert message in said
    assert out.read_text() == "precious"
    assert sorted(name for name in os.listdir(folder) if name != "__pycache__") == before


@pytest.mark.parametrize("name", BAD_MODELS)
def test_bad_models(tmp_path: Path, name: str) -> None:
    content, message = BAD_MODELS[name]
    check_refused(tmp_path, written(tmp_path, name, content), message)


@pytest.mark.parametrize("name", BAD_PYTHON)
def test_bad_python_files(tmp_path: Path, name: str) -> None:
    content, message = BAD_PYTHON[name]
    check_refused(tmp_path, written(tmp_path, f"{name}.py", content), message)


@pytest.mark.parametrize("name", ["none.obj", "none.py", "none.glb", "no/folder.ply"])
def test_missing_files(tmp_path: Path, name: str) -> None:
    check_refused(tmp_path, tmp_path / name, "no such file")


@pytest.mark.parametrize("name", ["folder.obj", "folder.py"])
def test_folders(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    check_refused(tmp_path, tmp_path / name, "")


def test_what_a_python_file_hides_of_us(tmp_path: Path) -> None:
    path = written(tmp_path, "scene.py", "import isophote as iso\nscene = iso.Scene([5])\n")
    result = run("render", path, "-o", tmp_path / "out.png")
    assert "runpy" not in result.stderr
    assert "scene/scene.py" not in result.stderr


MTL = "newmtl a\nmap_Kd missing.png\n"
OBJ = "mtllib a.mtl\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
OBJ += "usemtl a\nf 1/1 2/2 3/3 4/4\n"


def test_missing_textures_are_magenta(tmp_path: Path) -> None:
    path, out = written(tmp_path, "a.obj", OBJ), tmp_path / "out.exr"
    written(tmp_path, "a.mtl", MTL)
    result = run("render", path, "-o", out, "--size", "24x24", "--samples", 4)
    assert result.exit_code == 0
    warnings = [line for line in result.stderr.splitlines() if line.startswith("isophote: warning: ")]
    assert len(warnings) == 1
    assert "missing.png" in warnings[0]
    red, green, blue = np.moveaxis(iso.load_image(out).channels["albedo"], -1, 0)
    magenta = (red > 0.9) & (green < 0.1) & (blue > 0.9)
    assert magenta.mean() > 0.05


def test_strict_refuses_what_would_be_a_warning(tmp_path: Path) -> None:
    path, out = written(tmp_path, "a.obj", OBJ), written(tmp_path, "out.exr", "precious")
    written(tmp_path, "a.mtl", MTL)
    said = refuses("render", path, "-o", out, "--strict")
    assert "missing.png" in said
    assert "magenta" not in said
    inside = written(tmp_path, "a.py", "import isophote as iso\nscene = iso.load_scene('a.obj')\n")
    said = refuses("render", inside, "-o", out, "--strict")
    assert "a.py, line 2: " in said
    assert "missing.png" in said
    assert out.read_text() == "precious"
    (tmp_path / "a.mtl").unlink()
    assert "a.mtl" in refuses("render", path, "-o", out, "--strict")


def test_triangles_without_area_are_drawn_as_nothing(tmp_path: Path) -> None:
    text = TRIANGLE + "v 5 5 5\nf 1 1 1\nf 4 4 2\nf 1 2 2\nf 1 1 4\n"
    out = tmp_path / "out.exr"
    result = run("render", written(tmp_path, "flat.obj", text), "-o", out, "--size", "24x24", "--samples", 4)
    assert result.exit_code == 0
    picture = iso.load_image(out)
    assert np.isfinite(picture.channels["colour"]).all()
    assert np.isfinite(picture.channels["normal"]).all()
    assert picture.channels["colour"].max() > 0.1


@pytest.mark.parametrize("material", ["Matte", "Glass", "Mirror"])
def test_a_camera_inside_geometry(tmp_path: Path, material: str) -> None:
    text = (
        "import isophote as iso\n"
        "p = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]\n"
        "f = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]\n"
        f"item = iso.Item(iso.Mesh(p, f), iso.{material}())\n"
        "scene = iso.Scene([item], [iso.Sky('white')], iso.Camera((0, 0, 0), (0.1, 0.2, 1)))\n"
    )
    out = tmp_path / "out.exr"
    assert run("render", written(tmp_path, "inside.py", text), "-o", out, *QUICK).exit_code == 0
    channels = iso.load_image(out).channels
    assert np.isfinite(channels["colour"]).all()
    assert (channels["item"] == 0).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--size", "0x480"), "size must be two whole numbers of 1 or more"),
        (("--size", "640x0"), "size must be two whole numbers of 1 or more"),
        (("--size", "99999999x99999999"), "pixels are more than"),
        (("--samples", "0"), "samples must be a whole number"),
        (("--samples", "-3"), "samples must be a whole number"),
        (("--seconds", "0"), "seconds must be a number above 0"),
        (("--seconds", "nan"), "seconds must be a number above 0"),
        (("--noise", "-1"), "noise must be a number above 0"),
        (("--max-depth", "0"), "max_depth must be a whole number"),
        (("--threads", "0"), "threads must be a whole number from 1 to 1,024"),
    ],
)
def test_values_without_meaning(tmp_path: Path, options: tuple[str, ...], message: str) -> None:
    said = refuses("render", marked(tmp_path), "-o", tmp_path / "out.png", *options)
    assert message in said
    assert os.listdir(tmp_path) == ["scene.py"]


def marked(folder: Path) -> Path:
    """A scene that leaves a mark when it is read."""
    return written(folder, "scene.py", "open('read', 'w').close()\n" + SCENE)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("none/out.png", "no such file or directory"),
        ("folder.png", "it is a folder or a device"),
        ("scene.py/out.png", "not a directory"),
        ("out.xyz", '".xyz" is no ending of a picture; use one of .png'),
        ("out", "the name has no ending; use one of .png"),
        ("x" * 300 + ".png", "file name too long"),
        ("/proc/out.png", "cannot be written"),
    ],
)
def test_outputs_that_cannot_be_written_are_refused_before_the_scene_is_read(
    tmp_path: Path, name: str, message: str
) -> None:
    path = marked(tmp_path)
    (tmp_path / "folder.png").mkdir()
    before = sorted(os.listdir(tmp_path))
    assert message in refuses("render", path, "-o", tmp_path / name, *QUICK)
    assert sorted(os.listdir(tmp_path)) == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_not_be_written(tmp_path: Path) -> None:
    path = marked(tmp_path)
    tmp_path.chmod(0o500)
    try:
        assert "permission denied" in refuses("render", path, "-o", tmp_path / "out.png")
    finally:
        tmp_path.chmod(0o700)
    assert os.listdir(tmp_path) == ["scene.py"]


def test_a_scene_with_nothing_to_draw(tmp_path: Path) -> None:
    path = written(tmp_path, "scene.py", "import isophote as iso\nscene = iso.Scene([])\n")
    assert "without items" in refuses("render", path, "-o", tmp_path / "out.png", *QUICK)
    assert os.listdir(tmp_path) == ["scene.py"]
