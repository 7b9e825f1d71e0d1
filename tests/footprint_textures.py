"""Textures that show what they are asked with, for tests of footprints."""

from __future__ import annotations

from isophote.kernels.base.entry import entry
from isophote.kernels.base.vec import load_vec3, vec3
from isophote.kernels.texture.contract import (
    AXIS_A,
    AXIS_B,
    OWN,
    OWN_A,
    OWN_B,
    U,
    V,
    answer,
    open_place,
)

__all__ = ["show_own", "show_own_axes", "show_uv", "show_uv_axes"]


@entry
def show_uv(textures, node, record):
    """(u, v, 1)."""
    place = open_place(textures, node, record)
    return answer(place, vec3(place.record[U], place.record[V], place.record[U] * 0 + 1), place.record[U])


@entry
def show_uv_axes(textures, node, record):
    """(Σ du², Σ dv², |Σ du dv|) over the two half-axes."""
    place = open_place(textures, node, record)
    r = place.record
    a, b, c, d = r[AXIS_A], r[AXIS_A + 1], r[AXIS_B], r[AXIS_B + 1]
    return answer(place, vec3(a * a + c * c, b * b + d * d, abs(a * b + c * d)), a)


@entry
def show_own(textures, node, record):
    """The place in the shape's own space."""
    place = open_place(textures, node, record)
    return answer(place, load_vec3(place.record, OWN), place.record[U])


@entry
def show_own_axes(textures, node, record):
    """(Σ dx², Σ dy², Σ dz²) over the two half-axes in the shape's own space."""
    place = open_place(textures, node, record)
    a, b = load_vec3(place.record, OWN_A), load_vec3(place.record, OWN_B)
    return answer(place, a * a + b * b, place.record[U])
