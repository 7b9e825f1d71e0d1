"""The patch of a surface that a ray cone covers, and how much the surface bends under it.

write_footprint(scene, scratch)        the half-axes in the record that textures are asked with
curvature_at(scene, scratch)           an entry: the sum of the principal curvatures, for cones that go on

A cone cuts the tangent plane in an ellipse: as wide as the cone across the plane of incidence, and wider by one over
the cosine along it. Texture coordinates of triangles change evenly; those of primitives are asked a little beside.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.field_chain import surface_of_field
from isophote.kernels.accel.field_layout import FIELD
from isophote.kernels.accel.geometry import Hit, affine_vector
from isophote.kernels.accel.layout import BLOCK, LANES
from isophote.kernels.accel.surface import NORMALS, UVS, normal_to_world
from isophote.kernels.base.entry import element_address, entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int
from isophote.kernels.base.vec import cross, dot, length, load_vec3, orthonormal, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.primitive.chain import surface_of_primitive
from isophote.kernels.primitive.layout import BALL, OWN_AT
from isophote.kernels.texture import contract as texture
from isophote.kernels.trace.tables import SCENE

__all__ = ["curvature_at", "write_footprint", "write_uv_axes"]

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_FAR = np.float32(np.inf)
_WORDS, _FIELD, _PLACE = np.int64(contract.WORDS), np.int64(FIELD), np.int64(contract.TEXTURE_PLACE)
_UVS, _NORMALS, _BALL_RADIUS, _OWN_WORDS = np.int64(UVS), np.int64(NORMALS), np.int64(BALL + 3), np.int64(OWN_AT)
# Cosine below which an ellipse grows no longer.
_LEAST_COSINE = np.float32(2.0**-10)
# How far beside a hit a primitive is asked at most, in parts of its size, and what is endless or a field at least, in
# parts of the distance from the origin.
_BESIDE, _BESIDE_FIELD = np.float32(2.0**-7), np.float32(2.0**-10)

_scene_at = opener_at(SCENE)


# --- triangles --------------------------------------------------------------------------------------------------------


@device
def _corner(blocks, at, k):
    at += 3 * LANES * k
    return vec3(load_float(blocks, at), load_float(blocks, at + LANES), load_float(blocks, at + 2 * LANES))


@device
def _edges(scene, slot, instance):
    """The two edges from a triangle's first corner, in the world."""
    geometry = scene.geometry
    at = slot // LANES * BLOCK + slot % LANES
    a = _corner(geometry.blocks, at, 0)
    edge1, edge2 = _corner(geometry.blocks, at, 1) - a, _corner(geometry.blocks, at, 2) - a
    if geometry.identity[instance] != 0:
        return edge1, edge2
    return affine_vector(geometry.to_world, instance, edge1), affine_vector(geometry.to_world, instance, edge2)


@device
def _weights_along(edge1, edge2, v):
    """How the weights of the second and third corner change along `v`, in the triangle's plane."""
    normal = cross(edge1, edge2)
    size2 = dot(normal, normal)
    inverse = _ONE / size2 if size2 > _ZERO else _ZERO
    return dot(cross(v, edge2), normal) * inverse, dot(cross(edge1, v), normal) * inverse


@device
def _write_triangle_uv(scene, slot, instance, scratch, a, b):
    edge1, edge2 = _edges(scene, slot, instance)
    surfaces = scene.surfaces
    first = np.int64(surfaces.items[np.int64(load_int(scratch, contract.ITEM)), _UVS])
    u1, v1, u2, v2 = _ONE, _ZERO, _ZERO, _ONE
    if first >= 0:
        row = first + np.int64(load_int(scratch, contract.TRIANGLE))
        p, q, r = surfaces.uv_corners[row, 0], surfaces.uv_corners[row, 1], surfaces.uv_corners[row, 2]
        uvs = surfaces.uvs
        u1, v1 = uvs[q, 0] - uvs[p, 0], uvs[q, 1] - uvs[p, 1]
        u2, v2 = uvs[r, 0] - uvs[p, 0], uvs[r, 1] - uvs[p, 1]
    for at, v in ((_PLACE + texture.AXIS_A, a), (_PLACE + texture.AXIS_B, b)):
        w1, w2 = _weights_along(edge1, edge2, v)
        scratch[at], scratch[at + 1] = w1 * u1 + w2 * u2, w1 * v1 + w2 * v2


@device
def _triangle_bend(scene, slot, instance, scratch, a, b):
    """Sum of the principal curvatures of the interpolated normals, positive where they spread."""
    surfaces = scene.surfaces
    first = np.int64(surfaces.items[np.int64(load_int(scratch, contract.ITEM)), _NORMALS])
    if first < 0:
        return _ZERO
    row = first + np.int64(load_int(scratch, contract.TRIANGLE))
    p, q, r = surfaces.normal_corners[row, 0], surfaces.normal_corners[row, 1], surfaces.normal_corners[row, 2]
    normals = surfaces.normals
    base = vec3(normals[p, 0], normals[p, 1], normals[p, 2])
    n1, n2 = vec3(normals[q, 0], normals[q, 1], normals[q, 2]), vec3(normals[r, 0], normals[r, 1], normals[r, 2])
    size = length(base)
    if not size > _ZERO:
        return _ZERO
    edge1, edge2 = _edges(scene, slot, instance)
    if scene.geometry.identity[instance] == 0:
        base = normal_to_world(scene.geometry, instance, base)
        n1 = normal_to_world(scene.geometry, instance, n1)
        n2 = normal_to_world(scene.geometry, instance, n2)
        size = length(base)
    change1, change2 = (n1 - base) / size, (n2 - base) / size
    side = _ONE if dot(base, load_vec3(scratch, contract.OUTWARD)) >= _ZERO else -_ONE
    w1, w2 = _weights_along(edge1, edge2, a)
    bend = dot(change1 * w1 + change2 * w2, a)
    w1, w2 = _weights_along(edge1, edge2, b)
    return (bend + dot(change1 * w1 + change2 * w2, b)) * side


# --- primitives and fields --------------------------------------------------------------------------------------------


@device
def _primitive_beside(scene, slot, instance, scratch, place):
    """The `Surface` of a primitive next to a place beside it."""
    own = floats_at(element_address(scratch, _WORDS), _OWN_WORDS)
    direction = load_vec3(scratch, contract.DIRECTION)
    return surface_of_primitive(scene.primitives, place, direction, Hit(_ZERO, _ZERO, _ZERO, slot, instance), own)


@device
def _field_beside(scene, slot, instance, scratch, place):
    """As `_primitive_beside`, of a field."""
    hit = Hit(_ZERO, _ZERO, _ZERO, slot, instance)
    return surface_of_field(scene.fields, place, load_vec3(scratch, contract.DIRECTION), hit, scratch)


@device
def _most_beside(scene, instance):
    """How far beside a hit a primitive is asked at most."""
    size = np.float32(scene.primitives.reach[instance, _BALL_RADIUS])
    return size * _BESIDE if size < _FAR else _FAR


@device
def _unwound(difference):
    """A difference of coordinates that go round, from 1 on to 0."""
    return difference - np.float32(round(difference)) if abs(difference) > _HALF else difference


@device
def _write_primitive_uv(scene, slot, instance, scratch, a, b):
    place = load_vec3(scratch, contract.PLACE)
    most = _most_beside(scene, instance)
    for at, v in ((_PLACE + texture.AXIS_A, a), (_PLACE + texture.AXIS_B, b)):
        size = length(v)
        part = min(_ONE, most / size) if size > _ZERO else _ONE
        surface = _primitive_beside(scene, slot, instance, scratch, place + v * part)
        inverse = _ONE / part
        scratch[at] = _unwound(surface.u - scratch[contract.U]) * inverse
        scratch[at + 1] = _unwound(surface.v - scratch[contract.V]) * inverse


@device
def _direct_bend(scene, slot, instance, scratch, a, b):
    """As `_triangle_bend`, of primitives and fields, by the normals beside the hit; `a` and `b` are unit vectors."""
    place, normal = load_vec3(scratch, contract.PLACE), load_vec3(scratch, contract.OUTWARD)
    bend = _ZERO
    primitive = slot > _FIELD
    step = _most_beside(scene, instance) if primitive else _FAR
    if not step < _FAR:
        step = max(scratch[contract.RADIUS], length(place) * _BESIDE_FIELD)
    if not step > _ZERO:
        return bend
    for v in (a, b):
        if primitive:
            beside = _primitive_beside(scene, slot, instance, scratch, place + v * step)
        else:
            beside = _field_beside(scene, slot, instance, scratch, place + v * step)
        bend += dot(beside.normal - normal, v)
    return bend / step


# --- both -------------------------------------------------------------------------------------------------------------


@device
def _half_axes(direction, normal, radius):
    """Half-axes of the ellipse in which a cone of so much half-width cuts the tangent plane."""
    cosine = dot(direction, normal)
    along = direction - normal * cosine
    size = length(along)
    if size > _LEAST_COSINE:
        along = along * (_ONE / size)
        across = cross(normal, along)
    else:
        along, across = orthonormal(normal)
    return along * (radius / max(abs(cosine), _LEAST_COSINE)), across * radius


@device
def write_uv_axes(scene, scratch, a, b):
    """Write how texture coordinates change along `a` and `b`, small vectors in the tangent plane, as if these were the
    half-axes of the footprint."""
    slot, instance = np.int64(load_int(scratch, contract.HIT_SLOT)), np.int64(load_int(scratch, contract.HIT_INSTANCE))
    if slot >= 0:
        _write_triangle_uv(scene, slot, instance, scratch, a, b)
    elif slot > _FIELD:
        _write_primitive_uv(scene, slot, instance, scratch, a, b)


@device
def write_footprint(scene, scratch):
    """Write the half-axes of what the cone of half-width RADIUS covers of the surface in the scratch."""
    radius = scratch[contract.RADIUS]
    if not radius > _ZERO:
        return
    item, normal = np.int64(load_int(scratch, contract.ITEM)), load_vec3(scratch, contract.OUTWARD)
    a, b = _half_axes(load_vec3(scratch, contract.DIRECTION), normal, radius)
    store_vec3(scratch, _PLACE + texture.WORLD_A, a)
    store_vec3(scratch, _PLACE + texture.WORLD_B, b)
    store_vec3(scratch, _PLACE + texture.OWN_A, affine_vector(scene.textures.to_own, item, a))
    store_vec3(scratch, _PLACE + texture.OWN_B, affine_vector(scene.textures.to_own, item, b))
    write_uv_axes(scene, scratch, a, b)


@entry
def curvature_at(scene_words, scratch_address):
    """Leave in CURVATURE the sum of the principal curvatures of the surface in the scratch, positive where it bulges
    outward."""
    scene, scratch = _scene_at(scene_words), floats_at(scratch_address, _WORDS)
    slot = np.int64(load_int(scratch, contract.HIT_SLOT))
    instance = np.int64(load_int(scratch, contract.HIT_INSTANCE))
    a, b = orthonormal(load_vec3(scratch, contract.OUTWARD))
    if slot >= 0:
        scratch[contract.CURVATURE] = _triangle_bend(scene, slot, instance, scratch, a, b)
    else:
        scratch[contract.CURVATURE] = _direct_bend(scene, slot, instance, scratch, a, b)
    return 0
