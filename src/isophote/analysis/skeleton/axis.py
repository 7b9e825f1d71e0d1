"""Medial axes of polygons and of meshes."""

from __future__ import annotations

from typing import Any, overload

from isophote.analysis.skeleton.plane import medial_axis_of_polygon
from isophote.analysis.skeleton.result import MedialAxis
from isophote.analysis.skeleton.solid import MedialSurface, medial_axis_of_mesh
from isophote.shapes.mesh import Mesh

__all__ = ["medial_axis"]


@overload
def medial_axis(shape: Mesh, *, samples: int = ..., feature: float | None = ..., seed: int = ...) -> MedialSurface: ...
@overload
def medial_axis(shape: Any) -> MedialAxis: ...


def medial_axis(
    shape: Any, *, samples: int = 4000, feature: float | None = None, seed: int = 0
) -> MedialAxis | MedialSurface:
    """The medial axis of a polygon with holes or of a closed mesh: middles of balls in it that touch it twice or more.

    A polygon is given by its corners, (k, 2), or by a sequence of rings of corners, of which the first is the outer
    one; its axis is exact up to rounding, and the union of its balls is the polygon. Corners in the middle of straight
    stretches are left out.

    For a mesh the axis is made of the inner vertices of the Voronoi diagram of its vertices and of `samples` points on
    it, by `seed`, and pruned of what stands for less than `feature` of it, in the mesh's units (3 % of its diagonal if
    None), in a way that keeps its Euler characteristic; these three are for meshes only. Raises `GeometryError` for
    rings that meet or enclose nothing, and for meshes that do not bound a solid.
    """
    if isinstance(shape, Mesh):
        return medial_axis_of_mesh(shape, samples, feature, seed)
    return medial_axis_of_polygon(shape)
