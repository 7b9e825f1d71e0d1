"""Directed edges put one behind the other."""

from __future__ import annotations

from isophote.kernels.base.jit import kernel

__all__ = ["follow_edges"]


@kernel
def follow_edges(first, heads, following, starts, ends):
    """Write edges so that each begins where the one before ends, as long as there is one.

    `heads` are the ends of edges, `first` (v + 1,) where those of each vertex start, `following` a copy of it.
    """
    count = 0
    for vertex in range(len(first) - 1):
        v = vertex
        while following[v] < first[v + 1]:
            starts[count] = v
            following[v] += 1
            v = heads[following[v] - 1]
            ends[count] = v
            count += 1
