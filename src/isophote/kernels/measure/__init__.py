"""Kernels that measure: predicates at work, distances, winding numbers, triangulations."""
