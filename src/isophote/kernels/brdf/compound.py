"""Materials of materials: mixed by shares, or under a clear coat. Their nodes name the nodes inside.

Mixed: f = (1 − t) f_a + t f_b; slot: amount t.
Coated: f = f_coat + (1 − E(θ_o)) (1 − E(θ_i)) f_below; slot: roughness of the coat; data: see coat.py. What the coat
sends back inside is left out, so a coat darkens. Both are as reciprocal as their parts, and reflect no more.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import call_entry, entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import load_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.brdf.coat import coat_albedo, coat_direction, coat_highlight, is_smooth
from isophote.kernels.brdf.contract import (
    answer,
    answer_branch,
    answer_sample,
    into_of,
    no_sample,
    number_slot,
    open_lobe,
    out_of,
    point_of,
)

__all__ = ["branch_coated", "branch_mix", "evaluate_coated", "evaluate_mix", "sample_coated", "sample_mix"]

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_AMOUNT = np.int64(0)
_ALMOST_ONE = np.float32(1 - 2.0**-24)
# How often a coat is sampled at least, and at most.
_LEAST, _MOST = np.float32(0.1), np.float32(0.9)


@device
def _inside(lobe, column):
    return np.int64(lobe.materials.nodes[lobe.node, column])


@device
def _evaluate(materials, scratch, lobe, child):
    """(f |cosθ|, density) of a node inside towards the direction asked for."""
    call_entry(lobe.materials.nodes[child, contract.EVALUATE], (materials, child, scratch))
    return load_vec3(lobe.scratch, contract.VALUE), lobe.scratch[contract.DENSITY]


@device
def _sample(materials, scratch, lobe, child, pick):
    """Whether a node inside found a direction, which is left in the scratch with weight and density."""
    lobe.scratch[contract.PICK] = min(pick, _ALMOST_ONE)
    return call_entry(lobe.materials.nodes[child, contract.SAMPLE], (materials, child, scratch)) != 0


@device
def _branch(materials, scratch, lobe, child, k):
    """The share of light of a branch of a node inside, whose direction is left in the scratch."""
    found = call_entry(lobe.materials.nodes[child, contract.BRANCH], (materials, child, scratch, np.int64(k)))
    share = load_vec3(lobe.scratch, contract.VALUE)
    return share if found != 0 else share * _ZERO


@device
def _mixed(materials, scratch, lobe, a, b, amount):
    value_a, density_a = _evaluate(materials, scratch, lobe, a)
    value_b, density_b = _evaluate(materials, scratch, lobe, b)
    kept = _ONE - amount
    return value_a * kept + value_b * amount, density_a * kept + density_b * amount


@device
def _amount(lobe):
    return min(max(number_slot(lobe, _AMOUNT), _ZERO), _ONE)


@entry
def evaluate_mix(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    a, b = _inside(lobe, contract.CHILD_A), _inside(lobe, contract.CHILD_B)
    value, density = _mixed(materials, scratch, lobe, a, b, _amount(lobe))
    return answer(lobe, value, density)


@entry
def sample_mix(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    a, b = _inside(lobe, contract.CHILD_A), _inside(lobe, contract.CHILD_B)
    amount = _amount(lobe)
    _, _, pick = point_of(lobe)
    second = pick < amount
    rest = pick / amount if second else (pick - amount) / (_ONE - amount)
    if not _sample(materials, scratch, lobe, b if second else a, rest):
        return no_sample(lobe)
    # A single direction keeps its weight: the amount stands above and below the line.
    if lobe.scratch[contract.DENSITY] == _ZERO:
        return np.int64(1)
    into = into_of(lobe)
    value, density = _mixed(materials, scratch, lobe, a, b, amount)
    return answer_sample(lobe, into, value, density)


@entry
def branch_mix(materials, node, scratch, k):
    """See contract.py. The branches of the first come before those of the second."""
    lobe = open_lobe(materials, node, scratch)
    a, b = _inside(lobe, contract.CHILD_A), _inside(lobe, contract.CHILD_B)
    amount, first = _amount(lobe), np.int64(lobe.materials.nodes[a, contract.BRANCHES])
    if k < first:
        share = _branch(materials, scratch, lobe, a, k) * (_ONE - amount)
    else:
        share = _branch(materials, scratch, lobe, b, k - first) * amount
    return answer_branch(lobe, into_of(lobe), share)


@device
def _chance(albedo):
    """Of the coat."""
    return min(max(albedo, _LEAST), _MOST)


@device
def _through(lobe, out, into):
    return (_ONE - coat_albedo(lobe, out.z)) * (_ONE - coat_albedo(lobe, abs(into.z)))


@device
def _coated(materials, scratch, lobe, out, into):
    """(f |cosθ|, density)."""
    below, below_density = _evaluate(materials, scratch, lobe, _inside(lobe, contract.CHILD_A))
    highlight, density = coat_highlight(lobe, out, into)
    chance = _chance(coat_albedo(lobe, out.z))
    value = below * _through(lobe, out, into) + vec3(highlight, highlight, highlight)
    return value, chance * density + (_ONE - chance) * below_density


@entry
def evaluate_coated(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    value, density = _coated(materials, scratch, lobe, out_of(lobe), into_of(lobe))
    return answer(lobe, value, density)


@entry
def sample_coated(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    x, y, pick = point_of(lobe)
    albedo = coat_albedo(lobe, out.z)
    chance = _chance(albedo)
    if pick < chance:
        into = coat_direction(lobe, out, x, y)
        if is_smooth(lobe):
            share = albedo / chance
            return answer_sample(lobe, into, vec3(share, share, share), _ZERO)
        if into.z <= _ZERO:
            return no_sample(lobe)
        lobe.scratch[contract.INTO] = into.x
        lobe.scratch[contract.INTO + 1] = into.y
        lobe.scratch[contract.INTO + 2] = into.z
    elif not _sample(materials, scratch, lobe, _inside(lobe, contract.CHILD_A), (pick - chance) / (_ONE - chance)):
        return no_sample(lobe)
    elif lobe.scratch[contract.DENSITY] == _ZERO:
        into = into_of(lobe)
        weight = load_vec3(lobe.scratch, contract.VALUE) * (_through(lobe, out, into) / (_ONE - chance))
        return answer_sample(lobe, into, weight, _ZERO)
    into = into_of(lobe)
    value, density = _coated(materials, scratch, lobe, out, into)
    return answer_sample(lobe, into, value, density)


@entry
def branch_coated(materials, node, scratch, k):
    """See contract.py. The coat's own branch, where it is smooth, comes first."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    own = np.int64(is_smooth(lobe))
    if k < own:
        share = coat_albedo(lobe, out.z)
        return answer_branch(lobe, vec3(-out.x, -out.y, out.z), vec3(share, share, share))
    share = _branch(materials, scratch, lobe, _inside(lobe, contract.CHILD_A), k - own)
    into = into_of(lobe)
    return answer_branch(lobe, into, share * _through(lobe, out, into))
