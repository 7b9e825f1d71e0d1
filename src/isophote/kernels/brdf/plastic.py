"""Plastic: a matte body under a clear coat, with the light that the coat keeps inside.

    f = f_coat + (1 − E(θ_o)) (1 − E(θ_i)) ρ / (π n² (1 − ρ K))

E is what the coat reflects in all, and K what it sends back of diffuse light from below; a white body reflects all that
the coat lets through. Slots: roughness of the coat, colour ρ. Data: see coat.py. Source: Pharr, Jakob, Humphreys:
"Physically Based Rendering"; Egan, Hilgeman: "Optical Properties of Inhomogeneous Materials", 1979, for K.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.brdf.coat import (
    coat_albedo,
    coat_direction,
    coat_highlight,
    coat_inside,
    coat_ior,
    is_smooth,
)
from isophote.kernels.brdf.contract import (
    answer,
    answer_branch,
    answer_sample,
    colour_slot,
    cosine_direction,
    into_of,
    no_sample,
    open_lobe,
    out_of,
    point_of,
    share_of,
)

__all__ = ["branch_plastic", "evaluate_plastic", "sample_plastic"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_COLOUR = np.int64(1)


@device
def _white(value):
    return vec3(value, value, value)


@device
def _body(lobe):
    """ρ / (n² (1 − ρ K))."""
    colour, ior = colour_slot(lobe, _COLOUR), coat_ior(lobe)
    return colour / (ior * ior * (_ONE - colour * coat_inside(lobe)))


@device
def _chance(lobe, albedo):
    """Of the coat."""
    return share_of(_white(albedo), colour_slot(lobe, _COLOUR) * (_ONE - albedo))


@device
def _value(lobe, out, into):
    """(f cosθ, density)."""
    above = coat_albedo(lobe, out.z)
    through = (_ONE - above) * (_ONE - coat_albedo(lobe, into.z))
    highlight, density = coat_highlight(lobe, out, into)
    matte = into.z * INV_PI
    chance = _chance(lobe, above)
    return _body(lobe) * (through * matte) + _white(highlight), chance * density + (_ONE - chance) * matte


@entry
def evaluate_plastic(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    into = into_of(lobe)
    if into.z <= _ZERO:
        return answer(lobe, into * _ZERO, _ZERO)
    value, density = _value(lobe, out_of(lobe), into)
    return answer(lobe, value, density)


@entry
def sample_plastic(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    x, y, pick = point_of(lobe)
    albedo = coat_albedo(lobe, out.z)
    chance = _chance(lobe, albedo)
    into = coat_direction(lobe, out, x, y) if pick < chance else cosine_direction(x, y)
    if pick < chance and is_smooth(lobe):
        return answer_sample(lobe, into, _white(albedo / chance), _ZERO)
    if into.z <= _ZERO:
        return no_sample(lobe)
    value, density = _value(lobe, out, into)
    return answer_sample(lobe, into, value, density)


@entry
def branch_plastic(materials, node, scratch, k):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    return answer_branch(lobe, vec3(-out.x, -out.y, out.z), _white(coat_albedo(lobe, out.z)))
