"""Exact answers about shapes: topology, inside and outside, curvature, Voronoi, Delaunay, medial axis.

Names are loaded when they are first used.
"""

from __future__ import annotations

import importlib
from typing import Any

# Public name → the module of this package that defines it.
_HOME: dict[str, str] = {
    "BoundingSphere": "bounds.sphere",
    "Cell": "diagrams.cells",
    "Circle": "triangulation.circles",
    "ClosestPoints": "closeness",
    "Components": "connectivity.components",
    "ConvexHull": "triangulation.hull",
    "CurvatureTotals": "curvature.discrete",
    "Delaunay": "triangulation.result",
    "DelaunayComplex": "triangulation.complex",
    "FeatureLines": "curvature.features",
    "FieldReport": "field_trust",
    "HalfEdges": "connectivity.half_edges",
    "MassProperties": "mass",
    "MedialAxis": "skeleton.result",
    "MedialSurface": "skeleton.surface",
    "PowerDiagram": "diagrams.power",
    "PrincipalCurvatures": "curvature.fit",
    "RayCrossings": "rays.result",
    "RepairReport": "mending.repair",
    "SelfIntersections": "self_intersection",
    "SurfacePoints": "sampling",
    "SweepEvent": "diagrams.events",
    "Topology": "connectivity.topology",
    "Voronoi": "diagrams.result",
    "angle_deficit": "curvature.discrete",
    "area": "mass",
    "barycentric": "barycentrics",
    "boolean": "solids",
    "bounding_box": "bounds.box",
    "bounding_sphere": "bounds.sphere",
    "circumcircle": "triangulation.circles",
    "closest_point": "closeness",
    "coloured": "colouring",
    "compare_equiangularity": "triangulation.angles",
    "contains": "inside",
    "convex_hull": "triangulation.hull",
    "curvature_totals": "curvature.discrete",
    "delaunay": "triangulation.triangulate",
    "distance": "closeness",
    "empty_circle_violations": "triangulation.circles",
    "equiangularity": "triangulation.angles",
    "feature_lines": "curvature.features",
    "field_report": "field_trust",
    "from_barycentric": "barycentrics",
    "gaussian_curvature": "curvature.discrete",
    "geodesic_distance": "geodesic",
    "half_edges": "connectivity.half_edges",
    "incircle": "predicates",
    "insphere": "predicates",
    "interpolate": "barycentrics",
    "laplacian": "curvature.operators",
    "lloyd": "diagrams.build",
    "mass_matrix": "curvature.operators",
    "mass_properties": "mass",
    "mean_curvature": "curvature.discrete",
    "medial_axis": "skeleton.axis",
    "orient": "connectivity.orientation",
    "orient2d": "predicates",
    "orient3d": "predicates",
    "point_in_convex_polygon": "polygon_inside",
    "point_in_polygon": "polygon_inside",
    "power_diagram": "diagrams.power",
    "principal_curvatures": "curvature.fit",
    "ray_box": "rays.solids",
    "ray_cone": "rays.solids",
    "ray_cylinder": "rays.solids",
    "ray_plane": "rays.flats",
    "ray_polygon": "rays.flats",
    "ray_quadric": "rays.solids",
    "ray_sphere": "rays.solids",
    "ray_torus": "rays.solids",
    "ray_triangle": "rays.flats",
    "refine_triangulation": "triangulation.refinement",
    "repair": "mending.repair",
    "sample_points": "sampling",
    "self_intersections": "self_intersection",
    "signed_distance": "closeness",
    "thickness": "wall_thickness",
    "topology": "connectivity.topology",
    "vertex_normals": "curvature.normals",
    "voronoi": "diagrams.build",
    "winding_number": "inside",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    try:
        home = _HOME[name]
    except KeyError:
        raise AttributeError(f"module 'isophote.analysis' has no attribute {name!r}") from None
    value = getattr(importlib.import_module(f"isophote.analysis.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
