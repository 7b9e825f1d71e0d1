"""Descriptions of scenes: cameras, lights, materials, textures; no compiled code."""
