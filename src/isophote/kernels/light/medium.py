"""Clear media: which one a ray is in, and what it loses on its way.

Solids of glass may lie within each other or overlap. A ray carries the media that it is inside of, and the one of the
highest priority is the one that counts, or of several the one entered last (Schmidt, Budge: "Simple Nested Dielectrics
in Ray Traced Images", JGT 7(2), 2002). So a surface within a medium of higher priority is none to the ray.

The list is one int64 of four numbers of 16 bits, the medium entered last in the lowest; of more than four media one
inside another the oldest is forgotten. Number 0 is the air around everything.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.table import FLOAT_ROWS, INTS, Table
from isophote.kernels.base.vec import dot, vec3
from isophote.kernels.light.air import AIR

__all__ = [
    "MEDIA",
    "Boundary",
    "attenuation",
    "current_medium",
    "medium_ior",
    "medium_towards",
    "meet_boundary",
    "surface_boundary",
]

_BITS, _ONE_ENTRY, _OTHERS = np.int64(16), np.int64(0xFFFF), np.int64(0xFFFFFFFFFFFF)
_IOR, _PRIORITY, _ABSORPTION = np.int64(0), np.int64(1), np.int64(2)

_ZERO, _ONE = np.float32(0), np.float32(1)


# `of_material` (materials,): number of the medium behind surfaces of each material, or 0; `values` (media, 5): index of
# refraction, priority, absorption coefficient in 1/m by channels; row 0 is air, and `air` what that does to light.
MEDIA = Table("Media", of_material=INTS, values=FLOAT_ROWS, air=AIR)


class Boundary(NamedTuple):
    """The media before and behind a surface on the way of a ray, and the list of a ray that went through."""

    before: int
    behind: int
    inside: int


@device
def current_medium(media, inside):
    """The medium that a ray with the list `inside` goes through."""
    best = inside & _ONE_ENTRY
    rest = inside >> _BITS
    while rest != 0:
        medium = rest & _ONE_ENTRY
        if media.values[medium, _PRIORITY] > media.values[best, _PRIORITY]:
            best = medium
        rest >>= _BITS
    return best


@device
def _entered(inside, medium):
    return (inside & _OTHERS) << _BITS | medium


@device
def _left(inside, medium):
    """The list without the last entry of `medium`."""
    kept, place, rest, found = np.int64(0), np.int64(0), inside, False
    while rest != 0:
        entry = rest & _ONE_ENTRY
        if entry == medium and not found:
            found = True
        else:
            kept |= entry << place
            place += _BITS
        rest >>= _BITS
    return kept


@device
def meet_boundary(media, inside, medium, entering):
    """The `Boundary` where a ray meets the surface of `medium` from outside (`entering`) or from inside."""
    if entering:
        through = _entered(inside, medium)
        return Boundary(current_medium(media, inside), current_medium(media, through), through)
    through = _left(inside, medium)
    # A ray that leaves what it never entered began inside.
    whole = _entered(inside, medium) if through == inside else inside
    return Boundary(current_medium(media, whole), current_medium(media, through), through)


@device
def surface_boundary(media, material, inside, entering):
    """The `Boundary` at a surface of a material; the same medium on both sides where that is not clear."""
    medium = np.int64(media.of_material[material])
    if medium != 0:
        return meet_boundary(media, inside, medium, entering)
    current = current_medium(media, inside)
    return Boundary(current, current, inside)


@device
def medium_ior(media, medium):
    """Index of refraction of a medium."""
    return media.values[medium, _IOR]


@device
def _transmitted(coefficient, distance):
    return math.exp(-coefficient * distance) if coefficient > _ZERO else _ONE


@device
def medium_towards(boundary, normal, direction, into):
    """The medium that light goes through which comes to a surface from `into`, seen along `direction`."""
    through = dot(normal, into) * dot(normal, direction) > _ZERO
    return boundary.behind if through else boundary.before


@device
def attenuation(media, medium, distance):
    """What is left of light after so many metres of a medium: exp(−σ d) (Beer and Lambert)."""
    if medium == 0:
        return vec3(_ONE, _ONE, _ONE)
    values = media.values
    return vec3(
        _transmitted(values[medium, _ABSORPTION], distance),
        _transmitted(values[medium, _ABSORPTION + 1], distance),
        _transmitted(values[medium, _ABSORPTION + 2], distance),
    )
