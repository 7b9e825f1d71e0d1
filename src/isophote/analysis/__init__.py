"""Exact answers about shapes: topology, inside and outside, curvature, Voronoi, Delaunay, medial axis."""
