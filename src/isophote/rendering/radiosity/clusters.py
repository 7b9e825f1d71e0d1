"""Faces in groups of neighbours that turn the same way: the upper part of a tree of patches."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

__all__ = ["Groups", "Measured", "grouped", "measured"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

_WIDTH = 4
# Faces lie in one plane if their normals and heights differ by no more than this, the latter in parts of the radius.
_FLAT = 1e-5


@attrs.frozen(eq=False)
class Groups:
    """A tree over n faces taken in `order` (n,): group g has the faces `first[g]` ≤ i < `last[g]` of that order, and
    as children the nodes `first_child[g]` to `first_child[g] + children[g]`, faces being nodes 0 to n − 1 and groups
    following; the first group is the root."""

    order: Numbers
    first: Numbers
    last: Numbers
    first_child: Numbers
    children: Numbers


@attrs.frozen(eq=False)
class Measured:
    """Groups in numbers: `centres` (g, 3) by area, `areas`, `radii` (g,), `normals` (g, 3), means by area, of length 1
    where all are the same; `axes` (g, 6), two half edges of a rectangle around all faces, in the plane of the mean
    normal and about the centre; `flat` (g,): whether all faces lie in one plane; `boxes` (g, 6): least and most
    coordinates."""

    centres: Points
    areas: Points
    radii: Points
    normals: Points
    axes: Points
    flat: npt.NDArray[np.uint8]
    boxes: Points


class _Halves:
    """Ranges of an order, split in the middle of what they extend over most, places or normals."""

    def __init__(self, centres: Points, normals: Points) -> None:
        self._values = np.concatenate([centres, normals], axis=1)
        self.order = np.arange(len(centres))

    def split(self, first: Numbers, last: Numbers) -> Numbers:
        """Where each range ends its first half; ranges are sorted by that."""
        counts = last - first
        owner = np.repeat(np.arange(len(first)), counts)
        starts = np.cumsum(counts) - counts
        place = np.arange(len(owner)) - starts[owner]
        rows = first[owner] + place
        values = self._values[self.order[rows]]
        low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
        # A difference of normals of one counts as much as the diagonal.
        extents = high - low
        extents[:, 3:] *= np.linalg.norm(extents[:, :3], axis=1, keepdims=True)
        axis = np.argmax(extents, axis=1)
        each = np.arange(len(first))
        middle = (low[each, axis] + high[each, axis]) / 2
        upper = values[np.arange(len(owner)), axis[owner]] > middle[owner]
        # Where all are the same, halves by number.
        same = extents[each, axis] <= 0
        upper = np.where(same[owner], place >= (counts // 2)[owner], upper)
        self.order[rows] = self.order[rows][np.argsort(2 * owner + upper, kind="stable")]
        return first + counts - np.add.reduceat(upper.astype(np.int64), starts)


def grouped(centres: Points, normals: Points) -> Groups:
    """Groups of up to four, from the root down, of faces with `centres` and `normals` (n, 3)."""
    halves, faces = _Halves(centres, normals), len(centres)
    first, last = np.zeros(1, np.int64), np.full(1, faces)
    firsts, lasts, children, counts = [first], [last], [], []
    made = faces + 1
    while len(first):
        child, count = first.copy(), last - first
        inner = np.flatnonzero(count > _WIDTH)
        ranges = np.stack([first[inner], last[inner]], axis=1)
        owner = inner
        for _ in range(2):
            # Two ranges make way for four, where they are not small.
            wide = np.flatnonzero(ranges[:, 1] - ranges[:, 0] > _WIDTH)
            if len(wide) == 0:
                break
            middle = halves.split(ranges[wide, 0], ranges[wide, 1])
            upper = np.stack([middle, ranges[wide, 1]], axis=1)
            ranges[wide, 1] = middle
            ranges, owner = np.concatenate([ranges, upper]), np.concatenate([owner, owner[wide]])
        sorted_ = np.lexsort((ranges[:, 0], owner))
        ranges, owner = ranges[sorted_], owner[sorted_]
        number = np.bincount(owner, minlength=len(first))
        count = np.where(count > _WIDTH, number, count)
        child[inner] = (made + np.cumsum(number) - number)[inner]
        children.append(child)
        counts.append(count)
        made += len(ranges)
        first, last = ranges[:, 0], ranges[:, 1]
        firsts.append(first)
        lasts.append(last)
    return Groups(
        halves.order,
        np.concatenate(firsts),
        np.concatenate(lasts),
        np.concatenate(children),
        np.concatenate(counts),
    )


def measured(groups: Groups, corners: Points, normals: Points, areas: Points, centres: Points) -> Measured:
    """What the groups of faces with `corners` (n, 4, 3), all in the groups' order, are like."""
    count = len(groups.first)
    found = Measured(
        centres=np.zeros((count, 3)),
        areas=np.zeros(count),
        radii=np.zeros(count),
        normals=np.zeros((count, 3)),
        axes=np.zeros((count, 6)),
        flat=np.zeros(count, np.uint8),
        boxes=np.zeros((count, 6)),
    )
    edges = corners[:, 1] - corners[:, 0]
    # Groups of one level have no face in common and follow each other.
    ends = np.flatnonzero(np.append(groups.first[1:] < groups.last[:-1], True)) + 1
    for begin, end in zip(np.append(0, ends[:-1]), ends, strict=True):
        _measure(found, groups, slice(int(begin), int(end)), corners, normals, areas, centres, edges)
    return found


def _measure(
    found: Measured,
    groups: Groups,
    level: slice,
    corners: Points,
    normals: Points,
    areas: Points,
    centres: Points,
    edges: Points,
) -> None:
    """Fill the rows of groups that have no face in common."""
    first, counts = groups.first[level], (groups.last - groups.first)[level]
    owner = np.repeat(np.arange(len(first)), counts)
    starts = np.cumsum(counts) - counts
    rows = first[owner] + np.arange(len(owner)) - starts[owner]
    weights = areas[rows]
    total = np.add.reduceat(weights, starts)
    middle = np.add.reduceat(centres[rows] * weights[:, None], starts) / total[:, None]
    normal = np.add.reduceat(normals[rows] * weights[:, None], starts) / total[:, None]
    length = np.linalg.norm(normal, axis=1)
    # Where normals cancel any frame will do.
    axis = np.where(length[:, None] > 1e-6, normal / np.maximum(length, 1e-6)[:, None], normals[first])
    along = edges[first] - axis * (edges[first] * axis).sum(axis=1, keepdims=True)
    size = np.linalg.norm(along, axis=1, keepdims=True)
    along = np.where(size > 0, along / np.where(size > 0, size, 1.0), _perpendicular(axis))
    across = np.cross(axis, along)
    way = corners[rows] - middle[owner, None]
    reach = np.stack([np.abs((way * d[owner, None]).sum(axis=2)).max(axis=1) for d in (along, across, axis)], axis=1)
    reach = np.maximum.reduceat(reach, starts)
    radii = np.maximum.reduceat(np.linalg.norm(way, axis=2).max(axis=1), starts)
    found.centres[level], found.areas[level], found.radii[level], found.normals[level] = middle, total, radii, normal
    low, high = corners.min(axis=1)[rows], corners.max(axis=1)[rows]
    boxes = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
    found.boxes[level] = np.concatenate(boxes, axis=1)
    found.axes[level] = np.concatenate([along * reach[:, :1], across * reach[:, 1:2]], axis=1)
    found.flat[level] = (reach[:, 2] <= _FLAT * radii) & (length >= 1 - _FLAT**2)


def _perpendicular(axis: Points) -> Points:
    """(n, 3): some unit vector at right angles to each."""
    least = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    across = np.cross(axis, least)
    found: Points = across / np.linalg.norm(across, axis=1, keepdims=True)
    return found
