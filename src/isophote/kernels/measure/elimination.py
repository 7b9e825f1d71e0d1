"""Blue noise by elimination: of many points, those that crowd the others most are taken away one by one.

Source: Yuksel, "Sample Elimination for Generating Poisson Disk Sample Sets", 2015.
"""

from __future__ import annotations

from isophote.kernels.base.jit import device, kernel

__all__ = ["eliminate"]


@device
def _less(weights, a, b):
    """Whether point `a` stands below point `b` in the heap; equal weights by number, so that order never matters."""
    return weights[a] < weights[b] or (weights[a] == weights[b] and a < b)


@device
def _sink(heap, places, weights, size, at):
    """Move the point at a place of the heap down to where it belongs."""
    moved = heap[at]
    while 2 * at + 1 < size:
        child = 2 * at + 1
        if child + 1 < size and _less(weights, heap[child], heap[child + 1]):
            child += 1
        if not _less(weights, moved, heap[child]):
            break
        heap[at] = heap[child]
        places[heap[at]] = at
        at = child
    heap[at] = moved
    places[moved] = at


@kernel
def eliminate(starts, neighbours, crowding, wanted, heap, places, weights):
    """Take away points until `wanted` are left: those in the first places of `heap`.

    `neighbours[starts[i]]` up to `neighbours[starts[i + 1]]` are the points near i, `crowding` (k,) how much each
    of them crowds it. `heap`, `places` (n,) int64 and `weights` (n,) float64 are scratch.
    """
    count = starts.size - 1
    for i in range(count):
        weights[i] = 0.0
        for k in range(starts[i], starts[i + 1]):
            weights[i] += crowding[k]
        heap[i] = places[i] = i
    for at in range(count // 2 - 1, -1, -1):
        _sink(heap, places, weights, count, at)
    size = count
    while size > wanted:
        gone = heap[0]
        size -= 1
        heap[0] = heap[size]
        places[heap[0]] = 0
        places[gone] = -1
        _sink(heap, places, weights, size, 0)
        for k in range(starts[gone], starts[gone + 1]):
            near = neighbours[k]
            if places[near] >= 0:
                weights[near] -= crowding[k]
                _sink(heap, places, weights, size, places[near])
