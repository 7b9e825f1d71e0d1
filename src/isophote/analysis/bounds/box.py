"""Least boxes around shapes as they stand."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.lower.primitive_table import primitive_of
from isophote.scene.scene import Item, placed_box
from isophote.shapes.mesh import Mesh
from isophote.shapes.primitive.checks import finite_points
from isophote.shapes.primitive.extent import box_around
from isophote.shapes.primitive.polygon import Polygon

__all__ = ["bounding_box"]

Box: TypeAlias = npt.NDArray[np.float64]


def bounding_box(subject: Any) -> Box:
    """(2, 3): least and greatest corner of a box around points (n, 3), a shape, or an `Item` where it stands.

    The least box, whatever the transforms, of points, meshes, polygons, disks, and fields that are one simple solid
    (spheres, ellipsoids, boxes, cylinders, cones, tori, planes, slabs; moved, turned, mirrored, scaled, sheared);
    infinite where they are endless. Of other fields, their bounds. Raises `GeometryError` for other subjects.
    """
    matrix = subject.transform.matrix if isinstance(subject, Item) else np.eye(4)
    shape: Any = subject.shape if isinstance(subject, Item) else subject
    if isinstance(shape, Mesh | Polygon):
        points = shape.vertices[np.unique(shape.indices)] if isinstance(shape, Mesh) else shape.outline
        return _around(points @ matrix[:3, :3].T + matrix[:3, 3])
    if not hasattr(type(shape), "bounds"):
        return _around(finite_points("points", shape, 3))
    primitive = primitive_of(shape)
    if primitive is not None:
        return box_around(primitive.placed(matrix))
    box = np.asarray(shape.bounds, np.float64)
    if box.shape != (2, 3):
        raise GeometryError(f"bounding_box takes shapes in space, not {type(shape).__name__}")
    return placed_box(box, matrix)


def _around(points: Box) -> Box:
    return np.stack([points.min(axis=0), points.max(axis=0)])
