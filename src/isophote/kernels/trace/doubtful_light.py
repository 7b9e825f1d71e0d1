"""How much of the light that links are not sure of reaches each leaf: rays from the leaf itself, as many as it takes.

A link between two large nodes that see parts of each other says what part, for all of both. For a leaf of one of them

    E = Σ F B V + Σ F B (v − V)

with V what the link says and v the truth. The first sum is known; the second is sampled, sources in proportion to F B
times about how far v may be from V, until its standard error is as small as asked for. What V has right costs no
noise (a control variate). Leaves that lie partly in solids have all their light from rays that begin outside of these.
Places are those of a lattice in five dimensions: source, leaf, and place on the source
(Kronecker's sequence, Niederreiter: "Random Number Generation and Quasi-Monte Carlo Methods", 1992).
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import Double3, difference, dot3, row3
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.random import mix, unit_float
from isophote.kernels.base.vec import vec3
from isophote.kernels.light.form_factor import on_patch
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import find_blocked, trace_rays
from isophote.kernels.trace.covered import leaves_solid
from isophote.kernels.trace.exchange import face_of, leaf_at, open_patches
from isophote.kernels.trace.holes import share_left
from isophote.kernels.trace.tables import SCENE
from isophote.kernels.trace.wave import row_vec3, set_row_vec3

__all__ = ["BATCH", "CHANCES", "PROVED", "doubtful_light"]

# In place of the visible part: all is, for sure.
PROVED = 2.0

# Columns of the scratch for each source of a leaf: sum of chances up to it, what it would send if all were seen.
CHANCES = 2
_U = np.uint32
BATCH, _GRID = 64, 4
_ONE, _FAR, _ZERO, _INV_PI = np.float32(1), np.float32(np.inf), np.float64(0), 1 / math.pi
# Of a ray that begins within a solid, where no light is.
_BURIED = np.uint32(2)
# How far v may be from V at least, for what all rays of a link agree on.
_LEAST_DOUBT = 0.15
# Leaves that are parted by solids get so many times as many rays: some begin within these.
_PARTED = 4
# Places of a lattice are better than their variance says.
_EVEN = 0.5
# Dimensions of the lattice; its steps are powers of 1 / φ, φ⁶ = φ + 1.
_SOURCE, _LEAF_U, _LEAF_V, _SOURCE_U, _SOURCE_V = (np.int64(k) for k in range(5))
_PHI = 1.1347241384015194
_STEPS = tuple(_PHI**-k for k in range(1, 6))

open_scene, open_wave = SCENE.open, rows.WAVE.open


@device
def _doubt(visible, parted):
    """About how far what a leaf sees of a source may be from the part that its link says, and for leaves that are
    parted by solids from none."""
    if parted:
        return max(min(visible, 1.0), _LEAST_DOUBT)
    if visible > 1.0:
        return _ZERO
    return max(math.sqrt(max(visible * (1.0 - visible), _ZERO)), _LEAST_DOUBT)


@device
def _in_frame(patches, node, place):
    """A place in half edges of a node, from its centre."""
    axes = patches.axes
    along = Double3(axes[node, 0], axes[node, 1], axes[node, 2])
    across = Double3(axes[node, 3], axes[node, 4], axes[node, 5])
    way = difference(place, row3(patches.centres, node))
    a, b, c = dot3(along, along), dot3(along, across), dot3(across, across)
    x, y, size = dot3(way, along), dot3(way, across), a * c - b * b
    return (c * x - b * y) / size, (a * y - b * x) / size


@device
def _add(chances, picked, count, k, amount, doubt):
    """One more source, if it sends anything; how many there are then."""
    if amount * doubt <= _ZERO:
        return count
    before = chances[count - 1, 0] if count > 0 else _ZERO
    chances[count, 0], chances[count, 1] = before + amount * doubt, amount
    picked[count] = k
    return count + 1


@device
def _sources(patches, starts, near_starts, sources, visible, far, near, tone, parent, leaf, chances, picked):
    """(how many sources leaf has, with their chances; by how much the links may be off)."""
    first_near, place = starts[len(starts) - 1], row3(patches.centres, leaf)
    parted = patches.covered[leaf] != 0
    count, off, node = np.int64(0), _ZERO, leaf
    while node >= 0:
        if starts[node] < starts[node + 1]:
            s, t = _in_frame(patches, node, place)
            for k in range(starts[node], starts[node + 1]):
                factor = far[k, 0] + s * far[k, 1] + t * far[k, 2]
                factor += s * s * far[k, 3] + s * t * far[k, 4] + t * t * far[k, 5]
                amount, doubt = factor * tone[sources[k]], _doubt(visible[k], parted)
                count = _add(chances, picked, count, k, amount, doubt)
                off += max(amount, _ZERO) * doubt
        node = parent[node]
    for k in range(near_starts[leaf], near_starts[leaf + 1]):
        own = first_near + k
        amount, doubt = near[k] * tone[sources[own]], _doubt(visible[own], parted)
        count = _add(chances, picked, count, own, amount, doubt)
        off += amount * doubt
    return count, off


@device
def _found(chances, count, wanted):
    """The row whose share of all chances holds `wanted`, 0 to their sum."""
    low, high = np.int64(0), count - 1
    while low < high:
        middle = (low + high) >> 1
        if chances[middle, 0] <= wanted:
            low = middle + 1
        else:
            high = middle
    return low


@device
def _step(key, dimension, number):
    """Number `number` of the lattice in one dimension."""
    value = np.float64(unit_float(mix(_U(key + _U(dimension))))) + number * _STEPS[dimension]
    return value - math.floor(value)


@device
def _put(patches, wave, row, i, place, face):
    """A place above a face, into the rows from `row` on."""
    normal, bias = row3(patches.normals, face), np.float64(patches.bias)
    set_row_vec3(
        wave.floats,
        row,
        i,
        vec3(
            np.float32(place.x + bias * normal.x),
            np.float32(place.y + bias * normal.y),
            np.float32(place.z + bias * normal.z),
        ),
    )


@device
def _cell(u, v):
    """The cell of a grid of 4 × 4 that holds a place of the unit square."""
    return min(np.int64(u * _GRID), _GRID - 1) + _GRID * min(np.int64(v * _GRID), _GRID - 1)


@device
def _aim(patches, wave, chances, picked, sources, visible, count, leaf, key, number, i, ends):
    """Ray number `number` of a leaf, as shadow ray i; whether it carries anything. Its row DENSITY holds what it stands
    for, in parts of the source's mean and without its radiosity, the row SCATTER_U the visible part by the link, and
    `ends` the leaf at its end."""
    wanted = _step(key, _SOURCE, number) * chances[count - 1, 0]
    row = _found(chances, count, wanted)
    k = picked[row]
    q = np.int64(sources[k])
    u, v = _step(key, _LEAF_U, number), _step(key, _LEAF_V, number)
    s, t = _step(key, _SOURCE_U, number), _step(key, _SOURCE_V, number)
    # Where in its share of the chances the number lies says which face of a cluster it is.
    before = chances[row - 1, 0] if row > 0 else _ZERO
    face = face_of(patches, q, (wanted - before) / (chances[row, 0] - before))
    start = on_patch(patches.corners, patches.sides, leaf, u, v)
    end = on_patch(patches.corners, patches.sides, face, s, t)
    hidden = (patches.covered[face] >> _cell(s, t)) & 1 != 0
    way = difference(end, start)
    square = dot3(way, way)
    first, second = dot3(way, row3(patches.normals, leaf)), -dot3(way, row3(patches.normals, face))
    weight = _ZERO
    if first > _ZERO and second > _ZERO and not hidden:
        weight = first * second * _INV_PI / (square * square) * patches.sizes[q, 0] / chances[row, 1]
    elif patches.covered[leaf] == 0:
        return False
    _put(patches, wave, rows.SHADOW_ORIGIN, i, start, leaf)
    _put(patches, wave, rows.SHADOW_DIRECTION, i, end, face)
    for axis in range(3):
        wave.floats[rows.SHADOW_DIRECTION + axis, i] -= wave.floats[rows.SHADOW_ORIGIN + axis, i]
    wave.floats[rows.SHADOW_END, i] = _ONE
    wave.floats[rows.DENSITY, i], wave.floats[rows.SCATTER_U, i] = np.float32(weight), visible[k]
    ends[i] = leaf_at(patches, face, s, t)
    return True


@device
def _buried(scene, patches, wave, solid, leaf, count):
    """How many rays begin within solids; these rows of BLOCKED become 2."""
    normal, found = row3(patches.normals, leaf), np.int64(0)
    up = vec3(np.float32(normal.x), np.float32(normal.y), np.float32(normal.z))
    for i in range(count):
        set_row_vec3(wave.floats, rows.ORIGIN, i, row_vec3(wave.floats, rows.SHADOW_ORIGIN, i))
        set_row_vec3(wave.floats, rows.DIRECTION, i, up)
        wave.floats[rows.HIT_T, i] = _FAR
    trace_rays(scene, wave, count, True)
    for i in range(count):
        if leaves_solid(scene, wave, solid, i):
            wave.ints[rows.BLOCKED, i] = _BURIED
            found += 1
    return found


@device
def _sampled(
    scene, patches, wave, solid, chances, picked, sources, visible, count, light, tone, leaf, allowed, most, ends, sum_
):
    """Σ F B (v − V) of a leaf, or all its light where it is parted by solids, into `sum_` (3,)."""
    all_, key, parted = chances[count - 1, 0], mix(_U(leaf) ^ _U(0x5BD1E995)), patches.covered[leaf] != 0
    whole, off, square, opened = _ZERO, _ZERO, _ZERO, _ZERO
    sum_[0], sum_[1], sum_[2] = _ZERO, _ZERO, _ZERO
    cast, buried = np.int64(0), True
    if parted:
        most *= _PARTED
    while cast < most:
        aimed = np.int64(0)
        for number in range(cast, cast + BATCH):
            if _aim(patches, wave, chances, picked, sources, visible, count, leaf, key, number, aimed, ends):
                aimed += 1
        cast += BATCH
        find_blocked(scene, wave, aimed, False)
        if buried:
            # If none of the first begin within a solid, few of the others do.
            buried = _buried(scene, patches, wave, solid, leaf, aimed) > 0 or parted
        for i in range(aimed):
            if wave.ints[rows.BLOCKED, i] == _BURIED:
                continue
            link, weight = np.float64(wave.floats[rows.SCATTER_U, i]), np.float64(wave.floats[rows.DENSITY, i])
            seen = np.float64(share_left(scene, wave, i)) if wave.ints[rows.BLOCKED, i] == 0 else _ZERO
            change = weight * (seen if parted else seen - link) / _doubt(link, parted)
            q = ends[i]
            opened += 1.0
            whole += weight * tone[q]
            off += change * tone[q]
            square += (change * tone[q]) ** 2
            for j in range(3):
                sum_[j] += change * light[q, j]
        mean = off / cast
        # One ray more might have told otherwise, even if so far none did.
        error = all_ * math.sqrt(max((square + 1.0) / cast - mean * mean, _ZERO) / cast) * _EVEN
        if whole > _ZERO and error <= allowed:
            break
    whole = opened if parted else whole
    for j in range(3):
        sum_[j] = all_ * sum_[j] / whole if whole > _ZERO else _ZERO


@kernel
def doubtful_light(
    scene_words,
    patch_words,
    wave_words,
    solid,
    starts,
    near_starts,
    sources,
    visible,
    far,
    near,
    light,
    tone,
    parent,
    leaves,
    arriving,
    allowed,
    most,
    chances,
    picked,
    ends,
    found,
    first,
    last,
):
    """What the irradiance of leaves[first ≤ i < last] is more than `arriving` (n, 3), as links say, into the rows of
    `found` (n, 3), to a standard error of `allowed` (n,), by `most` rays at most.

    Entries as in `Expansion`, factors `far`, `near` as if all were visible; `light` (nodes, 3), its mean `tone` and the
    `parent` of each (nodes,); `solid` (items,): which items are. Scratch: `chances` (m, 2), `picked` (m,), with m the
    most sources that a leaf has, `ends` (64,).
    """
    scene, patches, wave = open_scene(scene_words), open_patches(patch_words), open_wave(wave_words)
    sum_ = np.zeros(3)
    for i in range(first, last):
        leaf = np.int64(leaves[i])
        count, off = _sources(
            patches, starts, near_starts, sources, visible, far, near, tone, parent, leaf, chances, picked
        )
        parted = patches.covered[leaf] != 0
        if count == 0 or off <= allowed[i] or patches.sizes[leaf, 2] == 0.0:
            continue
        _sampled(
            scene,
            patches,
            wave,
            solid,
            chances,
            picked,
            sources,
            visible,
            count,
            light,
            tone,
            leaf,
            allowed[i],
            most,
            ends,
            sum_,
        )
        for j in range(3):
            found[i, j] = sum_[j] - (arriving[i, j] if parted else _ZERO)
