"""The leaves of a tree of patches as one triangle mesh without cracks, with light at its vertices."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.rendering.radiosity.tree import PatchTree

__all__ = ["Surface", "surface_of"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

# Coordinates nearer than this part of the scene's size are one: middles of edges are rounded.
_SAME = 1e-9
# How far places of light are moved from the corner of a leaf towards its centre: at the corner itself another wall may
# touch, and rays could not tell its sides apart.
_INWARD = 0.05
# How far two sides of one surface lie apart, in parts of the scene's size.
_APART = 1e-5


@attrs.frozen(eq=False)
class Surface:
    """Triangles (t, 3) over vertices (v, 3), and for each vertex the leaves that meet there with the places where
    their light is asked for: rows `starts[i]` to `starts[i + 1]` of `leaf` and `place`. `leaf_of` (t,) is the leaf of
    each triangle."""

    vertices: Points
    triangles: Numbers
    leaf_of: Numbers
    starts: Numbers
    leaf: Numbers
    place: Points

    def averaged(self, values: Points) -> Points:
        """(v, k): means over the leaves that meet at each vertex of (rows, k) values."""
        sums: Points = np.add.reduceat(values, self.starts[:-1], axis=0)
        return sums / np.diff(self.starts)[:, None]


def surface_of(tree: PatchTree) -> Surface:
    """The leaves of `tree`; where a leaf meets smaller ones, it has their corners too."""
    leaves = tree.leaves
    size = float(np.ptp(tree.corners[leaves].reshape(-1, 3), axis=0).max())
    groups = _groups(tree, leaves)
    corners = _Corners(tree, leaves, groups, size)
    rim, rim_leaf = corners.with_middles()
    # Every leaf is a fan around its centre, whose vertex is its own.
    centre = corners.count + np.arange(len(leaves))
    after = np.roll(np.arange(len(rim)), -1)
    ends = np.flatnonzero(np.append(rim_leaf[1:] != rim_leaf[:-1], True))
    starts = np.append(0, ends[:-1] + 1)
    after[ends] = starts
    triangles = np.stack([rim, rim[after], centre[rim_leaf]], axis=1)
    vertex = np.concatenate([rim, centre])
    owner = np.concatenate([rim_leaf, np.arange(len(leaves))])
    positions = np.concatenate([corners.positions, tree.centres[leaves]])
    order = np.argsort(vertex, kind="stable")
    counts = np.bincount(vertex, minlength=len(positions))
    leaf, own = leaves[owner[order]], positions[vertex[order]]
    surface = Surface(
        vertices=positions,
        triangles=triangles,
        leaf_of=leaves[rim_leaf],
        starts=np.concatenate([[0], np.cumsum(counts)]),
        leaf=leaf,
        place=own + _INWARD * (tree.centres[leaf] - own),
    )
    return attrs.evolve(surface, vertices=positions + _APART * size * _lift(tree, surface))


def _lift(tree: PatchTree, surface: Surface) -> Points:
    """Mean normals of the vertices of surfaces that have two sides, zeros elsewhere."""
    faces = tree.faces
    both = np.zeros(int(faces.item.max()) + 1, bool)
    both[faces.item[faces.side == 1]] = True
    normals = tree.normals[surface.leaf] * both[faces.item[tree.face[surface.leaf]]][:, None]
    return surface.averaged(normals)


def _groups(tree: PatchTree, leaves: Numbers) -> Numbers:
    """(leaves,): light is blended between leaves of one group only: those of an item that lie in one plane on one side,
    or all that are smooth."""
    faces = tree.faces
    face = tree.face[leaves]
    normals = np.rint(tree.normals[leaves] * 1e4)
    height = (tree.normals[leaves] * tree.centres[leaves]).sum(axis=1)
    scale = max(float(np.abs(tree.corners[leaves]).max()), 1e-300)
    flat = np.column_stack([normals, np.rint(height / scale * 1e4)])
    flat[faces.smooth[face]] = 0
    keys = np.column_stack([faces.item[face], faces.side[face], flat])
    _, group = np.unique(keys, axis=0, return_inverse=True)
    result: Numbers = group.reshape(-1).astype(np.int64)
    return result


class _Corners:
    """Corners of leaves by group and place, found again for the middles of edges."""

    def __init__(self, tree: PatchTree, leaves: Numbers, groups: Numbers, size: float) -> None:
        self._sides = tree.sides[leaves].astype(np.int64)
        self._groups = groups
        corner = np.arange(4)[None, :] < self._sides[:, None]
        self._owner, self._turn = np.nonzero(corner)
        places = tree.corners[leaves][corner]
        self._tolerance = _SAME * size
        self._axes = [_distinct(places[:, axis], self._tolerance) for axis in range(3)]
        number = groups[self._owner]
        self._codes: list[Numbers] = []
        for axis, (values, _) in enumerate(self._axes):
            # Groups of corners, split by one coordinate after another.
            codes = number * len(values) + self._near(places, axis)
            known, first, number = np.unique(codes, return_index=True, return_inverse=True)
            self._codes.append(known)
        self.positions = places[first]
        self._vertex = number

    @property
    def count(self) -> int:
        """Distinct corners."""
        return len(self.positions)

    def _near(self, places: Points, axis: int) -> Numbers:
        """Numbers of coordinates among those of the corners, or −1."""
        starts, ends = self._axes[axis]
        at = np.maximum(np.searchsorted(starts, places[:, axis] + self._tolerance, side="right") - 1, 0)
        near = np.abs(np.clip(places[:, axis], starts[at], ends[at]) - places[:, axis]) <= self._tolerance
        return np.where(near, at, -1)

    def _find(self, places: Points, groups: Numbers) -> Numbers:
        """Numbers of the corners at places, or −1."""
        number, there = groups, np.ones(len(groups), bool)
        for axis, known in enumerate(self._codes):
            near = self._near(places, axis)
            code = number * len(self._axes[axis][0]) + near
            number = np.minimum(np.searchsorted(known, code), len(known) - 1)
            there &= (near >= 0) & (known[number] == code)
        return np.where(there, number, -1)

    def with_middles(self) -> tuple[Numbers, Numbers]:
        """(corners around every leaf, one leaf after another; the leaf of each): its own corners, and those of smaller
        leaves that lie in the middle of its edges, and in the middles of the halves, and so on."""
        vertex, owner = self._vertex, self._owner
        where = self._turn.astype(np.float64)
        starts = np.cumsum(self._sides) - self._sides
        after = np.arange(len(vertex)) + 1
        after[starts + self._sides - 1] = starts
        edges = np.stack([vertex, vertex[after]], axis=1)
        edge_owner, edge_at, half = owner, where, 0.5
        found = [(vertex, owner, where)]
        while len(edges):
            middles = self.positions[edges].mean(axis=1)
            new = self._find(middles, self._groups[edge_owner])
            # The middle of an edge that is next to nothing is one of its ends.
            there = (new >= 0) & (new != edges[:, 0]) & (new != edges[:, 1])
            new, edges, edge_owner, edge_at = new[there], edges[there], edge_owner[there], edge_at[there]
            found.append((new, edge_owner, edge_at + half))
            edges = np.concatenate([np.stack([edges[:, 0], new], axis=1), np.stack([new, edges[:, 1]], axis=1)])
            edge_at = np.concatenate([edge_at, edge_at + half])
            edge_owner, half = np.concatenate([edge_owner, edge_owner]), half / 2
        vertices, owners, places = (np.concatenate(column) for column in zip(*found, strict=True))
        order = np.lexsort((places, owners))
        return vertices[order], owners[order]


def _distinct(values: Points, tolerance: float) -> tuple[Points, Points]:
    """First and last of every run of values that are nearer to the next than the tolerance."""
    ordered = np.sort(values)
    gaps = np.diff(ordered) > tolerance
    return ordered[np.append(True, gaps)], ordered[np.append(gaps, True)]
