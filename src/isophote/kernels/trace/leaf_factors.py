"""Links of a tree of patches as seen from its leaves: every leaf has those of all nodes that it is part of."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import difference, dot3, norm, row3
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.light.form_factor import on_patch
from isophote.kernels.trace.exchange import face_of, factor_at, mean_factor, open_patches

__all__ = ["count_links", "leaf_factors", "place_irradiance"]

_PLACES, _GRID = 16, 4
_INV_PI = 1 / math.pi


@kernel
def count_links(parent, starts, leaves, found):
    """How many links each leaf has, its own and those of the nodes above it."""
    for i in range(len(leaves)):
        count, node = np.int64(0), np.int64(leaves[i])
        while node >= 0:
            count += starts[node + 1] - starts[node]
            node = np.int64(parent[node])
        found[i] = count


@device
def _cluster_factor(patches, place, normal, q):
    """Form factor from a place to a cluster, by places on its faces, as if nothing were in the way."""
    sum_ = 0.0
    for i in range(_PLACES):
        face = face_of(patches, q, (i + 0.5) / _PLACES)
        j = (5 * i + 3) % _PLACES
        on = on_patch(patches.corners, patches.sides, face, (j % _GRID + 0.5) / _GRID, (j // _GRID + 0.5) / _GRID)
        way = difference(on, place)
        square = dot3(way, way)
        first, second = dot3(way, normal), -dot3(way, row3(patches.normals, face))
        if first > 0.0 and second > 0.0:
            sum_ += first * second * _INV_PI / (square * square)
    return sum_ * patches.sizes[q, 0] / _PLACES


@device
def _open_share(patches, place, normal, q):
    """The share of what a place could see of patch q, above its horizon, that lies within no solid."""
    covered = patches.covered[q]
    if covered == 0:
        return 1.0
    above, opened = np.int64(0), np.int64(0)
    for cell in range(_PLACES):
        on = on_patch(patches.corners, patches.sides, q, (cell % _GRID + 0.5) / _GRID, (cell // _GRID + 0.5) / _GRID)
        if dot3(difference(on, place), normal) > 0.0:
            above += 1
            opened += 1 - ((covered >> cell) & 1)
    return opened / above if above > 0 else 0.0


@kernel
def leaf_factors(patch_words, parent, starts, sources, visible, leaves, ends, leaf_sources, factors, first, last):
    """Form factor times visibility of all links of leaves[first ≤ i < last], with the nodes that they lead to, at
    ends[i] − how many it has, and on."""
    patches = open_patches(patch_words)
    for i in range(first, last):
        leaf = np.int64(leaves[i])
        centre, normal = row3(patches.centres, leaf), row3(patches.normals, leaf)
        at, node = np.int64(ends[i]), leaf
        while node >= 0:
            for k in range(starts[node], starts[node + 1]):
                q = np.int64(sources[k])
                if patches.sides[q] == 0:
                    factor = _cluster_factor(patches, centre, normal, q)
                else:
                    distance = norm(difference(row3(patches.centres, q), centre))
                    factor = mean_factor(patches, leaf, q, distance)
                leaf_sources[at] = q
                factors[at] = factor * visible[k] * _open_share(patches, centre, normal, q)
                at += 1
            node = np.int64(parent[node])


@kernel
def place_irradiance(patch_words, parent, starts, sources, visible, light, nodes, places, found, first, last):
    """Irradiance, without that of lights that are no patches, at places[first ≤ i < last] (n, 3) on patches nodes[i],
    from the radiosity `light` of all nodes."""
    patches = open_patches(patch_words)
    for i in range(first, last):
        node = np.int64(nodes[i])
        place, normal = row3(places, i), row3(patches.normals, node)
        r, g, b = 0.0, 0.0, 0.0
        while node >= 0:
            for k in range(starts[node], starts[node + 1]):
                q = np.int64(sources[k])
                if patches.sides[q] == 0:
                    factor = _cluster_factor(patches, place, normal, q)
                else:
                    factor = factor_at(patches, place, normal, q)
                factor *= visible[k] * _open_share(patches, place, normal, q)
                r += factor * light[q, 0]
                g += factor * light[q, 1]
                b += factor * light[q, 2]
            node = np.int64(parent[node])
        found[i, 0], found[i, 1], found[i, 2] = r, g, b
