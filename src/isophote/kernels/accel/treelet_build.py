"""Binary trees cut into treelets of three levels (treelet.py) such that rays visit as few of them as can be.

A ray visits a treelet about as often as its root's cell is large. The cut is found from the leaves up: with f(n) the
cost of what is below n where a treelet begins there, and g(n, k) where one that began above has k levels left,

    f(n) = A(n) + g(lower, 2) + g(upper, 2)
    g(n, k) = min(f(n), g(lower, k − 1) + g(upper, k − 1)),    g(n, 0) = f(n)

and both are 0 for leaves.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel

__all__ = ["cut_into_treelets"]

_MISSING = -1


@device
def _costs(child, areas, begun, left):
    """f of all nodes to `begun`, g with one and two levels left to `left` (n, 2); children come after their parents."""
    for node in range(len(child) - 1, -1, -1):
        lower = child[node]
        if lower == _MISSING:
            begun[node] = left[node, 0] = left[node, 1] = 0.0
            continue
        begun[node] = areas[node] + left[lower, 1] + left[lower + 1, 1]
        left[node, 0] = min(begun[node], begun[lower] + begun[lower + 1])
        left[node, 1] = min(begun[node], left[lower, 0] + left[lower + 1, 0])


@device
def _goes_on(child, begun, left, node, levels):
    """Whether a node's plane is in a treelet that has so many levels left for it."""
    lower = child[node]
    if lower == _MISSING:
        return False
    if levels == 1:
        return begun[lower] + begun[lower + 1] < begun[node]
    return left[lower, 0] + left[lower + 1, 0] < begun[node]


@kernel
def cut_into_treelets(child, areas, leaf_codes, planes, codes):
    """Write the treelets of a tree, the root's first; returns how many there are.

    `child` (n,): the lower child of nodes, all after them, the upper one being next, or −1 for leaves; `areas` (n,) of
    cells; `leaf_codes` (n,). Siblings lie side by side, and soon behind them what is below the last. Of each treelet:
    `planes` (·, 7), the nodes with its planes or −1, and `codes` (·, 8) of its children, 0 where there is none; both
    have a row for each node that is no leaf, and one at least.
    """
    begun, left = np.empty(len(child), np.float64), np.empty((len(child), 2), np.float64)
    _costs(child, areas, begun, left)
    roots, pending, nodes = np.empty(len(planes), np.int32), np.empty(len(planes), np.int32), np.empty(8, np.int32)
    roots[0] = pending[0] = 0
    made, waiting = 1, 1
    while waiting > 0:
        waiting -= 1
        own = pending[waiting]
        planes[own, :] = _MISSING
        nodes[:] = _MISSING
        nodes[0] = roots[own]
        # Halves, then fourths, then eighths: the span of a node ends beside its plane's place.
        for level in range(3):
            span = 8 >> level
            for first in range(0, 8, span):
                node = nodes[first]
                begins = level == 0 and child[node] != _MISSING
                if begins or (node != _MISSING and _goes_on(child, begun, left, node, 3 - level)):
                    planes[own, first + span // 2 - 1] = node
                    nodes[first], nodes[first + span // 2] = child[node], child[node] + 1
        for lane in range(8):
            node = nodes[lane]
            if node == _MISSING:
                codes[own, lane] = 0
            elif child[node] == _MISSING:
                codes[own, lane] = leaf_codes[node]
            else:
                roots[made] = node
                pending[waiting] = codes[own, lane] = made
                made += 1
                waiting += 1
    return made
