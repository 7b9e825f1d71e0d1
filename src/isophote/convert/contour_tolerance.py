"""Meshes within a distance of the surface: cells are halved until a look at half the cell finds nothing farther off."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from isophote.accel.mesh_distance import build_mesh_distance
from isophote.convert.contour_grid import grid_over
from isophote.convert.contour_join import Triangles
from isophote.convert.contour_run import Options, contoured
from isophote.kernels.measure.closest import closest_points
from isophote.progress import Reporter
from isophote.shapes.field.field import Field
from isophote.shapes.field.form import Box

__all__ = ["within_tolerance"]

Points = npt.NDArray[np.float64]

# Cells along the longest side that are tried first, at least and at most.
_LEAST, _MOST = 16, 256
# Part of the tolerance that merging may use, and that what is measured may reach: samples see not all of a surface.
_MERGING, _MEASURED = 0.3, 0.9
_STEPS = 3


def within_tolerance(shape: Field, region: Box, tolerance: float, options: Options, report: Reporter) -> Triangles:
    """The mesh of the first cell tried that is within the tolerance of the surface, both ways."""
    longest = float((region[1] - region[0]).max())
    # A cell of a surface whose radius is a quarter of the longest side is off by cell² / radius / 3.
    cells = longest / math.sqrt(0.75 * longest * tolerance)
    cell = longest / min(max(cells, _LEAST), _MOST)
    mesh = contoured(shape, grid_over(region, cell), _MERGING * tolerance, options, report)
    while True:
        finer = contoured(shape, grid_over(region, cell / 2), _MERGING * tolerance, options, report)
        if _is_within(shape, mesh, finer, _MEASURED * tolerance):
            return mesh
        mesh, cell = finer, cell / 2


def _is_within(shape: Field, mesh: Triangles, finer: Triangles, distance: float) -> bool:
    if len(mesh.triangles) == 0 or len(finer.triangles) == 0:
        return len(mesh.triangles) == len(finer.triangles)
    off_surface = _from_surface(shape, _samples(mesh))
    return bool((off_surface <= distance).all() and (_from_mesh(mesh, _on_surface(shape, finer)) <= distance).all())


def _samples(mesh: Triangles) -> Points:
    """Vertices, middles of triangles and of edges."""
    corners = mesh.vertices[mesh.triangles]
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    return np.concatenate([mesh.vertices, corners.mean(axis=1), middles.reshape(-1, 3)])


def _to_surface(shape: Field, points: Points) -> Points:
    """Points moved to the surface, along the gradient."""
    moved = points
    for _ in range(_STEPS):
        gradient = shape.gradient(moved).astype(np.float64)
        square = np.einsum("ij,ij->i", gradient, gradient)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.where(square > 0, shape(moved) / square, 0.0)
        moved = moved - step[:, None] * gradient
    return moved


def _from_surface(shape: Field, points: Points) -> Points:
    """About how far points are from the surface."""
    far: Points = np.linalg.norm(_to_surface(shape, points) - points, axis=1)
    return far


def _on_surface(shape: Field, mesh: Triangles) -> Points:
    """Points of the surface near the vertices and the middles of the triangles of a mesh."""
    return _to_surface(shape, np.concatenate([mesh.vertices, mesh.vertices[mesh.triangles].mean(axis=1)]))


def _from_mesh(mesh: Triangles, points: Points) -> Points:
    """Distances of points from the nearest triangle."""
    ready = build_mesh_distance(mesh.vertices, mesh.triangles)
    far, none, no_numbers = np.empty(len(points)), np.empty((0, 3)), np.empty(0, np.int32)
    closest_points(ready.table.words, np.ascontiguousarray(points), 0, len(points), none, far, no_numbers, none)
    return far
