"""Which patches are too large for how light falls on them."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.rendering.radiosity.balance import Balance
from isophote.rendering.radiosity.links import level
from isophote.rendering.radiosity.tree import PatchTree, on_patches

__all__ = ["FINER", "PARTS", "PEAK", "cut_by_irradiance", "cut_painted_lamps"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]
Flags: TypeAlias = npt.NDArray[np.bool_]

# Light is looked at in the middles of 3 × 3 parts. Four would lie alike about a lamp over the middle of a patch.
_GRID = 3
_PLACES = _GRID * _GRID
# From their outermost, light that changes evenly changes by so much more than from the middles of quarters, by half of
# which these are off the mean.
_HALF_OF_QUARTERS = 0.5 * 0.5 * _GRID / (_GRID - 1)
# Where a lamp may be so many times as bright as anywhere that was looked at, there is a peak between.
PEAK = 2.0
# Patches under lamps have edges of such a part of how near these are, and are so much finer than others at most.
PARTS, FINER = 8.0, 32.0


class _Lamps(NamedTuple):
    """Pairs of a leaf, by its row, and a node that shines: how near that may be to a place on the leaf, or its radius
    where that is more."""

    owner: Numbers
    source: Numbers
    reach: Points


def cut_by_irradiance(
    tree: PatchTree, balance: Balance, light: Points, allowed: float, patch: float, *, follow_lamps: bool
) -> bool:
    """Cut leaves over which light that is reflected changes by more than `allowed`, while `light` (nodes, 3) leaves all
    nodes. Edges do not get shorter than `patch`, or, to `follow_lamps`, an eighth of how near a lamp is where that is
    less. Returns whether any were cut."""
    shortest = patch / FINER if follow_lamps else patch
    leaves = tree.leaves[tree.edges[tree.leaves] >= 2 * shortest]
    leaves = leaves[level(tree.albedo[leaves]) > 0]
    owner, source, reach = _near_lamps(tree, balance, leaves)
    least = np.full(len(leaves), patch)
    if follow_lamps:
        np.minimum.at(least, owner, np.maximum(reach / PARTS, shortest))
    able = tree.edges[leaves] >= 2 * least
    if not able.any():
        return False
    number = np.cumsum(able) - 1
    leaves, kept = leaves[able], able[owner]
    lamps = _Lamps(number[owner[kept]], source[kept], reach[kept])
    arriving, dull = _at_middles(tree, balance, light, leaves), level(tree.albedo[leaves])
    brightest = arriving.max(axis=1)
    poor = (brightest - arriving.min(axis=1)) * _HALF_OF_QUARTERS * dull > allowed
    poor |= _has_peak(tree, lamps, light, leaves, np.maximum(PEAK * brightest, allowed / dull))
    tree.cut(leaves[poor])
    return bool(poor.any())


def cut_painted_lamps(tree: PatchTree, patch: float) -> None:
    """Cut patches that shine by a texture as far as `patch` allows: what a texture does within them nobody knows."""
    while True:
        leaves = tree.leaves[tree.edges[tree.leaves] >= 2 * patch]
        faces = tree.face[leaves]
        shining = (tree.faces.glow[faces] >= 0) & (level(tree.faces.emission[faces]) > 0)
        if not shining.any():
            return
        tree.cut(leaves[shining])


def _at_middles(tree: PatchTree, balance: Balance, light: Points, leaves: Numbers) -> Points:
    """(n, 9): what arrives in the middles of nine parts of each leaf."""
    corners, sides = tree.corners[leaves], tree.sides[leaves]
    steps = (np.arange(_GRID) + 0.5) / _GRID
    places = np.stack([on_patches(corners, sides, a, b) for a in steps for b in steps], axis=1)
    found = balance.at_places(light, np.repeat(leaves, _PLACES), places.reshape(-1, 3))
    middles: Points = level(found).reshape(-1, _PLACES)
    return middles


def _near_lamps(tree: PatchTree, balance: Balance, leaves: Numbers) -> _Lamps:
    """What shines and is near some leaves."""
    owner, source = balance.near_sources(leaves)
    shines = level(tree.emission[source]) > 0
    owner, source = owner[shines], source[shines]
    leaf = leaves[owner]
    way = tree.centres[source] - tree.centres[leaf]
    height = (way * tree.normals[leaf]).sum(axis=1)
    aside = np.sqrt(np.maximum((way**2).sum(axis=1) - height**2, 0.0))
    near = np.hypot(height, np.maximum(aside - tree.radii[leaf], 0.0))
    return _Lamps(owner, source, np.maximum(near, tree.radii[source]))


def _has_peak(tree: PatchTree, lamps: _Lamps, light: Points, leaves: Numbers, least: Points) -> Flags:
    """(n,): whether lamps that are small beside a leaf, and near, may send more than `least` (n,) to a place on it."""
    owner, source, reach = lamps
    # Seen from so far, and straight on; a place sees half of all directions at most.
    most = level(light[source]) * np.minimum(1.0, tree.areas[source] / (np.pi * reach**2))
    found = np.zeros(len(leaves), np.bool_)
    found[owner[(most > least[owner]) & (2 * reach < tree.edges[leaves[owner]])]] = True
    return found
