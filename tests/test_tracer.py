"""Rays over arrays: against brute force in double precision, on random meshes and on models."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from isophote.errors import RenderError
from isophote.lower import geometry as lower_geometry
from isophote.rendering.pool import Pool
from scenes import box, icosphere, plane

MODELS = Path(__file__).parents[1] / "../shared/models"
NAMES = [
    "closed/bunny.obj",
    "closed/fox.ply",
    "broken/soup.stl",
    "broken/deg_faces.obj",
    "broken/fan3.obj",
    "genus/double-torus.obj",
]
NAMES += ["boundary/suzanne.obj", "broken/self_intersectA.obj"]


def triangles_of(mesh: iso.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """(t, 3, 3) corners, single precision as the tree has them, and the face of each triangle."""
    cut = iso.triangulate(mesh)
    return mesh.vertices.astype(np.float32).astype(np.float64)[cut.triangles], cut.face


def brute_force(corners: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, ...]:
    """For each ray: distance (inf: none), triangle, weights 1 and 2, whether it passes close to an edge or edge-on."""
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.linalg.norm(np.cross(e1, e2), axis=1)
    rows = []
    for o, d in zip(origins.astype(np.float32).astype(float), directions.astype(np.float32).astype(float), strict=True):
        p = np.cross(d, e2)
        scale = (e1 * p).sum(axis=1)
        with np.errstate(all="ignore"):
            q = np.cross(o - a, e1)
            u, v, t = ((o - a) * p).sum(axis=1) / scale, (q @ d) / scale, (q * e2).sum(axis=1) / scale
        margin = np.minimum(np.minimum(u, v), 1 - u - v)
        t = np.where((margin >= 0) & (t > 0) & (area > 0), t, np.inf)
        near = np.abs(margin) < 1e-3
        # Rounding of corners beside the size of their triangle, and directions within it.
        edge_on = np.abs(scale) < 1e-3 * area * np.linalg.norm(d)
        with np.errstate(invalid="ignore"):
            doubtful = bool(((near | edge_on | ~np.isfinite(margin)) & (area > 0) & (np.abs(margin) < 0.5)).any())
        k = int(np.argmin(t))
        rows.append((t[k], k, u[k], v[k], doubtful))
    return tuple(np.array(column) for column in zip(*rows, strict=True))


def rays_at(mesh: iso.Mesh, count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Rays from around the mesh toward places in its box, some from within, of many lengths."""
    rng = np.random.default_rng(seed)
    low, high = mesh.bounds
    size = np.maximum(high - low, 1e-3 * (high - low).max())
    origins = low + size * rng.uniform(-0.5, 1.5, (count, 3))
    targets = low + size * rng.uniform(0, 1, (count, 3))
    return origins, (targets - origins) * 10 ** rng.uniform(-3, 3, (count, 1))


def check(mesh: iso.Mesh, count: int) -> None:
    origins, directions = rays_at(mesh, count)
    tracer = iso.Tracer(mesh, threads=2)
    hits = tracer.closest(origins, directions)
    corners, faces = triangles_of(mesh)
    distance, triangle, u, v, doubtful = brute_force(corners, origins, directions)
    sure = ~doubtful
    assert sure.mean() > 0.4
    assert np.array_equal(hits.hit[sure], np.isfinite(distance)[sure])
    assert np.array_equal(tracer.occluded(origins, directions), hits.hit)
    both = sure & hits.hit
    assert both.any()
    reach = np.abs(mesh.vertices).max() / np.linalg.norm(directions, axis=1)
    assert (np.abs(hits.distance[both] - distance[both]) <= 2e-5 * (distance + reach)[both]).all()
    # Where other triangles are as near, which one it is does not matter.
    same = both & (hits.primitive == faces[triangle])
    assert same[both].mean() > 0.98
    single = same & (np.bincount(faces)[faces[triangle]] == 1)
    assert np.abs(hits.uv - np.stack([u, v], 1))[single].max(initial=0) < 5e-3
    e1, e2 = (corners[triangle, k] - corners[triangle, 0] for k in (1, 2))
    normal = np.cross(e1, e2)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    assert np.abs((hits.normal * normal).sum(axis=1) - 1)[single].max(initial=0) < 1e-3
    extent = np.abs(mesh.vertices).max()
    surface = corners[triangle, 0] + u[:, None] * e1 + v[:, None] * e2
    assert np.abs(hits.point - surface)[same].max() < 1e-4 * extent
    none = ~hits.hit
    assert np.isposinf(hits.distance[none]).all()
    assert (hits.item[none] == -1).all()
    assert (hits.primitive[none] == -1).all()


@pytest.mark.parametrize("seed", range(4))
def test_random_meshes(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(60, 3)) * 10 ** rng.uniform(-2, 2)
    sizes = rng.integers(3, 4 + (seed > 1), 40)
    check(iso.Mesh(points, [rng.choice(60, n, replace=False) for n in sizes]), 400)


@pytest.mark.parametrize("name", NAMES)
def test_models(name):
    path = MODELS / name
    if not path.exists():
        pytest.skip("the models are not here")
    check(iso.load_mesh(path), 60)


@pytest.mark.parametrize("length", [1e-6, 1e-2, 1.0, 1e12, 1e30])
def test_distances_are_in_lengths_of_the_direction_whatever_it_is(length):
    tracer = iso.Tracer(icosphere(3))
    rng = np.random.default_rng(2)
    origins = rng.normal(size=(500, 3)) * 2
    directions = rng.normal(size=(500, 3)) * (1, 0.01, 1)
    plain, scaled = tracer.closest(origins, directions), tracer.closest(origins, directions * length)
    assert plain.hit.any()
    assert np.array_equal(plain.primitive, scaled.primitive)
    assert np.allclose(plain.distance[plain.hit], scaled.distance[plain.hit] * length, rtol=1e-5)
    limit = plain.distance / length
    for factor, wanted in ((0.999, False), (1.001, True)):
        found = tracer.occluded(origins, directions * length, max_distance=np.minimum(limit * factor, 3e38))
        assert (found[plain.hit] == wanted).all()


def test_limits_cut_hits_off():
    tracer = iso.Tracer(box(2))
    origins, directions = np.array([[0.1, 0.2, 5]] * 4), (0, 0, -1)
    limits = [3, 4.0, 4.01, np.inf]
    assert tracer.occluded(origins, directions, limits).tolist() == [False, False, True, True]
    assert tracer.closest(origins, directions, limits).hit.tolist() == [False, False, True, True]
    assert not tracer.occluded(origins, directions, 0).any()
    assert not tracer.occluded(origins, directions, -1).any()
    # A limit beyond single precision is none.
    assert tracer.occluded(origins, directions, 1e300).all()


def test_one_row_stands_for_all_and_none_for_none():
    tracer = iso.Tracer(box(2))
    targets = np.random.default_rng(3).normal(size=(100, 3))
    assert tracer.closest((0, 0, 0), targets).hit.all()
    assert tracer.closest(targets * 10, (0, 0, 1)).distance.shape == (100,)
    single = tracer.closest((0, 0, 5), (0, 0, -2))
    assert single.distance.tolist() == [2]
    assert single.point.tolist() == [[0, 0, 1]]
    assert single.normal.tolist() == [[0, 0, 1]]
    none = tracer.closest(np.zeros((0, 3)), np.zeros((0, 3)))
    assert none.distance.shape == (0,)
    assert none.point.shape == (0, 3)
    assert tracer.occluded(np.zeros((0, 3)), (0, 0, 1)).shape == (0,)


@pytest.mark.parametrize(
    ("origins", "directions", "limit", "reason"),
    [
        (np.zeros((3, 2)), (0, 0, 1), np.inf, "shape"),
        (np.zeros((3, 3)), np.ones((2, 3)), np.inf, "length"),
        (np.zeros((3, 3)), np.ones((3, 3)), np.ones(2), "length"),
        ([(0, 0, np.nan)], (0, 0, 1), np.inf, "origins.*finite.*0"),
        ([(0, 0, 0), (0, 1e39, 0)], (0, 0, 1), np.inf, "origins.*finite.*1"),
        ((0, 0, 0), [(0, 0, 1), (0, np.inf, 1)], np.inf, "directions.*finite.*1"),
        ((0, 0, 0), [(0, 0, 1), (0, 0, 0)], np.inf, "zero.*1"),
        ((0, 0, 0), [(0, 0, 1), (0, 1e-20, 0)], np.inf, "shorter.*1"),
        ((0, 0, 0), (0, 0, 1), np.nan, "NaN"),
    ],
)
def test_wrong_rays_are_refused(origins, directions, limit, reason):
    tracer = iso.Tracer(box())
    for query in (tracer.closest, tracer.occluded):
        with pytest.raises(RenderError, match=reason):
            query(origins, directions, limit)


def test_items_faces_and_instances(monkeypatch):
    """A grid of boxes, some mirrored and stretched: the same whether they are instances or copies, and as computed."""
    mesh = box(0.8)
    items = [
        iso.Item(mesh).scale((-1 if (x + z) % 2 else 1, 1 + x / 5, 1)).rotate("y", x - z).translate((2 * x, 0, 2 * z))
        for x in range(5)
        for z in range(5)
    ]
    scene = iso.Scene([*items, iso.Item(plane(100)).translate((0, -2, 0))])
    rng = np.random.default_rng(4)
    origins, directions = rng.uniform(-1, 9, (20_000, 3)), rng.normal(size=(20_000, 3))
    found = []
    for baked in (10**9, 0):
        monkeypatch.setattr(lower_geometry, "_BAKED_TRIANGLES", baked)
        tracer = iso.Tracer(scene)
        found.append(tracer.closest(origins, directions))
        assert np.array_equal(tracer.occluded(origins, directions), found[-1].hit)
    copies, instances = found
    agree = (copies.item == instances.item) & (copies.primitive == instances.primitive)
    assert agree.mean() > 0.9995
    both = agree & copies.hit
    assert np.allclose(copies.distance[both], instances.distance[both], rtol=1e-4, atol=2e-5)
    assert np.abs(copies.normal - instances.normal)[both].max() < 1e-5
    for hits in found:
        for k, item in enumerate(items):
            on = hits.item == k
            assert on.any()
            local = item.transform.inverse().apply(hits.point[on])
            side = np.argmax(np.abs(local), axis=1)
            assert np.abs(np.abs(local).max(axis=1) - 0.4).max() < 1e-4
            # The outward normal of that side, through the inverse transposed.
            outward = np.sign(local[np.arange(len(local)), side])[:, None] * np.eye(3)[side]
            normal = outward @ item.transform.inverse().matrix[:3, :3]
            normal /= np.linalg.norm(normal, axis=1)[:, None]
            assert np.quantile((normal * hits.normal[on]).sum(axis=1), 0.02) > 0.999


def test_a_tracer_answers_after_it_refused() -> None:
    tracer = iso.Tracer(iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]))
    with pytest.raises(RenderError, match="zero"):
        tracer.closest([(0.2, 0.2, 1)], [(0, 0, 0)])
    assert tracer.closest([(0.2, 0.2, 1)], [(0, 0, -1)]).distance.tolist() == [1]
    assert tracer.occluded([(0.2, 0.2, 1)], [(0, 0, -1)]).tolist() == [True]


def test_an_interrupt_while_tracing_is_not_swallowed(monkeypatch: pytest.MonkeyPatch) -> None:
    tracer = iso.Tracer(iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]))
    monkeypatch.setattr(Pool, "run", lambda pool, *_: pool.stop())
    with pytest.raises(KeyboardInterrupt):
        tracer.closest([(0.2, 0.2, 1)], [(0, 0, -1)])
