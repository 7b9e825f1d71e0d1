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

import numpy as np

from isophote.kernels.accel.bundle_leaf import blocked_in_leaf
from isophote.kernels.accel.bundle_rays import (
    FIRST_ENTRY,
    GROUP,
    GROUPS,
    INVERSE,
    LANES_OF_GROUP,
    NO_RAYS,
    ONE_RAY,
    PLANES,
    ROW,
    SINGLES,
    prepare_bundle,
    sheared_ray,
    slabs_of_ray,
)
from isophote.kernels.accel.bvh import FAR_SLACK, any_below
from isophote.kernels.accel.layout import CHILD, LOWER, NODE, REACH, UPPER, WIDTH
from isophote.kernels.base.bit_set import count_of, first_of, leading
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    bits,
    load8,
    load16,
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    splat8,
    splat16,
    store8,
    store_int,
)

__all__ = ["blocked_of_bundle"]

# So few rays below a node go on one by one.
_FEW = np.int64(8)
# Words of an entry of the stack.
_ENTRY = np.int64(3)
_ZERO = np.float32(0)
_LOW_WORD = np.int64(0xFFFFFFFF)


@device
def _axis_planes(nodes, base, scratch, at, origin, n, place):
    """Planes of a node's boxes across one axis, moved outward, as the origin sees them, to the scratch: how far boxes
    reach along the normal on this axis, how near and how far they are on it at least and at most."""
    low = load8(nodes, base + LOWER + at) - splat8(origin) - splat8(place)
    high = load8(nodes, base + UPPER + at) - splat8(origin) + splat8(place)
    store8(scratch, PLANES + at, low)
    store8(scratch, PLANES + 3 * WIDTH + at, high)
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
    at = PLANES + child
    lx, hx = splat16(load_float(scratch, at)), splat16(load_float(scratch, at + 3 * WIDTH))
    ly, hy = splat16(load_float(scratch, at + WIDTH)), splat16(load_float(scratch, at + 4 * WIDTH))
    lz, hz = splat16(load_float(scratch, at + 2 * WIDTH)), splat16(load_float(scratch, at + 5 * WIDTH))
    entered = NO_RAYS
    for group in range(GROUPS):
        column = group * GROUP
        if (rays >> column) & LANES_OF_GROUP == 0:
            continue
        x0, x1 = _slab(scratch, lx, hx, INVERSE + column)
        y0, y1 = _slab(scratch, ly, hy, INVERSE + ROW + column)
        z0, z1 = _slab(scratch, lz, hz, INVERSE + 2 * ROW + column)
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
def _blocked_one_by_one(nodes, blocks, code, bundle, rays, scratch):
    """Those of the rays that meet a triangle below a node or in a leaf, each asked by itself."""
    blocked = NO_RAYS
    while rays != 0:
        i = first_of(rays)
        rays &= rays - ONE_RAY
        box, ray = slabs_of_ray(scratch, i), sheared_ray(scratch, bundle, i)
        if any_below(nodes, blocks, code, box, ray, bundle.limit, scratch, SINGLES):
            blocked |= ONE_RAY << i
    return blocked


@device
def blocked_of_bundle(nodes, blocks, root, origin, normal, limit, count, along_x, along_y, scratch):
    """Which of the `count` rays whose directions are in the scratch meet a triangle at 0 < t < `limit`, as a set.

    All start at `origin`; the first `along_x` have directions longest along x, the next `along_y` along y, the others
    along z. `normal`, of length 1, is one that most of them lie above. `scratch` is float32 of BUNDLE_SCRATCH words.
    """
    reach = load_float(nodes, np.int64(root) * NODE + REACH)
    bundle = prepare_bundle(scratch, count, along_x, along_y, origin, normal, limit, reach)
    free = leading(count)
    rays = free
    top = FIRST_ENTRY
    code = np.int32(root)
    while True:
        if code < 0:
            leaf = np.int64(-1) - np.int64(code)
            free &= ~blocked_in_leaf(blocks, leaf >> 3, leaf & 7, bundle, rays, scratch)
        elif count_of(rays) <= _FEW:
            free &= ~_blocked_one_by_one(nodes, blocks, code, bundle, rays, scratch)
        else:
            code, rays, top = _descend(nodes, np.int64(code) * NODE, bundle, rays, scratch, top)
            if rays != 0:
                continue
        while True:
            if top == FIRST_ENTRY or free == 0:
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
    code, most, entering = np.int32(0), NO_RAYS, NO_RAYS
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
