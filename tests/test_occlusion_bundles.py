"""Rays of one point that go through the tree together meet what they meet by themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso
from isophote.kernels.accel.bundle_rays import BUNDLE_SCRATCH
from isophote.kernels.trace import occlusion as kernels
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.wave import new_wave
from isophote.rendering.occlusion.points import lowered
from scenes import icosphere, plane

MODELS = Path(__file__).parents[1] / "../shared/models"
FILES = ["closed/bunny.obj", "broken/soup.stl", "boundary/moebius.obj", "broken/non_manifold_wrap.obj"]
# Points of a wave of 1,024 rays.
POINTS = 16

Floats = npt.NDArray[Any]


def rays_and_hits(
    mesh: iso.Mesh | iso.Item,
    points: Floats,
    normals: Floats,
    bias: float,
    reach: float = np.inf,
    directions: Floats | None = None,
    samples: int = 64,
) -> tuple[Floats, Floats, npt.NDArray[np.bool_]]:
    """Origins and directions of the rays above points, and whether each is blocked: all go in one wave."""
    count = len(points)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    openings = kernels.OPENINGS.pack(
        points=np.ascontiguousarray(points, np.float32),
        normals=np.ascontiguousarray(normals / lengths, np.float32),
        bias=np.full(count, bias, np.float32),
        samples=samples,
        seed=3,
        warp=kernels.UNIFORM if directions is None else kernels.GIVEN,
        reach=reach,
        directions=np.zeros((0, 4), np.float32) if directions is None else directions,
        open=np.zeros((count, 4)),
    )
    wave = new_wave(1040, BUNDLE_SCRATCH)
    kernels.find_openings(lowered(mesh, 1).words, openings.words, wave.words, 0, count)
    floats, rays = wave.arrays["floats"], count * samples
    blocked = wave.arrays["ints"][rows.BLOCKED, :rays] == 1
    starts = floats[rows.SHADOW_ORIGIN : rows.SHADOW_ORIGIN + 3, :rays].T
    return starts.copy(), floats[rows.SHADOW_DIRECTION : rows.SHADOW_DIRECTION + 3, :rays].T.copy(), blocked


def check(mesh: iso.Mesh | iso.Item, points: Floats, normals: Floats, bias: float, **settings: Any) -> int:
    """Compare with single rays; how many rays are blocked."""
    tracer, blocked_rays = iso.Tracer(mesh), 0
    for first in range(0, len(points), POINTS):
        some = slice(first, first + POINTS)
        origins, directions, blocked = rays_and_hits(mesh, points[some], normals[some], bias, **settings)
        alone = tracer.occluded(origins, directions, settings.get("reach", np.inf))
        np.testing.assert_array_equal(blocked, alone)
        blocked_rays += int(blocked.sum())
    return blocked_rays


def some_normals(count: int, seed: int) -> Floats:
    return np.random.default_rng(seed).normal(size=(count, 3))


@pytest.mark.parametrize("name", FILES)
def test_at_vertices_within_and_around_models(name: str) -> None:
    path = MODELS / name
    if not path.exists():
        pytest.skip(f"{name} is not there")
    mesh = iso.load_mesh(path)
    vertices = np.asarray(mesh.vertices)
    far = float(np.abs(vertices).max())
    pick = np.random.default_rng(1).integers(0, len(vertices), 10 * POINTS)
    random = some_normals(len(pick), 2)
    assert check(mesh, vertices[pick], random, 64 * 2.0**-24 * far) > 0
    check(mesh, vertices[pick], random, 0.0, reach=0.2 * far)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    around = low + (high - low) * np.random.default_rng(4).uniform(-0.2, 1.2, (len(pick), 3))
    assert check(mesh, around, random, 0.0) > 0


def test_within_and_on_a_ball() -> None:
    ball = icosphere(4)
    points = np.asarray(ball.vertices)[: 20 * POINTS]
    assert check(ball, points, points, 1e-5) == 0
    assert check(ball, points, -points, 1e-5) == 64 * len(points)


def test_points_in_the_planes_of_faces() -> None:
    # Boxes and triangles that touch the plane of the point, above and below by less than what is rounded away.
    steps = np.arange(-5, 6) * 0.5
    squares = [
        iso.Item(plane(0.5)).translate((x, (k % 3 - 1) * 2.0**-22, z)) for k, x in enumerate(steps) for z in steps
    ]
    corners = np.concatenate([np.asarray(s.shape.vertices) + s.transform.matrix[:3, 3] for s in squares])
    mesh = iso.Mesh(corners, np.arange(len(corners)).reshape(-1, 4))
    points = np.random.default_rng(5).uniform(-2, 2, (8 * POINTS, 3)) * (1, 0, 1)
    up = np.broadcast_to((0.0, 1.0, 0.0), points.shape)
    for bias in (0.0, 2.0**-24, 2.0**-22, 2.0**-20, 2.0**-18):
        check(mesh, points, up, bias)
        check(mesh, points, some_normals(len(points), 6), bias)


def test_degenerate_triangles() -> None:
    random = np.random.default_rng(7)
    corners = random.normal(size=(900, 3))
    corners[300:600:3] = corners[301:601:3]
    corners[602::3] = (corners[600::3] + corners[601::3]) / 2
    mesh = iso.Mesh(corners, np.arange(900).reshape(-1, 3))
    points = np.concatenate([corners[: 8 * POINTS], random.normal(size=(8 * POINTS, 3))])
    assert check(mesh, points, some_normals(len(points), 8), 1e-6) > 0


def test_directions_below_the_surface_and_along_axes() -> None:
    random = np.random.default_rng(9)
    mesh = icosphere(3)
    directions = random.normal(size=(60, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    directions = np.concatenate([directions, [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]])
    given = np.concatenate([directions, np.ones((64, 1))], axis=1).astype(np.float32)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    points = random.uniform(-1.5, 1.5, (10 * POINTS, 3))
    normals = np.concatenate([axes[random.integers(0, 6, 5 * POINTS)], some_normals(5 * POINTS, 10)])
    assert check(mesh, points, normals, 0.0, directions=given) > 0


@pytest.mark.parametrize("samples", [8, 17, 64, 100])
def test_any_number_of_rays_and_far_from_the_middle(samples: int) -> None:
    item = iso.Item(icosphere(3)).translate((3000, -40, 7e4))
    random = np.random.default_rng(11)
    points = random.uniform((2999, -41, 7e4 - 1), (3001, -39, 7e4 + 1), (5, 3))
    origins, directions, blocked = rays_and_hits(item, points, some_normals(5, 12), 0.0, samples=samples)
    np.testing.assert_array_equal(blocked, iso.Tracer(item).occluded(origins, directions))
    assert blocked.any()
    assert not blocked.all()
