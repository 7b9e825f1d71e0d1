"""Any material as if its surface were turned, by a normal map or a bump; its node names the node inside.

The slot holds the turned normal m in the world, outward. Where it is the surface's own, the node inside is asked as it
is. Else the surface is taken for a microsurface of two facets: one along m that is as the node inside says, and beside
it one that stands upright and reflects all light, t, so that both together have the surface's own normal g:

    a_p(w) = ⟨w, m⟩ / ⟨m, g⟩      a_t(w) = ⟨w, t⟩ √(1 − ⟨m, g⟩²) / ⟨m, g⟩      λ = a_p / (a_p + a_t)
    G(w) = min(1, ⟨w, g⟩ / (a_p(w) + a_t(w)))

Light along o comes to m with the chance λ(o), else by way of t. What m sends along w leaves with the chance G(w); the
rest is mirrored at t, and what then still goes down, at g. (Schüßler, Heitz, Hanika, Dachsbacher: "Microfacet-based
Normal Mapping for Robust Monte Carlo Path Tracing", TOG 36(6), 2017, with mirrors for tangent facets; there light may
go to and fro for longer, here it leaves after the second facet.) So every direction that the surface can be seen from
has light, and none of it is made or lost: under an even sky a white surface stays white, however it is turned. Only
the first way, from m straight out, is reciprocal. What goes through the surface does so by m alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.entry import call_entry, entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import cross, dot, load_vec3, normalise, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.brdf.contract import (
    answer,
    answer_branch,
    answer_sample,
    colour_slot,
    into_of,
    no_sample,
    open_lobe,
    out_of,
)

__all__ = ["branch_turned", "evaluate_turned", "sample_turned"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_NORMAL = np.int64(0)
# Normals that lean by less are the surface's own.
_UPRIGHT = np.float32(1 - 1e-7)
_LEAST = np.float32(1e-6)
_ALMOST_ONE = np.float32(1 - 2.0**-24)
# What is left of a sample number below so many parts is a number of its own.
_PARTS = np.float32(1024)


class _Facets(NamedTuple):
    """The turned normal m with two axes across it, and the upright facet's normal t, in the surface's frame; sine and
    cosine of the turn."""

    x: object
    y: object
    m: object
    t: object
    sine: float
    cosine: float


@device
def _facets(lobe):
    scratch = lobe.scratch
    normal = colour_slot(lobe, _NORMAL) * scratch[contract.SIDE]
    tangent, bitangent = load_vec3(scratch, contract.TANGENT), load_vec3(scratch, contract.BITANGENT)
    m = vec3(dot(normal, tangent), dot(normal, bitangent), dot(normal, load_vec3(scratch, contract.NORMAL)))
    sine = math.sqrt(m.x * m.x + m.y * m.y)
    down = _ONE / max(sine, _LEAST)
    x = normalise(vec3(_ONE, _ZERO, _ZERO) - m * m.x)
    return _Facets(x, cross(m, x), m, vec3(-m.x * down, -m.y * down, _ZERO), sine, max(m.z, _LEAST))


@device
def _is_upright(facets):
    return facets.m.z >= _UPRIGHT


@device
def _to_facet(facets, w):
    return vec3(dot(w, facets.x), dot(w, facets.y), dot(w, facets.m))


@device
def _from_facet(facets, w):
    return facets.x * w.x + facets.y * w.y + facets.m * w.z


@device
def _mirrored(facets, w):
    """At the upright facet."""
    along = dot(w, facets.t)
    return w - facets.t * (along + along)


@device
def _areas(facets, w):
    """(a_p, a_t) of a direction."""
    return max(dot(w, facets.m), _ZERO), max(dot(w, facets.t), _ZERO) * facets.sine


@device
def _share_of_map(facets, out):
    """λ."""
    mapped, upright = _areas(facets, out)
    return mapped / (mapped + upright) if mapped + upright > _ZERO else _ZERO


@device
def _seen(facets, w):
    """G."""
    mapped, upright = _areas(facets, w)
    area = (mapped + upright) / facets.cosine
    return min(max(w.z, _ZERO) / area, _ONE) if area > _ZERO else _ZERO


@device
def _child(lobe):
    return np.int64(lobe.materials.nodes[lobe.node, contract.CHILD_A])


@device
def _turn_frame(lobe, facets):
    """Make the frame in the scratch that of the facet along m. Returns what it was."""
    scratch = lobe.scratch
    tangent, bitangent = load_vec3(scratch, contract.TANGENT), load_vec3(scratch, contract.BITANGENT)
    normal = load_vec3(scratch, contract.NORMAL)
    store_vec3(scratch, contract.TANGENT, tangent * facets.x.x + bitangent * facets.x.y + normal * facets.x.z)
    store_vec3(scratch, contract.BITANGENT, tangent * facets.y.x + bitangent * facets.y.y + normal * facets.y.z)
    store_vec3(scratch, contract.NORMAL, tangent * facets.m.x + bitangent * facets.m.y + normal * facets.m.z)
    return tangent, bitangent, normal


@device
def _restore(lobe, tangent, bitangent, normal, out):
    scratch = lobe.scratch
    store_vec3(scratch, contract.TANGENT, tangent)
    store_vec3(scratch, contract.BITANGENT, bitangent)
    store_vec3(scratch, contract.NORMAL, normal)
    store_vec3(scratch, contract.OUT, out)


@device
def _ask(materials, scratch, lobe, facets, out, into):
    """(f |cosθ|, density) of the facet along m between two directions of the surface's frame."""
    local = _to_facet(facets, out)
    if local.z <= _ZERO:
        return vec3(_ZERO, _ZERO, _ZERO), _ZERO
    store_vec3(lobe.scratch, contract.OUT, local)
    store_vec3(lobe.scratch, contract.INTO, _to_facet(facets, into))
    child = _child(lobe)
    if call_entry(lobe.materials.nodes[child, contract.EVALUATE], (materials, child, scratch)) == 0:
        return vec3(_ZERO, _ZERO, _ZERO), lobe.scratch[contract.DENSITY]
    return load_vec3(lobe.scratch, contract.VALUE), lobe.scratch[contract.DENSITY]


@device
def _flipped(w):
    """Mirrored at the surface."""
    return vec3(w.x, w.y, -w.z)


@device
def _from_map(materials, scratch, lobe, facets, start, into):
    """(f |cosθ|, density) of light that comes to m along `start`, towards `into`: by the ways that lead there."""
    if into.z <= _ZERO:
        if dot(into, facets.m) >= _ZERO:
            return vec3(_ZERO, _ZERO, _ZERO), _ZERO
        return _ask(materials, scratch, lobe, facets, start, into)
    value, density = vec3(_ZERO, _ZERO, _ZERO), _ZERO
    mirrored = _mirrored(facets, into)
    for way in range(3):
        w = into if way == 0 else (mirrored if way == 1 else _flipped(mirrored))
        share = _seen(facets, w) if way == 0 else _ONE - _seen(facets, w)
        if share > _ZERO and dot(w, facets.m) > _ZERO:
            part, chance = _ask(materials, scratch, lobe, facets, start, w)
            value, density = value + part * share, density + chance * share
    return value, density


@device
def _both(materials, scratch, lobe, facets, out, into):
    """(f |cosθ|, density) of both facets."""
    share = _share_of_map(facets, out)
    value, density = vec3(_ZERO, _ZERO, _ZERO), _ZERO
    if share > _ZERO:
        part, chance = _from_map(materials, scratch, lobe, facets, out, into)
        value, density = part * share, chance * share
    if share < _ONE:
        part, chance = _from_map(materials, scratch, lobe, facets, _mirrored(facets, out), into)
        value, density = value + part * (_ONE - share), density + chance * (_ONE - share)
    return value, density


@entry
def evaluate_turned(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    facets = _facets(lobe)
    if _is_upright(facets):
        child = _child(lobe)
        return call_entry(lobe.materials.nodes[child, contract.EVALUATE], (materials, child, scratch))
    out, into = out_of(lobe), into_of(lobe)
    tangent, bitangent, normal = _turn_frame(lobe, facets)
    value, density = _both(materials, scratch, lobe, facets, out, into)
    _restore(lobe, tangent, bitangent, normal, out)
    store_vec3(lobe.scratch, contract.INTO, into)
    return answer(lobe, value, density)


@device
def _leaving(facets, w, escape):
    """Where light goes that the facet along m sends along `w`, by a number in [0, 1)."""
    if escape < _seen(facets, w):
        return w
    mirrored = _mirrored(facets, w)
    return mirrored if mirrored.z > _ZERO else _flipped(mirrored)


@device
def _go(materials, scratch, lobe, facets, start, pick, escape):
    """(whether there is one, direction in the surface's frame) that light goes to which comes to m along `start`; the
    weight of a single one stays in the scratch."""
    local = _to_facet(facets, start)
    if local.z <= _ZERO:
        return False, start
    store_vec3(lobe.scratch, contract.OUT, local)
    lobe.scratch[contract.PICK] = min(pick, _ALMOST_ONE)
    child = _child(lobe)
    if call_entry(lobe.materials.nodes[child, contract.SAMPLE], (materials, child, scratch)) == 0:
        return False, start
    facing = into_of(lobe)
    into = _from_facet(facets, facing)
    if facing.z < _ZERO:
        return into.z < _ZERO, into
    return True, _leaving(facets, into, escape)


@entry
def sample_turned(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    facets = _facets(lobe)
    if _is_upright(facets):
        child = _child(lobe)
        return call_entry(lobe.materials.nodes[child, contract.SAMPLE], (materials, child, scratch))
    out, pick = out_of(lobe), lobe.scratch[contract.PICK]
    share = _share_of_map(facets, out)
    to_map = pick < share
    pick = pick / share if to_map else (pick - share) / (_ONE - share)
    escape = pick * _PARTS
    escape = np.float32(escape - math.floor(escape))
    tangent, bitangent, normal = _turn_frame(lobe, facets)
    start = out if to_map else _mirrored(facets, out)
    found, into = _go(materials, scratch, lobe, facets, start, pick, escape)
    single = lobe.scratch[contract.DENSITY] == _ZERO
    value, density = load_vec3(lobe.scratch, contract.VALUE), _ZERO
    if found and not single:
        value, density = _both(materials, scratch, lobe, facets, out, into)
    _restore(lobe, tangent, bitangent, normal, out)
    if not found or not (single or density > _ZERO):
        return no_sample(lobe)
    return answer_sample(lobe, into, value, density)


@entry
def branch_turned(materials, node, scratch, k):
    """See contract.py. A branch that would go below the surface is mirrored, as light of other kinds."""
    lobe = open_lobe(materials, node, scratch)
    facets, child = _facets(lobe), _child(lobe)
    if _is_upright(facets):
        return call_entry(lobe.materials.nodes[child, contract.BRANCH], (materials, child, scratch, np.int64(k)))
    out = out_of(lobe)
    tangent, bitangent, normal = _turn_frame(lobe, facets)
    local = _to_facet(facets, out if dot(out, facets.m) > _LEAST else _mirrored(facets, out))
    store_vec3(lobe.scratch, contract.OUT, vec3(local.x, local.y, max(local.z, _LEAST)))
    found = call_entry(lobe.materials.nodes[child, contract.BRANCH], (materials, child, scratch, np.int64(k)))
    share, facing = load_vec3(lobe.scratch, contract.VALUE), into_of(lobe)
    into = _from_facet(facets, facing)
    if facing.z > _ZERO and into.z <= _ZERO:
        into = _flipped(_mirrored(facets, into))
    _restore(lobe, tangent, bitangent, normal, out)
    # Where light would go through on the wrong side, there is none.
    kept = found != 0 and (into.z > _ZERO) == (facing.z > _ZERO)
    return answer_branch(lobe, into, share if kept else share * _ZERO)
