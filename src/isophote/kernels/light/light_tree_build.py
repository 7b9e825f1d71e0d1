"""Building a light tree: binary, by what its halves would be picked for, then eight children to a node.

A node is split where

    K Σ I M_A M_Ω

over both sides is least (Conty Estevez, Kulla 2018, section 4.4): the sum of intensities, a measure of the box, one of
the directions, and K = longest side / the side that is cut. M_Ω is that of the cone with the same mean axis: over a
cap of half angle θ the mean of the unit vectors has the length (1 + cosθ) / 2. So bins only add up vectors; the cones
that bound are made afterwards, from the leaves to the root.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import load8, load_float, load_int, minimum, splat8, store8, store_float, store_int
from isophote.kernels.light import light_tree_layout as layout

__all__ = ["RECORD", "build_light_tree", "collapse_light_tree"]

# Records of lights, and nodes of the binary tree: lower x, y, z, the light's number or the first child as int32,
# -upper x, y, z, unused; axis times (1 + cosθ_o) / 2 (in nodes the axis), intensity, cosθ_o, cosθ_e, side, 1.
RECORD = 16
_NUMBER, _MEAN, _INTENSITY, _OPENING, _REACH, _SIDE = (np.int64(word) for word in (3, 8, 11, 12, 13, 14))
# Among the eight words of sums.
_SUM, _COUNT = np.int64(3), np.int64(7)

_BINS, _FEW_BINS, _FEW = 12, 6, 8
# What is halved by number from this level on is no deeper than 32 levels more.
_DEEPEST = 48
_THIN = np.float32(1 / 64)
_SMALLEST = np.float32(1e-15)
_ZERO, _ONE, _HALF, _QUARTER = np.float32(0), np.float32(1), np.float32(0.5), np.float32(0.25)
_INFINITY = np.float32(np.inf)
# M_Ω / 4π of a cone with θ_e = π / 2 as a cubic in sin(θ / 2), to 2 %.
_CUBIC = (np.float32(0.699), np.float32(0.892), np.float32(-0.841))
# A stack entry: node, first, count, level.
_ENTRY = 4
_LANES, _NODE = np.int64(layout.LANES), np.int64(layout.NODE)


@device
def _measure(box, at, sums, sums_at):
    """I M_A M_Ω of a box and sums of axes and intensities."""
    x, y, z = (
        -load_float(box, at + 4) - load_float(box, at),
        -load_float(box, at + 5) - load_float(box, at + 1),
        -load_float(box, at + 6) - load_float(box, at + 2),
    )
    area = x * y + y * z + z * x + _THIN * (x * x + y * y + z * z)
    a, b, c = load_float(sums, sums_at), load_float(sums, sums_at + 1), load_float(sums, sums_at + 2)
    count = load_float(sums, sums_at + _COUNT)
    mean = math.sqrt(a * a + b * b + c * c) / count
    s = math.sqrt(max(_ZERO, _ONE - mean))
    spread = _QUARTER + s * (_CUBIC[0] + s * (_CUBIC[1] + s * _CUBIC[2]))
    return load_float(sums, sums_at + _SUM) * area * spread


@device
def _centre(records, i, axis):
    """Twice the middle of a record's box on an axis."""
    at = i * RECORD + axis
    return load_float(records, at) - load_float(records, at + 4)


@device
def _bin_of(records, i, axis, low, scale, bins):
    return min(np.int64((_centre(records, i, axis) - low) * scale), bins - 1)


@device
def _fill(records, first, count, axis, low, scale, bins, table):
    """Boxes and sums of the records whose middles fall into each bin."""
    for k in range(bins):
        store8(table, k * RECORD, splat8(_INFINITY))
        store8(table, k * RECORD + 8, splat8(_ZERO))
    for i in range(first, first + count):
        k = _bin_of(records, i, axis, low, scale, bins) * RECORD
        store8(table, k, minimum(load8(records, i * RECORD), load8(table, k)))
        store8(table, k + 8, load8(records, i * RECORD + 8) + load8(table, k + 8))


@device
def _best_plane(table, bins, costs):
    """(cost, bins to the left) of the best plane between bins."""
    at = bins * RECORD
    store8(table, at, splat8(_INFINITY))
    store8(table, at + 8, splat8(_ZERO))
    for plane in range(bins - 1, 0, -1):
        store8(table, at, minimum(load8(table, at), load8(table, plane * RECORD)))
        store8(table, at + 8, load8(table, at + 8) + load8(table, plane * RECORD + 8))
        costs[plane] = _measure(table, at, table, at + 8)
    store8(table, at, splat8(_INFINITY))
    store8(table, at + 8, splat8(_ZERO))
    least, best = _INFINITY, np.int64(0)
    for plane in range(1, bins):
        store8(table, at, minimum(load8(table, at), load8(table, (plane - 1) * RECORD)))
        store8(table, at + 8, load8(table, at + 8) + load8(table, (plane - 1) * RECORD + 8))
        cost = _measure(table, at, table, at + 8) + costs[plane]
        # An empty side costs NaN, which is not less than anything.
        if cost < least:
            least, best = cost, np.int64(plane)
    return least, best


@device
def _swap(records, i, j):
    a, b = load8(records, i * RECORD), load8(records, i * RECORD + 8)
    store8(records, i * RECORD, load8(records, j * RECORD))
    store8(records, i * RECORD + 8, load8(records, j * RECORD + 8))
    store8(records, j * RECORD, a)
    store8(records, j * RECORD + 8, b)


@device
def _partition(records, first, count, axis, low, scale, bins, plane):
    """Records of the bins left of the plane to the front; returns how many."""
    i, j = first, first + count - 1
    while i <= j:
        if _bin_of(records, i, axis, low, scale, bins) < plane:
            i += 1
        else:
            _swap(records, i, j)
            j -= 1
    return i - first


@device
def _split(records, first, count, level, table, costs):
    """Put the records of one side to the front; returns how many, 1 ≤ m < count."""
    half = count // 2
    if count == 2 or level >= _DEEPEST:
        return half
    bins = np.int64(_FEW_BINS if count <= _FEW else _BINS)
    least, best_axis, best_plane, best_low, best_scale = _INFINITY, np.int64(-1), np.int64(0), _ZERO, _ZERO
    longest = _ZERO
    for axis in range(3):
        low, high = _bounds_of_middles(records, first, count, axis)
        longest = max(longest, high - low)
    for axis in range(3):
        low, high = _bounds_of_middles(records, first, count, axis)
        scale = np.float32(bins) / (high - low)
        # Also where all are in one place, or infinitely far apart.
        if not (high > low and scale < _INFINITY and scale > _ZERO):
            continue
        _fill(records, first, count, axis, low, scale, bins, table)
        cost, plane = _best_plane(table, bins, costs)
        cost *= longest / (high - low)
        if cost < least:
            least, best_axis, best_plane, best_low, best_scale = cost, np.int64(axis), plane, low, scale
    if best_axis < 0:
        return half
    left = _partition(records, first, count, best_axis, best_low, best_scale, bins, best_plane)
    return left if 0 < left < count else half


@device
def _bounds_of_middles(records, first, count, axis):
    low, high = _INFINITY, -_INFINITY
    for i in range(first, first + count):
        middle = _centre(records, i, axis)
        low, high = min(low, middle), max(high, middle)
    return low, high


@device
def _copy_leaf(records, i, nodes, node, children):
    """A leaf of the binary tree from a record; its axis in full length."""
    at = node * RECORD
    store8(nodes, at, load8(records, i * RECORD))
    store8(nodes, at + 8, load8(records, i * RECORD + 8))
    length = _HALF * (_ONE + load_float(records, i * RECORD + _OPENING))
    for k in range(3):
        whole = load_float(records, i * RECORD + _MEAN + k) / length if length > _ZERO else np.float32(k == 1)
        store_float(nodes, at + _MEAN + k, whole)
    children[node] = -1


@kernel
def build_light_tree(records, nodes, children):
    """A binary tree over `records` (16 n floats, reordered): `nodes` (2 n − 1 of 16 floats), `children` (2 n − 1): the
    first of two nodes side by side, −1 of leaves."""
    count = len(records) // RECORD
    stack = np.empty(_ENTRY * (_DEEPEST + 40), np.int64)
    table, costs = np.empty((_BINS + 1) * RECORD, np.float32), np.empty(_BINS, np.float32)
    stack[0], stack[1], stack[2], stack[3] = 0, 0, count, 0
    top, free = _ENTRY, np.int64(1)
    while top > 0:
        top -= _ENTRY
        node, first, size, level = stack[top], stack[top + 1], stack[top + 2], stack[top + 3]
        if size == 1:
            _copy_leaf(records, first, nodes, node, children)
            continue
        left = _split(records, first, size, level, table, costs)
        children[node] = free
        for child in (1, 0):
            stack[top], stack[top + 3] = free + child, level + 1
            stack[top + 1] = first if child == 0 else first + left
            stack[top + 2] = left if child == 0 else size - left
            top += _ENTRY
        free += 2
    # Children have higher numbers than their parents.
    for node in range(free - 1, -1, -1):
        if children[node] >= 0:
            _unite(nodes, node, children[node])


@device
def _axis_of(nodes, node):
    at = node * RECORD + _MEAN
    return np.float64(nodes[at]), np.float64(nodes[at + 1]), np.float64(nodes[at + 2])


@device
def _unite_cones(nodes, a, b):
    """(axis, θ) of the least cone around two (Conty Estevez, Kulla 2018, algorithm 1); where one shines to both sides,
    both will be taken to, and either may be turned round."""
    theta_a = math.acos(min(max(np.float64(nodes[a * RECORD + _OPENING]), -1.0), 1.0))
    theta_b = math.acos(min(max(np.float64(nodes[b * RECORD + _OPENING]), -1.0), 1.0))
    if theta_b > theta_a:
        a, b, theta_a, theta_b = b, a, theta_b, theta_a
    ax, ay, az = _axis_of(nodes, a)
    bx, by, bz = _axis_of(nodes, b)
    cosine = ax * bx + ay * by + az * bz
    mirrored = min(nodes[a * RECORD + _SIDE], nodes[b * RECORD + _SIDE]) < _ZERO
    if mirrored and cosine < 0.0:
        bx, by, bz, cosine = -bx, -by, -bz, -cosine
    # The angle between, also where it is too small for its cosine.
    cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    sine = math.sqrt(cx * cx + cy * cy + cz * cz)
    between = math.atan2(sine, cosine)
    if min(between + theta_b, math.pi) <= theta_a:
        return ax, ay, az, theta_a
    theta = 0.5 * (theta_a + between + theta_b)
    if theta >= math.pi or sine == 0.0:
        return ax, ay, az, math.pi
    # Turned towards b by the difference, within the plane of both.
    turn = theta - theta_a
    px, py, pz = bx - cosine * ax, by - cosine * ay, bz - cosine * az
    along, across = math.cos(turn), math.sin(turn) / math.sqrt(px * px + py * py + pz * pz)
    x, y, z = along * ax + across * px, along * ay + across * py, along * az + across * pz
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length, theta


@device
def _unite(nodes, node, child):
    """Bounds of a node from those of its children."""
    at, a, b = node * RECORD, child * RECORD, (child + 1) * RECORD
    store8(nodes, at, minimum(load8(nodes, a), load8(nodes, b)))
    x, y, z, theta = _unite_cones(nodes, child, child + 1)
    nodes[at + _MEAN], nodes[at + _MEAN + 1], nodes[at + _MEAN + 2] = x, y, z
    nodes[at + _INTENSITY] = nodes[a + _INTENSITY] + nodes[b + _INTENSITY]
    nodes[at + _OPENING] = math.cos(theta)
    nodes[at + _REACH] = min(nodes[a + _REACH], nodes[b + _REACH])
    nodes[at + _SIDE] = min(nodes[a + _SIDE], nodes[b + _SIDE])


@device
def _size(nodes, node):
    """By which the child that is opened next is chosen: intensity times the square of its diagonal."""
    at, total = node * RECORD, _ZERO
    for k in range(3):
        side = -load_float(nodes, at + 4 + k) - load_float(nodes, at + k)
        total += side * side
    return load_float(nodes, at + _INTENSITY) * total


@device
def _write_lane(nodes, node, wide, at, lane):
    """The bounds of a node of the binary tree as those of a child in the tree of eight."""
    own, radius2 = node * RECORD, _ZERO
    for k in range(3):
        low, high = load_float(nodes, own + k), -load_float(nodes, own + 4 + k)
        middle = low + _HALF * (high - low)
        half = max(high - middle, middle - low)
        radius2 += half * half
        store_float(wide, at + layout.MIDDLE + 8 * k + lane, middle)
        store_float(wide, at + layout.AXIS + 8 * k + lane, nodes[own + _MEAN + k])
    store_float(wide, at + layout.RADIUS + lane, max(math.sqrt(radius2), _SMALLEST))
    store_float(wide, at + layout.OPENING + lane, nodes[own + _OPENING])
    store_float(wide, at + layout.REACH + lane, nodes[own + _REACH])
    sign = -_ONE if nodes[own + _SIDE] < _ZERO else _ONE
    store_float(wide, at + layout.INTENSITY + lane, sign * nodes[own + _INTENSITY])


@kernel
def collapse_light_tree(nodes, children, wide, parents, leaves):
    """The tree of eight children from the binary one, whose nodes of the largest size are opened first.

    `wide` has NODE floats, zeros, for each node, `parents` one, for as many as there are nodes with children in the
    binary tree; `leaves` one for each light. Returns how many nodes there are.
    """
    # For every node of the wide tree the binary one that it is; in breadth, so that upper levels lie together.
    roots = np.empty(len(parents), np.int32)
    opened = np.empty(_LANES, np.int32)
    roots[0], parents[0] = 0, -1
    made, done = np.int64(1), np.int64(0)
    while done < made:
        root, at = roots[done], done * _NODE
        opened[0], count = root, np.int64(1)
        while count < _LANES:
            best, most = np.int64(-1), -_ONE
            for k in range(count):
                if children[opened[k]] >= 0:
                    size = _size(nodes, np.int64(opened[k]))
                    if size > most:
                        best, most = np.int64(k), size
            if best < 0:
                break
            first = children[opened[best]]
            opened[best], opened[count] = first, first + 1
            count += 1
        for lane in range(count):
            node = np.int64(opened[lane])
            _write_lane(nodes, node, wide, at, lane)
            if children[node] < 0:
                light = load_int(nodes, node * RECORD + _NUMBER)
                store_int(wide, at + layout.CHILDREN + lane, np.int32(~light))
                leaves[light] = done * _LANES + lane
            else:
                store_int(wide, at + layout.CHILDREN + lane, np.int32(made))
                roots[made], parents[made] = node, done * _LANES + lane
                made += 1
        done += 1
    return made
