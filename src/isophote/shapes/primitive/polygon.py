"""Planar polygons in space, with holes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh
from isophote.shapes.primitive.checks import finite_points, frozen
from isophote.shapes.primitive.primitive import Matrix, Primitive

__all__ = ["Polygon"]

Points: TypeAlias = npt.NDArray[np.float64]

# Corners may lie this far off the plane, in parts of the outline's size.
_FLAT = 1e-6
# Corners of single precision are as far off their plane as their coordinates are rounded.
_ROUNDING = 2.0**-23


def newell_normal(points: Points) -> Points:
    """Twice the area of a ring along its normal: Σ pᵢ × pᵢ₊₁, from the ring's own middle, so that it does not cancel
    far from the origin (Newell; Sutherland et al., "A Characterization of Ten Hidden-Surface Algorithms", 1974)."""
    centred = points - points.mean(axis=0)
    return np.asarray(np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0))


def _ring(name: str, values: npt.ArrayLike) -> Points:
    points = finite_points(name, values, 3, least=3)
    if len(points) > 3 and (points[0] == points[-1]).all():
        points = points[:-1]
    return frozen(points)


def _outline(values: npt.ArrayLike) -> Points:
    return _ring("Polygon: outline", values)


def _holes(value: Sequence[Any]) -> tuple[Points, ...]:
    if isinstance(value, np.ndarray) and value.ndim == 2:
        raise GeometryError("Polygon: holes must be a list of rings; write [...] around the one")
    return tuple(_ring(f"Polygon: hole {k}", ring) for k, ring in enumerate(value))


@attrs.frozen(eq=False, repr=False, slots=False)
class Polygon:
    """A planar polygon: `outline`, (n, 3), counterclockwise for who looks against its normal, and `holes`, a list of
    rings (m, 3), whose direction does not matter.

    It may be convex, concave or cross itself (what an odd number of rings winds round is inside), of any size, anywhere
    in space; the first corner may be repeated at the end. A surface without thickness. Texture coordinates are metres
    from the first corner: u along the first edge, v to its left in the plane.

    Corners must lie in one plane to 10⁻⁶ of the outline's size; `GeometryError` tells how far off the worst one is, and
    `Polygon.triangulated` makes a mesh of such an outline. Raises it too for outlines without area, and coordinates
    that are not finite.
    """

    outline: Points = attrs.field(converter=_outline)
    holes: tuple[Points, ...] = attrs.field(default=(), converter=_holes)

    def __attrs_post_init__(self) -> None:
        off, ring, corner = self._farthest_off()
        size = float(np.linalg.norm(np.ptp(self.outline, axis=0)))
        if off > _FLAT * size + _ROUNDING * float(np.abs(self.outline).max()):
            where = "outline" if ring < 0 else f"hole {ring}"
            raise GeometryError(
                f"Polygon: corner {corner} of the {where} lies {off:.3g} off the plane of the others, "
                f"{off / size:.2g} of the outline's size; Polygon.triangulated makes a mesh of it"
            )

    @cached_property
    def normal(self) -> Points:
        """(3,) the unit normal."""
        return frozen(_unit_normal(self.outline))

    def _farthest_off(self) -> tuple[float, int, int]:
        """(distance, hole or −1, corner) of the corner that is farthest off the plane through the outline's middle."""
        middle = self.outline.mean(axis=0)
        offs = [np.abs((ring - middle) @ self.normal) for ring in (self.outline, *self.holes)]
        worst = int(np.argmax([off.max() for off in offs]))
        return float(offs[worst].max()), worst - 1, int(offs[worst].argmax())

    @cached_property
    def frame(self) -> Matrix:
        """(4, 4): from the polygon's own space, where it lies in y = 0, to the world: x along the first edge that has a
        length, y along the normal, and −z to the left."""
        edges = np.roll(self.outline, -1, axis=0) - self.outline
        first = edges[int(np.argmax((edges != 0).any(axis=1)))]
        along = first - (first @ self.normal) * self.normal
        along /= np.linalg.norm(along)
        matrix = np.eye(4)
        matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = along, self.normal, -np.cross(self.normal, along)
        matrix[:3, 3] = self.outline[0] + ((self.outline.mean(axis=0) - self.outline[0]) @ self.normal) * self.normal
        return frozen(matrix)

    @cached_property
    def rings(self) -> tuple[Points, ...]:
        """Outline and holes in the plane, (n, 2) each, in the coordinates of the texture."""
        axes = np.stack([self.frame[:3, 0], -self.frame[:3, 2]], axis=1)
        return tuple(frozen((ring - self.frame[:3, 3]) @ axes) for ring in (self.outline, *self.holes))

    @cached_property
    def is_convex(self) -> bool:
        """Whether every corner of the outline turns left, once round in all, and there are no holes."""
        if self.holes:
            return False
        ring = self.rings[0]
        edges = np.roll(ring, -1, axis=0) - ring
        edges = edges[(edges != 0).any(axis=1)]
        after = np.roll(edges, -1, axis=0)
        cross = edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0]
        turns = np.arctan2(cross, (edges * after).sum(axis=1))
        return bool((turns >= 0).all() and turns.sum() < 3 * np.pi)

    @property
    def area(self) -> float:
        """Area of the outline less that of the holes, each as it is where rings do not cross."""
        areas = [float(np.linalg.norm(newell_normal(ring))) / 2 for ring in (self.outline, *self.holes)]
        return areas[0] - sum(areas[1:])

    @property
    def primitive(self) -> Primitive:
        """What rays meet."""
        if self.is_convex:
            return Primitive("convex", self.frame, self.rings[0].reshape(-1))
        edges = [np.column_stack([ring, np.roll(ring, -1, axis=0)]) for ring in self.rings]
        return Primitive("polygon", self.frame, np.concatenate(edges).reshape(-1))

    @property
    def bounds(self) -> Matrix:
        """(2, 3): the least box."""
        return np.stack([self.outline.min(axis=0), self.outline.max(axis=0)])

    @staticmethod
    def triangulated(outline: npt.ArrayLike) -> Mesh:
        """A mesh of one ring of corners, (n, 3), planar or not: a face, which is cut into triangles where it is drawn.

        Raises `GeometryError` for outlines without area, and coordinates that are not finite.
        """
        points = _ring("Polygon.triangulated: outline", outline)
        _unit_normal(points)
        return Mesh(points, [tuple(range(len(points)))])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Polygon):
            return NotImplemented
        mine, others = (self.outline, *self.holes), (other.outline, *other.holes)
        return len(mine) == len(others) and all(map(np.array_equal, mine, others))

    def __hash__(self) -> int:
        return hash((self.outline.tobytes(), len(self.holes)))

    def __repr__(self) -> str:
        holes = f", {[hole.tolist() for hole in self.holes]}" if self.holes else ""
        text = f"Polygon({self.outline.tolist()}{holes})"
        return text if len(text) <= 2000 else f"<Polygon: {len(self.outline)} corners, {len(self.holes)} holes>"


def _unit_normal(outline: Points) -> Points:
    normal = newell_normal(outline)
    size = float(np.linalg.norm(normal))
    if not size > 1e-12 * float(np.ptp(outline, axis=0).max()) ** 2:
        raise GeometryError(
            "Polygon: the outline has no area, so no normal: its corners lie on a line, or its loops cancel"
        )
    return normal / size
