"""Whether triangles overlap boxes: separating axes, made ready once for all boxes of one size.

Akenine-Möller: "Fast 3D Triangle-Box Overlap Testing", JGT 6(1), 2001, in the form of Schwarz, Seidel: "Fast Parallel
Surface and Solid Voxelization on GPUs", SIGGRAPH Asia 2010, section 3.1: the triangle's plane, and its edges as seen
along each axis, moved outward by the box's half size. The third kind of axis, the box's own, is left to the caller, who
asks only for boxes that meet the triangle's.

All is in double precision, and boxes are widened by a slack far larger than its rounding, so the answer errs only
towards overlap.
"""

from __future__ import annotations

from isophote.kernels.base.jit import device

__all__ = ["OVERLAP_WORDS", "overlaps", "prepare_overlap"]

# A plane (normal, offset, half width), then nine half-planes a · u + b · v + c ≥ 0, three along each axis.
_EDGES = 5
OVERLAP_WORDS = _EDGES + 27


@device
def _prepare_edges(corners, axis, sign, half, work):
    """The half-planes of the three edges as seen along an axis; corners are nine numbers, `half` the half sizes."""
    u = (axis + 1) % 3
    v = (axis + 2) % 3
    for edge in range(3):
        start, end = 3 * edge, 3 * ((edge + 1) % 3)
        a = -(corners[end + v] - corners[start + v]) * sign
        b = (corners[end + u] - corners[start + u]) * sign
        at = _EDGES + 9 * axis + 3 * edge
        work[at], work[at + 1] = a, b
        work[at + 2] = abs(a) * half[u] + abs(b) * half[v] - a * corners[start + u] - b * corners[start + v]


@device
def prepare_overlap(corners, half, work):
    """Make a triangle of nine float64 ready for boxes of half sizes `half`; `work` takes OVERLAP_WORDS float64."""
    x1, y1, z1 = corners[3] - corners[0], corners[4] - corners[1], corners[5] - corners[2]
    x2, y2, z2 = corners[6] - corners[0], corners[7] - corners[1], corners[8] - corners[2]
    work[0], work[1], work[2] = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    work[3] = work[0] * corners[0] + work[1] * corners[1] + work[2] * corners[2]
    work[4] = abs(work[0]) * half[0] + abs(work[1]) * half[1] + abs(work[2]) * half[2]
    for axis in range(3):
        _prepare_edges(corners, axis, 1.0 if work[axis] >= 0 else -1.0, half, work)


@device
def _inside(work, axis, u, v):
    at = _EDGES + 9 * axis
    first = work[at] * u + work[at + 1] * v + work[at + 2]
    second = work[at + 3] * u + work[at + 4] * v + work[at + 5]
    third = work[at + 6] * u + work[at + 7] * v + work[at + 8]
    return min(first, min(second, third)) >= 0


@device
def overlaps(work, x, y, z):
    """Whether the triangle overlaps the box with this middle."""
    if abs(work[0] * x + work[1] * y + work[2] * z - work[3]) > work[4]:
        return False
    return _inside(work, 0, y, z) and _inside(work, 1, z, x) and _inside(work, 2, x, y)
