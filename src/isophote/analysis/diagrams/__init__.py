"""Diagrams of points of the plane: Voronoi's and its weighted kin, their cells, and relaxation."""
