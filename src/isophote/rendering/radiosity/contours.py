"""Form factors between whole polygons, by integrals along their edges."""

from __future__ import annotations

import itertools
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError

__all__ = ["form_factor"]

Points: TypeAlias = npt.NDArray[np.float64]

# How far corners may lie off their plane, or edges turn inward, in parts of the polygon's size.
_FLAT = 1e-6
# Distances in sizes from which polygons are integrated over their areas: along edges, digits cancel.
_FAR = 500.0
# Places of the rule along pieces of edges: its ends come double exponentially near, where logarithms have poles.
_STEP, _REACH = 0.1, 3.3


def form_factor(first: npt.ArrayLike, second: npt.ArrayLike) -> float:
    """The part of the light from the polygon `first` (n, 3) that meets `second` (m, 3), nothing being in the way.

        F₁₂ = 1/A₁ ∫∫ cosθ₁ cosθ₂ / (π r²) dA₂ dA₁ = 1/(2π A₁) ∮∮ ln r dr₁ · dr₂

    Polygons are flat and convex and send and receive light on the side that their corners run counterclockwise around;
    what lies behind the other's plane takes no part, and they may touch. One integral of the logarithm is closed, the
    other a double exponential rule; errors are below 1e-9. F₁₂ A₁ = F₂₁ A₂. Raises `GeometryError` for other polygons.

    Source: Sparrow, "A New and Simpler Formulation for Radiative Angle Factors", Journal of Heat Transfer 85, 1963.
    """
    p, q = _checked(first, "first"), _checked(second, "second")
    # Near the origin and of size 1 no digits are lost.
    origin = p.mean(axis=0)
    size = max(float(np.ptp(p, axis=0).max()), float(np.ptp(q, axis=0).max()))
    p, q = (p - origin) / size, (q - origin) / size
    area = float(np.linalg.norm(_area(p)))
    near, seen = _clipped(p, q), _clipped(q, p)
    if len(near) < 3 or len(seen) < 3:
        return 0.0
    distance = float(np.linalg.norm(near.mean(axis=0) - seen.mean(axis=0)))
    reach = max(float(np.ptp(near, axis=0).max()), float(np.ptp(seen, axis=0).max()))
    exchanged = _over_areas(near, seen) if distance > _FAR * reach else _along_edges(near, seen, distance)
    return min(max(exchanged / area, 0.0), 1.0)


def _area(polygon: Points) -> Points:
    """Normal of a flat polygon, as long as its area."""
    fan = polygon[1:] - polygon[0]
    area: Points = np.cross(fan[:-1], fan[1:]).sum(axis=0) / 2
    return area


def _checked(corners: npt.ArrayLike, name: str) -> Points:
    polygon = np.asarray(corners, np.float64)
    if polygon.ndim != 2 or polygon.shape[1] != 3 or len(polygon) < 3:
        raise GeometryError(f"form_factor: {name} must be corners (n, 3), three or more, not {polygon.shape}")
    if not np.isfinite(polygon).all():
        raise GeometryError(f"form_factor: {name} has corners that are not finite")
    size = float(np.ptp(polygon, axis=0).max())
    if size == 0.0:
        raise GeometryError(f"form_factor: {name} has no area")
    local = (polygon - polygon[0]) / size
    normal = _area(local)
    area = float(np.linalg.norm(normal))
    if area < 1e-12:
        raise GeometryError(f"form_factor: {name} has no area")
    normal /= area
    if np.abs(local @ normal).max() > _FLAT:
        raise GeometryError(f"form_factor: {name} is not flat; cut it into triangles")
    edges = np.roll(local, -1, axis=0) - local
    turns = np.cross(edges, np.roll(edges, -1, axis=0)) @ normal
    # Edges that all turn left but run around more than once enclose some of the area twice.
    heading = np.arctan2(turns, (edges * np.roll(edges, -1, axis=0)).sum(axis=1)).sum()
    if turns.min() < -_FLAT or heading > 3 * np.pi:
        raise GeometryError(f"form_factor: {name} is not convex; cut it into triangles")
    return polygon


def _clipped(polygon: Points, other: Points) -> Points:
    """What of `polygon` lies in front of the plane of `other`; fewer than three corners where nothing does."""
    normal = _area(other)
    normal = normal / np.linalg.norm(normal)
    height = (polygon - other[0]) @ normal
    height[np.abs(height) < 1e-12] = 0.0
    if height.max() <= 0.0:
        return np.zeros((0, 3))
    kept = []
    for k in range(len(polygon)):
        after = (k + 1) % len(polygon)
        if height[k] >= 0.0:
            kept.append(polygon[k])
        if height[k] * height[after] < 0.0:
            part = height[k] / (height[k] - height[after])
            kept.append(polygon[k] + part * (polygon[after] - polygon[k]))
    return np.array(kept)


def _double_exponential() -> tuple[Points, Points, Points]:
    """(distance from the start, distance from the end, weight) of places on 0 … 1 (Takahasi, Mori, 1974)."""
    t = np.arange(-_REACH, _REACH + _STEP / 2, _STEP)
    u = np.pi / 2 * np.sinh(t)
    start, end = 1 / (1 + np.exp(-2 * u)), 1 / (1 + np.exp(2 * u))
    weight = _STEP * np.pi * np.cosh(t) * start * end
    return start, end, weight / weight.sum()


def _along_edges(p: Points, q: Points, unit: float) -> float:
    """1/2π ∮∮ ln (r / unit) dr₁ · dr₂: the unit changes nothing, for contours are closed."""
    start, end, weight = _double_exponential()
    sum_ = 0.0
    for a, b in zip(p, np.roll(p, -1, axis=0), strict=True):
        way = b - a
        length = float(np.linalg.norm(way))
        for c, d in zip(q, np.roll(q, -1, axis=0), strict=True):
            along = float(way @ (d - c))
            if along == 0.0 or length == 0.0:
                continue
            # The inner integral is smooth but where the edges come nearest, and next to the other's ends.
            cuts = _breaks(a, way, c, d)
            for low, high in itertools.pairwise(cuts):
                places = a + (low * end + high * start)[:, None] * way
                sum_ += along * (high - low) * float(weight @ _mean_log(places, c, d, unit))
    return sum_ / (2 * np.pi)


def _breaks(a: Points, way: Points, c: Points, d: Points) -> Points:
    """Where along a + t way, 0 ≤ t ≤ 1, the segment from c to d comes nearest, and its ends do."""
    other = d - c
    square, mixed, rest = float(way @ way), float(way @ other), float(other @ other)
    cuts = [0.0, 1.0, float((c - a) @ way) / square, float((d - a) @ way) / square]
    det = square * rest - mixed * mixed
    if det > 1e-12 * square * rest:
        gap = a - c
        cuts.append((mixed * float(other @ gap) - rest * float(way @ gap)) / det)
    return np.unique(np.clip(cuts, 0.0, 1.0))


def _mean_log(places: Points, c: Points, d: Points, unit: float) -> Points:
    """Mean of ln (r / unit) over the segment from c to d, r from places (n, 3): with u along it and h the distance from
    its line, ∫ ln r du = u ln r − u + h atan (u / h)."""
    way = d - c
    length = float(np.linalg.norm(way))
    way = way / length
    gap = c - places
    u = gap @ way
    h = np.linalg.norm(gap - u[:, None] * way, axis=1)

    def integral(u: Points) -> Points:
        r = np.hypot(u, h) / unit
        value: Points = u * np.log(np.where(r > 0.0, r, 1.0)) - u + h * np.arctan2(u, h)
        return value

    mean: Points = (integral(u + length) - integral(u)) / length
    return mean


def _over_areas(p: Points, q: Points) -> float:
    """∫∫ cosθ₁ cosθ₂ / (π r²) of polygons far apart: the middles of edges of fans, exact for squares of coordinates."""
    (first, weight1), (second, weight2) = _middles(p), _middles(q)
    way = second[None] - first[:, None]
    square = (way**2).sum(axis=2)
    cosines = np.maximum(way @ _area(p), 0.0) * np.maximum(-way @ _area(q), 0.0)
    kernel = cosines / (np.pi * square**2)
    return float(weight1 @ kernel @ weight2)


def _middles(polygon: Points) -> tuple[Points, Points]:
    """Places on a polygon and what part of it each stands for."""
    a, b, c = np.broadcast_to(polygon[0], (len(polygon) - 2, 3)), polygon[1:-1], polygon[2:]
    share = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    places = np.concatenate([(a + b) / 2, (b + c) / 2, (c + a) / 2])
    return places, np.tile(share / share.sum() / 3, 3)
