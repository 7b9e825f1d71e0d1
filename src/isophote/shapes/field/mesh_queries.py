"""The door from fields of meshes to the kernels that measure them, which are loaded when one is first asked."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["distances", "nearest", "prepared", "winding_numbers"]

Floats = npt.NDArray[np.float64]


def prepared(vertices: Floats, triangles: npt.NDArray[np.int32]) -> Any:
    """A triangle mesh, made ready for the questions below."""
    from isophote.accel.mesh_distance import build_mesh_distance

    return build_mesh_distance(vertices, triangles)


def distances(mesh: Any, points: Floats) -> Floats:
    """(n,) distances of points (n, 3) to the mesh."""
    from isophote.kernels.measure.closest import closest_points

    out, nothing = np.empty(len(points)), np.empty((0, 3))
    numbers = np.empty(0, np.int32)
    closest_points(mesh.table.words, np.ascontiguousarray(points), 0, len(points), nothing, out, numbers, nothing)
    return out


def nearest(mesh: Any, points: Floats) -> tuple[Floats, npt.NDArray[np.int32]]:
    """(n, 3) nearest points of the mesh, and (n,) numbers of the triangles that they lie on."""
    from isophote.kernels.measure.closest import closest_points

    places, numbers = np.empty((len(points), 3)), np.empty(len(points), np.int32)
    weights, out = np.empty((len(points), 3)), np.empty(len(points))
    closest_points(mesh.table.words, np.ascontiguousarray(points), 0, len(points), places, out, numbers, weights)
    return places, numbers


def winding_numbers(mesh: Any, points: Floats) -> Floats:
    """(n,) generalised winding numbers about points (n, 3)."""
    from isophote.kernels.measure.winding import winding_numbers as fill

    out, on = np.empty(len(points)), np.empty(len(points), np.int32)
    fill(mesh.table.words, np.ascontiguousarray(points), 0, len(points), out, on)
    return out
