"""Optics over arrays: what smooth boundaries reflect, and where they send the rest."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError

__all__ = ["fresnel"]

Array: TypeAlias = npt.NDArray[np.float64]

_UPRIGHT = math.pi / 2


def fresnel(
    angles: npt.ArrayLike, outside: npt.ArrayLike, inside: npt.ArrayLike, *, polarised: bool = False
) -> Array | tuple[Array, Array]:
    """The share of light that a smooth boundary reflects, from 0 to 1; the rest goes through.

    `angles` between the ray and the normal, in radians from 0 to π/2; `outside` and `inside` are the indices of
    refraction on the ray's side and beyond, `inside` complex, n + ik, for metals and all that absorbs. All are arrays
    that broadcast together. With η = inside / outside and m = √(η² − sin²θ),

        R_s = |(cosθ − m) / (cosθ + m)|²,  R_p = |(η² cosθ − m) / (η² cosθ + m)|²,  R = (R_s + R_p) / 2,

    of which R, for unpolarised light, is given, or with `polarised` the pair (R_s, R_p). Beyond the critical angle,
    where sinθ > η, all is reflected. R_p is 0 at Brewster's angle, atan η.

    Raises `SceneError` for angles out of range and indices whose real part is not above 0. Source: Born, Wolf,
    "Principles of Optics", 7th edition, sections 1.5 and 14.2.
    """
    theta = _angles(angles)
    eta = _index("inside", inside) / _real_index(outside)
    cosine = np.cos(theta)
    # As a sum in which nothing cancels where η is 1: m is the cosine then, and nothing is reflected.
    m = np.sqrt((eta - 1) * (eta + 1) + cosine**2)
    upright, flat = _share(cosine, m), _share(eta**2 * cosine, m)
    return (upright, flat) if polarised else (upright + flat) / 2


def _share(a: Any, b: Any) -> Array:
    """|(a − b) / (a + b)|², and 1 where both are 0: light along the boundary of equal media."""
    below = np.abs(a + b)
    result: Array = np.where(below > 0, np.abs(a - b) / np.where(below > 0, below, 1), 1.0) ** 2
    return result


def _angles(angles: npt.ArrayLike) -> Array:
    try:
        theta = np.asarray(angles, np.float64)
    except (TypeError, ValueError):
        raise SceneError(f"fresnel: angles must be numbers, not {angles!r}") from None
    if not ((theta >= 0) & (theta <= _UPRIGHT)).all():
        raise SceneError("fresnel: angles must be in radians from 0 to π/2, between the ray and the normal")
    return theta


def _index(name: str, value: npt.ArrayLike) -> npt.NDArray[np.complex128]:
    try:
        index = np.asarray(value, np.complex128)
    except (TypeError, ValueError):
        raise SceneError(f"fresnel: the index of refraction {name} must be numbers, not {value!r}") from None
    if not (np.isfinite(index).all() and (index.real > 0).all()):
        raise SceneError(f"fresnel: the index of refraction {name} must be finite and above 0, but is {value!r}")
    # Both signs of the imaginary part are in use; light falls off either way.
    result: npt.NDArray[np.complex128] = index.real + 1j * np.abs(index.imag)
    return result


def _real_index(value: npt.ArrayLike) -> Array:
    index = _index("outside", value)
    if index.imag.any():
        raise SceneError(f"fresnel: the medium outside, which light comes through, must be clear, but is {value!r}")
    return index.real
