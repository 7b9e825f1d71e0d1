"""Power diagrams: brute force, the Voronoi diagram as the case of equal weights, sites without cells."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
power_diagram = iso.analysis.power_diagram


def crossings(polygon: np.ndarray, queries: np.ndarray) -> np.ndarray:
    (ax, ay), (bx, by) = polygon.T, np.roll(polygon, -1, axis=0).T
    x, y = queries[:, :1], queries[:, 1:]
    with np.errstate(all="ignore"):
        crossed = ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    return crossed.sum(axis=1) % 2 == 1


@pytest.mark.parametrize("spread", [0.0, 0.001, 0.02, 0.3])
@pytest.mark.parametrize("bounds", [SQUARE, [(0, 0), (1, 0), (0.5, 0.4), (1, 1), (0, 1)]])
def test_points_belong_to_the_least_power(spread: float, bounds: list) -> None:
    rng = np.random.default_rng(7)
    points, weights = rng.random((120, 2)), rng.random(120) * spread
    d = power_diagram(points, weights, bounds)
    queries = rng.random((2000, 2))
    power = ((queries[:, None] - points) ** 2).sum(axis=2) - weights
    owner = np.argmin(power, axis=1)
    within = crossings(np.array(bounds, float), queries)
    for i, cell in enumerate(d.cells):
        held = np.zeros(len(queries), bool)
        for piece in cell.pieces:
            held |= crossings(piece, queries)
        np.testing.assert_array_equal(held, within & (owner == i))
        assert cell.area == pytest.approx(d.cells.areas[i], abs=1e-13)
    assert d.cells.areas.sum() == pytest.approx(d.region.area, rel=1e-12)
    assert {(a, b) for a, b in d.pairs.tolist()} == {(b, a) for a, b in d.pairs.tolist()}


def test_equal_weights_give_the_voronoi_diagram() -> None:
    points = np.random.default_rng(3).random((500, 2))
    v, d = iso.analysis.voronoi(points, SQUARE), power_diagram(points, 5.0, SQUARE)
    np.testing.assert_allclose(d.cells.areas, v.cells.areas, atol=1e-13)
    np.testing.assert_allclose(d.cells.centroids, v.cells.centroids, atol=1e-9)


def test_two_circles_are_parted_along_their_common_chord() -> None:
    # Circles of radii 0.5 and 0.4 about points 0.6 apart: x with x² - 0.25 = (x - 0.6)² - 0.16.
    d = power_diagram([(0, 0), (0.6, 0)], [0.25, 0.16], [(-1, -1), (2, -1), (2, 1), (-1, 1)])
    chord = (0.36 + 0.25 - 0.16) / 1.2
    np.testing.assert_allclose(d.cells.areas, [2 * (1 + chord), 2 * (2 - chord)])
    assert d.cells[0].neighbours.tolist() == [1]


def test_a_light_site_has_no_cell() -> None:
    d = power_diagram([(0.5, 0.5), (0.6, 0.5), (0.5, 0.5)], [1.0, 0.1, 2.0], SQUARE)
    assert d.cells.areas.tolist() == [0, 0, 1]
    assert d.cells[1].pieces == ()


def test_bad_weights_are_refused() -> None:
    with pytest.raises(iso.GeometryError, match="finite"):
        power_diagram([(0, 0)], [np.nan])
    with pytest.raises(iso.GeometryError, match="each of 2"):
        power_diagram([(0, 0), (1, 1)], [1, 2, 3])
