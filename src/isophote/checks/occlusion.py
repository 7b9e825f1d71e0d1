"""Ambient occlusion beside a wall, within a bowl and below a ball, in closed form."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.checks.check import Check, Effort, Measured, farthest, mean_of
from isophote.checks.scenes import quad
from isophote.rendering.occlusion.points import ambient_occlusion
from isophote.scene.scene import Item, Shape
from isophote.shapes.field.solids import plane, sphere

__all__ = ["CHECKS"]

_TOPIC = "ambient occlusion: visible part of the sky"

Triple: TypeAlias = tuple[float, float, float]
Floats: TypeAlias = npt.NDArray[np.float32]

_HERE, _UP = (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)
# As good as endless to both sides: 1e-6.
_FAR = 300.0
# Each point is asked so many times, by rays of its own, which tells how far its mean may be off.
_TIMES, _RAYS, _PIXELS = 64, 1024, 128
# Rows of a half cube's pixels fall on either side of an edge.
_EDGES = 4e-3
_ROUNDING = 1e-4


def _asked(subject: Shape | Item, point: Triple, normal: Triple, effort: Effort, **how: Any) -> Floats:
    points, normals = np.tile(point, (_TIMES, 1)), np.tile(normal, (_TIMES, 1))
    rays = effort.samples(_RAYS)
    found = ambient_occlusion(
        subject, points, normals, samples=rays, seed=effort.seed, threads=effort.threads, progress=False, **how
    )
    return found.visibility


def _beside_a_wall(height: float, distance: float, by: str, effort: Effort) -> Measured:
    corners = ((distance, 0, -_FAR), (distance, 0, _FAR), (distance, height, _FAR), (distance, height, -_FAR))
    exact = 1 - 0.5 * (1 - distance / math.hypot(distance, height))
    if by == "rays":
        return mean_of(_asked(quad(*corners), _HERE, _UP, effort, bias=1e-4), exact, _ROUNDING)
    found = ambient_occlusion(
        quad(*corners), [_HERE], [_UP], by=by, samples=_PIXELS, bias=1e-4, threads=effort.threads, progress=False
    )
    return Measured(float(found.visibility[0]), exact, _EDGES)


def _within_a_bowl(opening: float, effort: Effort) -> Measured:
    """Of five places the one that is farthest off; all see the opening's cap over the sphere's area."""
    bowl = (sphere(1.2) - sphere(1)) & plane().translate((0, opening, 0))
    found = []
    for polar in (0.0, 0.4, 0.8, 1.2, 1.5):
        up = (math.sin(polar), -math.cos(polar), 0.0)
        visibility = _asked(bowl, up, (-up[0], -up[1], 0.0), effort, bias=1e-3)
        # What the distance from the wall, a thousandth, makes.
        found.append(mean_of(visibility, (1 - opening) / 2, 1e-3))
    return farthest(found)


def _below_a_ball(weights: str, exact: float, effort: Effort) -> Measured:
    item = Item(sphere(0.5)).translate((0, 1, 0))
    return mean_of(_asked(item, _HERE, _UP, effort, weights=weights), exact, _ROUNDING)


CHECKS = [
    *(
        Check(_TOPIC, f"wall of height {height} at {distance}, {by}", partial(_beside_a_wall, height, distance, by))
        for height, distance in ((1.0, 0.5), (0.3, 1.0), (3.0, 0.2))
        for by in ("rays", "hemicube")
    ),
    Check(_TOPIC, "half a ball as a bowl, worst of five places", partial(_within_a_bowl, 0.0)),
    Check(_TOPIC, "deeper bowl, worst of five places", partial(_within_a_bowl, 0.5)),
    Check(_TOPIC, "below a ball, by the cosine", partial(_below_a_ball, "cosine", 0.75)),
    Check(_TOPIC, "below a ball, by solid angle", partial(_below_a_ball, "uniform", math.sqrt(0.75))),
]
