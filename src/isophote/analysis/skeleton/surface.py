"""What the medial axis of a solid is: balls, and how they hang together."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.convert.contour import to_mesh
from isophote.errors import GeometryError
from isophote.shapes.field.field import Field
from isophote.shapes.field.operations import union
from isophote.shapes.field.rounds import rounded_cone
from isophote.shapes.field.solids import sphere
from isophote.shapes.mesh import Mesh

__all__ = ["MedialSurface"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_MOST_BALLS = 400
# The size of the cells of `mesh`, in parts of the diagonal.
_CELL = 0.01


@attrs.frozen(eq=False, repr=False)
class MedialSurface:
    """The medial axis of a solid: vertices, edges and polygons of the Voronoi diagram of samples that lie inside.

    vertices          (v, 3) float64: middles of balls that touch the boundary in four samples
    radius            (v,) float64: of the balls
    edges             (e, 2) int32 numbers of vertices
    edge_polygons     (e, 3) int32: the polygons at each edge, -1 for none
    edge_feature      (e,) float64: half the greatest distance between samples that the balls along an edge touch
    polygon_feature   (p,) float64: half the distance between the two samples that the balls of a polygon touch
    """

    vertices: FloatArray
    radius: FloatArray
    edges: IntArray
    edge_polygons: IntArray
    edge_feature: FloatArray
    polygon_feature: FloatArray

    @property
    def euler(self) -> int:
        """Vertices less edges plus polygons: the Euler characteristic, half that of the solid's boundary."""
        return len(self.vertices) - len(self.edges) + len(self.polygon_feature)

    def polygons(self) -> list[IntArray]:
        """The vertices around each polygon."""
        at: list[dict[int, list[int]]] = [{} for _ in self.polygon_feature]
        for (a, b), row in zip(self.edges.tolist(), self.edge_polygons.tolist(), strict=True):
            for q in row:
                if q >= 0:
                    at[q].setdefault(a, []).append(b)
                    at[q].setdefault(b, []).append(a)
        return [np.array(_around(links), np.int32) for links in at]

    def sheets(self) -> Mesh:
        """The polygons as a mesh, to be drawn. Raises `GeometryError` where there are none."""
        found = self.polygons()
        if not found:
            raise GeometryError("this axis has no sheets, only curves; its edges are the axis")
        used = np.unique(np.concatenate(found))
        number = np.zeros(len(self.vertices), np.int32)
        number[used] = np.arange(len(used), dtype=np.int32)
        return Mesh(self.vertices[used], [number[polygon].tolist() for polygon in found])

    def shape(self, most: int = _MOST_BALLS) -> Field:
        """The solid again, about: the union of `most` of the balls, and of the cones around those that hang together.

        The largest balls are taken first, each other one where none taken covers its middle by three quarters of its
        radius; balls that are not taken are joined to one that is, along edges. Raises `GeometryError` where `most` is
        no whole number above 0.
        """
        if isinstance(most, bool) or not isinstance(most, int | np.integer) or most < 1:
            raise GeometryError(f"most must be a whole number above 0, not {most!r}")
        chosen, links = self._simplified(int(most))
        parts = [sphere(self.radius[i]).translate(self.vertices[i]) for i in chosen]
        return union(*parts, *(cone for a, b in links if (cone := self._cone(a, b)) is not None))

    def mesh(self, cell: float | None = None, most: int = _MOST_BALLS) -> Mesh:
        """The solid again, about, as a closed mesh: `shape` with cells of this size, by default 1 % of the diagonal."""
        field = self.shape(most)
        return to_mesh(
            field, cell=_CELL * float(np.linalg.norm(np.ptp(field.bounds, axis=0))) if cell is None else cell
        )

    def _simplified(self, most: int) -> tuple[list[int], list[tuple[int, int]]]:
        """Some of the vertices, and pairs of them that hang together."""
        owner = np.full(len(self.vertices), -1, np.int64)
        chosen: list[int] = []
        reach = np.full(len(self.vertices), np.inf)
        for i in np.argsort(-self.radius, kind="stable").tolist():
            if owner[i] >= 0:
                continue
            if len(chosen) == most:
                break
            chosen.append(i)
            away = np.linalg.norm(self.vertices - self.vertices[i], axis=1)
            near = (away < 0.75 * self.radius[i]) & (away < reach)
            near[i] = True
            owner[near], reach[near] = i, away[near]
            owner[chosen] = chosen
        self._spread_owners(owner)
        pairs = np.sort(owner[self.edges], axis=1)
        pairs = np.unique(pairs[(pairs[:, 0] != pairs[:, 1]) & (pairs >= 0).all(axis=1)], axis=0)
        return chosen, [(int(a), int(b)) for a, b in pairs]

    def _spread_owners(self, owner: npt.NDArray[np.int64]) -> None:
        """Give vertices without an owner that of a neighbour, as far as they hang together."""
        while True:
            a, b = self.edges.T
            owned = owner[self.edges] >= 0
            forwards, backwards = owned[:, 0] & ~owned[:, 1], owned[:, 1] & ~owned[:, 0]
            if not (forwards | backwards).any():
                return
            owner[b[forwards]] = owner[a[forwards]]
            owner[a[backwards]] = owner[b[backwards]]

    def _cone(self, a: int, b: int) -> Field | None:
        """The hull of two balls; None where one holds the other."""
        along = self.vertices[b] - self.vertices[a]
        apart = float(np.linalg.norm(along))
        low, high = float(self.radius[a]), float(self.radius[b])
        if apart <= abs(low - high) * (1 + 1e-6):
            return None
        height = apart + low + high
        up = along / apart
        side = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
        side /= np.linalg.norm(side)
        matrix = np.eye(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = side, up, np.cross(side, up)
        # The cone's middle is at half its height; its lower ball's middle is one radius above its lower end.
        matrix[:3, 3] = self.vertices[a] + up * (height / 2 - low)
        return rounded_cone(low, high, height).affine(matrix)

    def __repr__(self) -> str:
        return (
            f"MedialSurface({len(self.vertices)} vertices, {len(self.edges)} edges, "
            f"{len(self.polygon_feature)} polygons)"
        )


def _around(links: dict[int, list[int]]) -> list[int]:
    """The closed walk along the edges of a polygon."""
    first = min(links)
    walk, before, here = [first], first, links[first][0]
    while here != first:
        walk.append(here)
        a, b = links[here]
        before, here = here, b if a == before else a
    return walk
