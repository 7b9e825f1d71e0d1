"""Distances over surfaces: closed forms on boxes, cones and planes, and what must not change them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import Delaunay

import isophote as iso
from isophote import analysis
from isophote.errors import GeometryError
from trees import sphere

MODELS = Path(__file__).parents[1] / "../shared/models"

CUBE = iso.Mesh(
    [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)],
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]],
)


def flat(points: np.ndarray, keep: object = None) -> iso.Mesh:
    """A Delaunay mesh of points in the plane z = 0, of the triangles whose middles `keep` wants."""
    triangles = Delaunay(points).simplices
    if keep is not None:
        triangles = triangles[keep(points[triangles].mean(axis=1))]
    return iso.Mesh(np.column_stack([points, np.zeros(len(points))]), triangles)


def split(mesh: iso.Mesh, seed: int) -> iso.Mesh:
    """The same surface with a new vertex in each triangle and on each edge, not in their middles."""
    rng = np.random.default_rng(seed)
    vertices, faces = [*mesh.vertices], []
    on_edge: dict[tuple[int, int], int] = {}

    def middle(i: int, j: int) -> int:
        key = min(i, j), max(i, j)
        if key not in on_edge:
            t = rng.uniform(0.2, 0.8)
            on_edge[key] = len(vertices)
            vertices.append(mesh.vertices[key[0]] * (1 - t) + mesh.vertices[key[1]] * t)
        return on_edge[key]

    for a, b, c in iso.triangulate(mesh).triangles.tolist():
        ring = [a, middle(a, b), b, middle(b, c), c, middle(c, a)]
        weights = rng.dirichlet([3, 3, 3])
        vertices.append(weights @ mesh.vertices[[a, b, c]])
        faces += [[ring[k], ring[(k + 1) % 6], len(vertices) - 1] for k in range(6)]
    return iso.Mesh(np.array(vertices), faces)


def cone(angle: float, rings: int = 6, sectors: int = 24) -> tuple[iso.Mesh, np.ndarray]:
    """A cone with `angle` round its tip, a polyhedron of congruent faces, and its vertices' (radius, turn)."""
    radii, turns = np.meshgrid(np.arange(1, rings + 1.0), np.arange(sectors) * angle / sectors, indexing="ij")
    side = 2 * np.sin(angle / sectors / 2)
    # Vertices of a ring stand in turns higher and lower where the angle is too large for a plane polygon.
    around = 2 * np.pi * np.arange(sectors) / sectors
    if angle < 2 * np.pi:
        radius = side / (2 * np.sin(np.pi / sectors))
        unit = np.column_stack(
            [radius * np.cos(around), radius * np.sin(around), np.full(sectors, np.sqrt(1 - radius**2))]
        )
    else:
        low, high = 0.0, np.pi / 2
        for _ in range(200):
            tilt = (low + high) / 2
            wave = np.where(np.arange(sectors) % 2 == 0, tilt, -tilt)
            unit = np.column_stack([np.cos(wave) * np.cos(around), np.cos(wave) * np.sin(around), np.sin(wave)])
            low, high = (tilt, high) if np.linalg.norm(unit[1] - unit[0]) < side else (low, tilt)
    vertices = np.concatenate([[np.zeros(3)], *(r * unit for r in range(1, rings + 1))])
    k = np.arange(sectors)
    faces = [np.column_stack([np.zeros(sectors, int), 1 + k, 1 + (k + 1) % sectors])]
    for r in range(rings - 1):
        a, b = 1 + r * sectors + k, 1 + r * sectors + (k + 1) % sectors
        faces += [np.column_stack([a, a + sectors, b + sectors]), np.column_stack([a, b + sectors, b])]
    polar = np.column_stack([radii.reshape(-1), turns.reshape(-1)])
    return iso.Mesh(vertices, np.concatenate(faces)), np.concatenate([[[0, 0]], polar])


def test_over_a_cube() -> None:
    """One face away the diagonal of a square, at the far corner that of two squares unfolded."""
    np.testing.assert_allclose(analysis.geodesic_distance(CUBE, 0) ** 2, [0, 1, 1, 2, 1, 2, 2, 5], atol=1e-14)


@pytest.mark.parametrize("seed", [0, 1])
def test_in_a_plane_it_is_the_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = np.concatenate([rng.random((300, 2)), [(0, 0), (1, 0), (0, 1), (1, 1)]])
    found = analysis.geodesic_distance(flat(points), seed)
    np.testing.assert_allclose(found, np.linalg.norm(points - points[seed], axis=1), atol=1e-13)
    grid = np.stack(np.meshgrid(np.arange(12.0), np.arange(9.0)), axis=2).reshape(-1, 2)
    found = analysis.geodesic_distance(flat(grid), 40)
    np.testing.assert_allclose(found, np.linalg.norm(grid - grid[40], axis=1), atol=1e-13)


def test_round_a_corner_paths_turn_at_it() -> None:
    grid = np.stack(np.meshgrid(np.arange(13.0), np.arange(13.0)), axis=2).reshape(-1, 2)
    grid += 0.3 * np.random.default_rng(3).uniform(-1, 1, grid.shape) * (grid % 6 != 0).all(axis=1, keepdims=True)
    mesh = flat(grid, lambda p: ~((p > 6).all(axis=1)))
    source = int(np.flatnonzero((grid == (6, 12)).all(axis=1))[0])
    found = analysis.geodesic_distance(mesh, source)
    beyond = (grid[:, 1] <= 6) & (grid[:, 0] >= 6)
    corner = np.array([6.0, 6.0])
    np.testing.assert_allclose(found[beyond], 6 + np.linalg.norm(grid[beyond] - corner, axis=1), atol=1e-12)
    seen = grid[:, 0] <= 6
    np.testing.assert_allclose(found[seen], np.linalg.norm(grid[seen] - (6, 12), axis=1), atol=1e-12)


@pytest.mark.parametrize("angle", [1.5, 4.0, 5.5, 7.5, 9.0])
def test_on_cones_of_less_and_more_than_a_full_turn(angle: float) -> None:
    """Unrolled, straight lines, unless half a turn or more lies between: then through the tip."""
    mesh, polar = cone(angle)
    source = 1 + 2 * 24 + 5
    found = analysis.geodesic_distance(mesh, source)
    turn = np.abs(polar[:, 1] - polar[source, 1])
    turn = np.minimum(turn, angle - turn)
    r, s = polar[:, 0], polar[source, 0]
    expected = np.where(turn < np.pi, np.sqrt(np.maximum(r * r + s * s - 2 * r * s * np.cos(turn), 0)), r + s)
    # The rim of the polyhedron cuts off a little of the cone, and paths along it go round by the rim.
    inner = r <= 4
    np.testing.assert_allclose(found[inner], expected[inner], atol=1e-12)


@pytest.mark.parametrize("name", ["closed/fox.ply", "genus/bob_small.ply", "boundary/cat_head.obj"])
def test_splitting_faces_changes_nothing(name: str) -> None:
    """More vertices on the same surface; also: never longer than along edges, never shorter than straight."""
    path = MODELS / name
    if not path.exists():
        pytest.skip(f"{name} is not there")
    mesh = iso.load_mesh(path)
    found = analysis.geodesic_distance(mesh, 7)
    finer = analysis.geodesic_distance(split(mesh, 1), 7)[: len(found)]
    np.testing.assert_allclose(finer, found, rtol=1e-11, atol=1e-11 * found.max())
    i, j = (np.asarray(mesh.faces)[:, list(k)].reshape(-1) for k in ((0, 1, 2), (1, 2, 0)))
    length = np.linalg.norm(mesh.vertices[i] - mesh.vertices[j], axis=1)
    along = dijkstra(csr_array((length, (i, j)), shape=[len(found)] * 2), directed=False, indices=7)
    assert (found <= along * (1 + 1e-12)).all()
    assert (found >= np.linalg.norm(mesh.vertices - mesh.vertices[7], axis=1) * (1 - 1e-12)).all()


def test_distances_are_symmetric_and_nearest_sources_win() -> None:
    mesh = iso.Mesh(*sphere(9, 0.4))
    table = np.array([analysis.geodesic_distance(mesh, k) for k in range(40)])
    np.testing.assert_allclose(table[:, :40], table[:, :40].T, rtol=1e-12, atol=1e-14)
    together = analysis.geodesic_distance(mesh, range(0, 40, 9))
    np.testing.assert_allclose(together, table[::9].min(axis=0), rtol=1e-12)


def test_on_a_sphere_the_error_falls_with_the_square_of_the_edges() -> None:
    errors = []
    for rings in (12, 24, 48):
        positions, triangles = sphere(rings)
        p = positions / np.linalg.norm(positions, axis=1, keepdims=True)
        found = analysis.geodesic_distance(iso.Mesh(p, triangles), 0)
        errors.append(np.abs(found - np.arccos(np.clip(p @ p[0], -1, 1))).max())
    assert errors[0] / errors[1] > 3.3
    assert errors[1] / errors[2] > 3.3


def test_heat_comes_close() -> None:
    grid = np.stack(np.meshgrid(np.arange(40.0), np.arange(30.0)), axis=2).reshape(-1, 2)
    plane = flat(grid)
    noise = 0.2 * np.random.default_rng(1).uniform(-1, 1, (len(grid), 3)) * (1, 1, 0)
    for mesh, source in ((iso.Mesh(*sphere(30, 0.2)), 3), (plane.with_(vertices=plane.vertices + noise), 9)):
        exact, heat = (analysis.geodesic_distance(mesh, source, method) for method in ("exact", "heat"))
        assert np.abs(heat - exact).mean() < 0.03 * exact.max()
        assert heat[source] == 0
    scaled = mesh.with_(vertices=mesh.vertices * 2.0**300)
    again = analysis.geodesic_distance(scaled, source, "heat")
    np.testing.assert_allclose(again, heat * 2.0**300, rtol=1e-6)
    np.testing.assert_allclose(analysis.geodesic_distance(scaled, source), exact * 2.0**300, rtol=1e-9)


@pytest.mark.parametrize("method", ["exact", "heat"])
def test_parts_that_no_path_reaches_are_infinitely_far(method: str) -> None:
    two = iso.Mesh(
        [*CUBE.vertices, *(CUBE.vertices + 3), (9, 9, 9)], [*CUBE.faces.tolist(), *(CUBE.faces + 8).tolist()]
    )
    found = analysis.geodesic_distance(two, [0], method)
    assert np.isfinite(found[:8]).all()
    assert np.isinf(found[8:]).all()


def test_bad_input_is_refused() -> None:
    fan = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)], [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    against = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0)], [[0, 1, 2], [0, 1, 3]])
    point = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0)], [[0, 1, 2], [0, 2, 3]])
    for mesh, message in ((fan, "three or more"), (against, "orient"), (point, "without length")):
        with pytest.raises(GeometryError, match=message):
            analysis.geodesic_distance(mesh, 0)
    for sources in (8, -1, [], 0.5, [[0]]):
        with pytest.raises(GeometryError, match="sources"):
            analysis.geodesic_distance(CUBE, sources)
    with pytest.raises(GeometryError, match="method"):
        analysis.geodesic_distance(CUBE, 0, "fast")
    with pytest.raises(GeometryError, match="time"):
        analysis.geodesic_distance(CUBE, 0, "heat", time=0)
