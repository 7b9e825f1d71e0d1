"""Boundary loops: the closed walks along edges of one face."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.stars import Faces, Ints, Longs, Stars
from isophote.analysis.crew import run
from isophote.kernels.measure import stars as kernels
from isophote.kernels.measure.pieces import trace_loops

__all__ = ["Chains", "Details", "Walks", "look_closer", "passed_vertices", "trace"]


class Details(NamedTuple):
    """What is special at some vertices.

    `edge_kind`, (corners,) uint8, is not zero for half-edges at edges that are no proper meeting of two faces; `ends`
    are pairs of ends of half-edges without a neighbour: end 2 h where half-edge h begins, 2 h + 1 where it ends. A
    pair is the two sides of one fan.
    """

    edge_kind: npt.NDArray[np.uint8]
    ends: Ints

    def half_edges(self, kind: np.uint8) -> Longs:
        """The half-edges of a kind, in increasing order."""
        return np.flatnonzero(self.edge_kind == kind)


class Chains(NamedTuple):
    """Half-edges of the boundary in the order of walks, and which walks are open because an edge of three faces stops
    them. Chain i is `half_edges[starts[i]:starts[i + 1]]`; `backward` tells where it runs against a half-edge.
    """

    half_edges: Longs
    backward: npt.NDArray[np.bool_]
    starts: Longs
    is_open: npt.NDArray[np.bool_]


class Walks(NamedTuple):
    """The vertices that chains pass, those of open ones with both ends: `vertices[starts[i]:starts[i + 1]]`."""

    vertices: Ints
    starts: Longs
    is_open: npt.NDArray[np.bool_]


def look_closer(stars: Stars, chosen: Longs) -> Details:
    """What is special at the vertices `chosen`."""
    sizes = stars.starts[chosen + 1] - stars.starts[chosen]
    places = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes, dtype=np.int64)])
    edge_kind = np.zeros(len(stars.indices), np.uint8)
    ends = np.full(2 * int(places[-1]), -1, np.int32)
    jobs = [
        (*stars.table, chosen, places, first, last, scratch, edge_kind, ends)
        for first, last, scratch in stars.ranges_of(chosen)
    ]
    run(kernels.look_closer, jobs)
    return Details(edge_kind, ends[ends >= 0].reshape(-1, 2))


def trace(details: Details) -> Chains:
    """The walks along the boundary; from one edge to the next across the fan between them."""
    lone = np.flatnonzero((details.edge_kind == kernels.EDGE_BOUNDARY) | (details.edge_kind == kernels.EDGE_CROWDED))
    crowded = details.edge_kind[lone] == kernels.EDGE_CROWDED
    # The same ends, with half-edges numbered as in `lone`.
    ends = 2 * np.searchsorted(lone, details.ends >> 1) + (details.ends & 1)
    partner = np.empty(2 * len(lone), np.int64)
    partner[ends[:, 0]], partner[ends[:, 1]] = ends[:, 1], ends[:, 0]
    order, starts = np.empty(len(lone), np.int64), np.empty(len(lone) + 1, np.int64)
    is_open = np.empty(len(lone), np.bool_)
    count = trace_loops(partner, crowded, order, starts, is_open)
    order = order[: starts[count]]
    return Chains(lone[order >> 1], (order & 1).astype(bool), starts[: count + 1], is_open[:count])


def passed_vertices(faces: Faces, chains: Chains) -> Walks:
    """The vertices that chains pass."""
    begins, ends = faces.indices[chains.half_edges], faces.indices[faces.ahead(chains.half_edges)]
    entered, left = np.where(chains.backward, ends, begins), np.where(chains.backward, begins, ends)
    last = chains.starts[1:][chains.is_open]
    vertices = np.insert(entered, last, left[last - 1])
    return Walks(vertices, chains.starts + np.concatenate([[0], np.cumsum(chains.is_open)]), chains.is_open)
