"""How form factors change over patches: polynomials of second degree over nodes, and light at places from them.

Over node p with the centre c and the half edges U and V the form factor to q from the place c + s U + t V is

    F(s, t) = c₀ + c₁ s + c₂ t + c₃ s² + c₄ s t + c₅ t²

fitted to places of Gauss's rule, so that means are as exact as the rule's: over parallelograms 3 × 3 places, far away
2 × 2; over triangles six (Strang, Fix: "An Analysis of the Finite Element Method", 1973), far away three.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.double3 import Double3, difference, dot3, norm, row3, scaled, total
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.trace.exchange import open_patches
from isophote.kernels.trace.patch_factors import brightness_seen, mean_source_factor, source_factor

__all__ = ["far_factors", "near_factors", "place_irradiance"]

_TERMS, _MOST = 6, 9
_ZERO = np.float64(0)
# Distance of centres, in the receiver's radii, from which on the smaller rules are enough.
_DISTANT = 10.0


def _fitted(s, t, weights, terms):
    """(6, 9) matrix from values at places to coefficients, by weighted least squares in some of the terms."""
    basis = np.stack([np.ones_like(s), s, t, s * s, s * t, t * t], axis=1)[:, terms]
    normal = basis.T * weights
    matrix = np.zeros((_TERMS, _MOST))
    matrix[terms, : len(s)] = np.linalg.solve(normal @ basis, normal)
    return matrix


def _square_rule(nodes, weights, terms):
    s, t = (grid.reshape(-1) for grid in np.meshgrid(nodes, nodes, indexing="ij"))
    return s, t, _fitted(s, t, np.outer(weights, weights).reshape(-1), terms)


def _triangle_rule(orbits, terms):
    """Places with barycentric coordinates (1 − 2a, a, a) in all orders, for pairs (a, weight)."""
    places = [np.roll((1 - 2 * a, a, a), k) for a, _ in orbits for k in range(3)]
    u, v = np.array(places)[:, 1:].T
    s, t = 2 * (u - 1 / 3), 2 * (v - 1 / 3)
    return s, t, _fitted(s, t, np.repeat([weight for _, weight in orbits], 3), terms)


def _tables():
    """Places (4, 9, 2), matrices (4, 6, 9), numbers of places (4,): of parallelograms and triangles, near and far."""
    two, three = np.polynomial.legendre.leggauss(2), np.polynomial.legendre.leggauss(3)
    rules = [
        _square_rule(*three, [0, 1, 2, 3, 4, 5]),
        _square_rule(*two, [0, 1, 2, 4]),
        _triangle_rule(
            [(0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322)], [0, 1, 2, 3, 4, 5]
        ),
        _triangle_rule([(1 / 6, 1 / 3)], [0, 1, 2]),
    ]
    places, matrices = np.zeros((4, _MOST, 2)), np.zeros((4, _TERMS, _MOST))
    for k, (s, t, matrix) in enumerate(rules):
        places[k, : len(s)] = np.stack([s, t], axis=1)
        matrices[k] = matrix
    return places, matrices, np.array([len(s) for s, _, _ in rules])


_PLACES, _MATRICES, _COUNTS = _tables()


@device
def _axes(patches, p):
    """The half edges of node p."""
    axes = patches.axes
    return Double3(axes[p, 0], axes[p, 1], axes[p, 2]), Double3(axes[p, 3], axes[p, 4], axes[p, 5])


@kernel
def far_factors(patch_words, starts, sources, visible, bright, factors, first, last):
    """Coefficients of the form factors, times `visible`, of the entries starts[p] ≤ k < starts[p + 1] of nodes
    first ≤ p < last, into the rows of `factors` (n, 6); each times how bright the source is from there by `bright`
    (nodes,), if that is not empty."""
    patches = open_patches(patch_words)
    for p in range(first, last):
        if starts[p] == starts[p + 1]:
            continue
        centre, normal = row3(patches.centres, p), row3(patches.normals, p)
        along, across = _axes(patches, p)
        for k in range(starts[p], starts[p + 1]):
            q = np.int64(sources[k])
            apart = norm(difference(row3(patches.centres, q), centre)) - patches.sizes[q, 1]
            rule = (2 if patches.sides[p] == 3 else 0) + (1 if apart > _DISTANT * patches.sizes[p, 1] else 0)
            c0, c1, c2, c3, c4, c5 = _ZERO, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO
            for i in range(_COUNTS[rule]):
                offset = total(scaled(along, _PLACES[rule, i, 0]), scaled(across, _PLACES[rule, i, 1]))
                place = total(centre, offset)
                value = visible[k] * source_factor(patches, place, normal, q)
                value *= brightness_seen(patches, place, normal, q, bright)
                c0 += _MATRICES[rule, 0, i] * value
                c1 += _MATRICES[rule, 1, i] * value
                c2 += _MATRICES[rule, 2, i] * value
                c3 += _MATRICES[rule, 3, i] * value
                c4 += _MATRICES[rule, 4, i] * value
                c5 += _MATRICES[rule, 5, i] * value
            factors[k, 0], factors[k, 1], factors[k, 2] = c0, c1, c2
            factors[k, 3], factors[k, 4], factors[k, 5] = c3, c4, c5


@kernel
def near_factors(patch_words, leaves, starts, sources, visible, bright, factors, first, last):
    """Mean form factors, times `visible`, of the entries starts[i] ≤ k < starts[i + 1] of leaves[first ≤ i < last],
    and `bright` as for far ones."""
    patches = open_patches(patch_words)
    for i in range(first, last):
        leaf = np.int64(leaves[i])
        centre = row3(patches.centres, leaf)
        for k in range(starts[i], starts[i + 1]):
            q = np.int64(sources[k])
            apart = norm(difference(row3(patches.centres, q), centre))
            factors[k] = visible[k] * mean_source_factor(patches, leaf, q, apart, bright)


@kernel
def place_irradiance(patch_words, starts, sources, visible, bright, light, fields, leaves, places, found, first, last):
    """Irradiance at places[first ≤ i < last] (n, 3) on leaves[i], from the coefficients `fields` (nodes, 6, 3) and
    from the near entries starts[leaf] ≤ k < starts[leaf + 1] with the radiosity `light` of all nodes."""
    patches = open_patches(patch_words)
    for i in range(first, last):
        leaf = np.int64(leaves[i])
        place, normal = row3(places, i), row3(patches.normals, leaf)
        along, across = _axes(patches, leaf)
        way = difference(place, row3(patches.centres, leaf))
        a, b, c = dot3(along, along), dot3(along, across), dot3(across, across)
        x, y, size = dot3(way, along), dot3(way, across), a * c - b * b
        s, t = (c * x - b * y) / size, (a * y - b * x) / size
        for j in range(3):
            flat = fields[leaf, 0, j] + s * fields[leaf, 1, j] + t * fields[leaf, 2, j]
            bent = s * s * fields[leaf, 3, j] + s * t * fields[leaf, 4, j] + t * t * fields[leaf, 5, j]
            found[i, j] = flat + bent
        for k in range(starts[leaf], starts[leaf + 1]):
            q = np.int64(sources[k])
            factor = visible[k] * source_factor(patches, place, normal, q)
            factor *= brightness_seen(patches, place, normal, q, bright)
            for j in range(3):
                found[i, j] += factor * light[q, j]
