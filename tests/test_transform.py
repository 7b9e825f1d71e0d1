"""Transforms: group laws, known images of points, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isophote import SceneError, Transform

NUMBERS = st.floats(-100, 100)
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS)
FACTORS = st.floats(0.1, 10) | st.floats(-10, -0.1)
TRANSFORMS = st.builds(
    lambda offset, axis, angle, factors: Transform.identity().scale(factors).rotate(axis, angle).translate(offset),
    VECTORS,
    st.sampled_from(["x", "y", "z", (1, 2, 3), (-1, 0, 4)]),
    st.floats(-7, 7),
    st.tuples(FACTORS, FACTORS, FACTORS),
)


def close(a, b):
    return np.allclose(a, b, rtol=1e-9, atol=1e-9)


def test_turns_are_right_handed():
    quarter = np.pi / 2
    assert close(Transform.identity().rotate("x", quarter).apply((0, 1, 0)), (0, 0, 1))
    assert close(Transform.identity().rotate("y", quarter).apply((0, 0, 1)), (1, 0, 0))
    assert close(Transform.identity().rotate("z", quarter).apply((1, 0, 0)), (0, 1, 0))
    assert close(Transform.identity().rotate((1, 1, 1), 2 * np.pi / 3).apply((1, 0, 0)), (0, 1, 0))


def test_methods_come_one_after_another():
    moved = Transform.identity().translate((1, 0, 0)).rotate("z", np.pi / 2).scale((1, 2, 3)).mirror("y")
    assert close(moved.apply((0, 0, 0)), (0, -2, 0))
    assert close(Transform.identity().scale(2).apply([[1, 2, 3], [0, 0, 1]]), [[2, 4, 6], [0, 0, 2]])
    assert close(Transform.identity().mirror((1, 1, 0)).apply((1, 0, 5)), (0, -1, 5))


@given(TRANSFORMS, TRANSFORMS, VECTORS)
def test_composition(first, second, point):
    both = first.then(second)
    assert both == second @ first
    assert np.allclose(both.apply(point), second.apply(first.apply(point)), rtol=1e-9, atol=1e-6)


@given(TRANSFORMS, VECTORS)
def test_inverse_undoes(transform, point):
    assert np.allclose(transform.inverse().apply(transform.apply(point)), point, rtol=1e-7, atol=1e-6)


@given(TRANSFORMS)
def test_repr_can_be_pasted_back(transform):
    again = eval(repr(transform))
    assert again == transform
    assert hash(again) == hash(transform)


@given(VECTORS, VECTORS)
def test_look_at(eye, target):
    if np.hypot(eye[0] - target[0], eye[2] - target[2]) < 1e-3:
        return
    placed = Transform.look_at(eye, target)
    assert placed.is_rigid
    assert close(placed.apply((0, 0, 0)), eye)
    distance = np.linalg.norm(np.subtract(target, eye))
    assert close(placed.apply((0, 0, -distance)), target)
    right, up = placed.matrix[:3, 0], placed.matrix[:3, 1]
    assert abs(right[1]) < 1e-9
    assert up[1] > 0


def test_rigid_means_neither_scaled_nor_mirrored():
    assert Transform.identity().rotate((1, 2, 3), 1).translate((1, 2, 3)).is_rigid
    assert not Transform.identity().scale(1.001).is_rigid
    assert not Transform.identity().mirror("x").is_rigid


def test_small_scales_are_not_singular():
    assert close(Transform.identity().scale(1e-30).inverse().apply((1e-30, 0, 0)), (1, 0, 0))


@pytest.mark.parametrize(
    "make",
    [
        lambda: Transform(np.eye(3)),
        lambda: Transform(np.zeros((4, 4))),
        lambda: Transform(np.diag([1, 1, 0, 1])),
        lambda: Transform(np.full((4, 4), np.nan)),
        lambda: Transform([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]),
        lambda: Transform("identity"),
        lambda: Transform.identity().scale(0),
        lambda: Transform.identity().scale((1, 0, 1)),
        lambda: Transform.identity().scale(float("inf")),
        lambda: Transform.identity().scale(1e-320),
        lambda: Transform.identity().translate((1, 2)),
        lambda: Transform.identity().translate((1, 2, float("inf"))),
        lambda: Transform.identity().rotate("w", 1),
        lambda: Transform.identity().rotate((0, 0, 0), 1),
        lambda: Transform.identity().rotate("x", float("nan")),
        lambda: Transform.look_at((1, 1, 1), (1, 1, 1)),
        lambda: Transform.look_at((0, 1, 0), (0, 0, 0)),
        lambda: Transform.identity().apply([1, 2]),
    ],
)
def test_what_is_no_transform_is_refused(make):
    with pytest.raises(SceneError):
        make()


def test_the_matrix_given_is_neither_kept_nor_changed():
    matrix = np.eye(4)
    transform = Transform(matrix)
    matrix[0, 3] = 5
    assert transform == Transform.identity()
    with pytest.raises(ValueError, match="read-only"):
        transform.matrix[0, 0] = 2
