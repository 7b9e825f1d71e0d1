"""The command line: what its verbs print, write and return."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np
import pytest
import typer

import isophote as iso
from command_line import QUICK, SCENE, TRIANGLE, facts, misused, refuses, run, succeeds, written
from isophote.cli import machine, options
from isophote.cli.methods import METHODS, new_method
from isophote.rendering import passes, pixel_filter


@pytest.fixture
def triangle(tmp_path: Path) -> Path:
    return written(tmp_path, "triangle.obj", TRIANGLE)


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return written(tmp_path, "scene.py", SCENE)


def process(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "isophote", *(str(argument) for argument in arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, **options)  # type: ignore[call-overload, no-any-return]


def test_help_names_every_verb_and_each_verb_shows_examples() -> None:
    page = succeeds("--help")
    for verb in ("render", "info", "doctor"):
        assert verb in page
        assert re.search(rf"Examples:\n\s+isophote {verb}", succeeds(verb, "--help"))


def test_version() -> None:
    assert succeeds("--version") == f"isophote {iso.__version__}\n"
    assert process("--version").stdout == f"isophote {iso.__version__}\n"


def test_help_does_not_load_the_compiler() -> None:
    code = "import sys, isophote.cli.main; print([m for m in ('numba', 'scipy', 'OpenEXR') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


@pytest.mark.parametrize("name", ["triangle.obj", "scene.py"])
@pytest.mark.parametrize("ending", [".png", ".exr", ".jpg", ".webp", ".tif", ".bmp"])
def test_pictures_by_their_ending(tmp_path: Path, triangle: Path, scene: Path, name: str, ending: str) -> None:
    out = tmp_path / f"out{ending}"
    assert f"{out}: 16 × 12 pixels, 1 samples a pixel" in succeeds("render", tmp_path / name, "-o", out, *QUICK)
    picture = iso.load_image(out)
    assert picture.size == (16, 12)
    assert picture.channels["colour"].max() > 0.1


def test_options_reach_the_method_and_the_picture(tmp_path: Path, scene: Path) -> None:
    out = tmp_path / "out.exr"
    given = ("--samples", 3, "--max-depth", 5, "--filter", "tent", "--noise", 0.5, "--seconds", 60, "--seed", 7)
    given += ("--pattern", "jittered", "--denoise")
    found = facts("render", scene, "-o", out, "--size", "9x5", *given, "--method", "path", "--backend", "cpu")
    expected = repr(iso.PathTrace(samples=3, max_depth=5, filter="tent", noise=0.5, seconds=60.0, pattern="jittered"))
    assert found["denoised"].startswith("by ")
    assert found["method"] == expected
    assert found["size"] == [9, 5]
    assert found["seed"] == "7"
    assert found["stopped"] is None
    metadata = iso.load_image(out).metadata
    assert metadata["method"] == expected
    assert metadata["seed"] == "7"


def test_names_of_options_are_those_of_the_settings() -> None:
    assert tuple(pixel_filter.FILTERS) == options.FILTERS
    assert tuple(passes.PATTERNS) == options.PATTERNS
    assert {iso.Radiosity(method=name).method for name in options.SOLVERS} == set(options.SOLVERS)
    assert {iso.Radiosity(method="shooting", form_factors=name).form_factors for name in options.FORM_FACTORS} == set(
        options.FORM_FACTORS
    )
    assert {iso.AmbientOcclusion(by=name).by for name in options.WAYS} == set(options.WAYS)


@pytest.mark.parametrize("method", ["radiosity", "occlusion"])
def test_every_setting_of_radiosity_and_occlusion_is_an_option(tmp_path: Path, scene: Path, method: str) -> None:
    given = {
        "radiosity": {
            "patch": 0.5,
            "error": 0.05,
            "residual": 0.01,
            "samples": 4,
            "max-links": 50_000,
            "solver": "shooting",
            "form-factors": "hemicube",
            "directions": 192,
        },
        "occlusion": {"samples": 3, "max-distance": 0.5, "by": "classic"},
    }[method]
    kind = type(new_method(method, {}))
    assert {{"solver": "method"}.get(name, name.replace("-", "_")) for name in given} == {
        field.name for field in attrs.fields(kind)
    }
    options = [text for name, value in given.items() for text in (f"--{name}", value)]
    out = tmp_path / "out.png"
    found = facts("render", scene, "-o", out, "--size", "9x5", "--method", method, *options)
    settings = {name.replace("-", "_"): value for name, value in given.items()}
    assert found["method"] == repr(new_method(method, settings))
    assert iso.load_image(out).size == (9, 5)
    page = succeeds("render", "--help")
    for name in given:
        assert f"--{name} " in page


def test_settings_of_other_methods_are_misuse(scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    assert "the method path has no --solver" in misused("render", scene, "-o", out, "--solver", "shooting")
    assert "the method path has no --patch" in misused("render", scene, "-o", out, "--patch", "1")
    wrong = ("render", scene, "-o", out, "--method", "radiosity")
    assert "is not one of hierarchical" in misused(*wrong, "--solver", "magic")
    assert "patch must be a number above 0, or None, not -1.0" in refuses(*wrong, "--patch", -1)
    assert not out.exists()


def test_the_same_seed_gives_the_same_picture_for_any_threads(tmp_path: Path, scene: Path) -> None:
    pictures = {}
    for name, seed, threads in (("a", 1, 1), ("b", 1, 2), ("c", 2, 1)):
        path = tmp_path / f"{name}.exr"
        succeeds("render", scene, "-o", path, "--size", "40x40", "--samples", 2, "--seed", seed, "--threads", threads)
        pictures[name] = iso.load_image(path).channels["colour"]
    assert np.array_equal(pictures["a"], pictures["b"])
    assert not np.array_equal(pictures["a"], pictures["c"])


def test_a_python_file_runs_in_its_own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "there"
    folder.mkdir()
    written(folder, "neighbour.py", "COLOUR = 'tomato'\n")
    written(folder, "triangle.obj", TRIANGLE)
    text = (
        "import isophote as iso\nimport neighbour\n"
        "print('from the scene')\n"
        "shape = iso.Item(iso.load_mesh('triangle.obj'), iso.Matte(neighbour.COLOUR))\n"
        "if __name__ == '__main__':\n    raise RuntimeError\n"
    )
    written(folder, "scene.py", text)
    monkeypatch.chdir(tmp_path)
    result = run("render", "there/scene.py", "-o", "out.png", *QUICK)
    assert result.exit_code == 0
    assert result.stdout.startswith("out.png: ")
    assert "from the scene" in result.stderr
    assert (tmp_path / "out.png").is_file()
    assert Path.cwd() == tmp_path
    assert str(folder) not in sys.path


def test_scene_goes_before_shape(tmp_path: Path) -> None:
    path = written(tmp_path, "both.py", SCENE + "shape = 5\n")
    assert facts("info", path)["items"] == 1


# Once while the pool runs, and again and again, so that one comes between two runs.
@pytest.mark.parametrize("times", [1, 1000])
def test_an_interrupt_keeps_the_picture_so_far(
    tmp_path: Path, scene: Path, monkeypatch: pytest.MonkeyPatch, times: int
) -> None:
    raised = []

    def interrupted() -> Callable[[str, float], None]:
        def tell(stage: str, fraction: float) -> None:
            if stage == "path tracing" and 0 < fraction < 1 and len(raised) < times:
                raised.append(fraction)
                raise KeyboardInterrupt

        return tell

    monkeypatch.setattr("isophote.cli.progress.progress", interrupted)
    out = tmp_path / "out.png"
    result = run("render", scene, "-o", out, "--size", "64x64", "--samples", 2**20)
    assert result.exit_code == 1
    assert f"the picture so far is in {out}" in result.stderr
    picture = iso.load_image(out)
    assert picture.channels["colour"].max() > 0.1
    assert "interrupted" in picture.metadata["stopped"]


def test_an_interrupt_before_that_leaves_nothing(tmp_path: Path) -> None:
    path = written(tmp_path, "scene.py", "raise KeyboardInterrupt\n")
    result = run("render", path, "-o", tmp_path / "out.png")
    assert result.exit_code == 1
    assert result.stderr == "isophote: interrupted\n"
    assert os.listdir(tmp_path) == ["scene.py"]


def test_info_of_a_mesh(tmp_path: Path) -> None:
    text = (
        "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nvt 0 0\nvt 1 1\n"
        "usemtl red\nf 1/1 2/2 3/2 4/1\nusemtl blue\nf 1/1 2/2 5/1\nf 1/2 3/2 5/2\n"
    )
    path = written(tmp_path, "mesh.obj", text)
    found = facts("info", path)
    assert found["kind"] == "mesh"
    assert (found["vertices"], found["faces"], found["triangles"]) == (5, 3, 4)
    assert found["faces_by_size"] == {"3": 2, "4": 1}
    assert found["bounds"] == [[0, 0, 0], [1, 2, 3]]
    assert found["attributes"]["uv"]["at"] == "corners"
    assert found["labels"]["material"] == {"red": 1, "blue": 2}
    page = succeeds("info", path)
    assert "3: 2\n" in page
    assert "material: red 1, blue 2" in page


def test_info_of_a_scene(tmp_path: Path) -> None:
    text = (
        "import isophote as iso\n"
        "mesh = iso.Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])\n"
        "texture = iso.ImageTexture([[0.5]])\n"
        "items = [iso.Item(mesh).translate((i, 0, 0)) for i in range(3)]\n"
        "items += [iso.Item(iso.Mesh(mesh.vertices, mesh.faces), iso.Matte(texture))]\n"
        "scene = iso.Scene(items, [iso.Sky(), iso.Sun((0, 1, 0)), iso.Sky()], name='four')\n"
    )
    found = facts("info", written(tmp_path, "scene.py", text))
    assert (found["kind"], found["name"], found["items"], found["meshes"], found["instances"]) == (
        "scene",
        "four",
        4,
        2,
        3,
    )
    assert (found["triangles"], found["placed_triangles"], found["textures"]) == (4, 8, 1)
    assert found["lights"] == {"Sky": 2, "Sun": 1}
    assert found["materials"] == {"Matte": 2}
    assert found["bounds"] == [[0, 0, 0], [3, 1, 0]]
    assert found["camera"] is None


def test_info_tells_the_tree(triangle: Path, scene: Path) -> None:
    found = facts("info", triangle, "--tree")
    assert (found["tree"]["blocks"], found["tree"]["leaves"], found["tree"]["depth"]) == (1, 1, 1)
    assert found["tree"]["bytes"] <= found["memory"]["geometry"] <= found["memory"]["bytes"]
    assert facts("info", scene, "--tree")["memory"]["bytes"] > 0


def test_doctor(capfd: pytest.CaptureFixture[str]) -> None:
    found = facts("doctor")
    assert found["isophote"] == iso.__version__
    assert found["numpy"] == np.__version__
    assert found["cache"]["compiled"]
    assert found["cache"]["bytes"] > 0
    assert all(check["ok"] for check in found["checks"].values())
    page = succeeds("doctor")
    assert found["cache"]["folder"] in page
    assert "kernels are compiled" in page


def test_doctor_says_what_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise OSError("no such disk")

    monkeypatch.setattr("isophote.cli.self_test.load_image", broken)
    result = run("doctor")
    assert result.exit_code == 1
    assert "openexr check" in result.stdout
    assert "failed: OSError: no such disk" in result.stdout
    assert "error: failed: openexr" in result.stderr


def test_doctor_cleans_only_other_versions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ours, stale, other = tmp_path / ("0" * 16), tmp_path / "0123456789abcdef", tmp_path / "pictures"
    for folder in (ours, stale, other):
        folder.mkdir()
        written(folder, "file", b"12345")
    elsewhere = tmp_path / ("f" * 16)
    elsewhere.symlink_to(other)
    monkeypatch.setattr(machine, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(machine, "usable_folder", lambda: ours)
    found = machine.cache_facts()
    assert (found["bytes"], found["stale_folders"], found["stale_bytes"], found["writable"]) == (5, 1, 5, True)
    assert machine.clean_cache() == [str(stale)]
    assert sorted(os.listdir(tmp_path)) == sorted([ours.name, other.name, elsewhere.name])
    assert (other / "file").is_file()
    assert machine.cache_facts()["stale_folders"] == 0


def test_every_method_of_the_table_can_be_made() -> None:
    for name in METHODS:
        assert hasattr(new_method(name, {"samples": None}), "render")
    assert new_method("path", {"samples": 3}) == iso.PathTrace(samples=3)
    with pytest.raises(typer.BadParameter, match="the method path has no --cone-angle"):
        new_method("path", {"cone_angle": 1})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "SCENE"),
        (("scene.obj",), "--output"),
        (("scene.obj", "-o", "x.png", "--size", "abc"), "such as 640x480"),
        (("scene.obj", "-o", "x.png", "--size", "640"), "such as 640x480"),
        (("scene.obj", "-o", "x.png", "--size", "-4x3"), "such as 640x480"),
        (("scene.obj", "-o", "x.png", "--method", "magic"), "is not one of occlusion, path"),
        (("scene.obj", "-o", "x.png", "--filter", "magic"), "is not one of box, tent, gaussian, mitchell"),
        (("scene.obj", "-o", "x.png", "--backend", "abacus"), "is not one of auto, cpu"),
        (("scene.obj", "-o", "x.png", "--samples", "many"), "samples"),
        (("scene.obj", "-o", "x.png", "--colour", "red"), "--colour"),
    ],
)
def test_wrong_usage_has_status_2(arguments: tuple[str, ...], message: str) -> None:
    assert message in misused("render", *arguments)


def test_unknown_verbs_have_status_2() -> None:
    assert "dance" in misused("dance")


def test_errors_show_their_origin_only_when_asked(tmp_path: Path) -> None:
    assert "there is no such file" in refuses("info", tmp_path / "none.obj")
    with pytest.raises(iso.FileError):
        run("--traceback", "info", tmp_path / "none.obj")


def test_as_a_process(tmp_path: Path, scene: Path) -> None:
    out = tmp_path / "out.png"
    good = process("render", scene, "-o", out, *QUICK)
    assert good.returncode == 0
    assert good.stdout.startswith(f"{out}: 16 × 12")
    assert good.stderr in ("", "isophote: compiling kernels (first use on this machine)\n")
    bad = process("info", tmp_path / "none.obj")
    assert (bad.returncode, bad.stdout) == (1, "")
    assert bad.stderr.startswith("isophote: error: ")
    assert bad.stderr.count("\n") == 1


def test_a_reader_that_leaves_is_no_error(triangle: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as closed:
        ended = subprocess.run(
            [sys.executable, "-m", "isophote", "info", str(triangle)],
            stdout=closed,
            stderr=subprocess.PIPE,
            text=True,
            timeout=300,
            check=False,
        )
    assert ended.stderr == ""
