"""Which closed parts of a mesh lie inside others."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.stars import Ints, Longs
from isophote.analysis.inside import winding_number
from isophote.shapes.mesh import Mesh

__all__ = ["lie_inside"]


def lie_inside(vertices: npt.NDArray[np.float64], triangles: Ints, part: Ints, solids: Longs) -> npt.NDArray[np.bool_]:
    """(k,) whether each of the parts `solids` lies inside an odd number of the others.

    `part`, (t,), is the part of each of the `triangles`, (t, 3), which must agree on their sides. A part is inside
    another where its first vertex is; parts that cross have no better answer.
    """
    order = np.argsort(part, kind="stable")
    begins, ends = (np.searchsorted(part[order], solids, side) for side in ("left", "right"))
    shells = [triangles[order[begin:end]] for begin, end in zip(begins.tolist(), ends.tolist(), strict=True)]
    low = np.array([vertices[shell].min(axis=(0, 1)) for shell in shells])
    high = np.array([vertices[shell].max(axis=(0, 1)) for shell in shells])
    points = np.array([vertices[shell[0, 0]] for shell in shells])
    depth = np.zeros(len(solids), np.int64)
    for i, shell in enumerate(shells):
        within = ((low >= low[i]) & (high <= high[i])).all(axis=1)
        within[i] = False
        inner = np.flatnonzero(within)
        if len(inner):
            used, corners = np.unique(shell, return_inverse=True)
            around = winding_number(Mesh(vertices[used], corners.reshape(-1, 3)), points[inner])
            depth[inner] += np.abs(around) > 0.5
    odd: npt.NDArray[np.bool_] = depth % 2 == 1
    return odd
