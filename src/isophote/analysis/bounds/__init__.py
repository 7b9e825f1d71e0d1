"""Boxes and spheres around shapes."""
