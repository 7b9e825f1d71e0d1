"""Light along links: what arrives at nodes, what that is over their children, and at the leaves in the end."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import kernel

__all__ = ["bucket_order", "gather_far", "leaf_irradiance", "push_down"]

_TERMS, _COLOURS = 6, 3


@kernel
def bucket_order(keys, starts, order):
    """Where each row goes so that keys, whole numbers below len(starts) − 1, ascend; those of key k fill the rows from
    starts[k], rows with the same key in their order."""
    for i in range(len(keys)):
        starts[keys[i] + 1] += 1
    for k in range(1, len(starts)):
        starts[k] += starts[k - 1]
    for i in range(len(keys)):
        order[starts[keys[i]]] = i
        starts[keys[i]] += 1
    for k in range(len(starts) - 1, 0, -1):
        starts[k] = starts[k - 1]
    starts[0] = 0


@kernel
def gather_far(starts, sources, factors, light, fields, first, last):
    """fields[p] = Σ factors[k] light[sources[k]] over the entries starts[p] ≤ k < starts[p + 1] of nodes
    first ≤ p < last; `factors` (entries, 6), `light` (nodes, 3), `fields` (nodes, 6, 3)."""
    for p in range(first, last):
        fields[p] = 0.0
        for k in range(starts[p], starts[p + 1]):
            q = sources[k]
            r, g, b = light[q, 0], light[q, 1], light[q, 2]
            for i in range(_TERMS):
                fields[p, i, 0] += factors[k, i] * r
                fields[p, i, 1] += factors[k, i] * g
                fields[p, i, 2] += factors[k, i] * b


@kernel
def push_down(order, parent, frames, fields):
    """Add to the polynomials `fields` (nodes, 6, 3) of each node those of its parent, in `order` from the roots down.

    A place (s, t) of a node is (a + b s + c t, d + e s + f t) of its parent's, with a … f its row of `frames` (n, 6);
    parents whose frame does not hold (−1 in `parent`) are passed over.
    """
    for i in range(len(order)):
        node = order[i]
        p = parent[node]
        if p < 0:
            continue
        a, b, c = frames[node, 0], frames[node, 1], frames[node, 2]
        d, e, f = frames[node, 3], frames[node, 4], frames[node, 5]
        for j in range(_COLOURS):
            c0, c1, c2 = fields[p, 0, j], fields[p, 1, j], fields[p, 2, j]
            c3, c4, c5 = fields[p, 3, j], fields[p, 4, j], fields[p, 5, j]
            fields[node, 0, j] += c0 + c1 * a + c2 * d + c3 * a * a + c4 * a * d + c5 * d * d
            fields[node, 1, j] += c1 * b + c2 * e + 2.0 * c3 * a * b + c4 * (a * e + b * d) + 2.0 * c5 * d * e
            fields[node, 2, j] += c1 * c + c2 * f + 2.0 * c3 * a * c + c4 * (a * f + c * d) + 2.0 * c5 * d * f
            fields[node, 3, j] += c3 * b * b + c4 * b * e + c5 * e * e
            fields[node, 4, j] += 2.0 * c3 * b * c + c4 * (b * f + c * e) + 2.0 * c5 * e * f
            fields[node, 5, j] += c3 * c * c + c4 * c * f + c5 * f * f


@kernel
def leaf_irradiance(leaves, sides, fields, starts, sources, factors, light, arriving, first, last):
    """arriving[i] = the mean of fields[leaf] over leaf = leaves[i], and Σ factors[k] light[sources[k]] over its near
    entries starts[leaf] ≤ k < starts[leaf + 1], for first ≤ i < last."""
    for i in range(first, last):
        leaf = leaves[i]
        # Means of s² or t², and of s t, over a parallelogram, and over a triangle about its centroid.
        square, mixed = (2.0 / 9.0, -1.0 / 9.0) if sides[leaf] == 3 else (1.0 / 3.0, 0.0)
        for j in range(_COLOURS):
            arriving[i, j] = fields[leaf, 0, j] + square * (fields[leaf, 3, j] + fields[leaf, 5, j])
            arriving[i, j] += mixed * fields[leaf, 4, j]
        for k in range(starts[leaf], starts[leaf + 1]):
            q, factor = sources[k], np.float64(factors[k])
            for j in range(_COLOURS):
                arriving[i, j] += factor * light[q, j]
