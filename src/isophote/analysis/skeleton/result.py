"""What the medial axis of a polygon is."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.skeleton.pruning import pruned
from isophote.errors import GeometryError

__all__ = ["Balls", "MedialAxis"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]
BoolArray: TypeAlias = npt.NDArray[np.bool_]


class Balls(NamedTuple):
    """`centre` (..., 2) and `radius` (...) of balls, `feet` (..., 2, 2) of where they touch."""

    centre: FloatArray
    radius: FloatArray
    feet: FloatArray


@attrs.frozen(eq=False, repr=False, slots=False)
class MedialAxis:
    """The medial axis of a polygon: the middles of all balls in it that touch the boundary in two points or more.

    rings      the polygon: (k, 2) float64 corners, the outer ring counterclockwise, holes clockwise. Edges and corners
               are numbered through all rings; edge k starts at corner k
    vertices   (v, 2) float64
    radius     (v,) float64: of the ball around each; 0 at corners where the inside is narrower than a half-plane
    arcs       (a, 2) int32: the vertices at the ends of each arc
    sites      (a, 2) int32: what its balls touch, to the right and to the left: edge k, or corner k as n + k
    """

    rings: tuple[FloatArray, ...]
    vertices: FloatArray
    radius: FloatArray
    arcs: IntArray
    sites: IntArray

    @cached_property
    def _corners(self) -> FloatArray:
        return np.concatenate(self.rings)

    @cached_property
    def _directions(self) -> FloatArray:
        along = np.concatenate([np.roll(ring, -1, axis=0) - ring for ring in self.rings])
        directions: FloatArray = along / np.hypot(along[:, 0], along[:, 1])[:, None]
        return directions

    @property
    def parabolic(self) -> BoolArray:
        """(a,) bool: whether an arc is a parabola, between an edge and a corner, and not a straight line."""
        of_edge = self.sites < len(self._corners)
        return np.asarray(of_edge[:, 0] != of_edge[:, 1])

    @property
    def euler(self) -> int:
        """Vertices less arcs: the Euler characteristic, 1 less the number of holes."""
        return len(self.vertices) - len(self.arcs)

    def at(self, arc: npt.ArrayLike, t: npt.ArrayLike) -> Balls:
        """The balls of arcs at t, from 0 at the first end to 1 at the second; both broadcast against each other.

        Along a straight arc t is proportional to the length, along a parabola to the way of the foot on the edge.
        Raises `GeometryError` for arcs that are not there and t beyond 0 and 1.
        """
        numbers, steps = np.broadcast_arrays(np.asarray(arc), np.asarray(t, np.float64))
        if not np.issubdtype(numbers.dtype, np.integer) or ((numbers < 0) | (numbers >= len(self.arcs))).any():
            raise GeometryError(f"arcs are whole numbers from 0 to {len(self.arcs) - 1}")
        if not ((steps >= 0) & (steps <= 1)).all():
            raise GeometryError("t must lie between 0 and 1")
        return self._at(numbers, steps)

    def _at(self, arc: npt.NDArray[np.integer], t: FloatArray) -> Balls:
        a, b = self.vertices[self.arcs[arc, 0]], self.vertices[self.arcs[arc, 1]]
        s = t[..., None]
        centre = a + s * (b - a)
        curved = self.parabolic[arc]
        if curved.any():
            centre[curved] = self._on_parabola(arc[curved], a[curved], b[curved], s[curved])
        # Ends are vertices to the last place.
        centre = np.where(s == 1, b, centre)
        feet = np.stack([self._foot(self.sites[arc, side], centre) for side in (0, 1)], axis=-2)
        radius = np.linalg.norm(feet - centre[..., None, :], axis=-1).mean(axis=-1)
        return Balls(centre, radius, feet)

    def _on_parabola(self, arc: npt.NDArray[np.integer], a: FloatArray, b: FloatArray, t: FloatArray) -> FloatArray:
        """The point above the edge that is as far from it as from the corner."""
        count = len(self._corners)
        sites = self.sites[arc]
        edge, corner = sites.min(axis=-1), sites.max(axis=-1) - count
        origin, along, focus = self._corners[edge], self._directions[edge], self._corners[corner]
        normal = np.stack([-along[..., 1], along[..., 0]], axis=-1)
        u, v, w = (((p - origin) * along).sum(axis=-1, keepdims=True) for p in (a, b, focus))
        h = ((focus - origin) * normal).sum(axis=-1, keepdims=True)
        foot = u + t * (v - u)
        place: FloatArray = origin + foot * along + normal * ((foot - w) ** 2 + h * h) / (2 * h)
        return place

    def _foot(self, site: IntArray, x: FloatArray) -> FloatArray:
        count = len(self._corners)
        number = site % count
        origin, along = self._corners[number], self._directions[number]
        way = ((x - origin) * along).sum(axis=-1) * (site < count)
        foot: FloatArray = origin + way[..., None] * along
        return foot

    def sampled(self, spacing: float) -> Balls:
        """Balls along all arcs, at most `spacing` apart, ends included: (m, 2), (m,) and (m, 2, 2)."""
        if not spacing > 0:
            raise GeometryError(f"spacing must be above 0, not {spacing!r}")
        lengths = np.linalg.norm(self.vertices[self.arcs[:, 0]] - self.vertices[self.arcs[:, 1]], axis=1)
        # A parabola is at most √2 as long as its chord and its axis' share together; feet never move farther.
        steps = np.ceil(2 * lengths / spacing).astype(np.int64) + 1
        arc = np.repeat(np.arange(len(self.arcs)), steps + 1)
        first = np.concatenate([[0], np.cumsum(steps + 1)[:-1]])
        return self._at(arc, (np.arange(len(arc)) - first[arc]) / steps[arc])

    def pruned(self, feature: float = 0.0, scale: float = 1.0) -> MedialAxis:
        """The axis without branches that stand for little of the boundary; what is left hangs together as before.

        `feature`: from their ends, branches are cut back to where the two points that a ball touches are 2 `feature`
        apart (Chazal and Lieutier, "The λ-medial axis", 2005). `scale`, 1 or more: arcs at ends are left out as long
        as the ball at the outer end, enlarged by this factor about its middle, lies within the one at the inner end,
        enlarged too (after Giesen, Miklos, Pauly and Wormser, "The scale axis transform", 2009). Raises
        `GeometryError` for other numbers.
        """
        return pruned(self, feature, scale)

    def part(self, keep: BoolArray, vertices: FloatArray, radius: FloatArray, arcs: IntArray) -> MedialAxis:
        """The axis with only some of `arcs`, and only those of `vertices` at their ends; one vertex where no arc is
        left."""
        kept = arcs[keep]
        used = np.unique(kept) if len(kept) else np.array([int(np.argmax(radius))])
        number = np.full(len(vertices), -1, np.int32)
        number[used] = np.arange(len(used), dtype=np.int32)
        return MedialAxis(
            self.rings,
            read_only(vertices[used]),
            read_only(radius[used]),
            read_only(number[kept]),
            read_only(self.sites[keep]),
        )

    def __repr__(self) -> str:
        curved = int(self.parabolic.sum())
        return f"MedialAxis({len(self.vertices)} vertices, {len(self.arcs)} arcs, {curved} of them parabolic)"
