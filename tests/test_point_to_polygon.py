"""The closed form between a point and a polygon, integrated by Gauss's rule over a square."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import isophote as iso
from isophote.kernels.base.double3 import Double3
from isophote.kernels.light.form_factor import point_to_polygon

UNIT = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)


@njit(error_model="numpy")
def factors(points, corners, sides, found):
    up = Double3(0.0, 0.0, 1.0)
    for i in range(len(points)):
        found[i] = point_to_polygon(Double3(points[i, 0], points[i, 1], points[i, 2]), up, corners, sides, 0)


def from_the_unit_square(polygon: np.ndarray) -> float:
    """The mean form factor from the unit square, facing +z, by 24 × 24 places."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    x, y = np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2)
    points = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    corners = np.zeros((1, 12))
    corners[0, : polygon.size] = polygon.reshape(-1)
    found = np.zeros(len(points))
    factors(points, corners, np.array([len(polygon)], np.uint8), found)
    return float(found @ np.outer(weights / 2, weights / 2).reshape(-1))


@pytest.mark.parametrize(
    ("polygon", "exact"),
    [
        ([(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], 0.199824896),
        ([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)], 0.200043776),
    ],
)
def test_unit_squares(polygon: list[tuple[int, int, int]], exact: float) -> None:
    assert from_the_unit_square(np.array(polygon, float)) == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize("lowest", [0.5, 0.0, -0.5])
def test_triangles_also_where_they_reach_below_the_horizon(lowest: float) -> None:
    # Beside the square, facing it; the second way to the same number is an integral along the edges.
    triangle = np.array([(1.5, -1.0, lowest), (1.5, 2.5, lowest), (2.0, 0.4, 2.0)])
    facing = triangle if iso.form_factor(UNIT, triangle) > 0 else triangle[::-1]
    wanted = iso.form_factor(UNIT, facing)
    assert wanted > 0.05
    assert from_the_unit_square(facing) == pytest.approx(wanted, abs=1e-6)
