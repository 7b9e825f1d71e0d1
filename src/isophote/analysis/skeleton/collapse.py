"""Complexes of vertices, edges and polygons, collapsed from their rims: what is left hangs together as before."""

from __future__ import annotations

import heapq

import numpy as np

from isophote.analysis.arrays import read_only
from isophote.analysis.skeleton.surface import MedialSurface

__all__ = ["collapsed"]


def collapsed(axis: MedialSurface, least: float) -> MedialSurface:
    """The axis without what stands for less than `least`, as far as that can be collapsed.

    A polygon goes together with an edge that is at no other polygon, an edge at no polygon together with a vertex that
    is at no other edge: elementary collapses, which keep the homotopy type. Least first.
    """
    edges_left, polygons_left = _without_rims(axis, least)
    edges_left, vertices_left = _without_tips(axis, least, edges_left)
    number = np.full(len(axis.vertices), -1, np.int32)
    number[vertices_left] = np.arange(vertices_left.sum(), dtype=np.int32)
    polygon = np.full(len(polygons_left) + 1, -1, np.int32)
    polygon[:-1][polygons_left] = np.arange(polygons_left.sum(), dtype=np.int32)
    return MedialSurface(
        read_only(axis.vertices[vertices_left]),
        read_only(axis.radius[vertices_left]),
        read_only(number[axis.edges[edges_left]]),
        read_only(polygon[axis.edge_polygons[edges_left]]),
        read_only(axis.edge_feature[edges_left]),
        read_only(axis.polygon_feature[polygons_left]),
    )


def _without_rims(axis: MedialSurface, least: float) -> tuple[np.ndarray, np.ndarray]:
    at_edge = [[q for q in row if q >= 0] for row in axis.edge_polygons.tolist()]
    around: list[list[int]] = [[] for _ in axis.polygon_feature]
    for edge, polygons in enumerate(at_edge):
        for q in polygons:
            around[q].append(edge)
    feature = axis.polygon_feature.tolist()
    edges_left, polygons_left = np.ones(len(at_edge), np.bool_), np.ones(len(around), np.bool_)
    waiting = [(feature[row[0]], edge) for edge, row in enumerate(at_edge) if len(row) == 1]
    heapq.heapify(waiting)
    while waiting:
        size, edge = heapq.heappop(waiting)
        if size >= least:
            break
        if len(at_edge[edge]) != 1 or not edges_left[edge]:
            continue
        q = at_edge[edge][0]
        edges_left[edge] = polygons_left[q] = False
        for other in around[q]:
            at_edge[other].remove(q)
            if edges_left[other] and len(at_edge[other]) == 1:
                heapq.heappush(waiting, (feature[at_edge[other][0]], other))
    return edges_left, polygons_left


def _without_tips(axis: MedialSurface, least: float, edges_left: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    at_vertex: list[set[int]] = [set() for _ in axis.vertices]
    ends, feature = axis.edges.tolist(), axis.edge_feature.tolist()
    for edge in np.flatnonzero(edges_left).tolist():
        for vertex in ends[edge]:
            at_vertex[vertex].add(edge)
    vertices_left = np.ones(len(at_vertex), np.bool_)
    waiting = [(feature[next(iter(row))], vertex) for vertex, row in enumerate(at_vertex) if len(row) == 1]
    heapq.heapify(waiting)
    while waiting:
        size, vertex = heapq.heappop(waiting)
        if size >= least:
            break
        if len(at_vertex[vertex]) != 1:
            continue
        edge = at_vertex[vertex].pop()
        other = ends[edge][0] + ends[edge][1] - vertex
        edges_left[edge] = vertices_left[vertex] = False
        at_vertex[other].discard(edge)
        if len(at_vertex[other]) == 1:
            heapq.heappush(waiting, (feature[next(iter(at_vertex[other]))], other))
    return edges_left, vertices_left
