"""Panes: thin slabs of glass as one surface, with all the ways that light takes to and fro inside.

    T = (1 − F)² A / (1 − F² A²),  R = F (1 + A T),  A = exp(−σ d / cosθ')

F is Fresnel's share at one face, θ' the angle inside. Light that goes through goes straight on. Slots: index of
refraction, colour, absorption times thickness.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3
from isophote.kernels.brdf.contract import (
    answer_branch,
    answer_sample,
    colour_slot,
    number_slot,
    open_lobe,
    out_of,
    point_of,
    share_of,
)
from isophote.kernels.light.bsdf import fresnel_dielectric

__all__ = ["branch_pane", "sample_pane"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_IOR, _COLOUR, _DEPTH = np.int64(0), np.int64(1), np.int64(2)


@device
def _channel(share, inside, depth):
    """(reflected, transmitted) of one channel."""
    left = math.exp(-depth / inside)
    through = (_ONE - share) * (_ONE - share) * left / (_ONE - share * share * left * left)
    return share * (_ONE + left * through), through


@device
def _shares(lobe):
    """(reflected, transmitted)."""
    share, inside = fresnel_dielectric(out_of(lobe).z, number_slot(lobe, _IOR))
    colour, depth = colour_slot(lobe, _COLOUR), colour_slot(lobe, _DEPTH)
    if inside <= _ZERO or share >= _ONE:
        return colour, colour * _ZERO
    r, g, b = _channel(share, inside, depth.x), _channel(share, inside, depth.y), _channel(share, inside, depth.z)
    return colour * vec3(r[0], g[0], b[0]), colour * vec3(r[1], g[1], b[1])


@device
def _ways(lobe):
    """The mirror direction and the one straight on."""
    out = out_of(lobe)
    return vec3(-out.x, -out.y, out.z), vec3(-out.x, -out.y, -out.z)


@entry
def sample_pane(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    reflected, through = _shares(lobe)
    back, onward = _ways(lobe)
    chance = share_of(reflected, through)
    _, _, pick = point_of(lobe)
    if pick < chance:
        return answer_sample(lobe, back, reflected * (_ONE / chance), _ZERO)
    return answer_sample(lobe, onward, through * (_ONE / (_ONE - chance)), _ZERO)


@entry
def branch_pane(materials, node, scratch, k):
    """See contract.py. The reflected ray is the first, the one straight on the second."""
    lobe = open_lobe(materials, node, scratch)
    reflected, through = _shares(lobe)
    back, onward = _ways(lobe)
    if k == 0:
        return answer_branch(lobe, back, reflected)
    return answer_branch(lobe, onward, through)
