"""Medial axes of polygons cut back from the ends of their branches."""

from __future__ import annotations

import math
from typing import Any, Protocol, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError

__all__ = ["pruned"]

FloatArray: TypeAlias = npt.NDArray[np.float64]

_HALVINGS = 60


class _Axis(Protocol):
    """What is pruned, such as a `MedialAxis`."""

    @property
    def vertices(self) -> FloatArray:
        """(v, 2): ends of arcs."""

    @property
    def radius(self) -> FloatArray:
        """(v,): radii of the balls around them."""

    @property
    def arcs(self) -> npt.NDArray[np.int32]:
        """(a, 2): the ends of each arc."""

    def at(self, arc: npt.ArrayLike, t: npt.ArrayLike) -> Any:
        """Balls along arcs: `centre`, `radius`, `feet`."""

    def part(
        self, keep: npt.NDArray[np.bool_], vertices: FloatArray, radius: FloatArray, arcs: npt.NDArray[np.int32]
    ) -> Any:
        """The same with only some arcs."""


_Pruned = TypeVar("_Pruned", bound=_Axis)


def pruned(axis: _Pruned, feature: float, scale: float) -> _Pruned:
    """The axis without branches that stand for little; see `MedialAxis.pruned`."""
    if not 0 <= feature < math.inf:
        raise GeometryError(f"feature must be a finite number, 0 or more, not {feature!r}")
    if not 1 <= scale < math.inf:
        raise GeometryError(f"scale must be a finite number, 1 or more, not {scale!r}")
    if scale > 1:
        axis = _without(axis, _is_covered(axis, scale))
    return _cut_back(axis, feature) if feature > 0 else axis


def _is_covered(axis: _Axis, scale: float) -> npt.NDArray[np.bool_]:
    """(a, 2): whether the ball at this end of an arc lies in the one at the other, both enlarged."""
    a, b = axis.arcs.T
    apart = np.linalg.norm(axis.vertices[a] - axis.vertices[b], axis=1)
    gain = scale * (axis.radius[b] - axis.radius[a])
    return np.stack([apart <= gain, apart <= -gain], axis=1)


def _without(axis: _Pruned, removable: npt.NDArray[np.bool_]) -> _Pruned:
    """Leave out arcs from the ends of branches inwards, as far as they are removable from their outer end."""
    keep, _ = _walk(axis, removable)
    rest: _Pruned = axis.part(keep, axis.vertices, axis.radius, axis.arcs)
    return rest


def _walk(axis: _Axis, removable: npt.NDArray[np.bool_]) -> tuple[npt.NDArray[np.bool_], list[tuple[int, int]]]:
    """Arcs that stay, and (arc, end) for those that are left as the ends of branches."""
    arcs = axis.arcs
    degree = np.bincount(arcs.reshape(-1), minlength=len(axis.vertices))
    at: list[list[int]] = [[] for _ in degree]
    for number, (a, b) in enumerate(arcs.tolist()):
        at[a].append(number)
        at[b].append(number)
    keep = np.ones(len(arcs), np.bool_)
    tips = []
    waiting = np.flatnonzero(degree == 1).tolist()
    left = len(arcs)
    while waiting:
        vertex = waiting.pop()
        arc = next((number for number in at[vertex] if keep[number]), -1)
        if arc < 0:
            continue
        end = int(arcs[arc, 1] == vertex)
        if not removable[arc, end] or left == 1:
            tips.append((arc, end))
            continue
        keep[arc] = False
        left -= 1
        other = int(arcs[arc, 1 - end])
        degree[other] -= 1
        if degree[other] == 1:
            waiting.append(other)
    return keep, tips


def _cut_back(axis: _Pruned, feature: float) -> _Pruned:
    """Cut branches back to where feet are 2 `feature` apart."""
    numbers = np.arange(len(axis.arcs))
    ends = np.stack([_spread(axis, numbers, np.full(len(numbers), t)) for t in (0.0, 1.0)], axis=1)
    # An arc goes where its inner end is still too small.
    keep, tips = _walk(axis, ends[:, ::-1] < feature)
    tips = [(arc, end) for arc, end in tips if ends[arc, end] < feature <= ends[arc, 1 - end]]
    if not tips:
        whole: _Pruned = axis.part(keep, axis.vertices, axis.radius, axis.arcs)
        return whole
    arc, end = np.array(tips).T
    small, large = end.astype(np.float64), 1.0 - end
    for _ in range(_HALVINGS):
        middle = (small + large) / 2
        below = _spread(axis, arc, middle) < feature
        small, large = np.where(below, middle, small), np.where(below, large, middle)
    balls = axis.at(arc, large)
    arcs = axis.arcs.copy()
    arcs[arc, end] = len(axis.vertices) + np.arange(len(arc))
    vertices, radius = np.concatenate([axis.vertices, balls.centre]), np.concatenate([axis.radius, balls.radius])
    rest: _Pruned = axis.part(keep, vertices, radius, arcs)
    return rest


def _spread(axis: _Axis, arc: npt.NDArray[np.int64], t: FloatArray) -> FloatArray:
    """Half the distance between the two points that a ball touches."""
    feet = axis.at(arc, t).feet
    half: FloatArray = np.linalg.norm(feet[:, 0] - feet[:, 1], axis=1) / 2
    return half
