"""Many lights into a tree, from which those that matter at a place are picked (kernels/light/light_tree_entry.py)."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.light import emitter
from isophote.kernels.light.light_tree_layout import LIGHT_TREE, NODE
from isophote.lower.materials import emission_of
from isophote.scene.scene import Scene
from isophote.shapes.mesh import Mesh

__all__ = ["FEWEST", "is_local", "may_have_light_tree", "no_light_tree", "plant"]

Rows: TypeAlias = npt.NDArray[np.float64]
Kinds: TypeAlias = npt.NDArray[np.int32]

# From so many lights within the scene on there is a tree.
FEWEST = 8

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
_WORDS = 16


def is_local(kinds: Kinds) -> npt.NDArray[np.bool_]:
    """Which lights have a place, and are not infinitely far away."""
    return ~np.isin(kinds, (emitter.SUN, emitter.ENVIRONMENT))


def may_have_light_tree(scene: Scene) -> bool:
    """Whether a scene has so many lights, or shining shapes of so many faces, that a tree will pick among them."""
    shining = [item.shape for item in scene.items if max(emission_of(item.material)[0]) > 0]
    faces = sum(shape.face_count if isinstance(shape, Mesh) else 1 for shape in shining)
    return len(scene.lights) + faces >= FEWEST


def no_light_tree() -> Packed:
    """The table of a scene whose lights are picked by their power alone."""
    return LIGHT_TREE.pack(
        nodes=np.zeros(0, np.float32), parents=np.zeros(0, np.int32), leaves=np.zeros(0, np.int32), entry=0
    )


def plant(kinds: Kinds, values: Rows) -> Packed:
    """The tree over all lights that have a place, rows of `Lights.kinds` and `Lights.values`."""
    # Loaded where there are many lights: others are drawn sooner without.
    from isophote.kernels.light.light_tree_build import build_light_tree, collapse_light_tree
    from isophote.kernels.light.light_tree_entry import ask_light_tree

    chosen = np.flatnonzero(is_local(kinds))
    records = _records(kinds[chosen], values[chosen], chosen)
    count = len(chosen)
    nodes, children = np.zeros((2 * count - 1) * _WORDS, np.float32), np.zeros(2 * count - 1, np.int32)
    build_light_tree(records, nodes, children)
    inner = max(count - 1, 1)
    wide, parents = np.zeros(inner * NODE, np.float32), np.zeros(inner, np.int32)
    leaves = np.full(len(kinds), -1, np.int32)
    made = collapse_light_tree(nodes, children, wide, parents, leaves)
    return LIGHT_TREE.pack(
        nodes=wide[: made * NODE].copy(), parents=parents[:made].copy(), leaves=leaves, entry=ask_light_tree.address
    )


def _records(kinds: Kinds, values: Rows, numbers: npt.NDArray[np.int64]) -> npt.NDArray[np.float32]:
    """Records of light_tree_build.py, one after the other."""
    flat = np.isin(kinds, (emitter.TRIANGLE, emitter.PARALLELOGRAM, emitter.DISK))
    directed = flat | (kinds == emitter.SPOT)
    low, high = _boxes(kinds, values)
    opening = np.where(directed, 1.0, -1.0)
    # Lights with a surface fade with the cosine; a spot ends at its outer cone; all others shine everywhere.
    reach = np.where(kinds == emitter.SPOT, values[:, 4], 0.0)
    axis = np.where(directed[:, None], values[:, 9:12], 0.0)
    records = np.zeros((len(kinds), _WORDS), np.float32)
    records[:, 0:3], records[:, 4:7] = low, -high
    records[:, 3] = numbers.astype(np.int32).view(np.float32)
    records[:, 8:11] = axis
    records[:, 11] = _intensities(kinds, values)
    records[:, 12], records[:, 13] = opening, np.maximum(reach, 0.0)
    records[:, 14] = np.where(flat & (values[:, 16] != 0), -1.0, 1.0)
    records[:, 15] = 1.0
    return records.reshape(-1)


def _boxes(kinds: Kinds, values: Rows) -> tuple[Rows, Rows]:
    """Lower and upper corners around all lights."""
    place, edge1, edge2 = values[:, 0:3], values[:, 3:6], values[:, 6:9]
    low = place + np.minimum(np.minimum(edge1, edge2), 0.0)
    high = place + np.maximum(np.maximum(edge1, edge2), 0.0)
    sums = np.minimum(edge1, 0.0) + np.minimum(edge2, 0.0), np.maximum(edge1, 0.0) + np.maximum(edge2, 0.0)
    whole = (kinds == emitter.PARALLELOGRAM)[:, None]
    low, high = np.where(whole, place + sums[0], low), np.where(whole, place + sums[1], high)
    reach = np.where((kinds == emitter.DISK)[:, None], np.hypot(edge1, edge2), 0.0)
    reach = np.where((kinds == emitter.SPHERE)[:, None], values[:, 17:18], reach)
    around = np.isin(kinds, (emitter.DISK, emitter.SPHERE, emitter.POINT, emitter.SPOT))[:, None]
    return np.where(around, place - reach, low), np.where(around, place + reach, high)


def _intensities(kinds: Kinds, values: Rows) -> Rows:
    """Greatest radiant intensities, luminance, in parts of the largest: of surfaces radiance times the area that is
    seen. What shines at all has some."""
    light = values[:, 12:15] @ _LUMINANCE
    area = np.where(kinds == emitter.SPHERE, np.pi * values[:, 17] ** 2, values[:, 15])
    seen = np.where(np.isin(kinds, (emitter.POINT, emitter.SPOT)), light, light * area)
    shares: Rows = seen / max(float(seen.max()), np.finfo(float).tiny)
    return np.where(seen > 0, np.maximum(shares, 1e-12), 0.0)
