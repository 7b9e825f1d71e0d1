"""How thick a solid is behind points of its surface, by rays."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bvh import closest_triangle
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.vec import vec3
from isophote.kernels.measure.mesh_distance import STACK_WORDS, open_mesh, to_single

__all__ = ["thicknesses"]

_ROOT = np.int32(0)
_FAR = np.float32(np.inf)
# Where a ray starts behind the surface, in the mesh's frame: beyond what single precision may move the surface by.
_START = 2.0**-19


@device
def _behind(mesh, x, y, z, mx, my, mz, stack):
    """How far along the unit vector m the next surface lies; infinite for none."""
    origin = vec3(
        to_single(x + _START * mx, mesh.frame[0, 0]),
        to_single(y + _START * my, mesh.frame[0, 1]),
        to_single(z + _START * mz, mesh.frame[0, 2]),
    )
    direction = vec3(np.float32(mx), np.float32(my), np.float32(mz))
    t, _, _, slot = closest_triangle(mesh.nodes, mesh.blocks, _ROOT, origin, direction, _FAR, stack)
    if slot < 0:
        return np.inf
    # The same in double precision, by the plane of the triangle.
    c = mesh.corners
    ux, uy, uz = c[slot, 3] - c[slot, 0], c[slot, 4] - c[slot, 1], c[slot, 5] - c[slot, 2]
    vx, vy, vz = c[slot, 6] - c[slot, 0], c[slot, 7] - c[slot, 1], c[slot, 8] - c[slot, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    exact = nx * (c[slot, 0] - x) + ny * (c[slot, 1] - y) + nz * (c[slot, 2] - z)
    slope = nx * mx + ny * my + nz * mz
    single = np.float64(t) + _START
    if abs(slope) > 1e-3 * np.sqrt(nx * nx + ny * ny + nz * nz):
        return max(0.0, exact / slope)
    return single


@kernel
def thicknesses(words, points, normals, begin, end, found):
    """Fill `found` (n,) with the lengths of the rays from `points` against their outward unit `normals` (n, 3) to the
    next surface, infinite for none: a range of rows.
    """
    mesh = open_mesh(words)
    stack = np.empty(STACK_WORDS, np.float32)
    scale = mesh.frame[0, 3]
    for i in range(begin, end):
        x, y, z = points[i, 0] * scale, points[i, 1] * scale, points[i, 2] * scale
        mx, my, mz = -normals[i, 0], -normals[i, 1], -normals[i, 2]
        found[i] = _behind(mesh, x, y, z, mx, my, mz, stack) / scale
