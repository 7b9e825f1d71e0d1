"""Medial axes: of polygons, exactly, and of closed meshes, by balls inside them."""
