"""Mesh files by their endings: every shared model as its table says, packing, placing, and refusals."""

from __future__ import annotations

import gzip
import os
import re
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given

from isophote import Attribute, FileError, GeometryError, IsophoteWarning, Mesh, load_mesh, save
from isophote.io.mesh_file import READERS
from mesh_files import MODELS, meshes

FOLDERS = ("closed", "boundary", "genus", "broken", "formats", "subdiv", "textured", "scene", "large")
ENDINGS = (".obj", ".ply", ".stl", ".off", ".ply.gz")
TRIANGLE = Mesh(np.eye(3), [[0, 1, 2]])
_WORDS = {"tri": 3, "quad": 4}


def _table() -> list[tuple[str, int, dict[int, int]]]:
    """Name, number of vertices and of faces by their size, as SOURCES.md tells; no faces for a point cloud."""
    found = []
    sources = MODELS / "SOURCES.md"
    for line in sources.read_text().splitlines() if sources.is_file() else ():
        cells = [cell.strip() for cell in line.split("|")]
        name = re.fullmatch(r"`(.+)`", cells[1] if len(cells) > 5 else "")
        if name and name[1].split("/")[0] in FOLDERS and name[1].lower().endswith(ENDINGS):
            found.append((name[1], *_counts(cells[5])))
    return found


def _counts(text: str) -> tuple[int, dict[int, int]]:
    """ "507 / 500 32x3-gon/468x4-gon" and "313 / 622 tri" and "5 V"."""
    if points := re.fullmatch(r"(\d+) V", text):
        return int(points[1]), {}
    vertices, faces, kinds = re.fullmatch(r"(\d+) / (\d+) (.+)", text).groups()  # type: ignore[union-attr]
    if kinds in _WORDS:
        return int(vertices), {_WORDS[kinds]: int(faces)}
    sizes = {int(size): int(count) for count, size in re.findall(r"(\d+)x(\d+)-gon", kinds)}
    assert sum(sizes.values()) == int(faces)
    return int(vertices), sizes


TABLE = _table()


@pytest.mark.skipif(not MODELS.is_dir(), reason="the shared models are not here")
def test_the_table_of_models_was_understood() -> None:
    assert len(TABLE) >= 55
    listed = {name for name, _, _ in TABLE}
    here = {
        path.relative_to(MODELS).as_posix()
        for folder in FOLDERS
        for path in (MODELS / folder).rglob("*")
        if path.name.lower().endswith(ENDINGS) and "expected" not in path.parts
    }
    assert here == listed


@pytest.mark.filterwarnings("ignore:.*fuze_ascii.*:isophote.errors.IsophoteWarning")
@pytest.mark.parametrize(("name", "vertices", "sizes"), TABLE, ids=[row[0] for row in TABLE])
def test_every_model_is_as_its_table_says(name: str, vertices: int, sizes: dict[int, int]) -> None:
    path = MODELS / name
    if not sizes:
        with pytest.raises(FileError, match=f"point cloud: {vertices} points and no faces"):
            load_mesh(path)
        return
    mesh = load_mesh(path)
    found, counts = np.unique(mesh.face_sizes, return_counts=True)
    assert dict(zip(found.tolist(), counts.tolist(), strict=True)) == sizes
    if name.lower().endswith(".stl"):
        # The table counts vertices welded by position; STL stores three for each triangle.
        assert len(mesh.vertices) == 3 * mesh.face_count
        assert len(np.unique(mesh.vertices, axis=0)) == vertices
    else:
        assert len(mesh.vertices) == vertices


@pytest.mark.skipif(not MODELS.is_dir(), reason="the shared models are not here")
@pytest.mark.parametrize(
    "name",
    [
        "closed/fox.ply",
        "boundary/lego.ply",
        "closed/goathead.obj",
        "genus/plate_holes.STL",
        "broken/multibody.stl",
        "formats/cube_att.ply",
        "closed/bunny.obj",
        "boundary/bun_zipper.ply",
    ],
)
def test_coordinates_and_corners_are_those_that_trimesh_reads(name: str) -> None:
    mesh = load_mesh(MODELS / name)
    other = trimesh.load(MODELS / name, process=False, force="mesh", maintain_order=True)
    ours = mesh.vertices[mesh.faces]
    theirs = np.asarray(other.vertices)[np.asarray(other.faces)]
    assert ours.shape == theirs.shape
    # Text is read by trimesh as PLY's 32-bit floats or as doubles: both within one 32-bit rounding.
    assert np.allclose(ours, theirs, rtol=2**-23, atol=1e-30)


@pytest.mark.skipif(not MODELS.is_dir(), reason="the shared models are not here")
@pytest.mark.parametrize("name", ["boundary/suzanne.obj", "closed/koala.obj", "boundary/bun_zipper.ply"])
def test_coordinates_are_the_doubles_of_the_text(name: str) -> None:
    lines = (MODELS / name).read_text().split("end_header\n")[-1].splitlines()
    mesh = load_mesh(MODELS / name)
    rows = [line.removeprefix("v ").split() for line in lines if line.startswith("v ") or name.endswith(".ply")]
    expected = [list(map(float, row[:3])) for row in rows[: len(mesh.vertices)]]
    assert mesh.vertices.tolist() == expected


@pytest.mark.skipif(not MODELS.is_dir(), reason="the shared models are not here")
@pytest.mark.parametrize("name", ["large/dragon_vrip_res2.ply.gz", "closed/koala.obj"])
def test_large_texts_are_read_in_less_than_a_second(name: str) -> None:
    times = []
    for _ in range(3):
        start = time.perf_counter()
        load_mesh(MODELS / name)
        times.append(time.perf_counter() - start)
    assert min(times) < 1


@pytest.mark.skipif(not MODELS.is_dir(), reason="the shared models are not here")
@pytest.mark.parametrize("name", ["points3d/cactus.pts", "bezier/teapot", "nurbs/ex_curve01.cpt"])
def test_what_is_no_mesh_file_is_refused_with_the_known_endings(name: str) -> None:
    with pytest.raises(FileError) as caught:
        load_mesh(MODELS / name)
    assert all(ending in caught.value.reason for ending in READERS)


@given(mesh=meshes())
def test_z_up_files_are_turned_about_x_and_scaled(mesh: Mesh, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "turned.ply"
    bare = mesh.with_(vertices=np.clip(mesh.vertices, -1e9, 1e9), labels={}, attributes={})
    save(bare, path)
    assert load_mesh(path, up="y") == bare
    x, y, z = bare.vertices.T * 2
    assert np.array_equal(load_mesh(path, up="z", scale=2).vertices, np.stack([x, z, -y], axis=1))


def test_normals_turn_with_the_mesh_and_are_not_scaled(tmp_path: Path) -> None:
    mesh = Mesh(np.eye(3), [[0, 1, 2]], attributes={"normal": Attribute(np.array([[0, 0, 1.0]]), np.zeros(3, int))})
    save(mesh, tmp_path / "a.obj")
    normals = load_mesh(tmp_path / "a.obj", up="z", scale=3).normals
    assert normals == Attribute(np.array([[0, 1.0, -0.0]]), np.zeros(3, int))


@pytest.mark.parametrize("scale", [0, -1, np.nan, np.inf])
def test_scales_that_would_flatten_or_mirror_are_refused(scale: float) -> None:
    with pytest.raises(GeometryError, match="scale"):
        load_mesh("x.ply", scale=scale)


def test_another_axis_is_refused() -> None:
    with pytest.raises(GeometryError, match='"y" or "z"'):
        load_mesh("x.ply", up="x")  # type: ignore[arg-type]


def test_a_scale_beyond_the_doubles_is_an_error_of_the_file(tmp_path: Path) -> None:
    save(TRIANGLE.with_(vertices=np.eye(3) * 1e300), tmp_path / "a.ply")
    with pytest.raises(FileError, match="not finite"):
        load_mesh(tmp_path / "a.ply", scale=1e300)


@pytest.mark.parametrize("ending", [".ply", ".obj", ".off", ".STL", ".ply.gz", ".OBJ.GZ"])
def test_endings_in_any_case_and_packed(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.b{ending}"
    save(TRIANGLE, path)
    assert (path.read_bytes()[:2] == b"\x1f\x8b") == ending.lower().endswith(".gz")
    assert load_mesh(path) == TRIANGLE
    assert load_mesh(str(path)) == TRIANGLE
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_content_that_cannot_be_anything_else_outweighs_the_ending(tmp_path: Path) -> None:
    save(TRIANGLE, tmp_path / "a.ply")
    (tmp_path / "a.stl").write_bytes((tmp_path / "a.ply").read_bytes())
    (tmp_path / "b.obj").write_bytes(gzip.compress((tmp_path / "a.ply").read_bytes()))
    assert load_mesh(tmp_path / "a.stl") == load_mesh(tmp_path / "b.obj") == TRIANGLE


def test_files_that_are_not_there_or_no_files(tmp_path: Path) -> None:
    (tmp_path / "folder.ply").mkdir()
    for name, reason in (("none.ply", "no such file"), ("folder.ply", "folder"), ("a\0b.ply", "cannot be read")):
        with pytest.raises(FileError, match=reason) as caught:
            load_mesh(tmp_path / name)
        assert caught.value.path == str(tmp_path / name)
    os.mkfifo(tmp_path / "pipe.ply")
    with pytest.raises(FileError, match="not a regular file"):
        load_mesh(tmp_path / "pipe.ply")


def test_gzip_that_is_broken_short_or_none(tmp_path: Path) -> None:
    packed = gzip.compress(b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n" * 20)
    cases = {
        "short": (packed[:-9], "end too early"),
        "broken": (packed[:15] + b"\xff\xff\xff" + packed[18:], "broken"),
        "plain": (b"OFF\n", "not packed"),
    }
    for name, (data, reason) in cases.items():
        (tmp_path / f"{name}.off.gz").write_bytes(data)
        with pytest.raises(FileError, match=reason):
            load_mesh(tmp_path / f"{name}.off.gz")


def test_a_gzip_bomb_is_refused_before_it_fills_the_memory(tmp_path: Path) -> None:
    bomb = gzip.compress(bytes(1 << 28))
    (tmp_path / "a.ply.gz").write_bytes(bomb)
    tracemalloc.start()
    try:
        with pytest.raises(FileError, match="unpacks to more than"):
            load_mesh(tmp_path / "a.ply.gz")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 1 << 28


@pytest.mark.parametrize("name", ["a.xyz", "a", "a.gz", ".ply"])
def test_saving_under_an_unknown_ending_names_the_known_ones(name: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"\.obj, \.off, \.ply, \.stl"):
        save(TRIANGLE, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("name", "known"), [("a.ply", "binary, endian"), ("a.off", "it has none")])
def test_saving_with_an_unknown_option_names_the_known_ones(name: str, known: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=f'no option "ascii".*{known}'):
        save(TRIANGLE, tmp_path / name, ascii=True)
    assert list(tmp_path.iterdir()) == []


def test_saving_what_is_no_mesh_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="a dict cannot be saved"):
        save({}, tmp_path / "a.ply")


def test_a_write_that_fails_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    path.write_bytes(b"before")
    with pytest.raises(FileError):
        save(Mesh(np.eye(3), [[0, 1, 2]], attributes={"a b": np.ones(3)}), path)
    assert path.read_bytes() == b"before"
    with pytest.raises(FileError, match="cannot be written"):
        save(TRIANGLE, tmp_path / "none" / "a.ply")
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(FileError, match="cannot be written"):
        save(TRIANGLE, tmp_path / "folder.ply")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.ply", "folder.ply"]


def test_writing_the_same_mesh_gives_the_same_bytes(tmp_path: Path) -> None:
    save(TRIANGLE, tmp_path / "a.ply.gz")
    save(TRIANGLE, tmp_path / "b.ply.gz")
    assert (tmp_path / "a.ply.gz").read_bytes() == (tmp_path / "b.ply.gz").read_bytes()


@pytest.mark.skipif(not MODELS.is_dir(), reason="the shared models are not here")
def test_extra_words_in_a_row_are_warned_of() -> None:
    with pytest.warns(IsophoteWarning, match=r"line 523.*more than the header declares"):
        mesh = load_mesh(MODELS / "formats/fuze_ascii.ply")
    assert mesh.colours is not None
    # 192 of 255, decoded as IEC 61966-2-1 says.
    assert np.allclose(mesh.colours.values, [*[((192 / 255 + 0.055) / 1.055) ** 2.4] * 3, 1])


def test_the_examples_of_the_page_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (Path(__file__).parents[1] / "docs/files.md").read_text()
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL):
        exec(compile(block, "docs/files.md", "exec"), names)
    printed = re.findall(r"```text\n(.*?)```", page, re.DOTALL)
    assert capsys.readouterr().out == "".join(printed)


@pytest.mark.parametrize("name", ["a.ply", "a.obj", "a.stl", "a.off"])
def test_others_read_what_is_written(name: str, tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) / 4
    mesh = Mesh(points, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    for binary in (True, False):
        options = {"binary": binary} if name.endswith((".ply", ".stl")) else {}
        save(mesh, tmp_path / name, **options)
        other = trimesh.load(tmp_path / name, process=False, force="mesh", maintain_order=True)
        assert np.array_equal(np.asarray(other.vertices)[np.asarray(other.faces)], mesh.vertices[mesh.faces])
