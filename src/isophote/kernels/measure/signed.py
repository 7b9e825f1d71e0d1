"""Signed distances from triangle meshes: negative inside, told by the winding number, so that broken meshes work."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.measure.closest import closest_slot
from isophote.kernels.measure.mesh_distance import STACK_WORDS, open_mesh
from isophote.kernels.measure.winding import winding_of

__all__ = ["signed_distance_of", "signed_distances"]


@device
def signed_distance_of(mesh, x, y, z, stack):
    """The distance of a point, in the mesh's own units; negative where the mesh winds round it more than half a time,
    whichever way. `stack` is float32 scratch of STACK_WORDS.
    """
    scale = mesh.frame[0, 3]
    x, y, z = x * scale, y * scale, z * scale
    square, _ = closest_slot(mesh, x, y, z, np.inf, stack)
    winding, on = winding_of(mesh, x, y, z, stack)
    if on != 0:
        return 0.0
    distance = np.sqrt(square) / scale
    return -distance if abs(winding) > 0.5 else distance


@kernel
def signed_distances(words, points, begin, end, distances):
    """Fill `distances` (n,) with signed distances of the rows `begin` to `end` of `points`, (n, 3) float64."""
    mesh = open_mesh(words)
    stack = np.empty(STACK_WORDS, np.float32)
    for i in range(begin, end):
        distances[i] = signed_distance_of(mesh, points[i, 0], points[i, 1], points[i, 2], stack)
