"""Boxes and balls around primitives, as tight as can be: by how far each reaches along a direction.

A convex body K under p ↦ M p + c reaches h(Mᵀ d) + c · d along d, where h is how far it reaches in its own space. So
the box has no slack, whatever the map; a torus reaches as far as its convex hull.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.shapes.primitive.primitive import Matrix, Primitive

__all__ = ["ball_around", "balls_around", "box_around", "boxes_around"]

Floats: TypeAlias = npt.NDArray[np.float64]
# How far a body of the kind reaches along directions (n, 3) of its own space, not of unit length, given its values.
Reach: TypeAlias = Callable[[Floats, Floats], Floats]

# Columns of a map that differ by no more than this, in parts of its size, are equal, or at right angles.
_ALIKE = 1e-12


def _ball(d: Floats, values: Floats) -> Floats:
    return np.asarray(np.linalg.norm(d, axis=1))


def _around(d: Floats) -> Floats:
    return np.asarray(np.hypot(d[:, 0], d[:, 2]))


def _endless_unless_zero(d: Floats) -> Floats:
    return np.asarray(np.where(d == 0, 0.0, np.inf))


def _plane(d: Floats, values: Floats) -> Floats:
    return np.asarray(
        _endless_unless_zero(d[:, 0]) + _endless_unless_zero(d[:, 2]) + np.where(d[:, 1] < 0, np.inf, 0.0)
    )


def _disk(d: Floats, values: Floats) -> Floats:
    return _around(d)


def _block(d: Floats, values: Floats) -> Floats:
    return np.asarray(np.where(d == 0, 0.0, np.abs(np.where(d == 0, 1.0, d)) * values).sum(axis=1))


def _pipe(d: Floats, values: Floats) -> Floats:
    return np.asarray(_around(d) + _endless_unless_zero(d[:, 1]))


def _tube(d: Floats, values: Floats) -> Floats:
    return np.asarray(_around(d) + np.abs(d[:, 1]))


def _cone(d: Floats, values: Floats) -> Floats:
    middle, lean = values
    around = _around(d)
    return np.asarray(np.maximum(around * (middle + lean) + d[:, 1], around * (middle - lean) - d[:, 1]))


def _ring(d: Floats, values: Floats) -> Floats:
    return np.asarray(_around(d) + values[0] * np.linalg.norm(d, axis=1))


def _corners(d: Floats, points: Floats) -> Floats:
    """The farthest of points (k, 2) of the plane y = 0, given as (x, −z)."""
    return np.asarray((d[:, [0, 2]] * [1.0, -1.0] @ points.T).max(axis=1))


def _convex(d: Floats, values: Floats) -> Floats:
    return _corners(d, values.reshape(-1, 2))


def _polygon(d: Floats, values: Floats) -> Floats:
    return _corners(d, values.reshape(-1, 4)[:, :2])


def _quadric(d: Floats, values: Floats) -> Floats:
    """The nearer of the box's reach and, where the surface is an ellipsoid, the ellipsoid's."""
    low, high = values[10:13], values[13:16]
    with np.errstate(invalid="ignore"):
        box = np.where(d > 0, d * high, np.where(d < 0, d * low, 0.0)).sum(axis=1)
    a, b, c, ab, ac, bc, g, h, i, j = values[:10]
    matrix = np.array([[a, ab / 2, ac / 2], [ab / 2, b, bc / 2], [ac / 2, bc / 2, c]])
    eigenvalues = np.linalg.eigvalsh(matrix)
    if not eigenvalues[0] > _ALIKE * abs(eigenvalues[2]):
        return np.asarray(box)
    middle = -np.linalg.solve(matrix, np.array([g, h, i])) / 2
    level = max(float(middle @ matrix @ middle - j), 0.0)
    across = np.sqrt(level * np.einsum("ni,ij,nj->n", d, np.linalg.inv(matrix), d))
    return np.asarray(np.minimum(box, d @ middle + across))


_REACHES: dict[str, Reach] = {
    "ball": _ball,
    "plane": _plane,
    "disk": _disk,
    "block": _block,
    "pipe": _pipe,
    "tube": _tube,
    "cone": _cone,
    "ring": _ring,
    "quadric": _quadric,
    "convex": _convex,
    "polygon": _polygon,
}


def box_around(primitive: Primitive) -> Matrix:
    """(2, 3): the least box in the world; infinite where the primitive is endless."""
    linear, offset = primitive.matrix[:3, :3], primitive.matrix[:3, 3]
    directions = np.concatenate([-linear, linear])
    reach = _REACHES[primitive.kind](directions, primitive.values)
    return np.stack([offset - reach[:3], offset + reach[3:]])


def boxes_around(primitives: Sequence[Primitive]) -> Matrix:
    """(n, 2, 3): `box_around` of each; those of kinds without values all at once."""
    boxes = np.empty((len(primitives), 2, 3))
    for kind, rows in _by_kind(primitives).items():
        if len(primitives[rows[0]].values):
            for row in rows:
                boxes[row] = box_around(primitives[row])
            continue
        matrices = np.array([primitives[row].matrix[:3] for row in rows])
        linear, offset = matrices[:, :, :3], matrices[:, :, 3]
        directions = np.concatenate([-linear, linear], axis=1).reshape(-1, 3)
        reach = _REACHES[kind](directions, np.zeros(0)).reshape(-1, 2, 3)
        boxes[rows] = np.stack([offset - reach[:, 0], offset + reach[:, 1]], axis=1)
    return boxes


def balls_around(primitives: Sequence[Primitive], boxes: Matrix) -> tuple[Floats, Floats]:
    """Middles (n, 3) and radii (n,): `ball_around` of each, whose boxes are given; those of balls all at once."""
    middles, radii = np.empty((len(primitives), 3)), np.empty(len(primitives))
    for kind, rows in _by_kind(primitives).items():
        if kind != "ball":
            for row in rows:
                middles[row], radii[row] = _ball_in(primitives[row], boxes[row])
            continue
        matrices = np.array([primitives[row].matrix[:3] for row in rows])
        middles[rows], radii[rows] = matrices[:, :, 3], np.linalg.svd(matrices[:, :, :3], compute_uv=False)[:, 0]
    return middles, radii


def _by_kind(primitives: Sequence[Primitive]) -> dict[str, list[int]]:
    """Numbers of the primitives of each kind."""
    rows: dict[str, list[int]] = {}
    for row, primitive in enumerate(primitives):
        rows.setdefault(primitive.kind, []).append(row)
    return rows


def ball_around(primitive: Primitive) -> tuple[Floats, float]:
    """(middle, radius) of a ball around, infinite where the primitive is endless.

    It is the least one for balls, disks and boxes under any map, and for cylinders, cones and tori where the map keeps
    their circles circles and their axis upright; for others it is one that holds the box.
    """
    return _ball_in(primitive, box_around(primitive))


def _ball_in(primitive: Primitive, box: Matrix) -> tuple[Floats, float]:
    """`ball_around` of a primitive whose box is given."""
    if not np.isfinite(box).all():
        return np.zeros(3), np.inf
    linear, offset = primitive.matrix[:3, :3], primitive.matrix[:3, 3]
    own = _BALLS[primitive.kind](linear, primitive.values) if primitive.kind in _BALLS else None
    if own is not None:
        return offset + linear[:, 1] * own[0], own[1]
    middle = box.mean(axis=0)
    return middle, float(np.linalg.norm(box[1] - middle))


def _stretch(linear: Floats) -> float:
    return float(np.linalg.svd(linear, compute_uv=False)[0])


def _block_ball(linear: Floats, values: Floats) -> tuple[float, float]:
    signs = np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1]])
    return 0.0, float(np.linalg.norm(signs * values @ linear.T, axis=1).max())


def _is_upright(linear: Floats) -> bool:
    """Whether circles about y stay circles, and y stays across them."""
    gram = linear.T @ linear
    across = abs(gram[0, 1]) + abs(gram[1, 2]) + abs(gram[0, 2]) + abs(gram[0, 0] - gram[2, 2])
    return bool(across <= _ALIKE * np.trace(gram))


def _cone_ball(linear: Floats, values: Floats) -> tuple[float, float] | None:
    """About the point of the axis that is as far from the one rim as from the other, or about the larger lid's middle
    where that point would be beyond it."""
    if not _is_upright(linear):
        return None
    width, half = np.linalg.norm(linear[:, 0]), np.linalg.norm(linear[:, 1])
    top, bottom = width * (values[0] + values[1]), width * (values[0] - values[1])
    height = float(np.clip((top**2 - bottom**2) / (4 * half), -half, half))
    return float(height / half), float(max(np.hypot(top, half - height), np.hypot(bottom, half + height)))


def _tube_ball(linear: Floats, values: Floats) -> tuple[float, float] | None:
    return _cone_ball(linear, np.array([1.0, 0.0]))


def _ring_ball(linear: Floats, values: Floats) -> tuple[float, float] | None:
    width, height = np.linalg.norm(linear[:, 0]), np.linalg.norm(linear[:, 1])
    return (
        (0.0, float(width) * (1 + float(values[0]))) if _is_upright(linear) and height <= width * (1 + _ALIKE) else None
    )


# Places on the axis y of the kind's own space, and radii in the world.
_BALLS: dict[str, Callable[[Floats, Floats], tuple[float, float] | None]] = {
    "ball": lambda linear, values: (0.0, _stretch(linear)),
    "disk": lambda linear, values: (0.0, _stretch(linear[:, [0, 2]])),
    "block": _block_ball,
    "tube": _tube_ball,
    "cone": _cone_ball,
    "ring": _ring_ball,
}
