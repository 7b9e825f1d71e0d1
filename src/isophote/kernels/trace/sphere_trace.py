"""Sphere tracing: the classic look of fields in real time.

Packets of 4 × 4 pixels are traced through the fields (sphere_march.py) and, for whatever else the scene holds, through
the tree of triangles. Where a ray has arrived, the crossing nearby is found exactly; a ray that only comes near goes
on. Light comes from points, suns and the middles of area lights, with hard or soft shadows, and from the sky by how
open the surroundings are:

    L_o = colour / π · Σ E cosθ shadow + colour · L_sky · openness
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel import field_layout as layout
from isophote.kernels.accel.field_chain import closest_field, field_occludes
from isophote.kernels.accel.field_march import slots_at, tape_at
from isophote.kernels.accel.geometry import SCRATCH_WORDS, Hit, closest_hit, occluded
from isophote.kernels.accel.surface import MATERIAL, PUBLIC, face_number, offset_point
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import load_float, lowest_bit, store_float
from isophote.kernels.base.vec import dot, length, store_vec3, vec3
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.light.bsdf import BLACK
from isophote.kernels.light.environment import environment_radiance
from isophote.kernels.primitive.chain import closest_primitive, primitive_occludes
from isophote.kernels.trace import sphere_pixels as pixel
from isophote.kernels.trace.camera import camera_ray
from isophote.kernels.trace.cone import pixel_cone
from isophote.kernels.trace.direct import surface_of
from isophote.kernels.trace.material import turned_normal
from isophote.kernels.trace.shading import surface_colour, surface_emission
from isophote.kernels.trace.sphere_lights import light_from
from isophote.kernels.trace.sphere_march import (
    EXIT,
    GROWTH,
    NEAR,
    SCALE,
    START,
    STEP,
    STEPS,
    T,
    enter_field,
    march_packet,
)
from isophote.kernels.trace.sphere_packet import LANES
from isophote.kernels.trace.sphere_pixels import keep_hit, kept_hit, lane_vec3, set_lane_vec3
from isophote.kernels.trace.sphere_shadow import (
    LIGHT,
    is_cut_field,
    load_shadow_ray,
    may_dim,
    occlude_packet,
    shade_packet,
)
from isophote.kernels.trace.sphere_tables import END, LEFT, MARCH, SHADOW_DIRECTION, SHADOW_START, SPHERE_PICTURE
from isophote.kernels.trace.tables import SCENE

__all__ = ["HARD", "NO_SHADOWS", "SOFT", "sphere_trace_tile"]

NO_SHADOWS, HARD, SOFT = 0, 1, 2

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_FAR = np.float32(np.inf)
_BIT, _NONE, _NO_SLOT = np.int32(1), np.int32(0), np.int64(-1)
_NO, _YES = np.int64(0), np.int64(1)
_AT, _ONE_SAMPLE = np.int64(SCRATCH_WORDS), np.int64(1)
# A shadow ray ends this much short of its light, in parts of its length.
_SHADOW_END = np.float32(1 - 1e-4)
_EDGE = np.int64(4)
# How far ahead of where a ray has arrived a crossing is looked for, in footprints: slanting rays need more of them.
_AHEAD = np.float32(16)
# How the camera's origins and directions change from pixel to pixel (camera.py).
_OX, _DX = np.int64(1), np.int64(6)

open_scene, open_march, open_picture = SCENE.open, MARCH.open, SPHERE_PICTURE.open


@device
def _step_length(camera, row):
    """How far a camera's row goes from one pixel to the next."""
    return length(vec3(camera[row, 0], camera[row, 1], camera[row, 2]))


@device
def _load_pixels(scene, march, picture, x0, y0, x1, y1):
    """Rays of a packet's pixels, and the triangles that they meet; bits of the pixels that lie in the tile."""
    active, pixels = _NONE, picture.pixels
    for lane in range(LANES):
        x, y = x0 + lane % _EDGE, y0 + lane // _EDGE
        store_float(picture.lanes, STEPS + lane, _ZERO)
        if x >= x1 or y >= y1:
            continue
        active |= _BIT << np.int32(lane)
        origin, direction = camera_ray(scene.camera, np.float32(x) + _HALF, np.float32(y) + _HALF, _ZERO, _ZERO)
        inverse = _ONE / length(direction)
        direction = direction * inverse
        set_lane_vec3(pixels, pixel.ORIGIN, lane, origin)
        set_lane_vec3(pixels, pixel.DIRECTION, lane, direction)
        store_float(pixels, pixel.DEPTH_SCALE + lane, inverse)
        hit = Hit(march.max_distance, _ZERO, _ZERO, _NO_SLOT, np.int64(0))
        if scene.geometry.blocks.rows > 0:
            hit = closest_hit(scene.geometry, origin, direction, march.max_distance, picture.scratch)
        hit = closest_primitive(scene.primitives, origin, direction, hit, picture.scratch)
        keep_hit(pixels, lane, hit)
    return active


@device
def _trace_field(scene, march, picture, k, active, slots):
    """Follow a packet's rays through field `k`, and keep what lies before what they have met."""
    fields, lanes, pixels = scene.fields, picture.lanes, picture.pixels
    still, turning = _step_length(scene.camera, _OX) * march.epsilon, _step_length(scene.camera, _DX) * march.epsilon
    inside = _NONE
    for lane in range(LANES):
        if (active >> np.int32(lane)) & _BIT == 0:
            continue
        origin, direction = lane_vec3(pixels, pixel.ORIGIN, lane), lane_vec3(pixels, pixel.DIRECTION, lane)
        best = load_float(pixels, pixel.DISTANCE + lane)
        if not enter_field(fields, k, lanes, lane, origin, direction, _ZERO, best):
            continue
        inside |= _BIT << np.int32(lane)
        growth = turning * load_float(pixels, pixel.DEPTH_SCALE + lane)
        start, scale = load_float(lanes, START + lane), load_float(lanes, SCALE + lane)
        store_float(lanes, GROWTH + lane, growth)
        store_float(lanes, NEAR + lane, (still + growth * start) * scale)
    root = np.int64(fields.numbers[k, layout.ROOT_TAPE])
    if march.step == _ZERO and not tape_at(fields, root, root).lipschitz < _FAR:
        _find_exactly(scene, picture, inside)
        return
    while inside != _NONE:
        arrived = march_packet(fields, k, lanes, inside, march, slots)
        inside = _NONE
        while arrived != _NONE:
            bit = arrived & -arrived
            lane = np.int64(lowest_bit(arrived))
            arrived &= arrived - _BIT
            if not _met(scene, march, picture, lane):
                inside |= bit


@device
def _find_exactly(scene, picture, inside):
    """Without a Lipschitz constant there are no spheres: the first crossing is found as other methods do."""
    pixels = picture.pixels
    for lane in range(LANES):
        if (inside >> np.int32(lane)) & _BIT:
            origin, direction = lane_vec3(pixels, pixel.ORIGIN, lane), lane_vec3(pixels, pixel.DIRECTION, lane)
            keep_hit(
                pixels, lane, closest_field(scene.fields, origin, direction, kept_hit(pixels, lane), picture.scratch)
            )


@device
def _met(scene, march, picture, lane):
    """Keep the crossing next to where a lane's ray has arrived. Where there is none, the ray has only come near: it is
    brought past what was looked through. Returns whether there is one."""
    lanes, pixels = picture.lanes, picture.pixels
    scale, at = load_float(lanes, SCALE + lane), load_float(lanes, T + lane)
    footprint = (load_float(lanes, NEAR + lane) + at * load_float(lanes, GROWTH + lane)) / scale
    t = load_float(lanes, START + lane) + at / scale
    back, ahead = (
        max(t - max(footprint, march.step), _ZERO),
        t + max(max(_AHEAD * footprint, load_float(lanes, STEP + lane) / scale), march.step),
    )
    origin, direction = lane_vec3(pixels, pixel.ORIGIN, lane), lane_vec3(pixels, pixel.DIRECTION, lane)
    limit = Hit(min(load_float(pixels, pixel.DISTANCE + lane), ahead) - back, _ZERO, _ZERO, _NO_SLOT, np.int64(0))
    hit = closest_field(scene.fields, origin + direction * back, direction, limit, picture.scratch)
    if hit.slot != _NO_SLOT:
        keep_hit(pixels, lane, Hit(back + hit.t, _ZERO, _ZERO, hit.slot, hit.instance))
        return True
    store_float(lanes, T + lane, at + (ahead - t) * scale)
    store_float(lanes, STEP + lane, _ZERO)
    # The region is looked up again, for the ray may have left it.
    store_float(lanes, EXIT + lane, _ZERO)
    return False


@device
def _write(picture, scene, y, x, lane, surface, normal, colour):
    distance = load_float(picture.pixels, pixel.DISTANCE + lane)
    picture.distance[y, x] = distance
    picture.depth[y, x] = distance * load_float(picture.pixels, pixel.DEPTH_SCALE + lane)
    _set(picture.normal, y, x, normal)
    _set(picture.albedo, y, x, colour)
    picture.uv[y, 2 * x], picture.uv[y, 2 * x + 1] = surface.u, surface.v
    picture.item[y, x] = scene.surfaces.items[surface.item, PUBLIC]
    picture.primitive[y, x] = face_number(scene.surfaces, surface.item, surface.triangle)


@device
def _set(rows, y, x, v):
    rows[y, 3 * x], rows[y, 3 * x + 1], rows[y, 3 * x + 2] = v.x, v.y, v.z


@device
def _surfaces(scene, picture, active, x0, y0):
    """What each pixel sees, into its channels and rows; bits of those whose surface reflects light."""
    lit, pixels = _NONE, picture.pixels
    for lane in range(LANES):
        if (active >> np.int32(lane)) & _BIT == 0:
            continue
        x, y = x0 + lane % _EDGE, y0 + lane // _EDGE
        picture.steps[y, x] = np.int32(load_float(picture.lanes, STEPS + lane))
        direction = lane_vec3(pixels, pixel.DIRECTION, lane)
        hit = kept_hit(pixels, lane)
        if hit.slot == _NO_SLOT:
            set_lane_vec3(pixels, pixel.GATHERED, lane, environment_radiance(scene.lights.environment, direction))
            continue
        origin = lane_vec3(pixels, pixel.ORIGIN, lane)
        surface = surface_of(scene, origin, direction, hit, picture.scratch)
        width, spread = pixel_cone(scene.camera, direction, _ONE_SAMPLE)
        radius = width + hit.t * spread
        seen = turned_normal(scene, surface, hit, direction, radius, picture.scratch)
        seen = seen if dot(surface.shading, direction) < _ZERO else -seen
        colour = surface_colour(scene, surface, hit, direction, radius, picture.scratch)
        emitted, two_sided = surface_emission(scene, surface, hit, direction, radius, picture.scratch)
        shines = two_sided or dot(direction, surface.normal) < _ZERO
        set_lane_vec3(pixels, pixel.GATHERED, lane, emitted if shines else vec3(_ZERO, _ZERO, _ZERO))
        set_lane_vec3(pixels, pixel.PLACE, lane, surface.place)
        set_lane_vec3(pixels, pixel.NORMAL, lane, seen)
        set_lane_vec3(pixels, pixel.COLOUR, lane, colour)
        store_float(pixels, pixel.ERROR + lane, surface.error)
        _write(picture, scene, y, x, lane, surface, seen, colour)
        if scene.materials.kinds[np.int64(scene.surfaces.items[surface.item, MATERIAL])] != BLACK:
            lit |= _BIT << np.int32(lane)
    return lit


@device
def _start(pixels, lane, direction):
    """Where a lane's shadow ray starts, off the surface."""
    place, normal = lane_vec3(pixels, pixel.PLACE, lane), lane_vec3(pixels, pixel.NORMAL, lane)
    return offset_point(place, normal, load_float(pixels, pixel.ERROR + lane), direction)


@device
def _light(scene, march, picture, number, lit, slots):
    """Add the light of one light to each pixel."""
    pixels, fields = picture.pixels, scene.fields
    open_lanes = _NONE
    for lane in range(LANES):
        store_float(pixels, pixel.OPEN + lane, _ONE)
        if (lit >> np.int32(lane)) & _BIT == 0:
            continue
        arriving = light_from(march.lights, number, lane_vec3(pixels, pixel.PLACE, lane), march.light_width)
        if (
            dot(lane_vec3(pixels, pixel.NORMAL, lane), arriving.direction) <= _ZERO
            or arriving.irradiance.x + (arriving.irradiance.y + arriving.irradiance.z) <= _ZERO
        ):
            continue
        if march.shadows != NO_SHADOWS and _blocked(scene, march, picture, lane, arriving):
            continue
        open_lanes |= _BIT << np.int32(lane)
    if march.shadows == SOFT:
        for k in range(fields.numbers.rows):
            if not is_cut_field(scene, k):
                _soften(scene, march, picture, number, k, open_lanes, slots)
    for lane in range(LANES):
        if (open_lanes >> np.int32(lane)) & _BIT:
            arriving = light_from(march.lights, number, lane_vec3(pixels, pixel.PLACE, lane), march.light_width)
            cosine = dot(lane_vec3(pixels, pixel.NORMAL, lane), arriving.direction)
            share = cosine * INV_PI * load_float(pixels, pixel.OPEN + lane)
            light = lane_vec3(pixels, pixel.COLOUR, lane) * arriving.irradiance * share
            set_lane_vec3(pixels, pixel.GATHERED, lane, lane_vec3(pixels, pixel.GATHERED, lane) + light)


@device
def _soften(scene, march, picture, number, k, open_lanes, slots):
    """Dim the light that the lanes `open_lanes` (bits) get of one light by what is near field `k`."""
    pixels, lanes, fields = picture.pixels, picture.lanes, scene.fields
    dimmed = _NONE
    for lane in range(LANES):
        if (open_lanes >> np.int32(lane)) & _BIT == 0:
            continue
        arriving = light_from(march.lights, number, lane_vec3(pixels, pixel.PLACE, lane), march.light_width)
        start = _start(pixels, lane, arriving.direction)
        if may_dim(fields, k, start, arriving.direction, arriving.width):
            load_shadow_ray(fields, k, lanes, lane, start, arriving.direction, arriving.distance, arriving.width)
            dimmed |= _BIT << np.int32(lane)
    shade_packet(fields, k, lanes, dimmed, march.max_steps, slots)
    while dimmed != _NONE:
        lane = np.int64(lowest_bit(dimmed))
        dimmed &= dimmed - _BIT
        left = min(load_float(pixels, pixel.OPEN + lane), load_float(lanes, LIGHT + lane))
        store_float(pixels, pixel.OPEN + lane, left)


@device
def _blocked(scene, march, picture, lane, arriving):
    """Whether anything stands between a pixel's surface and a light; fields only where shadows are hard."""
    start = _start(picture.pixels, lane, arriving.direction)
    end = _FAR if arriving.distance == _FAR else arriving.distance * _SHADOW_END
    # A light that is seen as a point has no soft shadow either.
    hard = march.shadows == HARD or arriving.width <= _ZERO
    if march.light_left != 0:
        left = _light_left(scene, march, picture, start, arriving.direction, end, hard)
        store_float(picture.pixels, pixel.OPEN + lane, left)
        return left <= _ZERO
    if scene.geometry.blocks.rows > 0 and occluded(scene.geometry, start, arriving.direction, end, picture.scratch):
        return True
    if primitive_occludes(scene.primitives, start, arriving.direction, end, picture.scratch):
        return True
    return hard and field_occludes(scene.fields, start, arriving.direction, end, picture.scratch)


@device
def _light_left(scene, march, picture, start, direction, end, hard):
    """The part of a light that is seen through holes."""
    ray = picture.shadow
    store_vec3(ray, SHADOW_START, start)
    store_vec3(ray, SHADOW_DIRECTION, direction)
    ray[END] = end
    call_entry(march.light_left, (table_address(scene), table_address(picture), _NO if hard else _YES))
    return ray[LEFT]


@device
def _sky(scene, march, picture, lit, slots):
    """Add the sky's light to each pixel."""
    pixels = picture.pixels
    if march.occlusion > _ZERO:
        occlude_packet(scene, picture.lanes, lit, pixels, march.occlusion, slots)
    for lane in range(LANES):
        if (lit >> np.int32(lane)) & _BIT:
            openness = load_float(pixels, pixel.OPEN + lane) if march.occlusion > _ZERO else _ONE
            radiance = environment_radiance(scene.lights.environment, lane_vec3(pixels, pixel.NORMAL, lane))
            light = lane_vec3(pixels, pixel.COLOUR, lane) * radiance * openness
            set_lane_vec3(pixels, pixel.GATHERED, lane, lane_vec3(pixels, pixel.GATHERED, lane) + light)


@kernel
def sphere_trace_tile(scene_words, march_words, picture_words, x0, x1, y0, y1):
    """Sphere-trace the pixels x0 ≤ x < x1, y0 ≤ y < y1; where nothing is met, channels but colour and steps keep what
    they hold."""
    scene, march, picture = open_scene(scene_words), open_march(march_words), open_picture(picture_words)
    slots = slots_at(scene.fields, element_address(picture.scratch, _AT))
    for py in range(y0, y1, _EDGE):
        for px in range(x0, x1, _EDGE):
            active = _load_pixels(scene, march, picture, px, py, x1, y1)
            for k in range(scene.fields.numbers.rows):
                _trace_field(scene, march, picture, k, active, slots)
            if march.pass_holes != 0:
                call_entry(march.pass_holes, (table_address(scene), table_address(march), table_address(picture)))
            lit = _surfaces(scene, picture, active, px, py)
            if lit != _NONE:
                for number in range(march.lights.rows):
                    _light(scene, march, picture, number, lit, slots)
                _sky(scene, march, picture, lit, slots)
            for lane in range(LANES):
                if (active >> np.int32(lane)) & _BIT:
                    gathered = lane_vec3(picture.pixels, pixel.GATHERED, lane)
                    _set(picture.colour, py + lane // _EDGE, px + lane % _EDGE, gathered)
