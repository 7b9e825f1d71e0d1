"""Rays against solids, by the formulas that scenes are traced with."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.rays.given import checked_rays, positive_numbers, rows
from isophote.analysis.rays.result import RayCrossings
from isophote.errors import GeometryError
from isophote.kernels.primitive.lines import cross_lines, describe_places
from isophote.lower.primitives import KINDS, own_numbers
from isophote.shapes.primitive.primitive import Matrix, Primitive, upright
from isophote.shapes.primitive.quadric import Quadric
from isophote.shapes.primitive.recognise import frame_on

__all__ = ["ray_box", "ray_cone", "ray_cylinder", "ray_quadric", "ray_sphere", "ray_torus"]

Floats: TypeAlias = npt.NDArray[np.float64]
_ORIGIN = (0.0, 0.0, 0.0)
_NONE = np.zeros(0)


def ray_sphere(
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    centre: npt.ArrayLike = _ORIGIN,
    radius: npt.ArrayLike = 1.0,
) -> RayCrossings:
    """Rays against spheres, |p − c| = r: one, or one for each ray. A ray has two crossings, one where it touches.

    Raises `GeometryError` for a radius that is not above 0, zero directions, and numbers that are not finite.
    """
    o, d = checked_rays(origins, directions)
    c, r = rows("centre", centre, (3,), len(o)), positive_numbers("radius", radius, len(o))
    scale = np.broadcast_to(r[:, None], (len(r), 3))
    return _cross(Primitive("ball", np.eye(4), _NONE), o, d, c, scale, 2)


def ray_box(origins: npt.ArrayLike, directions: npt.ArrayLike, low: npt.ArrayLike, high: npt.ArrayLike) -> RayCrossings:
    """Rays against boxes from corner `low` to corner `high`: one, or one for each ray.

    Raises `GeometryError` where a box has no extent along an axis, and as `ray_sphere`.
    """
    o, d = checked_rays(origins, directions)
    a, b = rows("low", low, (3,), len(o)), rows("high", high, (3,), len(o))
    flat = ~(a < b).all(axis=1)
    if flat.any():
        raise GeometryError(f"high must be above low along every axis, but is not for box {int(np.argmax(flat))}")
    return _cross(Primitive("block", np.eye(4), np.ones(3)), o, d, (a + b) / 2, (b - a) / 2, 2)


def ray_cylinder(
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    start: npt.ArrayLike,
    end: npt.ArrayLike,
    radius: float,
    *,
    endless: bool = False,
) -> RayCrossings:
    """Rays against the cylinder of `radius` from `start` to `end`, (3,) each, with its lids, or, if `endless`, without.

    Raises `GeometryError` where the ends are one point, and as `ray_sphere`.
    """
    o, d = checked_rays(origins, directions)
    frame, half = _between(start, end)
    r = float(positive_numbers("radius", radius, 1)[0])
    shape = Primitive("pipe", upright(r, r), _NONE) if endless else Primitive("tube", upright(r, half), _NONE)
    return _cross_placed(shape.placed(frame), o, d, 2)


def ray_cone(
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    start: npt.ArrayLike,
    end: npt.ArrayLike,
    radius: float,
    top: float = 0.0,
) -> RayCrossings:
    """Rays against the cone from `start`, where its radius is `radius`, to its tip, or a lid of radius `top`, at `end`.

    Lids belong to it. Raises `GeometryError` for a `top` below 0, and as `ray_cylinder`.
    """
    o, d = checked_rays(origins, directions)
    frame, half = _between(start, end)
    bottom, lid = float(positive_numbers("radius", radius, 1)[0]), float(rows("top", top, ())[0])
    if lid < 0:
        raise GeometryError(f"top must not be below 0, but is {top!r}")
    widest = max(bottom, lid)
    values = np.array([(bottom + lid) / (2 * widest), (lid - bottom) / (2 * widest)])
    return _cross_placed(Primitive("cone", frame @ upright(widest, half), values), o, d, 2)


def ray_torus(
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    centre: npt.ArrayLike,
    axis: npt.ArrayLike,
    radius: float,
    tube: float,
) -> RayCrossings:
    """Rays against the torus of all within `tube` of the circle of `radius` about `centre`, (3,), across `axis`, (3,).

    A ray has up to four crossings; where the tube is thicker than the ring, the inner surface is left out. Raises
    `GeometryError` for a zero axis, and as `ray_sphere`.
    """
    o, d = checked_rays(origins, directions)
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = (
        frame_on(_unit("axis", rows("axis", axis, (3,), 1)[0])),
        rows("centre", centre, (3,), 1)[0],
    )
    r, t = (float(positive_numbers(name, value, 1)[0]) for name, value in (("radius", radius), ("tube", tube)))
    return _cross_placed(Primitive("ring", frame @ upright(r, r), np.array([t / r])), o, d, 4)


def ray_quadric(
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    coefficients: npt.ArrayLike,
    box: npt.ArrayLike | None = None,
    *,
    closed: bool = True,
) -> RayCrossings:
    """Rays against the quadric of ten `coefficients` within a `box`, (2, 3); without one everywhere, see `Quadric`.

    With `closed`, the box's faces belong to it where the surface leaves the box.
    """
    o, d = checked_rays(origins, directions)
    everywhere = np.array([[-np.inf] * 3, [np.inf] * 3])
    shape = Quadric(coefficients, everywhere if box is None else box, closed)
    return _cross_placed(shape.primitive, o, d, 4)


def _unit(name: str, vector: Floats) -> Floats:
    size = float(np.linalg.norm(vector))
    if not size > 0:
        raise GeometryError(f"{name} must not be zero")
    return np.asarray(vector / size)


def _between(start: npt.ArrayLike, end: npt.ArrayLike) -> tuple[Matrix, float]:
    """The frame whose y leads from one point to another, about their middle, and half their distance."""
    a, b = rows("start", start, (3,), 1)[0], rows("end", end, (3,), 1)[0]
    length = float(np.linalg.norm(b - a))
    if not length > 0:
        raise GeometryError(f"start and end must be two points, but are both {a.tolist()}")
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = frame_on((b - a) / length), (a + b) / 2
    return frame, length / 2


def _cross_placed(primitive: Primitive, o: Floats, d: Floats, most: int) -> RayCrossings:
    """Rays against a primitive where it stands."""
    inverse = np.linalg.inv(primitive.matrix[:3, :3])
    moved = (o - primitive.matrix[:3, 3]) @ inverse.T, d @ inverse.T
    distances, point, normal = _own_crossings(primitive, *moved, most)
    return _result(o, d, distances, point @ primitive.matrix[:3, :3].T + primitive.matrix[:3, 3], normal @ inverse)


def _cross(primitive: Primitive, o: Floats, d: Floats, centre: Floats, scale: Floats, most: int) -> RayCrossings:
    """Rays against a primitive scaled along the axes and moved, otherwise for each ray."""
    distances, point, normal = _own_crossings(primitive, (o - centre) / scale, d / scale, most)
    return _result(o, d, distances, point * scale + centre, normal / scale)


def _own_crossings(primitive: Primitive, o: Floats, d: Floats, most: int) -> tuple[Floats, Floats, Floats]:
    """All distances, (n, most), and places and normals of the first at 0 or beyond, in the primitive's own space."""
    kind, own = KINDS[primitive.kind], own_numbers(primitive)
    distances, parts = np.full((len(o), most), np.nan), np.zeros((len(o), most))
    cross_lines(kind.meet.address, own, np.ascontiguousarray(np.hstack([o, d])), -np.inf, np.inf, distances, parts)
    first: npt.NDArray[np.int64] = np.greater_equal(distances, 0.0).argmax(axis=1, keepdims=True)
    t = np.take_along_axis(distances, first, axis=1)
    places, normals, uvs = np.ascontiguousarray(o + t * d), np.full((len(o), 3), np.nan), np.empty((len(o), 2))
    # What is not met has NaN for its place, of which nothing comes but NaN.
    describe_places(
        kind.describe.address, own, places, np.take_along_axis(parts, first, axis=1)[:, 0].copy(), normals, uvs
    )
    return distances, places, normals


def _result(o: Floats, d: Floats, distances: Floats, point: Floats, normal: Floats) -> RayCrossings:
    ahead: npt.NDArray[np.bool_] = np.greater_equal(distances, 0.0)
    met = np.asarray(ahead.any(axis=1))
    first = np.where(met, np.take_along_axis(distances, ahead.argmax(axis=1, keepdims=True), axis=1)[:, 0], np.inf)
    with np.errstate(invalid="ignore", divide="ignore"):
        unit = normal / np.linalg.norm(normal, axis=1)[:, None]
    return RayCrossings(first, distances, np.where(met[:, None], point, np.nan), np.where(met[:, None], unit, np.nan))
