"""Sharp edges, ridges and valleys; values shown by colour; the command that draws curvature."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from command_line import run
from isophote.scene.image_texture import ImageTexture

WIDTH = 0.1


def _roof(sign: float, n: int = 61) -> iso.Mesh:
    """z = −sign √(x² + w²): a rounded ridge, or valley, along y with the curvature 1 / w."""
    x, y = (a.reshape(-1) for a in np.meshgrid(np.linspace(-0.5, 0.5, n), np.linspace(0, 1, n), indexing="ij"))
    # A slant, so that no vertex lies on the line itself.
    x = x + 0.03 * (y - 0.3)
    i, j = (a.reshape(-1) for a in np.meshgrid(np.arange(n - 1), np.arange(n - 1), indexing="ij"))
    a = i * n + j
    faces = np.concatenate([np.stack([a, a + n, a + n + 1], 1), np.stack([a, a + n + 1, a + 1], 1)])
    return iso.Mesh(np.stack([x, y, -sign * np.sqrt(x**2 + WIDTH**2)], 1), faces)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_rounded_roof_has_one_ridge_and_a_gutter_one_valley(sign: float) -> None:
    lines = iso.analysis.feature_lines(_roof(sign), strength=2.0)
    found, other = (lines.ridges, lines.valleys) if sign > 0 else (lines.valleys, lines.ridges)
    strength = lines.ridge_strength if sign > 0 else -lines.valley_strength
    assert len(other) == 0
    inner = (np.abs(found[..., 1] - 0.5) < 0.4).all(axis=1)
    assert np.abs(found[inner][..., 0]).max() < 0.01
    np.testing.assert_allclose(strength[inner], 1 / WIDTH, rtol=0.05)
    lengths = np.linalg.norm(found[inner][:, 1] - found[inner][:, 0], axis=1)
    assert lengths.sum() == pytest.approx(0.8, rel=0.05)


def test_strength_leaves_out_weak_lines() -> None:
    assert len(iso.analysis.feature_lines(_roof(1.0), strength=20.0).ridges) == 0


def test_a_cube_has_its_twelve_edges() -> None:
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    sharp = iso.analysis.feature_lines(iso.Mesh(corners, faces)).sharp
    lengths = np.linalg.norm(np.diff(np.array(corners, float)[sharp], axis=1), axis=2)
    assert len(sharp) == 12
    np.testing.assert_allclose(lengths, 1)


def test_angles_without_meaning_are_refused() -> None:
    with pytest.raises(iso.GeometryError, match="angle_degrees"):
        iso.analysis.feature_lines(_roof(1.0, 5), angle_degrees=-1)


def _column(item: iso.Item) -> np.ndarray:
    uvs = item.shape.uvs.values[:, 0]
    assert isinstance(item.material.colour, ImageTexture)
    return item.material.colour.pixels[0][np.rint(uvs * 256 - 0.5).astype(int)]


def test_values_become_colours() -> None:
    mesh = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [(0, 1, 3, 2)])
    colours = _column(iso.analysis.coloured(mesh, [-2.0, 0.0, 2.0, 9.0], limits=(-2, 2)))
    assert colours[0][2] > 5 * colours[0][0], "the lowest is blue"
    assert colours[2][0] > 5 * colours[2][2], "the highest is red"
    np.testing.assert_allclose(colours[1], 0.8, atol=0.02)
    np.testing.assert_allclose(colours[3], colours[2], err_msg="beyond the limits is the end of the scale")


@pytest.mark.parametrize(
    ("change", "message"),
    [({"values": [1.0]}, "one a vertex"), ({"scale": "rainbow"}, "scale"), ({"limits": (2, 1)}, "limits")],
)
def test_what_cannot_be_coloured(change: dict, message: str) -> None:
    mesh = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    with pytest.raises(iso.GeometryError, match=message):
        iso.analysis.coloured(**{"mesh": mesh, "values": [1.0, 2.0, 3.0], **change})


def test_the_command_measures_and_draws(tmp_path: Path) -> None:
    iso.save(_roof(1.0, 21), tmp_path / "roof.ply")
    picture = tmp_path / "roof.png"
    result = run(
        "curvature", str(tmp_path / "roof.ply"), "-o", str(picture), "--kind", "k1", "--size", "40x30", "--json"
    )
    assert result.exit_code == 0, result.stderr
    facts = json.loads(result.stdout)
    assert facts["greatest"] == pytest.approx(1 / WIDTH, rel=0.2)
    assert facts["euler"] == 1
    assert facts["total_gaussian"] + facts["total_boundary"] == pytest.approx(2 * np.pi)
    assert iso.load_image(picture).size == (40, 30)


def test_the_command_refuses_what_it_cannot_do(tmp_path: Path) -> None:
    assert run("curvature", str(tmp_path / "none.obj")).exit_code == 1
    assert run("curvature", "x.obj", "--kind", "magic").exit_code == 2
    assert run("curvature", "x.obj", "--limit", "-1").exit_code == 2
