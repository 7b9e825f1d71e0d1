"""The medial axis of a polygon."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.skeleton.result import MedialAxis
from isophote.analysis.skeleton.rings import Rings, in_order
from isophote.errors import GeometryError
from isophote.kernels.measure import medial_trace
from isophote.kernels.measure.medial_trace import BALLS, BRANCHES, FAULTS, LEFT, NODE, RIGHT, TRACE, TWIN

__all__ = ["medial_axis_of_polygon"]

IntArray: TypeAlias = npt.NDArray[np.int32]

# Points within this part of the polygon's size are one; where no trace ends well, other sizes are tried.
_TOLERANCES = (1e-10, 1e-11, 1e-9, 1e-12)
# Places along each branch at which islands are looked for.
_CHECKS = (5, 31)


def medial_axis_of_polygon(polygon: Any) -> MedialAxis:
    """The medial axis of corners (k, 2), or of rings of them, the outer one first."""
    rings = in_order(polygon)
    holes = len(rings.rings) - 1
    for tolerance in _TOLERANCES:
        for checks in _CHECKS if holes else (0,):
            found = _traced(rings, tolerance, checks)
            if found is not None and found.euler == 1 - holes:
                return found
    raise GeometryError(
        "the medial axis could not be traced: parts of the boundary are nearer to each other than rounding allows; "
        "move corners onto a coarser grid"
    )


def _traced(rings: Rings, tolerance: float, checks: int) -> MedialAxis | None:
    """The axis; None where a branch found no end."""
    count = sum(map(len, rings.rings))
    balls, branches = 12 * count + 64, 30 * count + 192
    table = TRACE.pack(
        balls=np.empty((balls, 3)),
        branch=np.empty((branches, 4), np.int32),
        course=np.empty((branches, 2)),
        first=np.zeros(balls + 1, np.int32),
        slots=np.full(1 << int(2 * balls).bit_length(), -1, np.int32),
        counts=np.zeros(3, np.int64),
    )
    medial_trace.trace(rings.table.words, table.words, tolerance * rings.size, 2 * rings.size, np.int64(checks))
    counts = table.arrays["counts"]
    if counts[FAULTS]:
        return None
    nodes = table.arrays["balls"][: counts[BALLS]]
    branch: IntArray = table.arrays["branch"][: counts[BRANCHES]]
    out = branch[branch[:, TWIN] > np.arange(len(branch))]
    ends = np.stack([out[:, NODE], branch[out[:, TWIN], NODE]], axis=1)
    return MedialAxis(
        rings.rings,
        read_only(nodes[:, :2].copy()),
        read_only(nodes[:, 2].copy()),
        read_only(ends),
        read_only(np.stack([out[:, RIGHT], out[:, LEFT]], axis=1)),
    )
