"""Tables of measured reflectance: made, written, read, damaged, sampled and drawn; files of metals."""

from __future__ import annotations

import gzip
import struct
from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from isophote.checks.materials import probe_of
from isophote.checks.scatter import direction, disk_points, sphere_grid
from isophote.checks.statistics import chi_square_deviation
from isophote.lower.probe import Probe

PLASTIC = iso.Plastic((0.6, 0.2, 0.1), 0.4)


@pytest.fixture(scope="module")
def table() -> iso.Measured:
    return iso.measure_brdf(PLASTIC, "plastic")


@pytest.fixture(scope="module")
def file(table: iso.Measured, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("brdf") / "red plastic.binary"
    iso.save(table, path)
    return path


def test_a_table_reflects_as_what_it_was_made_of(table: iso.Measured) -> None:
    measured = Probe(table)
    for angle in (0.0, 0.5, 1.0, 1.3):
        out = direction(angle, 0.3)
        grid, _ = sphere_grid(90, 60)
        above = grid[grid[:, 2] > 0.1]
        a, b = (one.evaluate(out, above).value for one in (measured, probe_of(PLASTIC)))
        # Cells are as wide as a degree and more.
        np.testing.assert_allclose(a, b, rtol=0.06, atol=0.003)


def test_tables_are_reciprocal(table: iso.Measured) -> None:
    v = np.random.default_rng(1).normal(size=(2, 2000, 3))
    v[:, :, 2] = np.abs(v[:, :, 2]) + 0.1
    out, into = v / np.linalg.norm(v, axis=2, keepdims=True)
    measured = Probe(table)
    there = measured.evaluate(out, into).value / into[:, 2:]
    np.testing.assert_allclose(there, measured.evaluate(into, out).value / out[:, 2:], rtol=2e-3, atol=1e-5)


def test_tables_are_sampled_by_their_density(table: iso.Measured) -> None:
    count, rows, columns, fine = 160_000, 24, 32, 12
    measured, out = Probe(table), direction(0.7, 0.5)
    rng = np.random.default_rng(4)
    points = rng.random((count, 3))
    radius, phi = np.sqrt(points[:, 0]), 2 * np.pi * points[:, 1]
    points[:, 0], points[:, 1] = radius * np.cos(phi), radius * np.sin(phi)
    sample = measured.sample(out, np.minimum(points, 1 - 2.0**-24))
    into = sample.into[sample.value.any(axis=1)].astype(np.float64)
    row = np.clip(((1 - np.arccos(np.clip(into[:, 2], -1, 1)) / np.pi) * rows).astype(int), 0, rows - 1)
    column = (np.arctan2(into[:, 1], into[:, 0]) % (2 * np.pi) / (2 * np.pi) * columns).astype(int) % columns
    grid, cell = sphere_grid(rows * fine, columns * fine)
    density = measured.evaluate(out, grid).density.astype(np.float64) * cell * count
    expected = density.reshape(rows, fine, columns, fine).sum(axis=(1, 3)).reshape(-1)
    assert abs(len(into) - expected.sum()) < 0.005 * count
    observed = np.bincount(row * columns + column, minlength=rows * columns)
    assert chi_square_deviation(observed, expected * observed.sum() / expected.sum()) < 5


def test_what_tables_reflect_is_sampled_without_bias(table: iso.Measured) -> None:
    for angle in (0.2, 1.2):
        a, b = (one.sample(direction(angle), disk_points(160_000)).value for one in (Probe(table), probe_of(PLASTIC)))
        np.testing.assert_allclose(a.mean(axis=0), b.mean(axis=0), rtol=0.02)


def test_round_trip(table: iso.Measured, file: Path) -> None:
    assert file.stat().st_size == 12 + 8 * 90 * 90 * 180 * 3
    again = iso.load_brdf(file)
    assert again.name == "red plastic"
    np.testing.assert_allclose(again.values, table.values, rtol=1e-7)
    assert iso.Measured(again.values, "plastic") == table


def test_the_layout_is_merl_s(file: Path, table: iso.Measured) -> None:
    """Red, green, blue one after another; θ_h slowest, φ_d fastest; scaled by 1/1500, 1.15/1500, 1.66/1500."""
    data = file.read_bytes()
    assert struct.unpack_from("<3i", data) == (90, 90, 180)
    for channel, scale in enumerate((1 / 1500, 1.15 / 1500, 1.66 / 1500)):
        for i, j, k in ((0, 0, 0), (3, 80, 179), (89, 1, 90)):
            place = 12 + 8 * (channel * 90 * 90 * 180 + (i * 90 + j) * 180 + k)
            (stored,) = struct.unpack_from("<d", data, place)
            assert stored * scale == pytest.approx(table.values[i, j, k, channel], rel=1e-6)


def test_packed_files_are_read(file: Path, table: iso.Measured, tmp_path: Path) -> None:
    packed = tmp_path / "paint.binary.gz"
    packed.write_bytes(gzip.compress(file.read_bytes(), 1))
    assert iso.load_brdf(packed).name == "paint"


def test_damaged_files_are_refused(file: Path, tmp_path: Path) -> None:
    data = file.read_bytes()
    bad = tmp_path / "bad.binary"
    infinite = bytearray(data)
    infinite[12 + 8 * 5 : 20 + 8 * 5] = struct.pack("<d", np.inf)
    for damaged, words in (
        (b"", "too few"),
        (data[:7], "too few"),
        (struct.pack("<3i", 45, 90, 180) + data[12:], "begins with"),
        (data[:-8], "should have"),
        (data + b"\0" * 8, "should have"),
        (bytes(infinite), "byte 52"),
        (data[:12] + struct.pack("<d", 1e300) + data[20:], "no reflectance"),
    ):
        bad.write_bytes(damaged)
        with pytest.raises(iso.FileError, match=words):
            iso.load_brdf(bad)
    with pytest.raises(iso.FileError, match="no such file"):
        iso.load_brdf(tmp_path / "none.binary")


def test_bad_tables_are_refused(table: iso.Measured, tmp_path: Path) -> None:
    with pytest.raises(iso.SceneError, match="shape"):
        iso.Measured(np.zeros((90, 90, 180)))
    values = table.values.copy()
    values[1, 2, 3, 0] = np.nan
    with pytest.raises(iso.SceneError, match="finite"):
        iso.Measured(values)
    with pytest.raises(iso.FileError, match="binary"):
        iso.save(table, tmp_path / "table.csv")
    with pytest.raises(iso.RenderError, match="single directions"):
        iso.measure_brdf(iso.Mirror())
    with pytest.raises(iso.RenderError, match="material"):
        iso.measure_brdf("gold")


def test_negative_cells_count_as_black() -> None:
    assert (
        not probe_of(iso.Measured(np.full((90, 90, 180, 3), -1.0))).evaluate(direction(0.3), direction(0.5)).value.any()
    )


# --- indices of refraction ------------------------------------------------------------------------

NK = """DATA:
  - type: tabulated nk
    data: |
        0.38 0.2 3.0
        0.60 0.2 3.0

        0.80 0.2 3.0
"""
APART = """DATA:
  - type: tabulated n
    data: |
        0.38 0.5
        0.80 0.5
  - type: tabulated k
    data: |
        0.38 2
        0.80 2
SPECS:
    thickness: 3
"""


def test_files_of_metals(tmp_path: Path) -> None:
    path = tmp_path / "metal.yml"
    path.write_text(NK)
    metal = iso.load_metal(path, 0.2)
    np.testing.assert_allclose(metal.index, [[0.2] * 3, [3.0] * 3])
    assert metal.roughness == (0.2, 0.2)
    path.write_text(APART)
    np.testing.assert_allclose(iso.load_metal(path).index, [[0.5] * 3, [2.0] * 3])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no table of n"),
        (APART.replace("tabulated k", "formula 1"), "no table of k"),
        (NK.replace("0.60 0.2 3.0", "0.60 0.2"), "line 5: there should be 3"),
        (NK.replace("0.80", "0.50"), "rise"),
        (NK.replace("0.80", "0.65"), "400 to 700"),
        (NK.replace("3.0", "nan"), "finite"),
        (NK.replace("0.2", "-0.2"), "no metal"),
        ("DATA:\n  - type: tabulated nk\n    data: |\n", "empty"),
    ],
)
def test_damaged_files_of_metals_are_refused(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "metal.yml"
    path.write_text(text)
    with pytest.raises(iso.FileError, match=words):
        iso.load_metal(path)


# --- plots ----------------------------------------------------------------------------------------


def test_plots_show_lobes() -> None:
    for material in (iso.Metal("gold"), iso.Glass(1.5), iso.Glass(1.5, roughness=0.5), iso.Matte(0.0)):
        image = iso.brdf_plot(material, (0, 45), (300, 260))
        assert image.size == (300, 260)
        pixels = np.asarray(image.channels["colour"])
        assert pixels[0, 0].tolist() == [1, 1, 1]
    # Red plastic is brighter where it mirrors: the curve of 60° reaches far to the right, that of 0° does not.
    pixels = np.asarray(iso.brdf_plot(iso.Plastic("red", 0.3), (60,), (400, 300)).channels["colour"])
    blue = (pixels[..., 2] > 1.5 * pixels[..., 0]) & (pixels[..., 2] < 0.9)
    assert blue[40:, 250:].sum() > 2 * blue[40:, :100].sum()


def test_bad_plots_are_refused() -> None:
    for wrong in (
        {"angles_degrees": (95,)},
        {"angles_degrees": ()},
        {"angles_degrees": "x"},
        {"size": (10, 10)},
        {"angles_degrees": (1,) * 9},
    ):
        with pytest.raises(iso.RenderError):
            iso.brdf_plot(iso.Matte(), **wrong)
    with pytest.raises(iso.RenderError, match="material"):
        iso.brdf_plot("gold")
