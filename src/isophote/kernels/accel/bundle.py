"""Up to 64 rays from one origin through the tree together.

Rays into the hemisphere above a point go every way, but near the root, and near the point, they all come by the same
boxes. So the tree is walked once for all of them, with the set of rays that enter each node: four times sixteen rays
are tested against a box, whose planes are taken from the origin once for all. Where few rays are left, each goes on by
itself (Benthin, Wald, Woop, Ernst, Mark: "Combining Single and Packet-Ray Tracing for Arbitrary Ray Distributions on
the Intel MIC Architecture", 2012).

What lies below the cone of directions n · d ≥ c, where c is the least n · d of all rays, is met by none: with the plane
through the origin, most of a closed mesh. A point of a box is met only at

    n · (x − o)  ≥  c |x − o|

Everything is tested as conservatively as for single rays (bvh.py), so rays meet the same triangles, bit for bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bvh import FAR_SLACK, Slabs, any_below
from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, LOWER, MAX_DEPTH, NODE, REACH, STACK, UPPER, WIDTH
from isophote.kernels.accel.spread import LARGEST, LEAST_SHARE, PLACE_SLACK, TINY
from isophote.kernels.base.bit_set import count_of, first_of, leading
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    bits,
    least,
    load4,
    load8,
    load16,
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    select,
    splat4,
    splat8,
    splat16,
    store4,
    store8,
    store16,
    store_float,
    store_int,
)
from isophote.kernels.base.simd_product import product_difference
from isophote.kernels.forms.triangle import Shear, meets_blocks

__all__ = ["BUNDLE", "BUNDLE_SCRATCH", "blocked_of_bundle", "set_direction_of_bundle"]

# Rays of a bundle, and of a group: one register of theirs.
BUNDLE = 64
_GROUP = 16
_GROUPS = np.int64(BUNDLE // _GROUP)
_LANES_OF_GROUP = np.int64(0xFFFF)

# Rows of the scratch, BUNDLE words each: directions, 1/d, o/d moved outward on both sides, shears.
_DIRECTIONS, _INVERSE, _ENTER, _LEAVE, _SHEARS = (np.int64(row * BUNDLE) for row in (0, 3, 6, 9, 12))
_ROW = np.int64(BUNDLE)
# Planes of a node's boxes from the origin, corners of a block's triangles from there, sets of rays that enter the
# children, then the stacks: of the bundle, whose entries are a code and a set, and of single rays.
_PLANES = np.int64(15 * BUNDLE)
_CORNERS = np.int64(15 * BUNDLE + 6 * WIDTH)
_STACK = np.int64(15 * BUNDLE + 6 * WIDTH + 9 * LANES)
_ENTRY = np.int64(3)
_SINGLES = np.int64(15 * BUNDLE + 6 * WIDTH + 9 * LANES + 3 * (WIDTH - 1) * (MAX_DEPTH + 4))
BUNDLE_SCRATCH = 15 * BUNDLE + 6 * WIDTH + 9 * LANES + 3 * (WIDTH - 1) * (MAX_DEPTH + 4) + STACK

# So few rays go on one by one: below a node, and in a leaf.
_FEW, _FEW_IN_LEAF = np.int64(8), np.int64(12)

_ZERO, _ONE = np.float32(0), np.float32(1)
_NO_RAYS, _ONE_RAY = np.int64(0), np.int64(1)
_LOW_WORD = np.int64(0xFFFFFFFF)
# Rounding of n · d, for vectors of length 1.
_COSINE_SLACK = np.float32(2.0**-21)


class _Cone(NamedTuple):
    """What rays can reach at all: the normal n; c where it is positive, and −c where it is not; how uncertain places
    are."""

    nx: float
    ny: float
    nz: float
    above: float
    below: float
    place: float


class _Bundle(NamedTuple):
    """The origin, the rays whose directions are longest along x, y and z, their cone, and where they end."""

    origin: object
    along_x: int
    along_y: int
    along_z: int
    cone: _Cone
    limit: float


@device
def set_direction_of_bundle(scratch, column, direction):
    """Write the direction of ray `column`, of length 1."""
    store_float(scratch, _DIRECTIONS + column, direction.x)
    store_float(scratch, _DIRECTIONS + _ROW + column, direction.y)
    store_float(scratch, _DIRECTIONS + 2 * _ROW + column, direction.z)


@device
def _finite(x):
    widest = splat16(LARGEST)
    return maximum(minimum(x, widest), splat16(_ZERO) - widest)


@device
def _prepare_axis(scratch, at, row, d, smallest, origin, place):
    """Rows of 1/d and o/d of one axis (spread.py)."""
    zero = splat16(_ZERO)
    safe = select(absolute(d) > smallest, d, select(d >= zero, smallest, zero - smallest))
    inverse = splat16(_ONE) / safe
    along = _finite(splat16(origin) * inverse)
    slack = _finite(splat16(place) * absolute(inverse))
    store16(scratch, _INVERSE + row + at, inverse)
    store16(scratch, _ENTER + row + at, along + slack)
    store16(scratch, _LEAVE + row + at, along - slack)


@device
def _prepare_group(scratch, at, origin, normal, place):
    """Write the rows that are told by the directions of the sixteen rays from column `at` on; the least n · d."""
    x, y, z = (
        load16(scratch, _DIRECTIONS + at),
        load16(scratch, _DIRECTIONS + _ROW + at),
        load16(scratch, _DIRECTIONS + 2 * _ROW + at),
    )
    ax, ay, az = absolute(x), absolute(y), absolute(z)
    smallest = maximum(maximum(ax, maximum(ay, az)) * splat16(LEAST_SHARE), splat16(TINY))
    _prepare_axis(scratch, at, np.int64(0), x, smallest, origin.x, place)
    _prepare_axis(scratch, at, _ROW, y, smallest, origin.y, place)
    _prepare_axis(scratch, at, 2 * _ROW, z, smallest, origin.z, place)
    # As `shear` in forms/triangle.py, lane by lane.
    on_x, on_y = (ax >= ay) & (ax >= az), ay >= az
    scale = splat16(_ONE) / select(on_x, x, select(on_y, y, z))
    store16(scratch, _SHEARS + at, select(on_x, y, select(on_y, z, x)) * scale)
    store16(scratch, _SHEARS + _ROW + at, select(on_x, z, select(on_y, x, y)) * scale)
    store16(scratch, _SHEARS + 2 * _ROW + at, scale)
    return least(splat16(normal.x) * x + splat16(normal.y) * y + splat16(normal.z) * z)


@device
def _prepare(scratch, count, along_x, along_y, origin, normal, limit, reach):
    most = max(reach, max(abs(origin.x), max(abs(origin.y), abs(origin.z))))
    place = min(most * PLACE_SLACK, LARGEST)
    cosine = _ONE
    for column in range(count, (count + (_GROUP - 1)) // _GROUP * _GROUP):
        for row in range(3):
            store_float(scratch, _DIRECTIONS + row * _ROW + column, load_float(scratch, _DIRECTIONS + row * _ROW))
    for at in range(0, count, _GROUP):
        cosine = min(cosine, _prepare_group(scratch, at, origin, normal, place))
    cosine -= _COSINE_SLACK
    cone = _Cone(normal.x, normal.y, normal.z, max(cosine, _ZERO), max(-cosine, _ZERO), place)
    x, y = leading(along_x), leading(along_x + along_y)
    return _Bundle(origin, x, y & ~x, leading(count) & ~y, cone, limit)


@device
def _axis_planes(nodes, base, scratch, at, origin, n, place):
    """Planes of a node's boxes across one axis, moved outward, as the origin sees them, to the scratch: how far boxes
    reach along the normal on this axis, how near and how far they are on it at least and at most."""
    low = load8(nodes, base + LOWER + at) - splat8(origin) - splat8(place)
    high = load8(nodes, base + UPPER + at) - splat8(origin) + splat8(place)
    store8(scratch, _PLANES + at, low)
    store8(scratch, _PLANES + 3 * WIDTH + at, high)
    zero = splat8(_ZERO)
    up = maximum(low * splat8(n), high * splat8(n))
    return up, maximum(low, zero - high), maximum(zero - low, high)


@device
def _reached_children(nodes, base, scratch, bundle):
    """Which children the bundle may reach, as bits; their planes are left in the scratch."""
    cone, o = bundle.cone, bundle.origin
    up_x, near_x, far_x = _axis_planes(nodes, base, scratch, np.int64(0), o.x, cone.nx, cone.place)
    up_y, near_y, far_y = _axis_planes(nodes, base, scratch, np.int64(WIDTH), o.y, cone.ny, cone.place)
    up_z, near_z, far_z = _axis_planes(nodes, base, scratch, np.int64(2 * WIDTH), o.z, cone.nz, cone.place)
    near = maximum(maximum(near_x, near_y), maximum(near_z, splat8(_ZERO)))
    up = up_x + up_y + up_z + splat8(cone.below) * (far_x + far_y + far_z) + splat8(cone.place)
    there = load8(nodes, base + LOWER) <= load8(nodes, base + UPPER)
    return bits(there & (up >= near * splat8(cone.above)) & (near <= splat8(bundle.limit * FAR_SLACK)))


@device
def _slab(scratch, low, high, at):
    """Where the sixteen rays whose 1/d are at word `at` enter and leave the space between two planes."""
    inverse = load16(scratch, at)
    a, b = low * inverse, high * inverse
    return minimum(a, b), maximum(a, b)


@device
def _rays_into_child(scratch, child, limit, rays):
    """Those of the rays that enter a child whose planes are in the scratch."""
    at = _PLANES + child
    lx, hx = splat16(load_float(scratch, at)), splat16(load_float(scratch, at + 3 * WIDTH))
    ly, hy = splat16(load_float(scratch, at + WIDTH)), splat16(load_float(scratch, at + 4 * WIDTH))
    lz, hz = splat16(load_float(scratch, at + 2 * WIDTH)), splat16(load_float(scratch, at + 5 * WIDTH))
    entered = _NO_RAYS
    for group in range(_GROUPS):
        column = group * _GROUP
        if (rays >> column) & _LANES_OF_GROUP == 0:
            continue
        x0, x1 = _slab(scratch, lx, hx, _INVERSE + column)
        y0, y1 = _slab(scratch, ly, hy, _INVERSE + _ROW + column)
        z0, z1 = _slab(scratch, lz, hz, _INVERSE + 2 * _ROW + column)
        near = maximum(maximum(x0, y0), maximum(z0, splat16(_ZERO)))
        far = minimum(minimum(x1, y1), minimum(z1, splat16(limit)))
        entered |= np.int64(bits(near <= far * splat16(FAR_SLACK))) << column
    return entered & rays


@device
def _push(scratch, top, code, rays):
    """Put a node and the rays that enter it on the stack. Returns the new top."""
    store_int(scratch, top, code)
    store_int(scratch, top + 1, np.int32(rays & _LOW_WORD))
    store_int(scratch, top + 2, np.int32(rays >> 32))
    return top + _ENTRY


@device
def _rays_at(scratch, top):
    low, high = np.int64(load_int(scratch, top + 1)), np.int64(load_int(scratch, top + 2))
    return (low & _LOW_WORD) | (high << 32)


@device
def _along(vector, axis):
    return vector.x if axis == 0 else (vector.y if axis == 1 else vector.z)


@device
def _sheared(scratch, bundle, i):
    """Ray `i` made ready for triangles."""
    ray = _ONE_RAY << i
    kz = np.int64(0 if bundle.along_x & ray != 0 else (1 if bundle.along_y & ray != 0 else 2))
    kx = np.int64(kz + 1 if kz < 2 else 0)
    ky = np.int64(kx + 1 if kx < 2 else 0)
    o = bundle.origin
    return Shear(
        kx,
        ky,
        kz,
        splat8(_along(o, kx)),
        splat8(_along(o, ky)),
        splat8(_along(o, kz)),
        splat8(load_float(scratch, _SHEARS + i)),
        splat8(load_float(scratch, _SHEARS + _ROW + i)),
        splat8(load_float(scratch, _SHEARS + 2 * _ROW + i)),
    )


@device
def _slabs(scratch, i):
    """Ray `i` made ready for boxes."""
    ix, iy, iz = (
        load_float(scratch, _INVERSE + i),
        load_float(scratch, _INVERSE + _ROW + i),
        load_float(scratch, _INVERSE + 2 * _ROW + i),
    )
    return Slabs(
        np.int64(0 if ix >= _ZERO else UPPER),
        np.int64(8 if iy >= _ZERO else UPPER + 8),
        np.int64(16 if iz >= _ZERO else UPPER + 16),
        splat8(ix),
        splat8(iy),
        splat8(iz),
        splat8(load_float(scratch, _ENTER + i)),
        splat8(load_float(scratch, _ENTER + _ROW + i)),
        splat8(load_float(scratch, _ENTER + 2 * _ROW + i)),
        splat8(load_float(scratch, _LEAVE + i)),
        splat8(load_float(scratch, _LEAVE + _ROW + i)),
        splat8(load_float(scratch, _LEAVE + 2 * _ROW + i)),
    )


@device
def _blocked_one_by_one(nodes, blocks, code, bundle, rays, scratch):
    """Those of the rays that meet a triangle below a node or in a leaf, each asked by itself."""
    blocked = _NO_RAYS
    while rays != 0:
        i = first_of(rays)
        rays &= rays - _ONE_RAY
        box, ray = _slabs(scratch, i), _sheared(scratch, bundle, i)
        if any_below(nodes, blocks, code, box, ray, bundle.limit, scratch, _SINGLES):
            blocked |= _ONE_RAY << i
    return blocked


@device
def _corner_from(blocks, scratch, at, corner, bundle):
    """Leave a corner of a block's triangles, from the origin, in the scratch; how far along the normal it is, less
    what the cone reaches below."""
    cone, o = bundle.cone, bundle.origin
    step = corner * (3 * LANES)
    x = load4(blocks, at + step) - splat4(o.x)
    y = load4(blocks, at + step + LANES) - splat4(o.y)
    z = load4(blocks, at + step + 2 * LANES) - splat4(o.z)
    store4(scratch, _CORNERS + step, x)
    store4(scratch, _CORNERS + step + LANES, y)
    store4(scratch, _CORNERS + step + 2 * LANES, z)
    up = splat4(cone.nx) * x + splat4(cone.ny) * y + splat4(cone.nz) * z
    return up + splat4(cone.below) * (absolute(x) + absolute(y) + absolute(z))


@device
def _reached_triangles(blocks, block, scratch, bundle):
    """Which triangles of a block the bundle may reach, as bits; their corners are left in the scratch."""
    at = block * BLOCK
    a = _corner_from(blocks, scratch, at, np.int64(0), bundle)
    b = _corner_from(blocks, scratch, at, np.int64(1), bundle)
    c = _corner_from(blocks, scratch, at, np.int64(2), bundle)
    # Places, and the sums above, are uncertain.
    return bits(maximum(a, maximum(b, c)) >= splat4(bundle.cone.place * np.float32(-3)))


@device
def _corner(scratch, corner, axis, lane):
    return splat16(load_float(scratch, _CORNERS + corner * (3 * LANES) + axis * LANES + lane))


@device
def _meet_triangle(scratch, lane, kx, ky, kz, sx, sy, sz, limit):
    """Which of sixteen rays meet triangle `lane` of the block in the scratch, as bits; see forms/triangle.py."""
    az, bz, cz = _corner(scratch, 0, kz, lane), _corner(scratch, 1, kz, lane), _corner(scratch, 2, kz, lane)
    ax = _corner(scratch, 0, kx, lane) - sx * az
    bx = _corner(scratch, 1, kx, lane) - sx * bz
    cx = _corner(scratch, 2, kx, lane) - sx * cz
    ay = _corner(scratch, 0, ky, lane) - sy * az
    by = _corner(scratch, 1, ky, lane) - sy * bz
    cy = _corner(scratch, 2, ky, lane) - sy * cz
    u = product_difference(cx, by, cy, bx)
    v = product_difference(ax, cy, ay, cx)
    w = product_difference(bx, ay, by, ax)
    zero = splat16(_ZERO)
    inside = (minimum(u, minimum(v, w)) >= zero) | (maximum(u, maximum(v, w)) <= zero)
    scale = splat16(_ONE) / (u + v + w)
    t = (u * az + v * bz + w * cz) * sz * scale
    return bits(inside & (t > zero) & (t < limit))


@device
def _blocked_along(scratch, kz, limit, rays, reached):
    """Those of the rays, all with directions longest along axis `kz`, that meet triangles of the block in scratch."""
    kx = np.int64(kz + 1 if kz < 2 else 0)
    ky = np.int64(kx + 1 if kx < 2 else 0)
    blocked = _NO_RAYS
    while rays != 0:
        column = first_of(rays) // _GROUP * _GROUP
        of_group = rays & (_LANES_OF_GROUP << column)
        rays &= ~of_group
        sx, sy, sz = (
            load16(scratch, _SHEARS + column),
            load16(scratch, _SHEARS + _ROW + column),
            load16(scratch, _SHEARS + 2 * _ROW + column),
        )
        left = reached
        met = np.int32(0)
        while left != 0:
            lane = np.int64(lowest_bit(left))
            left &= left - np.int32(1)
            met |= _meet_triangle(scratch, lane, kx, ky, kz, sx, sy, sz, splat16(limit))
        blocked |= (np.int64(met) << column) & of_group
    return blocked


@device
def _blocked_in_leaf(blocks, first, count, bundle, rays, scratch):
    """Those of the rays that meet a triangle in blocks first ≤ b < first + count."""
    if count_of(rays) <= _FEW_IN_LEAF:
        return _blocked_alone(blocks, first, count, bundle, rays, scratch)
    blocked = _NO_RAYS
    for block in range(first, first + count):
        left = rays & ~blocked
        reached = _reached_triangles(blocks, block, scratch, bundle)
        if reached == 0:
            continue
        blocked |= _blocked_along(scratch, np.int64(0), bundle.limit, left & bundle.along_x, reached)
        blocked |= _blocked_along(scratch, np.int64(1), bundle.limit, left & bundle.along_y, reached)
        blocked |= _blocked_along(scratch, np.int64(2), bundle.limit, left & bundle.along_z, reached)
    return blocked


@device
def _blocked_alone(blocks, first, count, bundle, rays, scratch):
    """`_blocked_in_leaf`, ray by ray."""
    blocked = _NO_RAYS
    while rays != 0:
        i = first_of(rays)
        rays &= rays - _ONE_RAY
        if meets_blocks(blocks, first, first + count, _sheared(scratch, bundle, i), bundle.limit):
            blocked |= _ONE_RAY << i
    return blocked


@device
def blocked_of_bundle(nodes, blocks, root, origin, normal, limit, count, along_x, along_y, scratch):
    """Which of the `count` rays whose directions are in the scratch meet a triangle at 0 < t < `limit`, as a set.

    All start at `origin`; the first `along_x` have directions longest along x, the next `along_y` along y, the others
    along z. `normal`, of length 1, is one that most of them lie above. `scratch` is float32 of BUNDLE_SCRATCH words.
    """
    reach = load_float(nodes, np.int64(root) * NODE + REACH)
    bundle = _prepare(scratch, count, along_x, along_y, origin, normal, limit, reach)
    free = leading(count)
    rays = free
    top = _STACK
    code = np.int32(root)
    while True:
        if code < 0:
            leaf = np.int64(-1) - np.int64(code)
            free &= ~_blocked_in_leaf(blocks, leaf >> 3, leaf & 7, bundle, rays, scratch)
        elif count_of(rays) <= _FEW:
            free &= ~_blocked_one_by_one(nodes, blocks, code, bundle, rays, scratch)
        else:
            code, rays, top = _descend(nodes, np.int64(code) * NODE, bundle, rays, scratch, top)
            if rays != 0:
                continue
        while True:
            if top == _STACK or free == 0:
                return leading(count) & ~free
            top -= _ENTRY
            rays = _rays_at(scratch, top) & free
            if rays != 0:
                code = load_int(scratch, top)
                break


@device
def _descend(nodes, base, bundle, rays, scratch, top):
    """(code, rays) of the child of a node that most of the rays enter, if any, and the new top of the stack, where the
    other children are."""
    reached = _reached_children(nodes, base, scratch, bundle)
    code, most, entering = np.int32(0), _NO_RAYS, _NO_RAYS
    while reached != 0:
        child = np.int64(lowest_bit(reached))
        reached &= reached - np.int32(1)
        entered = _rays_into_child(scratch, child, bundle.limit, rays)
        if entered == 0:
            continue
        other, count = load_int(nodes, base + CHILD + child), count_of(entered)
        if entering == 0:
            code, entering, most = other, entered, count
            continue
        more = count > most
        top = _push(scratch, top, code if more else other, entering if more else entered)
        code, entering, most = other if more else code, entered if more else entering, count if more else most
    return code, entering, top
