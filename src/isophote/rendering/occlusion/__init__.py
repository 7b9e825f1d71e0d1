"""Ambient occlusion: at points, in pictures, from depth, and baked into textures."""
