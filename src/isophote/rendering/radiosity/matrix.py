"""The matrix of form factors between all patches, row by row, as rows are asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from isophote.kernels.base.table import Packed
from isophote.kernels.trace.exchange import exchanges
from isophote.kernels.trace.local_factors import near_factors
from isophote.kernels.trace.shaft import new_shaft
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.rendering.occlusion.directions import hemicube, hemisphere
from isophote.rendering.pool import Pool
from isophote.rendering.radiosity.tree import PatchTree, on_patches
from isophote.rendering.tracer import Tracer
from isophote.shapes.mesh import Mesh

__all__ = ["DirectionRows", "FactorMatrix", "PairRows", "Rows"]

Points: TypeAlias = npt.NDArray[np.float64]
Floats: TypeAlias = npt.NDArray[np.float32]
Numbers: TypeAlias = npt.NDArray[np.int64]
# Form factors (k, n) of patches, by their numbers among the leaves, to all leaves.
Rows: TypeAlias = Callable[[Numbers], Floats]

_WAVE = 272
_PAIRS_A_JOB = 2048
_PAIRS_AT_ONCE, _RAYS_AT_ONCE = 2**20, 2**20
_GRID = 4
_GOLDEN_ANGLE = np.pi * (3 - 5**0.5)
# How near the centres of two sides of a patch are, in parts of the scene's size.
_SAME = 1e-6


class PairRows:
    """Rows by pairs of patches: what sixteen rays see, times Lambert's closed form averaged by Gauss's rule."""

    def __init__(self, scene: Packed, tree: PatchTree, threads: int | None) -> None:
        self._scene, self._patches, self._threads = scene, tree.packed(), threads
        self._leaves = tree.leaves
        self.at_once = max(1, _PAIRS_AT_ONCE // len(self._leaves))

    def __call__(self, numbers: Numbers) -> Floats:
        """(k, n) float32."""
        leaves, count = self._leaves, len(self._leaves)
        own = np.sort(leaves[numbers])
        a, b = np.repeat(own, count), np.tile(leaves, len(own))
        pairs = np.stack([np.minimum(a, b), np.maximum(a, b)], axis=1)
        seen = np.zeros((len(pairs), 3))
        pool = Pool(self._threads)
        words = scratch_words(self._scene.arrays["fields"])
        waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]
        shafts = [new_shaft() for _ in range(pool.threads)]

        def see(first: int, thread: int) -> None:
            last = min(first + _PAIRS_A_JOB, len(pairs))
            own_wave, own_shaft = waves[thread].words, shafts[thread].words
            exchanges(self._scene.words, self._patches.words, own_wave, own_shaft, pairs, seen, first, last)

        pool.run(see, range(0, len(pairs), _PAIRS_A_JOB), lambda done: None)
        starts = np.arange(len(own) + 1) * count
        factors = np.zeros(len(pairs), np.float32)
        visible = np.where(seen[:, 1] > 0, seen[:, 0], 0.0).astype(np.float32)
        targets, patches, even = b.astype(np.int32), self._patches.words, np.zeros(0)

        def measure(first: int, thread: int) -> None:
            near_factors(patches, own, starts, targets, visible, even, factors, first, min(first + 1, len(own)))

        pool.run(measure, range(len(own)), lambda done: None)
        if pool.interrupted:
            raise KeyboardInterrupt
        return factors.reshape(-1, count)[np.argsort(np.argsort(numbers))]


class DirectionRows:
    """Rows by rays from the middle of a patch through the pixels of a half cube, or of a hemisphere: each gives its
    weight to the patch that it meets."""

    def __init__(self, tree: PatchTree, way: str, directions: int, threads: int | None) -> None:
        leaves = tree.leaves
        self._normals, self._places = tree.normals[leaves], _places(tree, leaves)
        self._places = self._places + tree.bias * self._normals
        along = tree.corners[leaves, 1] - tree.corners[leaves, 0]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        # Each patch turns its directions by another angle, or errors of neighbours would add up to stripes.
        angle = (_GOLDEN_ANGLE * np.arange(len(leaves)))[:, None]
        self._along = np.cos(angle) * along + np.sin(angle) * np.cross(self._normals, along)
        made = hemicube if way == "hemicube" else hemisphere
        # The half cube of edge e has 3 e² pixels, the hemisphere e².
        edge = round((directions / (3 if way == "hemicube" else 1)) ** 0.5 / 2) * 2
        self._set = made(max(edge, 2)).astype(np.float64)
        self._back = _other_sides(tree, leaves)
        front = np.flatnonzero(tree.faces.side[tree.face[leaves]] == 0)
        quads = front[tree.sides[leaves[front]] == 4]
        self._met = np.concatenate([front, quads])
        corners = np.concatenate([tree.corners[leaves[front]][:, :3], tree.corners[leaves[quads]][:, [0, 2, 3]]])
        triangles = np.arange(3 * len(corners)).reshape(-1, 3)
        self._tracer = Tracer(Mesh(corners.reshape(-1, 3), triangles), threads=threads)
        self.at_once = max(1, _RAYS_AT_ONCE // len(self._set))

    def __call__(self, numbers: Numbers) -> Floats:
        """(k, n) float32."""
        count, each = len(self._normals), len(self._set)
        normals, along = self._normals[numbers], self._along[numbers]
        frames = np.stack([along, np.cross(normals, along), normals], axis=1)
        ways = np.einsum("dk,nkc->ndc", self._set[:, :3], frames)
        origins = np.repeat(self._places[numbers], each, axis=0)
        hits = self._tracer.closest(origins, ways.reshape(-1, 3))
        met = self._met[np.maximum(hits.primitive, 0)]
        behind = np.einsum("nc,nc->n", ways.reshape(-1, 3), self._normals[met]) > 0
        met = np.where(behind, self._back[met], met)
        met[~hits.hit] = -1
        row = np.repeat(np.arange(len(numbers)), each)
        weight = np.tile(self._set[:, 3], len(numbers))
        known = met >= 0
        sums = np.bincount(row[known] * count + met[known], weight[known], minlength=len(numbers) * count)
        return sums.reshape(-1, count).astype(np.float32)


def _places(tree: PatchTree, leaves: Numbers) -> Points:
    """(n, 3): the centre of each patch or, where part of it lies within a solid, the middle of a cell that does not,
    the one nearest to the centre of all of these."""
    places = tree.centres[leaves].copy()
    partly = np.flatnonzero((tree.covered[leaves] != 0) & (tree.open[leaves] > 0))
    if len(partly) == 0:
        return places
    own = leaves[partly]
    cells = [
        on_patches(tree.corners[own], tree.sides[own], (k % _GRID + 0.5) / _GRID, (k // _GRID + 0.5) / _GRID)
        for k in range(_GRID**2)
    ]
    middles = np.stack(cells, axis=1)
    is_open = ((tree.covered[own][:, None] >> np.arange(_GRID**2)) & 1) == 0
    centre = (middles * is_open[:, :, None]).sum(axis=1) / is_open.sum(axis=1)[:, None]
    away = np.where(is_open, np.linalg.norm(middles - centre[:, None], axis=2), np.inf)
    places[partly] = middles[np.arange(len(own)), away.argmin(axis=1)]
    return places


def _other_sides(tree: PatchTree, leaves: Numbers) -> Numbers:
    """(n,): for each patch the number of the one behind it, −1 where there is none."""
    faces = tree.faces
    face = tree.face[leaves]
    found = np.full(len(leaves), -1, np.int64)
    front, back = np.flatnonzero(faces.side[face] == 0), np.flatnonzero(faces.side[face] == 1)
    if len(back) == 0:
        return found
    size = float(np.ptp(tree.centres[leaves], axis=0).max()) + float(tree.radii[leaves].max())
    # Patches of other faces are far off along coordinates of their own.
    names = np.stack([faces.item[face], faces.primitive[face]], axis=1) * size
    keys = np.concatenate([tree.centres[leaves], names], axis=1)
    distance, nearest = cKDTree(keys[back]).query(keys[front])
    found[front] = np.where(distance < _SAME * size, back[nearest], -1)
    return found


class FactorMatrix:
    """Form factors F (n, n) float32 from each of n patches to each; rows are made when they are first asked for."""

    def __init__(self, count: int, rows: PairRows | DirectionRows) -> None:
        self._rows = rows
        # Memory is taken up as rows are written.
        self._values = np.empty((count, count), np.float32)
        self._known = np.zeros(count, bool)

    def row(self, number: int) -> Floats:
        """(n,): form factors of one patch."""
        if not self._known[number]:
            self._values[number] = self._rows(np.array([number]))[0]
            self._known[number] = True
        found: Floats = self._values[number]
        return found

    @property
    def known(self) -> npt.NDArray[np.bool_]:
        """(n,): whether each row is there."""
        return self._known

    def filled(self, told: Callable[[float], None]) -> Floats:
        """(n, n): all rows."""
        missing = np.flatnonzero(~self._known)
        for first in range(0, len(missing), self._rows.at_once):
            some = missing[first : first + self._rows.at_once]
            self._values[some] = self._rows(some)
            self._known[some] = True
            told((first + len(some)) / len(missing))
        return self._values

    def sums(self) -> Points:
        """(n,): Σ F of each patch; NaN for rows that were never asked for."""
        found = np.full(len(self._known), np.nan)
        for number in np.flatnonzero(self._known):
            found[number] = self._values[number].sum(dtype=np.float64)
        return found
