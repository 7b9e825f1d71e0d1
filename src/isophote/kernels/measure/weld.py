"""Which points stand for others that are near."""

from __future__ import annotations

from isophote.kernels.base.jit import kernel

__all__ = ["lead"]


@kernel
def lead(pairs, leader):
    """Let points follow the first one that is near them and follows none itself.

    `pairs`, (k, 2), are near points with the smaller number first, in increasing order; `leader`, (points,), holds each
    point's own number before. Whoever follows is near its leader, however long a chain of near points is.
    """
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        if leader[i] == i and leader[j] == j:
            leader[j] = i
