"""How well two patches, or clusters of patches, see each other, and how much light they could exchange.

    G = ∫∫ cosθ cosθ' / (π r²) dA dA'          V = 1/G ∫∫ v cosθ cosθ' / (π r²) dA dA'

v is 0 where something stands in the way and 1 elsewhere. For patches the inner integral of G over the larger is
Lambert's closed form, and the outer one over the smaller Gauss's rule with up to 4 × 4 places. V is the mean over 16
rays between jittered places of both, each with its part of the integral. For clusters G is a sum over 16 places of
their faces.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import difference, dot3, norm, row3
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.random import combine, mix, unit_float
from isophote.kernels.base.table import BYTES, DOUBLE_BOXES, FLOAT, INTS, Table
from isophote.kernels.base.vec import vec3
from isophote.kernels.light.form_factor import on_patch
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import find_blocked
from isophote.kernels.trace.holes import share_left
from isophote.kernels.trace.patch_factors import heights_over, mean_factor
from isophote.kernels.trace.shaft import SHAFT, sees_all
from isophote.kernels.trace.tables import SCENE
from isophote.kernels.trace.wave import set_row_vec3

__all__ = ["PATCHES", "exchanges", "face_of", "leaf_at", "lit_shares", "open_patches"]

# Nodes: `corners` (n, 12), `sides` (n,) 3 or 4, 0 for clusters; `normals`, `centres` (n, 3); `axes` (n, 6): two half
# edges, of a cluster those of a rectangle about the centre; `flat` (n,): 0 for clusters that lie in no plane;
# `first_child`, −1 where there is none, and `children` (n,); `sizes` (n, 3): area, radius around the centre, and the
# share of it that lies within no solid. `covered` (n,): a bit for each cell of a grid
# of 4 × 4 that does. `first_face`, `last_face` (n,): the faces of a cluster as numbers into `faces`, which are
# nodes; `shares` (faces, 1): cumulative areas of the faces. `boxes` (2 n, 3): least and most coordinates of clusters.
# `roots`: nodes without a parent. `bias`: how far rays start above patches.
PATCHES = Table(
    "Patches",
    corners=DOUBLE_BOXES,
    sides=BYTES,
    normals=DOUBLE_BOXES,
    centres=DOUBLE_BOXES,
    axes=DOUBLE_BOXES,
    flat=BYTES,
    first_child=INTS,
    children=INTS,
    sizes=DOUBLE_BOXES,
    covered=INTS,
    first_face=INTS,
    last_face=INTS,
    faces=INTS,
    shares=DOUBLE_BOXES,
    boxes=DOUBLE_BOXES,
    roots=INTS,
    bias=FLOAT,
)

_U = np.uint32
_RAYS, _GRID = 16, 4
_ONE = np.float32(1)
_INV_PI = 1 / math.pi
open_scene, open_patches, open_wave, open_shaft = SCENE.open, PATCHES.open, rows.WAVE.open, SHAFT.open


@device
def _in_front(patches, p, q):
    """Whether any of node q is in front of node p's plane."""
    _, highest = heights_over(patches, p, q)
    return highest > 1e-9 * (patches.sizes[q, 1] + patches.sizes[p, 1])


@device
def face_of(patches, node, u):
    """A face of a cluster with a chance in proportion to its area, or the patch itself."""
    if patches.sides[node] != 0:
        return np.int64(node)
    first, last = np.int64(patches.first_face[node]), np.int64(patches.last_face[node])
    low = patches.shares[first, 0]
    wanted = low + u * (patches.shares[last, 0] - low)
    while last - first > 1:
        middle = (first + last) >> 1
        if patches.shares[middle, 0] <= wanted:
            first = middle
        else:
            last = middle
    return np.int64(patches.faces[first])


@device
def _lifted(patches, wave, row, i, place, face):
    normal = row3(patches.normals, face)
    set_row_vec3(
        wave.floats,
        row,
        i,
        vec3(
            np.float32(place.x + patches.bias * normal.x),
            np.float32(place.y + patches.bias * normal.y),
            np.float32(place.z + patches.bias * normal.z),
        ),
    )


@device
def _aim(patches, wave, p, q):
    """Sixteen rays between jittered places; the row DENSITY holds what each stands for, cosθ cosθ' / (π r²), the rows
    PICK and LIGHT the places on the faces of p and q. Returns the sum of the former."""
    floats = wave.floats
    key = combine(_U(p), _U(q))
    turn = np.int64(key & _U(15))
    sum_ = 0.0
    for i in range(_RAYS):
        a = mix(_U(key + _U(0x9E3779B9) * _U(i + 1)))
        b, c, d = mix(_U(a ^ _U(0x68BC21EB))), mix(_U(a ^ _U(0x02E5BE93))), mix(_U(a ^ _U(0x63D83595)))
        # Cells of the one go with those of the other turned: 5 and 16 have no common factor.
        j = (5 * i + turn) & (_RAYS - 1)
        u, v = (i % _GRID + np.float64(unit_float(a))) / _GRID, (i // _GRID + np.float64(unit_float(b))) / _GRID
        s, t = (j % _GRID + np.float64(unit_float(c))) / _GRID, (j // _GRID + np.float64(unit_float(d))) / _GRID
        from_, to = face_of(patches, p, (i + 0.5) / _RAYS), face_of(patches, q, (j + 0.5) / _RAYS)
        start = on_patch(patches.corners, patches.sides, from_, u, v)
        end = on_patch(patches.corners, patches.sides, to, s, t)
        way = difference(end, start)
        square = dot3(way, way)
        first, second = dot3(way, row3(patches.normals, from_)), -dot3(way, row3(patches.normals, to))
        part = max(first, 0.0) * max(second, 0.0) * _INV_PI / (square * square) if square > 0.0 else 0.0
        # No light is within solids: a patch is what lies outside of them.
        if (patches.covered[from_] >> i) & 1 or (patches.covered[to] >> j) & 1:
            part = 0.0
        _lifted(patches, wave, rows.SHADOW_ORIGIN, i, start, from_)
        _lifted(patches, wave, rows.SHADOW_DIRECTION, i, end, to)
        for k in range(3):
            floats[rows.SHADOW_DIRECTION + k, i] -= floats[rows.SHADOW_ORIGIN + k, i]
        floats[rows.SHADOW_END, i] = _ONE
        floats[rows.DENSITY, i] = np.float32(part)
        floats[rows.PICK_U, i], floats[rows.PICK_V, i] = np.float32(u), np.float32(v)
        floats[rows.LIGHT_U, i], floats[rows.LIGHT_V, i] = np.float32(s), np.float32(t)
        sum_ += part
    return sum_


@device
def _seen(scene, wave):
    """What the rays that nothing blocks stand for."""
    find_blocked(scene, wave, _RAYS, True)
    sum_ = 0.0
    for i in range(_RAYS):
        if wave.ints[rows.BLOCKED, i] == 0:
            sum_ += np.float64(wave.floats[rows.DENSITY, i] * share_left(scene, wave, i))
    return sum_


@device
def _between_patches(scene, patches, wave, shaft, p, q):
    """(V, G, how far V may be off) of two flat nodes; G is 0 where they do not face each other."""
    if not (_in_front(patches, p, q) and _in_front(patches, q, p)):
        return 0.0, 0.0, 0.0
    if patches.sizes[p, 0] > patches.sizes[q, 0]:
        p, q = q, p
    distance = norm(difference(row3(patches.centres, p), row3(patches.centres, q)))
    whole = _aim(patches, wave, p, q)
    if patches.sizes[p, 2] == 0.0 or patches.sizes[q, 2] == 0.0:
        return 0.0, 0.0, 0.0
    exchange = patches.sizes[p, 0] * patches.sizes[q, 0] * whole / _RAYS
    if patches.sides[p] != 0:
        exchange = max(exchange, patches.sizes[p, 0] * mean_factor(patches, p, q, distance))
    if whole <= 0.0:
        # They face each other, but none of the sixteen places do.
        return 1.0, exchange, 1.0
    # Lamps that are no patches may block, too; many are primitives.
    lamps = scene.lights.lamps.rows + scene.primitives.numbers.rows
    if lamps == 0 and sees_all(patches, shaft, p, q):
        return 1.0, exchange, 0.0
    visible = _seen(scene, wave) / whole
    # What sixteen rays cannot tell: half a ray, and more where some are blocked.
    return visible, exchange, 0.5 / _RAYS + visible * (1.0 - visible)


@device
def _between_clusters(scene, patches, wave, p, q):
    """(V, G, how far V may be off) where at least one is a cluster: all of it; infinite where they overlap."""
    distance = norm(difference(row3(patches.centres, p), row3(patches.centres, q)))
    if distance <= patches.sizes[p, 1] + patches.sizes[q, 1]:
        return 0.0, math.inf, 1.0
    areas = patches.sizes[p, 0] * patches.sizes[q, 0]
    whole = _aim(patches, wave, p, q)
    # As if all faces turned half to each other: sixteen places may miss the few that face each other.
    most = 0.25 * _INV_PI * areas / (distance * distance)
    if whole <= 0.0:
        return 1.0, most, 1.0
    return _seen(scene, wave) / whole, max(most, areas * whole / _RAYS), 1.0


@kernel
def exchanges(scene_words, patch_words, wave_words, shaft_words, pairs, found, first, last):
    """(V, G, how far V may be off) of pairs first ≤ i < last, into the rows of `found` (n, 3)."""
    scene, patches = open_scene(scene_words), open_patches(patch_words)
    wave, shaft = open_wave(wave_words), open_shaft(shaft_words)
    for i in range(first, last):
        p, q = np.int64(pairs[i, 0]), np.int64(pairs[i, 1])
        if patches.flat[p] != 0 and patches.flat[q] != 0:
            found[i, 0], found[i, 1], found[i, 2] = _between_patches(scene, patches, wave, shaft, p, q)
        else:
            found[i, 0], found[i, 1], found[i, 2] = _between_clusters(scene, patches, wave, p, q)


@device
def leaf_at(patches, node, u, v):
    """The leaf below a patch where `on_patch` puts (u, v)."""
    three = patches.sides[node] == 3
    if three:
        u, v = (u - v / 2, v / 2) if v <= u else (u / 2, v - u / 2)
    while patches.first_child[node] >= 0:
        child = np.int64(patches.first_child[node])
        if three and u < 0.5 and v < 0.5 and u + v >= 0.5:
            # The part in the middle has turned axes.
            node, u, v = child + 3, 2.0 * (u + v) - 1.0, 1.0 - 2.0 * u
            continue
        right, upper = u >= 0.5, v >= 0.5
        if three:
            node = child + 1 if right else (child + 2 if upper else child)
        else:
            node = child + ((2 if right else 3) if upper else (1 if right else 0))
        u, v = 2.0 * u - (1.0 if right else 0.0), 2.0 * v - (1.0 if upper else 0.0)
    return node


@kernel
def lit_shares(scene_words, patch_words, wave_words, bright, pairs, found, first, last):
    """What part of the light of each of the pairs first ≤ i < last reaches the other, into the rows of `found` (n, 2):
    of the second's, of the first's, by the rays of `exchanges` and what the leaves at their ends send out, `bright`
    (nodes,). Rows stay as they are where no ray tells."""
    scene, patches, wave = open_scene(scene_words), open_patches(patch_words), open_wave(wave_words)
    floats = wave.floats
    for i in range(first, last):
        p, q = np.int64(pairs[i, 0]), np.int64(pairs[i, 1])
        turned = patches.flat[p] != 0 and patches.flat[q] != 0 and patches.sizes[p, 0] > patches.sizes[q, 0]
        if turned:
            p, q = q, p
        _aim(patches, wave, p, q)
        find_blocked(scene, wave, _RAYS, True)
        turn = np.int64(combine(_U(p), _U(q)) & _U(15))
        all_p, all_q, lit_p, lit_q = 0.0, 0.0, 0.0, 0.0
        for k in range(_RAYS):
            j = (5 * k + turn) & (_RAYS - 1)
            near = leaf_at(
                patches, face_of(patches, p, (k + 0.5) / _RAYS), floats[rows.PICK_U, k], floats[rows.PICK_V, k]
            )
            far = leaf_at(
                patches, face_of(patches, q, (j + 0.5) / _RAYS), floats[rows.LIGHT_U, k], floats[rows.LIGHT_V, k]
            )
            weight = np.float64(floats[rows.DENSITY, k])
            passed = np.float64(share_left(scene, wave, k)) if wave.ints[rows.BLOCKED, k] == 0 else 0.0
            all_p, all_q = all_p + weight * bright[near], all_q + weight * bright[far]
            lit_p, lit_q = lit_p + weight * bright[near] * passed, lit_q + weight * bright[far] * passed
        of_p, of_q = (np.int64(0), np.int64(1)) if turned else (np.int64(1), np.int64(0))
        if all_p > 0.0:
            found[i, of_p] = lit_p / all_p
        if all_q > 0.0:
            found[i, of_q] = lit_q / all_q
