"""Ray cones: how wide the bundle of light is that a ray stands for.

A cone has a signed half-width w where its ray begins and a spread s, so that it is |w + t s| wide after t. The camera's
cones fill the pixel, or as much of it as falls to one of its samples. At smooth surfaces they turn as light does near
the ray (Coddington's equations; as cones: Akenine-Möller et al., "Improved Shader and Texture Level of Detail Using Ray
Cones", JCGT 10(1), 2021), H being the mean curvature, η the ratio of indices, θ and θ′ the angles on both sides:

    s′ = s + 2 H w        s′ = (η s cosθ + (η cosθ − cosθ′) H w) / √(cosθ cosθ′)

The first is the mean of what happens along and across the plane of incidence, the second between both.

Scattered rays stand for what falls to a sample of all directions, a solid angle of one over their density. Scenes
without textures have no cones.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.accel.surface import MATERIAL
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device, exact_apart
from isophote.kernels.base.vec import cross, dot, length, vec3
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.brdf import contract
from isophote.kernels.light.bsdf import GLASS
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.shading import write_surface
from isophote.kernels.trace.wave import row_vec3

__all__ = ["carry_cone", "carry_scattered_cone", "cone_radius", "leaving_cone", "pixel_cone", "start_cones"]

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
# Rows of the camera (camera.py).
_OX, _OY, _DX, _DY = np.int64(1), np.int64(2), np.int64(6), np.int64(7)
# A pixel's samples share it among them, but beyond so many all stay as wide: narrower ones would show no more.
_LEAST_SHARE = np.float32(1 / 8)
_WIDEST = np.float32(0.5)
# Rays that go on by less than this from straight are not bent, and sines below which indices are not told by them.
_STRAIGHT, _LEAST_SINE = np.float32(1 - 1e-6), np.float32(0.03)
_START, _IOR = np.int64(0), np.int64(6)


@device
def _camera_row(camera, k):
    return vec3(camera[k, 0], camera[k, 1], camera[k, 2])


@device
def _share(samples):
    """Width of what falls to one of so many samples, in parts of the whole."""
    return max(_LEAST_SHARE, _ONE / math.sqrt(np.float32(samples)))


@device
def pixel_cone(camera, direction, samples):
    """(half-width, spread) of the cone about a camera ray of unit `direction`, for a pixel of so many samples."""
    across, along = _camera_row(camera, _DX), _camera_row(camera, _DY)
    axis = cross(across, along)
    area = length(axis)
    still = length(cross(_camera_row(camera, _OX), _camera_row(camera, _OY)))
    # A pixel is seen under the solid angle area · cos³ of the angle to the axis.
    cosine = abs(dot(axis, direction)) / area if area > _ZERO else _ZERO
    half = _HALF * _share(samples)
    return half * math.sqrt(still), half * math.sqrt(area * cosine) * cosine


@device
def start_cones(scene, plan, wave, count):
    """Begin the cones of the camera rays in wave columns 0 … count − 1."""
    floats = wave.floats
    for i in range(count):
        width, spread = pixel_cone(scene.camera, row_vec3(floats, rows.DIRECTION, i), plan.samples)
        floats[rows.WIDTH, i], floats[rows.SPREAD, i] = width, spread


@device
def cone_radius(wave, i, t):
    """Half-width of the cone in wave column `i` after `t`."""
    return abs(wave.floats[rows.WIDTH, i] + t * wave.floats[rows.SPREAD, i])


@device
def _eta(scene, surface, direction, cosine, after):
    """Index of refraction before a surface over that behind it, by the sines that a ray makes on both sides."""
    before2, after2 = _ONE - cosine * cosine, _ONE - after * after
    if before2 > _LEAST_SINE * _LEAST_SINE:
        return math.sqrt(max(after2, _ZERO) / before2)
    material = np.int64(scene.surfaces.items[surface.item, MATERIAL])
    if scene.materials.kinds[material] != GLASS:
        return _ONE
    ior = scene.materials.values[material, _IOR]
    return _ONE / ior if dot(direction, surface.normal) < _ZERO else ior


@device
def _turned(scene, surface, hit, direction, into, width, spread, scratch):
    """The spread after a smooth surface, where the cone is `width` wide."""
    if dot(direction, into) > _STRAIGHT:
        return spread
    write_surface(scene, surface, hit, direction, abs(width), scratch)
    call_entry(scene.textures.curvature, (table_address(scene), element_address(scratch, _START)))
    bend = _HALF * scratch[contract.CURVATURE]
    before, after = dot(direction, surface.shading), dot(into, surface.shading)
    bend = bend * width if before < _ZERO else -bend * width
    if before * after < _ZERO:
        return spread + bend + bend
    cosine, after = abs(before), abs(after)
    eta = _eta(scene, surface, direction, cosine, after)
    return (eta * cosine * spread + (eta * cosine - after) * bend) / math.sqrt(max(cosine * after, _LEAST_SINE))


@device
def _scattered(plan, width, spread, density):
    """(half-width, spread) of a cone after scattering of some density where it is `width` wide."""
    share = _share(plan.samples)
    return abs(width), min(math.sqrt(spread * spread + share * share * INV_PI / density), _WIDEST)


@exact_apart
def _leaving(scene, plan, wave, i, surface, hit, direction, into, density):
    """What `leaving_cone` tells where there are textures. Apart, so that tiles without have nothing of it."""
    spread = wave.floats[rows.SPREAD, i]
    width = wave.floats[rows.WIDTH, i] + hit.t * spread
    if density == _ZERO:
        return width, _turned(scene, surface, hit, direction, into, width, spread, wave.scratch)
    return _scattered(plan, width, spread, density)


@device
def leaving_cone(scene, plan, wave, i, surface, hit, direction, into, density):
    """(half-width, spread) of the cone that goes on to `into` where that in wave column `i` met a surface; `density` is
    that of the scattering, 0 where it is smooth."""
    if scene.textures.nodes.rows == 0:
        return _ZERO, _ZERO
    return _leaving(scene, plan, wave, i, surface, hit, direction, into, density)


@device
def carry_scattered_cone(scene, plan, wave, i, to, t, density):
    """Let the cone in wave column `i` go on in column `to` from where it was scattered after `t`."""
    if scene.textures.nodes.rows > 0:
        floats = wave.floats
        spread = floats[rows.SPREAD, i]
        width, spread = _scattered(plan, floats[rows.WIDTH, i] + t * spread, spread, density)
        floats[rows.WIDTH, to], floats[rows.SPREAD, to] = width, spread


@device
def carry_cone(scene, plan, wave, i, to, surface, hit, direction, into, density):
    """Let the cone in wave column `i` go on in column `to`."""
    if scene.textures.nodes.rows > 0:
        width, spread = _leaving(scene, plan, wave, i, surface, hit, direction, into, density)
        wave.floats[rows.WIDTH, to], wave.floats[rows.SPREAD, to] = width, spread
