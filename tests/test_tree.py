"""Trees: what they hold, how deep and good they are, and that no ray slips through them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote
from isophote.accel.tree import BOXES, TRIANGLES, build_boxes, build_triangles
from isophote.accel.tree_statistics import tree_statistics
from isophote.errors import GeometryError
from isophote.kernels.accel.layout import (
    BLOCK,
    LANES,
    MAX_DEPTH,
    NODE,
)
from trees import (
    GEOMETRIES,
    Geometry,
    brute_force,
    chain,
    check_triangles,
    coincident,
    is_closed,
    leaves,
    random_soup,
    shoot,
    soup,
    sphere,
    swept_cost,
    unequal_soup,
    winding,
)

CLOSED_MODELS = Path(__file__).parents[1] / "../shared/models/closed"

# --- what trees hold ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GEOMETRIES)
def test_every_triangle_lies_in_one_lane_and_in_its_boxes(name):
    check_triangles(build_triangles(*GEOMETRIES[name]), GEOMETRIES[name])


@settings(max_examples=60, deadline=None)
@given(
    corners=st.lists(st.lists(st.integers(-3, 3), min_size=9, max_size=9), min_size=1, max_size=70),
    scale=st.sampled_from([1e-40, 1e-20, 1.0, 1e30]),
)
def test_any_triangles_make_a_sound_tree(corners, scale):
    geometry = soup(np.array(corners, np.float64).reshape(-1, 3, 3) * scale)
    check_triangles(build_triangles(*geometry), geometry)


def test_a_single_triangle_hangs_on_an_inner_root():
    tree = build_triangles(*random_soup(1))
    assert tree_statistics(tree)._replace(cost=0, bytes=0) == (1, 1, 1, 1, 1 / LANES, 0, 0)


def test_no_triangles_make_a_tree_that_nothing_meets():
    tree = build_triangles(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    assert not shoot(tree, np.zeros((1, 3)), np.ones((1, 3)))[2].any()
    assert tree_statistics(tree).leaves == 0


@pytest.mark.parametrize("make", [coincident, chain, unequal_soup])
def test_hundred_thousand_awkward_triangles(make):
    geometry = make(100_000)
    assert 1 < check_triangles(build_triangles(*geometry), geometry) <= MAX_DEPTH


@pytest.mark.parametrize("geometry", [sphere(200, 0.05), coincident(150_000), chain(150_000)])
def test_same_bits_for_any_number_of_threads(geometry):
    alone = build_triangles(*geometry, threads=1)
    for threads in (2, 3, 7, None):
        together = build_triangles(*geometry, threads=threads)
        assert all(a.tobytes() == b.tobytes() for a, b in zip(alone, together, strict=True))


def test_read_only_and_strided_input_is_taken_as_it_is():
    points, triangles = sphere(10)
    wide = np.zeros((len(points), 6))
    wide[:, ::2] = points
    wide.flags.writeable = False
    from_other = build_triangles(wide[:, ::2], triangles.astype(np.uint64))
    assert from_other.blocks.tobytes() == build_triangles(points, triangles).blocks.tobytes()


@pytest.mark.parametrize(
    ("points", "triangles", "reason"),
    [
        ([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]], "finite"),
        ([[0, 0, 0], [1, 0, 1e39], [0, 1, 0]], [[0, 1, 2]], "finite"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]], "outside 0 to 2"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, -1, 2]], "outside 0 to 2"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2**32]], "outside 0 to 2"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2.0]], "whole numbers"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2, 0]], "whole numbers"),
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], "shape"),
    ],
)
def test_bad_triangles_are_refused(points, triangles, reason):
    with pytest.raises(GeometryError, match=reason):
        build_triangles(np.array(points), np.array(triangles))


# --- trees of boxes -------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, 9, 1000, 30_000])
@pytest.mark.parametrize("spread", [0.0, 1.0])
def test_every_box_lies_in_one_leaf(count, spread):
    rng = np.random.default_rng(count)
    lower = (spread * rng.normal(size=(count, 3))).astype(np.float32)
    upper = (lower + 0.01 + 0.05 * spread * rng.random((count, 3))).astype(np.float32)
    tree = build_boxes(lower, upper)
    assert tree.blocks.dtype == np.int32
    assert np.array_equal(np.sort(tree.blocks), np.arange(count))
    used = np.zeros(count, int)
    found, depth = leaves(tree)
    for low, high, first, size in found:
        items = tree.blocks[first : first + size]
        used[items] += 1
        assert np.array_equal(lower[items].min(axis=0), low)
        assert np.array_equal(upper[items].max(axis=0), high)
    assert (used == 1).all()
    assert depth <= MAX_DEPTH
    if spread > 0:
        assert len(found) >= 0.99 * count


def test_bad_boxes_are_refused():
    for lower, upper in (([[0, 0, 0]], [[1, -1, 1]]), ([[0, 0, np.nan]], [[1, 1, 1]]), ([[0, 0, 0]], [[1, 1, np.inf]])):
        with pytest.raises(GeometryError):
            build_boxes(np.array(lower, np.float32), np.array(upper, np.float32))
    with pytest.raises(GeometryError):
        build_boxes(np.zeros((2, 3)), np.ones((3, 3)))


# --- how good they are ----------------------------------------------------------------------------


@pytest.mark.parametrize("geometry", [sphere(72, 0.05), random_soup(8000), random_soup(3000, 1.0)])
def test_cost_is_near_that_of_trying_every_split(geometry):
    corners = geometry[0].astype(np.float64)[geometry[1]]
    swept = swept_cost(corners.min(axis=1), corners.max(axis=1), *TRIANGLES.collapse)
    assert tree_statistics(build_triangles(*geometry)).cost <= 1.05 * swept


def test_cost_of_boxes_is_near_that_of_trying_every_split():
    lower = np.random.default_rng(1).uniform(-1, 1, (3000, 3)).astype(np.float32)
    upper = lower + np.float32(0.03)
    swept = swept_cost(lower.astype(np.float64), upper.astype(np.float64), *BOXES.collapse)
    assert tree_statistics(build_boxes(lower, upper)).cost <= 1.05 * swept


def test_cost_of_two_separate_boxes():
    lower = np.array([[0, 0, 0], [3, 0, 0]], np.float32)
    # Surfaces: root 4 x 1 x 1 has 18, each box 6; the root's test and, for each box, its block.
    expected = 1 + 2 * 6 / 18 * float(BOXES.leaf_cost + BOXES.block_cost)
    assert tree_statistics(build_boxes(lower, lower + 1)).cost == pytest.approx(expected)


def test_memory_of_a_mesh():
    geometry = sphere(72, 0.05)
    numbers = tree_statistics(build_triangles(*geometry))
    assert numbers.bytes == numbers.nodes * 4 * NODE + numbers.blocks * 4 * BLOCK
    assert numbers.bytes <= 75 * len(geometry[1])
    assert numbers.occupancy == pytest.approx(len(geometry[1]) / (LANES * numbers.blocks))


# --- what rays meet -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["one", "two", "five", "soup", "needles", "sphere", "flat", "coincident", "slivers"])
def test_same_hits_as_brute_force(name):
    geometry = GEOMETRIES[name]
    rng = np.random.default_rng(11)
    origins = rng.uniform(-1.5, 1.5, (600, 3)).astype(np.float32)
    targets = geometry[0][geometry[1][rng.integers(len(geometry[1]), size=600)]]
    weights = rng.dirichlet(np.ones(3), 600)[:, :, None]
    directions = ((targets * weights).sum(axis=1) - origins).astype(np.float32)
    directions[::3] = rng.normal(size=(200, 3))
    expected, doubtful = brute_force(geometry, origins, directions)
    distances, slots, found = shoot(build_triangles(*geometry), origins, directions)
    sure = ~doubtful
    assert sure.sum() > 200
    assert np.array_equal(np.isfinite(expected)[sure], (slots >= 0)[sure])
    assert np.array_equal(found, slots >= 0)
    hit = sure & (slots >= 0)
    assert hit.sum() > 60
    assert np.allclose(distances[hit], expected[hit], rtol=1e-4, atol=1e-5)


def test_rays_along_axes_and_in_the_planes_of_boxes():
    """Directions with zeros, origins on planes of boxes: no 0 times infinity loses a box."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    cells = np.arange(16, dtype=np.float32)
    grid = np.stack(np.meshgrid(cells, cells, [0], indexing="ij"), 3).reshape(-1, 1, 3)
    corners = (grid + points[None])[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    tree = build_triangles(*soup(corners))
    x, y = np.meshgrid(np.linspace(0, 16, 33), np.linspace(0, 16, 33))
    for sign in (1, -1):
        origins = np.stack([x, y, np.full_like(x, -2.0 * sign)], 2).reshape(-1, 3)
        distances, _, found = shoot(tree, origins, np.tile([0.0, -0.0, sign], (len(origins), 1)))
        assert (distances == 2).all()
        assert found.all()


def escapes(geometry: Geometry, origins: np.ndarray, count: int) -> int:
    """Rays out of a closed mesh, a third each in any direction, at vertices, and at midpoints of edges."""
    rng = np.random.default_rng(3)
    points, triangles = geometry
    corners = points[triangles[rng.integers(len(triangles), size=count)]]
    origins = origins[rng.integers(len(origins), size=count)].astype(np.float32)
    ends = corners[:, 0].copy()
    ends[1::3] = (corners[1::3, 0] + corners[1::3, 1]) / 2
    directions = ends - origins
    directions[2::3] = rng.normal(size=directions[2::3].shape)
    _, slots, found = shoot(build_triangles(*geometry), origins, directions)
    return int((slots < 0).sum() + (~found).sum())


@pytest.mark.parametrize("rings", [3, 24, 160])
def test_no_ray_escapes_from_a_sphere(rings):
    origins = np.concatenate([np.zeros((1, 3)), np.random.default_rng(4).uniform(-0.3, 0.3, (50, 3))])
    assert escapes(sphere(rings, 0.05), origins, 400_000) == 0


@pytest.mark.parametrize("offset", [1e-4, 1e5])
def test_no_ray_escapes_at_any_scale(offset):
    points, triangles = sphere(24, 0.05)
    origins = np.random.default_rng(4).uniform(-0.3, 0.3, (50, 3)) * offset
    assert escapes((points * np.float32(offset), triangles), origins, 60_000) == 0


@pytest.mark.parametrize("name", ["koala", "bunny", "goathead"])
def test_no_ray_escapes_from_a_model(name):
    path = CLOSED_MODELS / f"{name}.obj"
    if not path.exists():
        pytest.skip("the models are not here")
    mesh = isophote.load_mesh(path)
    fans = [face[[0, k, k + 1]] for face in mesh.faces for k in range(1, len(face) - 1)]
    geometry = mesh.vertices.astype(np.float32), np.array(fans, np.int32)
    if not is_closed(geometry[1]):
        pytest.skip("the model is not closed")
    rng = np.random.default_rng(8)
    guesses = rng.uniform(*mesh.bounds, (150, 3)).astype(np.float32)
    inside = np.array([g for g in guesses if abs(winding(geometry, g)) > 0.99])
    assert len(inside) > 5
    assert escapes(geometry, inside, 100_000) == 0
