"""Metals: microfacets that reflect by Fresnel's equations of conductors, and the smooth mirror.

Slots: index n, extinction k, colour, roughness along the tangent and across.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, load_vec3, normalise, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.brdf.contract import answer, answer_sample, colour_slot, no_sample, number_slot, open_lobe
from isophote.kernels.brdf.fresnel import fresnel_conductor
from isophote.kernels.brdf.microfacet import alpha_of, density_of_normals, masking, visible_normal

__all__ = ["branch_smooth", "evaluate_conductor", "evaluate_nothing", "sample_conductor", "sample_smooth"]

_ZERO, _ONE, _TWO, _QUARTER = np.float32(0), np.float32(1), np.float32(2), np.float32(0.25)
_N, _K, _COLOUR, _ALONG, _ACROSS = np.int64(0), np.int64(1), np.int64(2), np.int64(3), np.int64(4)


@device
def _reflected(lobe, cosine):
    return colour_slot(lobe, _COLOUR) * fresnel_conductor(cosine, colour_slot(lobe, _N), colour_slot(lobe, _K))


@device
def _lobe_at(lobe, out, into, h):
    """(f cosθ, density): F D G / (4 cosθ_out) and G1(out) D / (4 cosθ_out)."""
    ax, ay = alpha_of(number_slot(lobe, _ALONG)), alpha_of(number_slot(lobe, _ACROSS))
    density = masking(out, ax, ay) * density_of_normals(h, ax, ay) * _QUARTER / out.z
    return _reflected(lobe, dot(out, h)) * (density * masking(into, ax, ay)), density


@entry
def evaluate_conductor(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out, into = load_vec3(lobe.scratch, contract.OUT), load_vec3(lobe.scratch, contract.INTO)
    if into.z <= _ZERO:
        return answer(lobe, vec3(_ZERO, _ZERO, _ZERO), _ZERO)
    value, density = _lobe_at(lobe, out, into, normalise(out + into))
    return answer(lobe, value, density)


@entry
def sample_conductor(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = load_vec3(lobe.scratch, contract.OUT)
    ax, ay = alpha_of(number_slot(lobe, _ALONG)), alpha_of(number_slot(lobe, _ACROSS))
    h = visible_normal(out, ax, ay, lobe.scratch[contract.X], lobe.scratch[contract.Y])
    into = h * (_TWO * dot(out, h)) - out
    if into.z <= _ZERO:
        return no_sample(lobe)
    value, density = _lobe_at(lobe, out, into, h)
    return answer_sample(lobe, into, value, density)


@entry
def evaluate_nothing(materials, node, scratch):
    """The `evaluate` of kinds that only branch."""
    return answer(open_lobe(materials, node, scratch), vec3(_ZERO, _ZERO, _ZERO), _ZERO)


@entry
def sample_smooth(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = load_vec3(lobe.scratch, contract.OUT)
    return answer_sample(lobe, vec3(-out.x, -out.y, out.z), _reflected(lobe, out.z), _ZERO)


@entry
def branch_smooth(materials, node, scratch, k):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = load_vec3(lobe.scratch, contract.OUT)
    store_vec3(lobe.scratch, contract.INTO, vec3(-out.x, -out.y, out.z))
    return answer(lobe, _reflected(lobe, out.z), _ZERO)
