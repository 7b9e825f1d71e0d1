"""What a hit says about the surface: place, normals, texture coordinates, item, material."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.geometry import affine_point, affine_vector
from isophote.kernels.accel.layout import BLOCK, LANES, NUMBER
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int
from isophote.kernels.base.table import FLOAT_ROWS, FLOATS, INT_ROWS, INTS, Table
from isophote.kernels.base.vec import cross, dot, maximum_component, normalise, vec3

__all__ = [
    "SURFACES",
    "Surface",
    "blend_corners",
    "corner_at",
    "face_number",
    "item_of",
    "normal_to_world",
    "offset_point",
    "surface_at",
    "triangle_light",
    "triangle_number",
    "true_normal",
]

# Columns of `Surfaces.items`.
FIRST_TRIANGLE, MATERIAL, LIGHTS, NORMALS, UVS, FACES, FLIPPED, PUBLIC, TANGENTS = 0, 1, 2, 3, 4, 5, 6, 7, 8
ITEM_COLUMNS = 9

_ZERO, _ONE = np.float32(0), np.float32(1)
# Rounding of a hit's place in units of 2^-24 times the largest coordinate of its triangle, with room to spare.
PLACE_ERROR = np.float32(32 * 2.0**-24)
# How many of its errors a place is pulled in from the rim of its triangle, and the most in parts of the triangle.
PULL, MOST_PULL = np.float32(4), np.float32(1 / 16)
THIRD = np.float32(1 / 3)
# So many items are counted, to find that of a triangle.
_FEW_ITEMS = 16


# What belongs to triangles apart from their corners.
# `items` (n, 9): first triangle of the item within its object, material, and the first rows of its lights, normals,
# texture coordinates and faces below (−1: none), 1 where its corners were placed by a transform that mirrors, its
# number for the user, and the first row of its tangents, which only items with a normal map have.
# `spans` (instances, 2): first item and number of items of each instance.
# `slack` (instances,): rounding of places on instances that are not in the world's place, in the world's units.
# `normals` (k, 3), `uvs` (k, 2), `tangents` (k, 4) with `normal_corners`, `uv_corners`, `tangent_corners` (t, 3), the
# rows of a triangle's three corners; the fourth number of a tangent is the sign of n × t along the other axis;
# `faces` (t,): face of each triangle; `triangle_lights` (t,): light of each triangle, or −1.
SURFACES = Table(
    "Surfaces",
    items=INT_ROWS,
    spans=INT_ROWS,
    slack=FLOATS,
    normals=FLOAT_ROWS,
    normal_corners=INT_ROWS,
    uvs=FLOAT_ROWS,
    uv_corners=INT_ROWS,
    tangents=FLOAT_ROWS,
    tangent_corners=INT_ROWS,
    faces=INTS,
    triangle_lights=INTS,
)


class Surface(NamedTuple):
    """A place on an item. `normal` is the geometric one and points outward; `shading` is the interpolated one, on the
    same side. `error` bounds the distance of `place` from the true surface. `u`, `v`: texture coordinates."""

    place: object
    normal: object
    shading: object
    error: float
    u: float
    v: float
    item: int
    triangle: int


@device
def corner_at(blocks, at):
    """The corner whose first coordinate is word `at` of leaf blocks."""
    return vec3(load_float(blocks, at), load_float(blocks, at + LANES), load_float(blocks, at + 2 * LANES))


@device
def item_of(surfaces, instance, triangle):
    """The item that triangle number `triangle` of an instance's object belongs to."""
    low, count = np.int64(surfaces.spans[instance, 0]), np.int64(surfaces.spans[instance, 1])
    # Few are counted: halving is by branches, which are guessed wrong half the time.
    while count > _FEW_ITEMS:
        half = count >> 1
        low += half if surfaces.items[low + half, FIRST_TRIANGLE] <= triangle else 0
        count -= half
    item = low
    for k in range(1, count):
        item += surfaces.items[low + k, FIRST_TRIANGLE] <= triangle
    return item


@device
def triangle_light(surfaces, item, triangle):
    """Number of the light that a triangle is, or −1."""
    first = surfaces.items[item, LIGHTS]
    return np.int64(surfaces.triangle_lights[first + triangle]) if first >= 0 else np.int64(-1)


@device
def face_number(surfaces, item, triangle):
    """Number of the mesh's face that a triangle is part of."""
    first = surfaces.items[item, FACES]
    return np.int64(surfaces.faces[first + triangle]) if first >= 0 else np.int64(triangle)


@device
def blend_corners(rows, corners, at, w0, w1, w2):
    """What rows hold for the three corners of triangle `at`, weighed."""
    a, b, c = corners[at, 0], corners[at, 1], corners[at, 2]
    return vec3(
        rows[a, 0] * w0 + rows[b, 0] * w1 + rows[c, 0] * w2,
        rows[a, 1] * w0 + rows[b, 1] * w1 + rows[c, 1] * w2,
        rows[a, 2] * w0 + rows[b, 2] * w1 + rows[c, 2] * w2,
    )


@device
def normal_to_world(geometry, instance, n):
    """Normals go by the transposed inverse: n · M⁻¹."""
    m = geometry.to_object
    return vec3(
        m[instance, 0] * n.x + m[instance, 4] * n.y + m[instance, 8] * n.z,
        m[instance, 1] * n.x + m[instance, 5] * n.y + m[instance, 9] * n.z,
        m[instance, 2] * n.x + m[instance, 6] * n.y + m[instance, 10] * n.z,
    )


@device
def _shading_normal(geometry, surfaces, instance, at, w0, w1, w2, normal):
    """The interpolated normal on the side of the geometric one, or that one where there is nothing to interpolate."""
    blended = blend_corners(surfaces.normals, surfaces.normal_corners, at, w0, w1, w2)
    if geometry.identity[instance] == 0:
        blended = normal_to_world(geometry, instance, blended)
    size2 = dot(blended, blended)
    if not size2 > _ZERO:
        return normal
    shading = normalise(blended)
    return shading if dot(shading, normal) >= _ZERO else -shading


@device
def _oriented_normal(geometry, surfaces, instance, item, a, b, c):
    """Unit normal of the triangle a, b, c of an instance's object in the world, outward."""
    normal = cross(b - a, c - a)
    if geometry.identity[instance] == 0:
        normal = normal_to_world(geometry, instance, normal)
    normal = normalise(normal)
    return -normal if surfaces.items[item, FLIPPED] != 0 else normal


@device
def true_normal(geometry, surfaces, hit, item):
    """Unit geometric normal of a `Hit`, outward."""
    blocks = geometry.blocks
    at = hit.slot // LANES * BLOCK + hit.slot % LANES
    a, b, c = corner_at(blocks, at), corner_at(blocks, at + 3 * LANES), corner_at(blocks, at + 6 * LANES)
    return _oriented_normal(geometry, surfaces, hit.instance, item, a, b, c)


@device
def triangle_number(geometry, slot):
    """Number of a hit's triangle within its object."""
    return np.int64(load_int(geometry.blocks, slot // LANES * BLOCK + slot % LANES + NUMBER))


@device
def surface_at(geometry, surfaces, hit):
    """The `Surface` of a `Hit`."""
    blocks, instance = geometry.blocks, hit.instance
    block = hit.slot // LANES
    at = block * BLOCK + hit.slot % LANES
    a, b, c = corner_at(blocks, at), corner_at(blocks, at + 3 * LANES), corner_at(blocks, at + 6 * LANES)
    number = np.int64(load_int(blocks, at + NUMBER))
    w1, w2 = hit.weight1, hit.weight2
    w0 = _ONE - w1 - w2
    edge1, edge2 = b - a, c - a
    if geometry.identity[instance] != 0:
        error = max(_reach(a), max(_reach(b), _reach(c))) * PLACE_ERROR
        place = _pulled_in(a, b, c, w0, w1, w2, error / max(_reach(edge1), _reach(edge2)))
    else:
        error = surfaces.slack[instance]
        matrices = geometry.to_world
        edge1, edge2 = affine_vector(matrices, instance, edge1), affine_vector(matrices, instance, edge2)
        place = _pulled_in(a, b, c, w0, w1, w2, error / max(_reach(edge1), _reach(edge2)))
        place = affine_point(geometry.to_world, instance, place)
    item = item_of(surfaces, instance, number)
    triangle = number - surfaces.items[item, FIRST_TRIANGLE]
    normal = _oriented_normal(geometry, surfaces, instance, item, a, b, c)
    shading = normal
    first = surfaces.items[item, NORMALS]
    if first >= 0:
        shading = _shading_normal(geometry, surfaces, instance, first + triangle, w0, w1, w2, normal)
    u, v = w1, w2
    first = surfaces.items[item, UVS]
    if first >= 0:
        p, q, r = (
            surfaces.uv_corners[first + triangle, 0],
            surfaces.uv_corners[first + triangle, 1],
            surfaces.uv_corners[first + triangle, 2],
        )
        uvs = surfaces.uvs
        u = uvs[p, 0] * w0 + uvs[q, 0] * w1 + uvs[r, 0] * w2
        v = uvs[p, 1] * w0 + uvs[q, 1] * w1 + uvs[r, 1] * w2
    return Surface(place, normal, shading, error, u, v, item, triangle)


@device
def _pulled_in(a, b, c, w0, w1, w2, error):
    """The place with these weights, moved toward the triangle's middle by a few times its error (here in parts of the
    triangle): at an edge, rounding could put it behind the next triangle."""
    pull = min(error * PULL, MOST_PULL)
    w0, w1, w2 = w0 + (THIRD - w0) * pull, w1 + (THIRD - w1) * pull, w2 + (THIRD - w2) * pull
    return w0 * a + w1 * b + w2 * c


@device
def _reach(p):
    return maximum_component(vec3(abs(p.x), abs(p.y), abs(p.z)))


@device
def offset_point(place, normal, error, direction):
    """`place` moved off the surface by its error, to the side that `direction` goes to, so that a ray from there does
    not meet the surface again. Each coordinate's own rounding is covered by `error`."""
    side = error if dot(normal, direction) >= _ZERO else -error
    return place + normal * side
