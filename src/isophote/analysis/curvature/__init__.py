"""Normals and curvatures of meshes."""
