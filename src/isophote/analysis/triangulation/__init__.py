"""Delaunay triangulations: of the plane, constrained and refined, of space, and by lifted hulls."""
