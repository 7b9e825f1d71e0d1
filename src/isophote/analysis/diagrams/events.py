"""Fortune's sweep, event by event, to be looked at."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.diagrams.order import in_order
from isophote.kernels.measure import fortune
from isophote.kernels.measure.diagram import centres
from isophote.kernels.measure.fortune_state import ARCS, CIRCLES, SITE, TRIANGLES, Sweep, new_sweep

__all__ = ["SweepEvent", "sweep_events"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_ONE = np.int64(1)


@attrs.frozen(eq=False)
class SweepEvent:
    """The state of a sweep just after an event.

    kind          "site": a site, or all that share the least y, came onto the beach line; "circle": an arc vanished
    y             where the sweep line is; it goes upwards
    arcs          (k,) int32: the sites of the arcs of the beach line, from left to right
    breakpoints   (k - 1, 2) float64: where arcs meet, on edges that are being drawn; infinite where two sites of the
                  first row meet as yet below everything
    sites         (j,) int32: the sites that came by this event; at a circle, the three that a vertex lies between
    vertex        (2,) float64: the vertex that a circle event found, None at a site
    edges         (m, 2) int32: pairs of sites between which an edge begins
    """

    kind: Literal["site", "circle"]
    y: float
    arcs: IntArray
    breakpoints: FloatArray
    sites: IntArray
    vertex: FloatArray | None
    edges: IntArray
    _places: FloatArray = attrs.field(repr=False)

    def beach(self, x: npt.ArrayLike) -> FloatArray:
        """The heights of the beach line above x: the greatest of the parabolas around the sites below the sweep line;
        -inf where there is none."""
        places = self._places[self.arcs]
        at = np.asarray(x, np.float64)
        height = np.full(at.shape, -np.inf)
        for ax, ay in places[places[:, 1] < self.y]:
            height = np.maximum(height, (self.y + ay) / 2 - (at - ax) ** 2 / (2 * (self.y - ay)))
        return height


def sweep_events(points: FloatArray) -> Iterator[SweepEvent]:
    """All events of a sweep over finite points (n, 2)."""
    ordered = in_order(points)
    sweep = new_sweep(ordered.sites.places)
    seen, circles = 0, 0
    while True:
        y = _unscaled(fortune.advance(sweep.table.words, _ONE), ordered.sites.exponent)
        if np.isnan(y):
            return
        arcs = ordered.names[_owners(sweep)]
        new = ordered.names[seen : int(sweep.counts[SITE])]
        if sweep.counts[CIRCLES] > circles:
            circles += 1
            corners = ordered.names[sweep.triangles[int(sweep.counts[TRIANGLES]) - 1]]
            vertex = np.empty(2)
            centres(points.reshape(-1), corners, 0, 1, vertex)
            edges = corners[None, [0, 2]]
            yield _event("circle", y, arcs, points, corners, vertex, edges)
            continue
        edges = _new_edges(arcs, new, first=seen == 0)
        seen += len(new)
        yield _event("site", y, arcs, points, new, None, edges)


def _event(
    kind: Literal["site", "circle"],
    y: float,
    arcs: IntArray,
    points: FloatArray,
    sites: IntArray,
    vertex: FloatArray | None,
    edges: IntArray,
) -> SweepEvent:
    breakpoints = read_only(_breakpoints(points[arcs], y))
    found = None if vertex is None else read_only(vertex)
    return SweepEvent(kind, y, read_only(arcs), breakpoints, read_only(sites), found, read_only(edges), points)


def _unscaled(y: float, exponent: int) -> float:
    with np.errstate(over="ignore"):
        return float(np.ldexp(y, exponent))


def _owners(sweep: Sweep) -> npt.NDArray[np.int64]:
    """The sites of the arcs, from left to right."""
    owners = np.empty(int(sweep.counts[ARCS]), np.int64)
    return owners[: fortune.owners(sweep.table.words, owners)]


def _new_edges(arcs: IntArray, new: IntArray, first: bool) -> IntArray:
    if first:
        return np.stack([new[:-1], new[1:]], axis=1)
    at = int(np.flatnonzero(arcs == new[0])[0])
    return np.array([[arcs[at - 1], new[0]]], np.int32)


def _breakpoints(places: FloatArray, y: float) -> FloatArray:
    """(k - 1, 2) where the parabolas of neighbouring sites (k, 2) meet, the left one being ahead on the left."""
    a, b = places[:-1], places[1:]
    with np.errstate(all="ignore"):
        x = _meeting(a[:, 0], y - a[:, 1], b[:, 0], y - b[:, 1])
        low = np.where(a[:, 1] < b[:, 1], a[:, 1], b[:, 1])
        of = np.where(a[:, 1] < b[:, 1], a[:, 0], b[:, 0])
        height = np.where(low < y, (y + low) / 2 - (x - of) ** 2 / (2 * (y - low)), -np.inf)
    return np.stack([x, height], axis=1)


def _meeting(ax: FloatArray, ad: FloatArray, bx: FloatArray, bd: FloatArray) -> FloatArray:
    """The x at which the parabola of site a, `ad` below the line, gives way to that of b.

    (x - ax)² / ad + ad = (x - bx)² / bd + bd; with d = bx - ax and t = x - ax, (bd - ad) t² + 2 ad d t - ad (d² + bd
    (bd - ad)) = 0, of which the root is taken for which the left-hand side grows.
    """
    d, fall = bx - ax, bd - ad
    half, rest = ad * d, ad * (d * d + bd * fall)
    root = np.sqrt(np.maximum(half * half + fall * rest, 0))
    t = np.where(half >= 0, rest / (half + root), (root - half) / fall)
    return np.where(ad == 0, ax, np.where(bd == 0, bx, np.where(fall == 0, ax + d / 2, ax + t)))
