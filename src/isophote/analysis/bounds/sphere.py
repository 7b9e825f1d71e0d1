"""The least sphere around points, and a fast one."""

from __future__ import annotations

from itertools import combinations
from typing import Any, Literal, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.lower.primitive_table import primitive_of
from isophote.shapes.mesh import Mesh
from isophote.shapes.primitive.checks import finite_points
from isophote.shapes.primitive.extent import ball_around
from isophote.shapes.primitive.polygon import Polygon

__all__ = ["BoundingSphere", "bounding_sphere"]

Points: TypeAlias = npt.NDArray[np.float64]
Method: TypeAlias = Literal["welzl", "ritter"]

# A point this far outside, in parts of the radius, is rounding.
_OUTSIDE = 1e-13


@attrs.frozen(eq=False)
class BoundingSphere:
    """A sphere: `centre`, (3,), or (2,) in the plane, and `radius`. `support` (k,): numbers of the points that hold it,
    2 to 4 of them, 3 in the plane, in increasing order; empty where it was not found from points."""

    centre: Points
    radius: float
    support: npt.NDArray[np.int64]


def bounding_sphere(subject: Any, method: Method = "welzl") -> BoundingSphere:
    """A sphere around points, (n, 3) or (n, 2), a `Mesh`, a `Polygon`, or another shape that is one simple solid.

    "welzl": the least one. Points that are outside are taken into the support, the farthest first, and the least sphere
    of the support is found from its parts (Welzl, "Smallest enclosing disks (balls and ellipsoids)", 1991; Gärtner,
    "Fast and Robust Smallest Enclosing Balls", 1999). "ritter": one around two points far apart, grown to reach the
    others (Ritter, "An Efficient Bounding Sphere", 1990), a few per cent larger. No point is outside, whatever the
    rounding. Of balls, disks, boxes, and cylinders, cones and tori that were not sheared, it is known without points.
    Raises `GeometryError` for other subjects, endless shapes, no points, and coordinates that are not finite.
    """
    if method not in ("welzl", "ritter"):
        raise GeometryError(f'method must be "welzl" or "ritter", not {method!r}')
    points = _points_of(subject)
    if points is None:
        primitive = primitive_of(subject)
        if primitive is None:
            raise GeometryError(
                f"bounding_sphere takes points, a Mesh or a shape of one simple solid, not {type(subject).__name__}"
            )
        centre, radius = ball_around(primitive)
        if not np.isfinite(radius):
            raise GeometryError("the shape is endless, so no sphere holds it")
        return BoundingSphere(centre, radius, np.zeros(0, np.int64))
    # Scaled, so that squares neither overflow nor vanish.
    middle = (points.min(axis=0) / 2 + points.max(axis=0) / 2)[None]
    moved = points - middle
    size = float(np.abs(moved).max()) or 1.0
    moved /= size
    if method == "welzl":
        centre, support = _welzl(moved)
    else:
        centre, support = _ritter(moved), np.zeros(0, np.int64)
    placed = centre * size + middle[0]
    radius = float(np.linalg.norm(moved - centre, axis=1).max()) * size
    return BoundingSphere(placed, _held(points, placed, radius), np.sort(support))


def _held(points: Points, centre: Points, radius: float) -> float:
    """The radius from the centre as it was rounded."""
    with np.errstate(over="ignore"):
        reach = float(np.linalg.norm(points - centre, axis=1).max())
    return reach if np.isfinite(reach) else radius


def _points_of(subject: Any) -> Points | None:
    if isinstance(subject, Mesh):
        return subject.vertices[np.unique(subject.indices)]
    if isinstance(subject, Polygon):
        return subject.outline
    if hasattr(type(subject), "bounds"):
        return None
    width = np.shape(subject)[1] if np.ndim(subject) == 2 else 3
    return finite_points("points", subject, 2 if width == 2 else 3)


def _circumcentre(points: Points) -> Points:
    """The point of their own affine hull that is equally far from a few points; NaN where they do not span it."""
    edges = points[1:] - points[0]
    gram = edges @ edges.T
    try:
        return np.asarray(points[0] + np.linalg.solve(2 * gram, np.diag(gram)) @ edges)
    except np.linalg.LinAlgError:
        return np.full(points.shape[1], np.nan)


def _basis(points: Points, newest: int) -> tuple[Points, tuple[int, ...]]:
    """The least sphere of a handful of points, of which one must be on it: (centre, numbers of those that hold it)."""
    others = [k for k in range(len(points)) if k != newest]
    best, centre = np.inf, points[newest]
    held_by: tuple[int, ...] = (newest,)
    for count in range(min(points.shape[1], len(others)) + 1):
        for chosen in combinations(others, count):
            support = (newest, *chosen)
            at = _circumcentre(points[list(support)]) if count else points[newest]
            reach = np.linalg.norm(points - at, axis=1)
            radius = reach[newest]
            if radius < best and (reach <= radius * (1 + _OUTSIDE)).all():
                best, centre, held_by = radius, at, support
    return centre, held_by


def _welzl(points: Points) -> tuple[Points, npt.NDArray[np.int64]]:
    """The centre of the least sphere, and the points that hold it."""
    support = np.array([0])
    centre, radius = points[0], 0.0
    while True:
        reach = np.linalg.norm(points - centre, axis=1)
        farthest = int(reach.argmax())
        if reach[farthest] <= radius * (1 + _OUTSIDE) or farthest in support:
            return centre, support
        tried = np.append(support, farthest)
        at, held_by = _basis(points[tried], len(tried) - 1)
        grown = float(np.linalg.norm(points[farthest] - at))
        if not grown > radius:
            # What is gained is below rounding.
            return centre, support
        centre, radius, support = at, grown, tried[list(held_by)]


def _ritter(points: Points) -> Points:
    """The centre of a sphere that was grown, always toward the farthest point outside."""
    first = points[int(np.linalg.norm(points - points[0], axis=1).argmax())]
    second = points[int(np.linalg.norm(points - first, axis=1).argmax())]
    centre, radius = (first + second) / 2, float(np.linalg.norm(second - first)) / 2
    while True:
        reach = np.linalg.norm(points - centre, axis=1)
        farthest = int(reach.argmax())
        excess = float(reach[farthest]) - radius
        if excess <= _OUTSIDE * radius:
            return np.asarray(centre)
        centre = centre + (points[farthest] - centre) * (excess / 2 / reach[farthest])
        radius += excess / 2
