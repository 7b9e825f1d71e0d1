"""Repairing meshes, step by step, with everything that survives kept."""
