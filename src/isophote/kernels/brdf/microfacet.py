"""Trowbridge and Reitz's microfacets (GGX), anisotropic, and their visible normals.

    D(h) = 1 / (π αx αy (hx²/αx² + hy²/αy² + hz²)²)
    G1(v) = 2 / (1 + √(1 + (αx² vx² + αy² vy²) / vz²)),   G = G1(out) G1(into)

Sources: Walter et al.: "Microfacet Models for Refraction", EGSR 2007; Heitz: "Sampling the GGX Distribution of Visible
Normals", JCGT 7(4), 2018; Dupuy, Benyoub: "Sampling Visible GGX Normals with Spherical Caps", HPG 2023.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import normalise, vec3
from isophote.kernels.base.warp import INV_PI

__all__ = ["alpha_of", "density_of_normals", "masking", "visible_normal"]

_ZERO, _ONE, _TWO = np.float32(0), np.float32(1), np.float32(2)
_TINY = np.float32(1e-30)
# Below it, single precision cannot tell the distribution's slope; what is meant to be smooth is a branch.
_LEAST_ALPHA = np.float32(1e-3)


@device
def alpha_of(roughness):
    """α = roughness², at most 1, and not less than single precision can tell."""
    return min(max(roughness * roughness, _LEAST_ALPHA), _ONE)


@device
def density_of_normals(h, ax, ay):
    """D(h): area of microfacets with normal `h` for each steradian and area of the surface."""
    x, y = h.x / ax, h.y / ay
    t = x * x + y * y + h.z * h.z
    return INV_PI / (ax * ay * t * t)


@device
def masking(v, ax, ay):
    """G1(v): the part of microfacets facing `v` that is seen from there."""
    x, y = ax * v.x, ay * v.y
    z2 = v.z * v.z
    return _TWO / (_ONE + math.sqrt(_ONE + (x * x + y * y) / max(z2, _TINY)))


@device
def visible_normal(out, ax, ay, x, y):
    """A normal with density G1(out) D(h) (out · h)⁺ / out.z, from a point of the unit disk.

    In the space where the distribution is a hemisphere, the reflected ray of a visible normal is uniform in a cap of
    the sphere: its height goes with the squared radius of the point, its angle is that of the point.
    """
    o = normalise(vec3(ax * out.x, ay * out.y, out.z))
    r2 = x * x + y * y
    z = (_ONE - r2) * (_ONE + o.z) - o.z
    s = math.sqrt(max(_ZERO, (_ONE - z) * (_ONE + z)) / max(r2, _TINY))
    return normalise(vec3(ax * (s * x + o.x), ay * (s * y + o.y), max(z + o.z, _TINY)))
