"""The benchmarks run by hand; here with tiny sizes, those with a peer only where it is installed."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

BENCH = Path(__file__).parents[1] / "bench"
TINY_RAYS = ("--size", "16", "--rounds", "1")

needs_embree = pytest.mark.skipif(find_spec("embreex") is None, reason="embreex is not installed")
needs_igl = pytest.mark.skipif(find_spec("igl") is None, reason="libigl is not installed")
needs_triangle = pytest.mark.skipif(find_spec("triangle") is None, reason="triangle is not installed")
needs_mitsuba = pytest.mark.skipif(find_spec("mitsuba") is None, reason="mitsuba is not installed")


def output_of(script: str, *arguments: str) -> str:
    """What `python bench/SCRIPT ARGUMENTS` prints."""
    run = subprocess.run([sys.executable, BENCH / script, *arguments], capture_output=True, text=True, timeout=600)
    assert run.returncode == 0, run.stderr
    return run.stdout


def cells(output: str, row: str) -> list[str]:
    """The cells of a table's row, by the text of its first cell."""
    found = re.search(rf"^\| {re.escape(row)} \|(.*)\|$", output, re.MULTILINE)
    assert found is not None, output
    return [cell.strip() for cell in found[1].split("|")]


def test_every_script_says_what_it_does() -> None:
    scripts = [path for path in BENCH.glob("*.py") if 'if __name__ == "__main__":' in path.read_text()]
    assert len(scripts) >= 7
    for path in scripts:
        assert f"python bench/{path.name}" in path.read_text()


def test_spheres_are_closed_and_face_outward(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCH))
    from common import bumpy_sphere, geodesic_sphere

    for frequency in (1, 2, 5):
        for points, triangles in (geodesic_sphere(frequency), bumpy_sphere(frequency)):
            assert (len(points), len(triangles)) == (10 * frequency**2 + 2, 20 * frequency**2)
            edges = {tuple(edge) for k in range(3) for edge in np.roll(triangles, k, axis=1)[:, :2].tolist()}
            assert len(edges) == 3 * len(triangles)
            assert all((b, a) in edges for a, b in edges)
            assert (np.linalg.det(points[triangles].astype(float)) > 0).all()


def test_motion() -> None:
    output = output_of("motion.py", "--size", "8", "--samples", "4", "--rounds", "1", "--parts", "noise", "steps")
    assert float(cells(output, "blue-noise")[1]) < float(cells(output, "independent")[1])
    assert float(cells(output, "256")[1]) < float(cells(output, "8")[1])


def test_sampling() -> None:
    tiny = ("--size", "8", "--rounds", "1", "--reference", "64")
    output = output_of("sampling.py", *tiny, "--parts", "patterns", "spectrum")
    few, many = (float(cells(output, "area light, sobol")[k]) for k in (0, 2))
    assert many < 0.3 * few
    assert float(cells(output, "area light, independent")[5]) == 1
    assert float(cells(output, "area light, blue-noise")[0]) > 0
    output = output_of("sampling.py", *tiny, "--parts", "adaptive")
    assert float(cells(output, "stars, noise 0.05")[2]) > 0.2


def test_threads() -> None:
    output = output_of("threads.py", *TINY_RAYS, "--frequency", "4", "--samples", "1")
    assert float(cells(output, "PathTrace, Cornell box")[2]) > 0


def test_startup() -> None:
    output = output_of("startup.py", "--rounds", "1", "--first-rounds", "0", "--size", "8", "--samples", "1")
    assert float(cells(output, "`import isophote`")[2]) > 0


def test_brdf() -> None:
    output = output_of("brdf.py", "--rounds", "1", "--count", "256")
    assert float(cells(output, "direction, weight, density")[0]) > 0
    assert float(cells(output, "Ward")[3]) > 0


def test_nothing_escapes() -> None:
    output = output_of("watertight.py", "--rays", "20000", "--frequency", "8")
    assert "Escaped in all: 0" in output
    assert len(re.findall(r"\| 0 of 2,500 \|", output)) == 8


def test_a_hole_lets_rays_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCH))
    import isophote as iso
    import watertight

    whole = watertight.meshes(8)["torus"]()
    tracer = iso.Tracer(iso.Mesh(whole.vertices, whole.triangles[1:]))
    rays = watertight.random_rays(whole, 20_000, np.random.default_rng(1))
    for query in watertight._QUERIES:
        assert 0 < watertight.escapes(tracer, query, rays) < 2000


@needs_embree
def test_rays() -> None:
    output = output_of("rays.py", *TINY_RAYS, "--meshes", "70k")
    assert output.count("| 70k |") == 3 * 6 + 3


def test_primitives() -> None:
    output = output_of("primitives.py", *TINY_RAYS, "--triangles", "2000")
    for solid in ("sphere", "cylinder", "torus"):
        assert float(cells(output, solid)[3]) > 0


@needs_embree
def test_build() -> None:
    output = output_of("build.py", "--rounds", "1", "--frequency", "8")
    assert float(cells(output, "tree (nodes and leaf blocks)")[0]) > 0


@needs_mitsuba
def test_packets() -> None:
    output = output_of("packets.py", *TINY_RAYS, "--frequency", "4")
    assert "name another triangle for 0." in output


@needs_mitsuba
def test_path_trace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    output = output_of("path_trace.py", *TINY_RAYS, "--samples", "16", "--scenes", "bumpy20")
    assert "Isophote, whole call" in output


@needs_igl
def test_topology() -> None:
    output = output_of("topology.py", "--rounds", "1", "--frequency", "8", "--large", "8")
    assert cells(output, "closed")[0] == "1280"
    assert float(cells(output, "topology")[1]) > 0


@needs_igl
def test_inside() -> None:
    output = output_of("inside.py", "--rounds", "1", "--frequency", "12", "--queries", "2000")
    assert float(cells(output, "winding number, closed, near")[2]) > 0
    for name in ("winding number, closed, box", "winding number, with holes, near", "exact geodesics, difference"):
        errors = output.partition("largest error")[2]
        assert float(cells(errors, name)[0]) < 1e-13


def test_fields_have_their_speeds_told_and_no_pixel_wrong() -> None:
    output = output_of("fields.py", "--rounds", "1", "--side", "64")
    assert cells(output, "values")[0] == "44"
    assert "met" in output or "missed" in output
    assert "picture of 7,010 operations" in output
    assert "Pixels that differ from NumPy's in double precision: 0 of 256." in output


@needs_triangle
def test_delaunay() -> None:
    output = output_of("delaunay.py", "--rounds", "1", "--points", "2000", "--space", "500")
    assert float(cells(output, "uniform, against Triangle")[0]) > 0
    assert float(cells(output, "lifted hull")[0]) > 0


@needs_triangle
def test_voronoi() -> None:
    output = output_of("voronoi.py", "--rounds", "1", "--points", "2000", "--edges", "100")
    assert float(cells(output, "sweep against triangle")[0]) > 0
    assert cells(output, "100")[2].startswith("≤ 1")


def test_ray_trace() -> None:
    arguments = ("--rounds", "1", "--size", "8", "--frequency", "4", "--samples", "2", "--long", "16", "--no-peer")
    output = output_of("ray_trace.py", *arguments)
    assert float(cells(output, "glass and mirror, depth 8")[1]) > 0
    assert len(cells(output, "64")) == 5


def test_accelerators_are_compared_with_the_tree() -> None:
    output = output_of("accelerators.py", *TINY_RAYS, "--scenes", "houses", "--accelerators", "grid", "kdtree")
    for name in ("grid", "kdtree"):
        assert re.search(rf"^\| houses \| {name} \|", output, re.MULTILINE), output


def test_the_lazy_hierarchy_is_timed_against_the_tree() -> None:
    output = output_of("lazy.py", *TINY_RAYS, "--frequency", "6")
    for what in ("building", "rays", "picture, sun", "picture, sky"):
        assert 0 < float(cells(output, what)[1]) < 0.5
        assert all(float(cell) > 0 for cell in cells(output, what)[2:9])


def test_accelerators_over_primitives_are_compared_with_the_tree() -> None:
    output = output_of("accelerated_shapes.py", "--count", "20", "--rounds", "1", "--rays", "50")
    for scene in ("spheres", "crowd"):
        assert re.search(rf"^\| {scene} \| kdtree \| 20 \|", output, re.MULTILINE), output


def test_texture_filters_are_compared() -> None:
    output = output_of("textures.py", "--quick", "--only", "error")
    errors = {line.split()[0]: float(line.split()[1]) for line in output.splitlines()[2:] if line}
    assert errors["ewa"] < 0.5 * errors["trilinear"] < 0.5 * errors["bilinear"]
