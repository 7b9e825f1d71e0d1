"""Wall thickness of solids whose walls are known."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote import analysis
from test_inside import CUBE
from trees import sphere


def tube(outer: float, inner: float, sides: int) -> iso.Mesh:
    """A closed tube of regular polygons along y, of height 4."""
    turn = 2 * np.pi * np.arange(sides) / sides
    rings = [(outer, -2), (outer, 2), (inner, 2), (inner, -2)]
    vertices = np.concatenate([np.column_stack([r * np.cos(turn), 0 * turn + y, r * np.sin(turn)]) for r, y in rings])
    k = np.arange(sides)
    faces = []
    for a in range(4):
        low, high = a * sides, (a + 1) % 4 * sides
        faces.append(np.column_stack([low + k, high + k, high + (k + 1) % sides, low + (k + 1) % sides]))
    return iso.Mesh(vertices, np.concatenate(faces))


@pytest.mark.parametrize("size", [(3, 1, 2), (1, 0.001, 1), (2.0**-400, 2.0**-401, 2.0**-402), (1e200, 1e201, 3e200)])
def test_a_slab_is_as_thick_as_it_is(size: tuple[float, ...]) -> None:
    slab = iso.Mesh(CUBE.vertices * size + np.array(size) * 7, CUBE.faces)
    np.testing.assert_allclose(analysis.thickness(slab), np.array(size)[[2, 2, 1, 1, 0, 0]], rtol=1e-12)


def test_a_tube_has_its_wall() -> None:
    """The wall of a polygonal tube, and its height through the ring's ends."""
    sides = 64
    part = tube(2, 1.5, sides)
    found = analysis.thickness(part)
    wall = 0.5 * np.cos(np.pi / sides)
    np.testing.assert_allclose(found[:sides], wall, rtol=1e-12)
    np.testing.assert_allclose(found[2 * sides : 3 * sides], wall, rtol=1e-12)
    np.testing.assert_allclose(found[sides : 2 * sides], 4, rtol=1e-12)
    inward = iso.Mesh(part.vertices, part.faces[:, ::-1])
    np.testing.assert_allclose(analysis.thickness(inward), found, rtol=1e-12)


def test_a_sphere_is_as_thick_as_its_diameter() -> None:
    positions, triangles = sphere(32)
    np.testing.assert_allclose(analysis.thickness(iso.Mesh(positions * 3.0, triangles)), 6, rtol=0.01)


def test_rays_end_on_the_surface_and_stay_inside() -> None:
    positions, triangles = sphere(16, 0.5)
    mesh = iso.Mesh(positions.astype(np.float64), triangles)
    walls = analysis.thickness(mesh)
    corners = mesh.vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    start = corners.mean(axis=1)
    assert analysis.distance(mesh, start - walls[:, None] * normals).max() < 1e-12
    for part in (0.01, 0.3, 0.7, 0.99):
        assert analysis.contains(mesh, start - part * walls[:, None] * normals).all()


def test_open_and_flat_faces() -> None:
    lid = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0)], [[0, 1, 2], [0, 1, 3]])
    found = analysis.thickness(lid)
    assert found[0] == np.inf
    assert np.isnan(found[1])
