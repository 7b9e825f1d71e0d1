"""Many motions asked together: they stand where each by itself says."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import isophote as iso
from isophote.scene.scene import placed_box, placed_boxes
from isophote.scene.ways import Ways

I = iso.Transform.identity()
MOTIONS = [
    iso.Motion({0.0: I, 1.0: I.translate((1, 2, 3))}),
    I.scale(2).translate((5, 0, 0)),
    iso.Motion({-1.0: I.rotate("x", 0.5), 0.25: I.scale((1, 2, 3)), 0.5: I.rotate("y", 2.0).translate((0, 1, 0))}),
    iso.Motion.turn("z", 40.0, (0.0, 2.0), I.translate((1, 0, 0))),
    iso.Motion({0.0: I.scale((-1, 1, 1)), 3.0: I.scale((-1, 2, 1)).rotate("x", 1.0)}),
    iso.Motion({0.0: I.rotate("x", 1.0), 1.0: I.rotate("x", 1.0)}),
]


@given(st.floats(-2, 4))
def test_all_stand_where_each_motion_says(time):
    found = Ways(MOTIONS).at(time)
    for matrix, one in zip(found, MOTIONS, strict=True):
        expected = one.at(time) if isinstance(one, iso.Motion) else one
        np.testing.assert_array_equal(matrix, expected.matrix)


def test_placements_are_met_to_the_last_bit():
    ways = Ways(MOTIONS)
    for number, motion in enumerate(MOTIONS):
        if isinstance(motion, iso.Motion):
            for time, transform in motion.placements:
                np.testing.assert_array_equal(ways.at(time)[number], transform.matrix)
                assert motion.at(time) == transform


@pytest.mark.parametrize("placed", [[], [I, I.scale(2)]])
def test_what_stands_still_stays(placed):
    matrices = Ways(placed).at(0.5)
    assert matrices.shape == (len(placed), 4, 4)
    for matrix, transform in zip(matrices, placed, strict=True):
        np.testing.assert_array_equal(matrix, transform.matrix)


def test_boxes_around_many_are_those_around_each():
    generator = np.random.default_rng(2)
    boxes = np.sort(generator.normal(size=(20, 2, 3)), axis=1)
    boxes[3, 1, 2], boxes[4, 0] = np.inf, -np.inf
    matrices = np.array([I.rotate("z", k % 4).translate((k, 0, 1)).matrix for k in range(20)])
    found = placed_boxes(boxes, matrices)
    for one, box, matrix in zip(found, boxes, matrices, strict=True):
        np.testing.assert_array_equal(one, placed_box(box, matrix))
        if np.isfinite(box).all():
            corners = box[[[k >> 2, k >> 1 & 1, k & 1] for k in range(8)], [0, 1, 2]]
            placed = corners @ matrix[:3, :3].T + matrix[:3, 3]
            np.testing.assert_allclose(one, [placed.min(axis=0), placed.max(axis=0)], rtol=1e-12)
