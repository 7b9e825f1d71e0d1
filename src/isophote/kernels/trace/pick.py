"""Which light a surface of a path aims at, and how likely that was: by power, or in the tree where there are many."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import store_vec3
from isophote.kernels.light import light_tree_layout as tree
from isophote.kernels.light.emitter import pick_light

__all__ = ["chance_of_light", "pick_for"]

_ZERO = np.float32(0)
_START, _ANY = np.int64(0), np.int64(-1)


@device
def _ask(lights, ask, place, normal, k):
    """The tree's answer; its chance is left in `ask`."""
    store_vec3(ask, tree.PLACE, place)
    store_vec3(ask, tree.NORMAL, normal)
    return call_entry(lights.tree.entry, (table_address(lights.tree), element_address(ask, _START), np.int64(k)))


@device
def pick_for(lights, ask, place, normal, u):
    """(number, chance) of a light for a surface at `place` that light reaches from the side of `normal`, from both if
    that is zero; number −1 where none in the tree can send any."""
    whole = lights.cdf[0]
    if u < whole:
        ask[tree.NUMBER] = u / whole
        k = _ask(lights, ask, place, normal, _ANY)
        return k, whole * ask[tree.CHANCE]
    k, chance, _ = pick_light(lights, u)
    return k, chance


@device
def chance_of_light(lights, ask, k, place, normal):
    """Chance with which `pick_for` picks light `k`."""
    chance = lights.cdf[k + 1] - lights.cdf[k]
    if chance > _ZERO or lights.tree.entry == 0:
        return chance
    _ask(lights, ask, place, normal, k)
    return lights.cdf[0] * ask[tree.CHANCE]
