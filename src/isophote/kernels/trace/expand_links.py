"""Links of a tree of patches, brought down to where light along them is smooth.

A link between two large nodes says that they see each other. How the light of one falls on the other is worked out
nearer by: a *far* entry (p, q) says that the form factor from places of p to q is all but a polynomial of second
degree, a *near* entry that p is a leaf, for which it is averaged. As in the fast multipole method entries are far from
a certain distance on (Greengard, Rokhlin: "A Fast Algorithm for Particle Simulations", 1987; Hanrahan, Salzman,
Aupperle: "A Rapid Hierarchical Radiosity Algorithm", SIGGRAPH 1991, for patches).
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import cross3, difference, dot3, norm, row3, scaled
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.light.form_factor import corner3
from isophote.kernels.trace.exchange import open_patches
from isophote.kernels.trace.patch_factors import heights_over

__all__ = ["STACK", "expand_links"]

# Rows of pairs that wait: four for every level of both nodes, of which there are no more than this.
STACK = 1024
_NONE, _FAR, _NEAR, _RECEIVER, _SOURCE = np.int64(0), np.int64(1), np.int64(2), np.int64(3), np.int64(4)
_ZERO = np.float64(0)
# Nodes that a plane crosses by less than this part of the radii are on one side of it.
_ROUNDING = 1e-9
# Distances from a receiver's centre to a source, in the receiver's radii, and from a receiver to a cluster's centre, in
# the cluster's radii, from which on entries are far.
_SMOOTH, _SMALL = 2.5, 4.0


@device
def _to_segment(place, a, b):
    """Distance of a place from a segment."""
    along, way = difference(b, a), difference(place, a)
    square = dot3(along, along)
    t = min(max(dot3(way, along) / square, _ZERO), 1.0) if square > _ZERO else _ZERO
    return norm(difference(way, scaled(along, t)))


@device
def _to_patch(patches, place, q):
    """Distance of a place from patch q."""
    normal = row3(patches.normals, q)
    count = patches.sides[q]
    inside, least = True, math.inf
    a = corner3(patches.corners, q, count - 1)
    for c in range(count):
        b = corner3(patches.corners, q, c)
        if dot3(cross3(difference(b, a), difference(place, a)), normal) < _ZERO:
            inside = False
        least = min(least, _to_segment(place, a, b))
        a = b
    return abs(dot3(difference(place, a), normal)) if inside else least


@device
def _judged(patches, p, q):
    """What becomes of the pair of a receiver p and a source q."""
    radius, reach = patches.sizes[p, 1], patches.sizes[q, 1]
    little = _ROUNDING * (radius + reach)
    leaf = patches.first_child[p] < 0
    crossed = False
    if patches.flat[p] != 0 and heights_over(patches, p, q)[1] <= little:
        return _NONE
    if patches.flat[q] != 0:
        low, high = heights_over(patches, q, p)
        if high <= little:
            return _NONE
        crossed = low < -little
    centre = row3(patches.centres, p)
    distance = norm(difference(row3(patches.centres, q), centre))
    if patches.sides[q] == 0 and distance - radius < _SMALL * reach:
        return _RECEIVER if radius > reach and not leaf else _SOURCE
    if patches.covered[q] != 0 and patches.first_child[q] >= 0:
        return _SOURCE
    if patches.flat[p] == 0:
        return _RECEIVER
    distance = distance - reach if patches.sides[q] == 0 else _to_patch(patches, centre, q)
    if distance >= _SMOOTH * radius and not crossed:
        return _FAR
    return _NEAR if leaf else _RECEIVER


@kernel
def expand_links(patch_words, receivers, sources, visible, counts, ends, keys, nodes, shares, stack, fill, first, last):
    """Entries of the links first ≤ i < last from `sources` to `receivers`, of which the part `visible` is.

    Unless `fill`, only how many there are, into `counts`. Else those of link i end at ends[i]: in `keys` the receiver,
    plus the number of nodes where the entry is near, in `nodes` the source, in `shares` the visible part. `stack`
    (STACK, 2) is scratch.
    """
    patches = open_patches(patch_words)
    every = patches.sides.rows
    for i in range(first, last):
        top, count = np.int64(1), np.int64(0)
        stack[0, 0], stack[0, 1] = receivers[i], sources[i]
        at = ends[i] - counts[i] if fill else np.int64(0)
        while top > 0:
            top -= 1
            p, q = stack[top, 0], stack[top, 1]
            found = _judged(patches, p, q)
            if found in (_FAR, _NEAR):
                if fill:
                    keys[at + count] = p if found == _FAR else p + every
                    nodes[at + count], shares[at + count] = q, visible[i]
                count += 1
            elif found == _RECEIVER:
                child = np.int64(patches.first_child[p])
                for k in range(patches.children[p]):
                    stack[top, 0], stack[top, 1] = child + k, q
                    top += 1
            elif found == _SOURCE:
                child = np.int64(patches.first_child[q])
                for k in range(patches.children[q]):
                    stack[top, 0], stack[top, 1] = p, child + k
                    top += 1
        if not fill:
            counts[i] = count
