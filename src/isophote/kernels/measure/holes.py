"""The triangulation of a closed polygon in space that has the least area.

Barequet and Sharir: "Filling gaps in the boundary of a polyhedron", CAGD 1995.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device, kernel

__all__ = ["least_area"]


@device
def _area(points, i, j, k):
    px, py, pz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
    qx, qy, qz = points[k, 0] - points[i, 0], points[k, 1] - points[i, 1], points[k, 2] - points[i, 2]
    x, y, z = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    return math.sqrt(x * x + y * y + z * z)


@kernel
def least_area(points, taken, cost, apex, stack, triangles):
    """Triangulate the polygon `points`, (n, 3), without the diagonals that are `taken`, (n, n): whether that can be.

    cost[i, k], the least area between the points i to k, is the least sum of cost[i, j], cost[j, k] and the triangle
    i, j, k; `apex` keeps the j. Both are (n, n) scratch, `stack` is (2 n,). `triangles`, (n - 2, 3), gets positions in
    the polygon, each triangle in the polygon's direction.
    """
    n = len(points)
    for i in range(n - 1):
        cost[i, i + 1] = 0.0
    for span in range(2, n):
        for i in range(n - span):
            k = i + span
            best, chosen = np.inf, -1
            if span == n - 1 or not taken[i, k]:
                for j in range(i + 1, k):
                    sides = cost[i, j] + cost[j, k]
                    if sides < best:
                        total = sides + _area(points, i, j, k)
                        if total < best:
                            best, chosen = total, j
            cost[i, k], apex[i, k] = best, chosen
    if apex[0, n - 1] < 0:
        return False
    stack[0], stack[1] = 0, n - 1
    depth, count = 1, 0
    while depth > 0:
        depth -= 1
        i, k = stack[2 * depth], stack[2 * depth + 1]
        if k - i < 2:
            continue
        j = apex[i, k]
        triangles[count, 0], triangles[count, 1], triangles[count, 2] = i, j, k
        count += 1
        stack[2 * depth], stack[2 * depth + 1] = i, j
        stack[2 * depth + 2], stack[2 * depth + 3] = j, k
        depth += 2
    return True
