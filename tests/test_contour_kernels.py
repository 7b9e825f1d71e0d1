"""Parts of contouring by themselves: sums of planes, points that lie best on them, and tables of the cube."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from isophote.kernels.base.jit import kernel
from isophote.kernels.base.simd_double import load_doubles, store_doubles
from isophote.kernels.base.simd_planes import later_products, leading_products
from isophote.kernels.measure.contour_cases import (
    COMPONENT_EDGES,
    CROSSED,
    FACE_BITS,
    FACE_EDGES,
    HIGH_FACES,
    LOW_FACES,
    SIMPLE,
)
from isophote.kernels.measure.qef import BOX_HIGH, BOX_LOW, MATRIX, QEF_WORDS, RIGHT, SOLUTION, solve_qefs

Points = npt.NDArray[np.float64]
LANES = 16


@kernel
def add_products(planes: Any, out: Any) -> None:
    for k in range(len(planes) // 8):
        plane = load_doubles(planes, 8 * k)
        store_doubles(out, 0, load_doubles(out, 0) + leading_products(plane))
        store_doubles(out, 8, load_doubles(out, 8) + later_products(plane))


@kernel
def solve(work: Any) -> None:
    solve_qefs(work)


def test_products_of_planes_are_those_of_their_error_function() -> None:
    random = np.random.default_rng(2)
    normals, points = random.normal(size=(2, 20, 3))
    distances = np.einsum("ij,ij->i", normals, points)
    planes = np.column_stack([normals, distances, points, np.ones(20)])
    out = np.zeros(16)
    add_products(planes.reshape(-1), out)
    matrix, right = normals.T @ normals, normals.T @ distances
    expected = [*matrix[np.triu_indices(3)], *right, distances @ distances, *points.sum(axis=0), 20]
    np.testing.assert_allclose(out[:14], expected, rtol=1e-12, atol=1e-12)


def planes_near(random: np.random.Generator, normals: Points, count: int) -> tuple[Points, Points]:
    """Planes through a point within half a cell of the middle, with these normals in turns, and points on them."""
    corner = random.uniform(-0.2, 0.2, 3)
    chosen = normals[np.arange(count) % len(normals)]
    points = corner + random.uniform(-0.2, 0.2, (count, 3))
    points -= np.einsum("ij,ij->i", points - corner, chosen)[:, None] * chosen
    return chosen, points


def put(work: Any, lane: int, normals: Points, points: Points) -> Points:
    """Write an error function into a lane, and give its least squares solution of least length."""
    middle = points.mean(axis=0)
    matrix = normals.T @ normals
    right = normals.T @ np.einsum("ij,ij->i", normals, points - middle)
    work[MATRIX + lane : RIGHT : LANES] = matrix[np.triu_indices(3)]
    work[RIGHT + lane : BOX_LOW : LANES] = right
    work[BOX_LOW + lane : BOX_HIGH : LANES], work[BOX_HIGH + lane : SOLUTION : LANES] = -0.5, 0.5
    solution: Points = np.linalg.pinv(matrix, rcond=1e-3, hermitian=True) @ right
    return solution


@pytest.mark.parametrize("kinds", [(1,), (2,), (3,), (1, 2, 3)], ids=["flat", "edges", "corners", "all"])
def test_vertices_lie_on_planes_edges_and_corners(kinds: tuple[int, ...]) -> None:
    random = np.random.default_rng(4)
    for _ in range(20):
        work = np.zeros(QEF_WORDS, np.float32)
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        expected = [
            put(work, lane, *planes_near(random, turn[: kinds[lane % len(kinds)]], 6 + lane)) for lane in range(LANES)
        ]
        solve(work)
        found = work[SOLUTION : SOLUTION + 48].reshape(3, LANES).T
        np.testing.assert_allclose(found, expected, atol=2e-5)


def test_components_of_a_case_share_out_its_crossed_edges() -> None:
    for signs in range(256):
        components = COMPONENT_EDGES[4 * signs : 4 * signs + 4].tolist()
        assert sum(components) == CROSSED[signs]
        assert np.bitwise_or.reduce(components) == CROSSED[signs]


def test_bits_of_faces_are_those_of_their_edges() -> None:
    for edges in range(1 << 12):
        counts = [(edges & int(face)).bit_count() for face in FACE_EDGES]
        assert FACE_BITS[edges] & 63 == sum(1 << face for face, count in enumerate(counts) if count)
        assert bool(FACE_BITS[edges] & SIMPLE) == all(count in (0, 2) for count in counts)


def test_two_children_name_the_face_between_them_alike() -> None:
    """And every child has three faces within the whole."""
    for child in range(8):
        faces = 64 * child + 63
        assert int(LOW_FACES[faces]).bit_count() + int(HIGH_FACES[faces]).bit_count() == 3
        for axis in range(3):
            if child >> axis & 1 == 0:
                other = child | 1 << axis
                from_low, from_high = LOW_FACES[64 * child + (2 << 2 * axis)], HIGH_FACES[64 * other + (1 << 2 * axis)]
                assert from_low == from_high
                assert int(from_low).bit_count() == 1
