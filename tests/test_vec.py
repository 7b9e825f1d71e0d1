"""Three-component vectors of the kernels, against NumPy in double precision."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from isophote.kernels.base.vec import (
    cross,
    dot,
    length,
    load_vec3,
    maximum_component,
    normalise,
    orthonormal,
    reflect,
    store_vec3,
)

EPSILON = 2.0**-23
COORDINATE = st.floats(-1e6, 1e6, width=32, allow_subnormal=False)
TRIPLE = st.lists(COORDINATE, min_size=3, max_size=3).map(lambda values: np.array(values, np.float32))
MANY = settings(max_examples=300, deadline=None)


@njit(error_model="numpy")
def arithmetic(a, b, s, out):
    p, q = load_vec3(a, 0), load_vec3(b, 0)
    store_vec3(out, 0, p + q)
    store_vec3(out, 3, p - q)
    store_vec3(out, 6, p * q)
    store_vec3(out, 9, p / q)
    store_vec3(out, 12, p * s)
    store_vec3(out, 15, s * p)
    store_vec3(out, 18, p / s)
    store_vec3(out, 21, s - p)
    store_vec3(out, 24, -p)


@MANY
@given(a=TRIPLE, b=TRIPLE, s=st.floats(0.5, 100, width=32))
def test_operators_work_by_components_and_with_scalars(a, b, s):
    out = np.zeros(27, np.float32)
    arithmetic(a, b, np.float32(s), out)
    with np.errstate(all="ignore"):
        s = np.float32(s)
        wanted = np.stack([a + b, a - b, a * b, a / b, a * s, s * a, a / s, s - a, -a])
    assert np.array_equal(out.reshape(9, 3), wanted, equal_nan=True)


@pytest.mark.parametrize("scalar", [3, 2.5, np.float64(0.1), np.int32(-2)])
def test_any_scalar_becomes_single_precision(scalar):
    a, out = np.array([1, 2, 3], np.float32), np.zeros(27, np.float32)
    arithmetic(a, a, scalar, out)
    assert np.array_equal(out[12:15], a * np.float32(scalar))


@njit(error_model="numpy")
def products(a, b, out):
    p, q = load_vec3(a, 0), load_vec3(b, 0)
    store_vec3(out, 0, cross(p, q))
    out[3], out[4], out[5] = dot(p, q), length(p), maximum_component(p)


@MANY
@given(a=TRIPLE, b=TRIPLE)
def test_products(a, b):
    out = np.zeros(6, np.float32)
    products(a, b, out)
    x, y = a.astype(np.float64), b.astype(np.float64)
    bound = 8 * EPSILON * np.abs(x) @ np.abs(y) + 1e-30
    size = np.linalg.norm(x) * np.linalg.norm(y)
    assert np.abs(out[:3] - np.cross(x, y)).max() <= 8 * EPSILON * size + 1e-30
    assert abs(out[3] - x @ y) <= bound
    assert out[4] == pytest.approx(np.linalg.norm(x), rel=8 * EPSILON, abs=1e-18)
    assert out[5] == a.max()


@njit(error_model="numpy")
def frame(n, d, out):
    normal = normalise(load_vec3(n, 0))
    tangent, bitangent = orthonormal(normal)
    store_vec3(out, 0, tangent)
    store_vec3(out, 3, bitangent)
    store_vec3(out, 6, normal)
    store_vec3(out, 9, reflect(load_vec3(d, 0), normal))


DIRECTIONS = [
    *np.eye(3),
    *-np.eye(3),
    (1e-4, 0, -1),
    (1e-4, 1e-4, -1),
    (0, 1e-6, -1),
    (1, 0, -1e-30),
    (1, 1, 0),
    (1, -1, -0.0),
    *np.random.default_rng(2).normal(size=(500, 3)),
]


def test_frames_are_orthonormal_and_right_handed_everywhere():
    for n in DIRECTIONS:
        out = np.zeros(12, np.float32)
        frame(np.array(n, np.float32), np.array((0.3, -0.5, 0.8), np.float32), out)
        axes = out[:9].reshape(3, 3).astype(np.float64)
        assert np.abs(axes @ axes.T - np.eye(3)).max() < 4e-7
        assert np.linalg.det(axes) == pytest.approx(1, abs=1e-6)


def test_reflection_keeps_length_and_turns_the_part_along_the_normal():
    d = np.array((0.3, -0.5, 0.8))
    for n in DIRECTIONS:
        out = np.zeros(12, np.float32)
        frame(np.array(n, np.float32), d.astype(np.float32), out)
        normal = np.array(n) / np.linalg.norm(n)
        assert np.abs(out[9:] - (d - 2 * (d @ normal) * normal)).max() < 1e-6


def test_vectors_lie_anywhere_in_an_array():
    source, target = np.arange(20, dtype=np.float32), np.full(20, -1, np.float32)

    @njit
    def move(a, b, i, j):
        store_vec3(b, j, load_vec3(a, i))

    move(source, target, 5, 13)
    assert target[13:16].tolist() == [5, 6, 7]
    assert (np.delete(target, [13, 14, 15]) == -1).all()
