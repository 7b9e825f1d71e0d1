"""`isophote voronoi`: points from text files, drawings, the sweep as a moving picture, and what goes wrong."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image as Pillow

import isophote as iso
from command_line import facts, misused, refuses, succeeds, written
from isophote.io.points_file import read_points

POINTS = "x,y\n0,0\n2,0\n2,2\n0,2\n1,1\n1,1\n"


def test_facts_are_the_diagrams(tmp_path: Path) -> None:
    found = facts("voronoi", written(tmp_path, "p.csv", POINTS))
    assert found["points"] == 6
    assert found["cells"] == 5
    assert found["repeated_points"] == 1
    # A diamond around the middle, and four rays.
    assert (found["vertices"], found["edges"], found["endless_edges"]) == (4, 8, 4)
    assert found["bounds"] == [[pytest.approx(-0.2)] * 2, [pytest.approx(2.2)] * 2]
    assert found["greatest_area"] == pytest.approx(2)
    assert found["mean_area"] == pytest.approx(2.4**2 / 5)
    assert "repeated points" in succeeds("voronoi", tmp_path / "p.csv")


def test_a_drawing_holds_all_cells(tmp_path: Path) -> None:
    out = tmp_path / "out.svg"
    succeeds("voronoi", written(tmp_path, "p.csv", POINTS), "-o", out, "--size", "200x100")
    root = ElementTree.fromstring(out.read_text())
    name = "{http://www.w3.org/2000/svg}"
    polygons = [
        np.array([pair.split(",") for pair in p.attrib["points"].split()], float) for p in root.iter(f"{name}polygon")
    ]
    assert len(polygons) == 5
    assert len(list(root.iter(f"{name}circle"))) == 6
    areas = [abs(np.sum(p[:, 0] * np.roll(p[:, 1], -1) - np.roll(p[:, 0], -1) * p[:, 1]) / 2) for p in polygons]
    # 2.4 units on 96 of 100 pixels.
    assert sum(areas) == pytest.approx(96**2, rel=1e-3)
    assert max(areas) == pytest.approx(2 * 40**2, rel=1e-3)


def test_a_picture_has_a_colour_for_each_cell(tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    succeeds("voronoi", written(tmp_path, "p.csv", POINTS), "-o", out, "--size", "60x60")
    colour = iso.load_image(out).channels["colour"]
    assert colour.shape == (60, 60, 3)
    places = [(10, 12), (10, 47), (47, 12), (47, 47), (24, 30)]
    assert len({tuple(np.round(colour[y, x], 3)) for y, x in places}) == 5


def test_the_sweep_moves(tmp_path: Path) -> None:
    out = tmp_path / "sweep.gif"
    points = "0 0\n3 0.4\n1.4 1.1\n0.2 1.9\n2.8 2.6\n1 3\n"
    found = facts("voronoi", written(tmp_path, "p.csv", points), "--animate", out, "--size", "80x60")
    with Pillow.open(out) as film:
        # Frames that look alike are one.
        assert 3 < film.n_frames <= found["frames"]
        assert film.size == (80, 60)
        frames = [np.asarray((film.seek(k), film.convert("RGB"))[1]) for k in range(film.n_frames)]
    red = [np.flatnonzero(((f[..., 0] > 180) & (f[..., 1] < 110)).any(axis=1)) for f in frames[:-1]]
    rows = [float(r.mean()) for r in red if len(r)]
    assert rows == sorted(rows, reverse=True)
    assert rows[0] > rows[-1]


def test_relaxation_moves_the_sites(tmp_path: Path) -> None:
    path = written(tmp_path, "p.csv", "0 0\n1 0\n0 1\n0.1 0.1\n0.2 0.1\n")
    before, after = facts("voronoi", path), facts("voronoi", path, "--lloyd", 50)
    assert after["least_area"] > 2 * before["least_area"]
    assert after["bounds"] == before["bounds"]


@pytest.mark.parametrize(
    "text", ["1,2\n3,4\n", "\ufeffx;y\n1;2\n3;4\n", "# two\n1 2 9\n\n 3\t4 \n", "1, 2\r\n3, 4\r\n"]
)
def test_kinds_of_text(tmp_path: Path, text: str) -> None:
    np.testing.assert_array_equal(read_points(written(tmp_path, "p.txt", text)), [(1, 2), (3, 4)])


def test_no_points_are_a_diagram_too(tmp_path: Path) -> None:
    found = facts(
        "voronoi", written(tmp_path, "p.csv", "x,y\n"), "-o", tmp_path / "a.png", "--animate", tmp_path / "a.gif"
    )
    assert found["cells"] == 0


def test_what_goes_wrong(tmp_path: Path) -> None:
    good = written(tmp_path, "good.csv", POINTS)
    assert "line 2" in refuses("voronoi", written(tmp_path, "p.csv", "x,y\n1,two\n"))
    assert "line 1" in refuses("voronoi", written(tmp_path, "q.csv", "1\n"))
    assert "not finite" in refuses("voronoi", written(tmp_path, "r.csv", "1,nan\n"))
    assert "no text" in refuses("voronoi", written(tmp_path, "s.csv", b"\xff\xfe\x00"))
    assert "no such file" in refuses("voronoi", tmp_path / "none.csv")
    assert "ending" in refuses("voronoi", good, "-o", tmp_path / "out.xyz")
    assert ".gif" in refuses("voronoi", good, "--animate", tmp_path / "out.mp4")
    assert "4096" in refuses("voronoi", good, "-o", tmp_path / "out.png", "--size", "9000x10")
    assert "--lloyd" in misused("voronoi", good, "--lloyd", "-1")
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith("out")] == []
