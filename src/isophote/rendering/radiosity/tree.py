"""Patches as a tree: clusters of faces above, faces in the middle, and what faces are cut into below."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.trace.exchange import PATCHES
from isophote.rendering.radiosity.clusters import Groups, grouped, measured
from isophote.rendering.radiosity.coverage import Coverage
from isophote.rendering.radiosity.faces import Around, Faces, looked_up

__all__ = ["PatchTree", "on_patches"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

_WIDTH = 4
# Albedos are means over so many by so many places of a patch.
_PLACES = 3
# Room for the rounding of places in single precision, in parts of the largest coordinate.
_ROUNDING = 64 * 2.0**-24
# Faces up to which there are no clusters: all pairs of faces are few.
_FEW = 24


class PatchTree:
    """Nodes that grow as patches are cut: node k has the columns k of every array.

    `corners` (n, 4, 3), `sides` (0 for clusters), `normals`, `centres` (n, 3), `axes` (n, 6), two half edges, `flat`
    (1 for all but clusters of faces that lie in no common plane), `areas`, `radii`, `parent`, `first_child` (−1: none),
    `children`, `depth`, `face` (−1 for clusters), `edges`, the longest of each (0 for clusters), `open`, the share that
    lies within no solid (1 for clusters), and `albedo`, `emission` (n, 3), means by area for clusters. `roots` are the
    nodes without a parent.
    """

    def __init__(self, faces: Faces, coverage: Coverage) -> None:
        self.faces = faces
        self._coverage = coverage
        count = len(faces.sides)
        order, groups = _order(faces), None
        if count > _FEW:
            groups = grouped(_measured(faces.corners, faces.sides)[0], faces.normals)
            order = groups.order
        self.corners = faces.corners[order]
        self.uvs = faces.uvs[order]
        self.sides = faces.sides[order]
        self.normals = faces.normals[order]
        self.face = order
        self.parent = np.full(count, -1, np.int64)
        self.first_child = np.full(count, -1, np.int64)
        self.children = np.zeros(count, np.int64)
        self.depth = np.zeros(count, np.int64)
        self.emission, self.albedo = np.zeros((count, 3)), np.zeros((count, 3))
        self.centres, self.areas, self.radii = _measured(self.corners, self.sides)
        self.axes, self.flat = _half_edges(self.corners, self.sides), np.ones(count, np.uint8)
        self._paint(np.arange(count))
        self.span = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
        self._shares = np.concatenate([[0.0], np.cumsum(self.areas)])[:, None]
        self._faces = count
        self._boxes = np.zeros((count, 6))
        self.covered = np.zeros(count, np.int32)
        self.edges, self.open = _longest_edges(self.corners, self.sides), np.ones(count)
        self._packed: Packed | None = None
        self.roots = np.arange(count)
        if groups is not None:
            self._cluster(groups)
        low, high = faces.corners.min(axis=(0, 1)), faces.corners.max(axis=(0, 1))
        self.bias = _ROUNDING * float(np.abs([low, high]).max())
        self._cover(np.arange(count))

    def __len__(self) -> int:
        return len(self.sides)

    @property
    def leaves(self) -> Numbers:
        """Patches that are not cut."""
        return np.flatnonzero((self.first_child < 0) & (self.sides > 0))

    def packed(self) -> Packed:
        """The nodes as kernels see them."""
        if self._packed is None:
            self._packed = self._pack()
        return self._packed

    def _pack(self) -> Packed:
        return PATCHES.pack(
            corners=np.ascontiguousarray(self.corners.reshape(-1, 12)),
            sides=self.sides,
            normals=self.normals,
            centres=self.centres,
            axes=self.axes,
            flat=self.flat,
            first_child=self.first_child.astype(np.int32),
            children=self.children.astype(np.int32),
            sizes=np.stack([self.areas, self.radii, self.open], axis=1),
            covered=self.covered,
            first_face=self.span[:, 0].astype(np.int32),
            last_face=self.span[:, 1].astype(np.int32),
            faces=np.arange(self._faces, dtype=np.int32),
            shares=self._shares,
            boxes=self._boxes.reshape(-1, 3),
            roots=self.roots.astype(np.int32),
            bias=self.bias,
        )

    def cut(self, nodes: Numbers) -> None:
        """Cut patches that have no children into four each, by the middles of their edges."""
        nodes = nodes[(self.first_child[nodes] < 0) & (self.sides[nodes] > 0)]
        if len(nodes) == 0:
            return
        first, count = len(self), len(nodes)
        corners = _quarters(self.corners[nodes], self.sides[nodes])
        self.first_child[nodes] = first + _WIDTH * np.arange(count)
        self.children[nodes] = _WIDTH
        again = np.repeat(nodes, _WIDTH)
        centres, areas, radii = _measured(corners, self.sides[again])
        self._append(
            corners=corners,
            uvs=_quarters(self.uvs[nodes], self.sides[nodes]),
            sides=self.sides[again],
            normals=self.normals[again],
            face=self.face[again],
            parent=again,
            first_child=np.full(len(again), -1),
            children=np.zeros(len(again), np.int64),
            depth=self.depth[again] + 1,
            emission=self.emission[again],
            centres=centres,
            axes=_half_edges(corners, self.sides[again]),
            flat=np.ones(len(again), np.uint8),
            areas=areas,
            radii=radii,
            albedo=self.albedo[again],
            span=self.span[again],
            edges=_longest_edges(corners, self.sides[again]),
            open=np.ones(len(again)),
            covered=np.zeros(len(again), np.int32),
        )
        made = np.arange(first, len(self))
        self._cover(made)
        self._paint(made)

    def _cover(self, nodes: Numbers) -> None:
        """Find what of patches lies within solids."""
        found = self._coverage(self.packed(), nodes)
        bits = np.unpackbits(found.astype("<u4").view(np.uint8).reshape(-1, 4), axis=1)
        self.covered[nodes], self.open[nodes] = found, 1.0 - bits.sum(axis=1) / 16
        self._packed = None

    def _append(self, **columns: npt.NDArray[np.generic]) -> None:
        self._packed = None
        for name, rows in columns.items():
            old = getattr(self, name)
            setattr(self, name, np.concatenate([old, rows.astype(old.dtype, copy=False)]))

    def _paint(self, nodes: Numbers) -> None:
        """Write mean albedo and emission of patches."""
        face, faces = self.face[nodes], self.faces
        self.albedo[nodes] = self._tinted(nodes, faces.albedo[face], faces.texture[face])
        self.emission[nodes] = self._tinted(nodes, faces.emission[face], faces.glow[face])

    def _tinted(self, nodes: Numbers, values: Points, texture: Numbers) -> Points:
        """(n, 3): `values` of patches, times the mean of the `texture` on each, if that is not −1."""
        textured = np.flatnonzero(texture >= 0)
        if len(textured) == 0:
            return values
        chosen, total = nodes[textured], np.zeros((len(textured), 3))
        sides = self.sides[chosen]
        for i in range(_PLACES):
            for j in range(_PLACES):
                a, b = (i + 0.5) / _PLACES, (j + 0.5) / _PLACES
                uvs, places = _around(self.uvs[chosen], sides, a, b), _around(self.corners[chosen], sides, a, b)
                total += looked_up(self.faces.textures, texture[textured], uvs, places)
        tinted = values.copy()
        tinted[textured] *= total / _PLACES**2
        return tinted

    def _cluster(self, groups: Groups) -> None:
        """Groups of faces above the faces, all under one root."""
        faces, count = self._faces, len(groups.first)
        found = measured(groups, self.corners, self.normals, self.areas, self.centres)
        weights = self._shares[groups.last] - self._shares[groups.first]

        def mean(values: Points) -> Points:
            sums = np.concatenate([np.zeros((1, 3)), np.cumsum(values * self.areas[:, None], axis=0)])
            means: Points = np.maximum(sums[groups.last] - sums[groups.first], 0.0) / weights
            return means

        made = faces + np.arange(count)
        parent = np.full(faces + count, -1)
        owner = np.repeat(made, groups.children)
        place = np.arange(len(owner)) - np.repeat(np.cumsum(groups.children) - groups.children, groups.children)
        parent[np.repeat(groups.first_child, groups.children) + place] = owner
        self.parent = parent[:faces]
        self._append(
            corners=np.zeros((count, 4, 3)),
            uvs=np.zeros((count, 4, 2)),
            sides=np.zeros(count, np.uint8),
            normals=found.normals,
            face=np.full(count, -1),
            parent=parent[faces:],
            first_child=groups.first_child,
            children=groups.children,
            depth=np.zeros(count, np.int64),
            emission=mean(self.emission),
            centres=found.centres,
            axes=found.axes,
            flat=found.flat,
            areas=found.areas,
            radii=found.radii,
            albedo=mean(self.albedo),
            edges=np.zeros(count),
            open=np.ones(count),
            covered=np.zeros(count, np.int32),
            span=np.stack([groups.first, groups.last], axis=1),
        )
        self.roots = made[:1]
        self._boxes = np.concatenate([self._boxes, found.boxes])
        self._deepen()

    def _deepen(self) -> None:
        """Depths from the root down."""
        level, depth = self.roots, 0
        while len(level):
            self.depth[level] = depth
            inner = level[self.first_child[level] >= 0]
            level = np.concatenate([self.first_child[inner] + k for k in range(_WIDTH)])
            own = np.concatenate([self.children[inner] > k for k in range(_WIDTH)])
            level, depth = level[own], depth + 1


def _order(faces: Faces) -> Numbers:
    """Faces along Morton's curve, so that neighbours in the order are neighbours in space."""
    middles = faces.corners[:, :3].mean(axis=1)
    low, high = middles.min(axis=0), middles.max(axis=0)
    cells = ((middles - low) / max(float((high - low).max()), 1e-300) * 2097151).astype(np.uint64)
    code = np.zeros(len(cells), np.uint64)
    for bit in range(21):
        for axis in range(3):
            code |= ((cells[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
    order: Numbers = np.argsort(code, kind="stable")
    return order


def on_patches(rows: Points, sides: npt.NDArray[np.uint8], a: float, b: float) -> Points:
    """The place (a, b) of each patch, as kernels put it there."""
    p, q = (a - b / 2, b / 2) if b <= a else (a / 2, b - a / 2)
    three = (sides == 3)[:, None]
    along, across = np.where(three, p, a), np.where(three, q, b)
    last = np.where(three, rows[:, 2], rows[:, 3])
    place: Points = rows[:, 0] + along * (rows[:, 1] - rows[:, 0]) + across * (last - rows[:, 0])
    return place


def _around(rows: Points, sides: npt.NDArray[np.uint8], a: float, b: float) -> Around:
    """The place (a, b) of each patch, and what lies as near to it as to the next such place."""
    half = 0.5 / _PLACES
    along = on_patches(rows, sides, a + half, b) - on_patches(rows, sides, a - half, b)
    across = on_patches(rows, sides, a, b + half) - on_patches(rows, sides, a, b - half)
    return Around(on_patches(rows, sides, a, b), np.stack([along, across], axis=1) / 2)


def _quarters(rows: Points, sides: npt.NDArray[np.uint8]) -> Points:
    """(4n, 4, …): four parts of each patch; the last corner of a triangle repeats its first."""
    a, b, c, d = (rows[:, k] for k in range(4))
    ab, bc, ca, cd, da = (a + b) / 2, (b + c) / 2, (c + a) / 2, (c + d) / 2, (d + a) / 2
    middle = (a + c) / 2
    quads = [(a, ab, middle, da), (ab, b, bc, middle), (middle, bc, c, cd), (da, middle, cd, d)]
    triangles = [(a, ab, ca, a), (ab, b, bc, ab), (ca, bc, c, ca), (ab, bc, ca, ab)]
    four, three = (np.stack([np.stack(part, axis=1) for part in parts], axis=1) for parts in (quads, triangles))
    chosen: Points = np.where((sides == 3)[:, None, None, None], three, four)
    return chosen.reshape(-1, *rows.shape[1:])


def _measured(corners: Points, sides: npt.NDArray[np.uint8]) -> tuple[Points, Points, Points]:
    """(centres, areas, radii around the centres) of patches."""
    three = sides == 3
    used = np.where(three[:, None, None], corners[:, [0, 1, 2, 0]], corners)
    centres = np.where(three[:, None], corners[:, :3].mean(axis=1), corners.mean(axis=1))
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = np.linalg.norm(np.cross(edge1, edge2), axis=1) * np.where(three, 0.5, 1.0)
    return centres, areas, np.linalg.norm(used - centres[:, None], axis=2).max(axis=1)


def _half_edges(corners: Points, sides: npt.NDArray[np.uint8]) -> Points:
    """(n, 6): halves of the edges from the first corner, to the second and to the last."""
    origin, last = corners[:, 0], np.where((sides == 3)[:, None], corners[:, 2], corners[:, 3])
    found: Points = np.concatenate([corners[:, 1] - origin, last - origin], axis=1) / 2
    return found


def _longest_edges(corners: Points, sides: npt.NDArray[np.uint8]) -> Points:
    used = np.where((sides == 3)[:, None, None], corners[:, [0, 1, 2, 0]], corners)
    edges: Points = np.linalg.norm(used - np.roll(used, 1, axis=1), axis=2).max(axis=1)
    return edges
