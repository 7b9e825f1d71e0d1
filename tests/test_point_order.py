"""The order in which points are asked for what they see."""

from __future__ import annotations

import numpy as np
import pytest

from isophote.rendering.occlusion.order import near_each_other


def test_cells_of_a_grid_come_along_a_z_curve() -> None:
    corners = np.array([(x, y, z) for z in (0, 7) for y in (0, 7) for x in (0, 7)], np.float32)
    shuffled = np.random.default_rng(3).permutation(8)
    found = corners[shuffled][near_each_other(corners[shuffled])]
    # x leads, then y, then z.
    expected = [(x, y, z) for x in (0, 7) for y in (0, 7) for z in (0, 7)]
    np.testing.assert_array_equal(found, expected)


def test_neighbours_in_the_list_are_near() -> None:
    points = np.random.default_rng(5).random((4096, 3)).astype(np.float32)
    order = near_each_other(points)
    np.testing.assert_array_equal(np.sort(order), np.arange(4096))
    steps = np.linalg.norm(np.diff(points[order], axis=0), axis=1)
    # Chance gives a mean of 0.66 in the unit cube; a curve through 4,096 cells steps by about a cell, 1/16.
    assert steps.mean() < 0.15


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.ones((1, 3)), np.full((5, 3), -2.0), np.full((3, 3), 1e30)])
def test_few_points_and_equal_ones(points: np.ndarray) -> None:
    np.testing.assert_array_equal(near_each_other(points.astype(np.float32)), np.arange(len(points)))
