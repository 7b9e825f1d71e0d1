"""Disk and sphere lights as primitives, which rays find by a tree: a few are asked one by one, many would take long."""

from __future__ import annotations

import numpy as np

from isophote.scene.light import DiskLight, SphereLight
from isophote.scene.scene import Scene
from isophote.shapes.primitive.primitive import Primitive

__all__ = ["lamp_primitive", "many_lamps"]

# So many are asked one by one; measured: from about ten on a tree takes less time.
_FEW = 12


def many_lamps(scene: Scene) -> dict[int, DiskLight | SphereLight]:
    """The disk and sphere lights of a scene by their numbers, or none where there are few."""
    numbered = enumerate(scene.lights, start=len(scene.items))
    lamps = {number: light for number, light in numbered if isinstance(light, DiskLight | SphereLight)}
    return lamps if len(lamps) > _FEW else {}


def lamp_primitive(light: DiskLight | SphereLight) -> Primitive:
    """The light's own surface, outward where it shines."""
    matrix, radius = light.transform.matrix, light.radius
    if isinstance(light, SphereLight):
        return Primitive("ball", matrix @ np.diag([radius, radius, radius, 1.0]), np.zeros(0))
    # A disk faces +y in its own space, a light −y.
    return Primitive("disk", matrix @ np.diag([radius, -1.0, -radius, 1.0]), np.zeros(0))
