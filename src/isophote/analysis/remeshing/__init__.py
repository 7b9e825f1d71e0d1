"""Meshes of the same surface with other triangles."""
