"""Tables of data that operators have as their constants: outlines, grids of samples, meshes.

Each knows its value, intervals and partial derivatives in NumPy, in double precision: the oracle of what kernels do
with the same arrays. Arguments are arrays of one shape, or numbers.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.shapes.field import mesh_queries
from isophote.shapes.field.arcs import arc_points, arc_slopes, nearest_on_arcs, winding_numbers

__all__ = ["GridData", "MeshData", "OutlineData"]

Floats: TypeAlias = npt.NDArray[np.float64]
Interval: TypeAlias = tuple[Any, Any]


def _flat(*arguments: Any) -> tuple[tuple[int, ...], list[Floats]]:
    """The arguments' common shape, and each as a flat array."""
    arrays = np.broadcast_arrays(*(np.asarray(a, np.float64) for a in arguments))
    return arrays[0].shape, [np.ascontiguousarray(a).reshape(-1) for a in arrays]


def _around(value: Any, slope: float, *intervals: Interval) -> Interval:
    """Interval of a function with the Lipschitz constant `slope`, by its values in the middles of boxes.

    (−∞, ∞) for endless boxes.
    """
    shape, ends = _flat(*(end for interval in intervals for end in interval))
    low, high = np.stack(ends[::2]), np.stack(ends[1::2])
    endless = ~(np.isfinite(low) & np.isfinite(high)).all(axis=0)
    low, high = np.where(endless, 0.0, low), np.where(endless, 0.0, high)
    middle = value(*((low + high) / 2))
    radius = np.where(endless, np.inf, slope * np.sqrt((((high - low) / 2) ** 2).sum(axis=0)))
    return (middle - radius).reshape(shape), (middle + radius).reshape(shape)


@attrs.frozen(eq=False)
class OutlineData:
    """Closed outlines of quadratic Bézier arcs; the value is the exact signed distance, negative inside.

    `segments` is (n, 6) float32, rows (x0, y0, x1, y1, x2, y2), each monotone in x and in y (a line has the middle of
    its ends as control point). Inside is where the winding number of all of them is not zero. `sides` is (n,) int8:
    1 where the inside lies left of an arc only, −1 right of it only, 0 where both sides are inside or both outside:
    such arcs count for the winding number but are no boundary, and no distance is measured to them.
    """

    segments: npt.NDArray[np.float32]
    sides: npt.NDArray[np.int8]
    # A Lipschitz constant of the value.
    slope: float = 1.0

    @cached_property
    def _arcs(self) -> Floats:
        return self.segments.astype(np.float64)

    @cached_property
    def _edges(self) -> Floats:
        """The arcs that are boundary."""
        edges: Floats = self._arcs[self.sides != 0]
        return edges

    @cached_property
    def bounds(self) -> Floats:
        """(2, 2): the box of the boundary."""
        ends = np.concatenate([self._edges[:, :2], self._edges[:, 4:]])
        return np.stack([ends.min(axis=0), ends.max(axis=0)])

    def value(self, x: Any, y: Any) -> Floats:
        """Signed distance at (x, y)."""
        shape, (px, py) = _flat(x, y)
        distance = nearest_on_arcs(self._edges, px, py).distance
        inside = winding_numbers(self._arcs, px, py) != 0
        return np.where(inside, -distance, distance).reshape(shape)

    def interval(self, x: Interval, y: Interval) -> Interval:
        """An interval that holds the values over boxes."""
        return _around(self.value, self.slope, x, y)

    def partials(self, x: Any, y: Any) -> tuple[Floats, Floats]:
        """The gradient: away from the nearest point of the boundary, outside; toward it, inside.

        Within an arc it is the arc's normal, which holds on the boundary too; at an arc's end, the direction to it.
        """
        shape, (px, py) = _flat(x, y)
        _, arc, t = nearest_on_arcs(self._edges, px, py)
        rows, sides = self._edges[arc], self.sides[self.sides != 0][arc]
        inside = winding_numbers(self._arcs, px, py) != 0
        (cx, cy), (tx, ty) = arc_points(rows, t), arc_slopes(rows, t)
        sign = np.where(inside, -1.0, 1.0)
        at_end = ((t == 0) | (t == 1)) & ((cx != px) | (cy != py))
        # Right of the arc's direction is (ty, −tx).
        dx, dy = np.where(at_end, sign * (px - cx), sides * ty), np.where(at_end, sign * (py - cy), -sides * tx)
        size = np.hypot(dx, dy)
        size = np.where(size == 0, 1.0, size)
        return (dx / size).reshape(shape), (dy / size).reshape(shape)


def _checked_samples(values: npt.ArrayLike) -> npt.NDArray[np.float32]:
    array = np.array(values, np.float32, order="C")
    array.flags.writeable = False
    return array


@attrs.frozen(eq=False)
class GridData:
    """Samples on a grid of squares or cubes, linear between them along each axis.

    `values` is (ny, nx) or (nz, ny, nx) float32, 2 or more along each axis; sample (…, j, i) is at
    low + step · (i, j, …). Beyond the grid, at a distance e from its nearest point, where the value is g, it is
    √(max(g, 0)² + e²) + min(g, 0): of a distance to what lies within the grid's box, which is convex, this is a bound.
    """

    values: npt.NDArray[np.float32] = attrs.field(converter=_checked_samples)
    low: tuple[float, ...]
    step: float

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.values.ndim

    @cached_property
    def slope(self) -> float:
        """A Lipschitz constant of the value."""
        return self._slope_of_samples()

    def _slope_of_samples(self) -> float:
        """A Lipschitz constant of what samples mean: differences of neighbours bound the slopes within each cell.

        Beyond the grid, where samples are above 0, the square of the slope is a mean of that of the samples and of 1;
        where they are below 0, it is their sum, less the slope of the samples along the direction to the grid.
        """
        squares = np.stack([self._steepest(axis) ** 2 for axis in range(self.dimension)])
        slope = max(squares.sum(axis=0).max(), 1.0)
        if any((self.values.take(end, axis) < 0).any() for axis in range(self.dimension) for end in (0, -1)):
            slope = max(slope, *((squares.sum(axis=0) - square).max() + 1.0 for square in squares))
        return float(np.sqrt(slope))

    def _steepest(self, axis: int) -> Floats:
        """For each cell the steepest rise along an axis."""
        rises = np.abs(np.diff(self.values.astype(np.float64), axis=axis)) / self.step
        for other in range(self.dimension):
            if other != axis:
                near = np.moveaxis(rises, other, 0)
                rises = np.moveaxis(np.maximum(near[:-1], near[1:]), 0, other)
        return rises

    def value(self, *point: Any) -> Floats:
        """The value at (x, y) or (x, y, z)."""
        shape, coordinates = _flat(*point)
        cells, weights, beyond = self._cells(coordinates)
        held, away = self._held(cells, weights), np.sqrt((beyond**2).sum(axis=0))
        values: Floats = np.hypot(np.maximum(held, 0.0), away) + np.minimum(held, 0.0)
        return values.reshape(shape)

    def _held(self, cells: npt.NDArray[np.int64], weights: Floats, along: int | None = None) -> Floats:
        """Samples of cells mixed by weights; with `along`, the slope of that along an axis."""
        total = np.zeros(weights.shape[1])
        for corner in np.ndindex(*(2,) * self.dimension):
            factors = [w if c else 1 - w for w, c in zip(weights, corner, strict=True)]
            if along is not None:
                factors[along] = np.full_like(total, 1 / self.step if corner[along] else -1 / self.step)
            total += np.prod(factors, axis=0) * self._samples(cells, corner)
        return total

    def interval(self, *intervals: Interval) -> Interval:
        """An interval that holds the values over boxes."""
        return _around(self.value, self.slope, *intervals)

    def partials(self, *point: Any) -> tuple[Floats, ...]:
        """The derivatives along the axes; those of the cell above where cells meet."""
        shape, coordinates = _flat(*point)
        cells, weights, beyond = self._cells(coordinates)
        held, away = np.maximum(self._held(cells, weights), 0.0), np.sqrt((beyond**2).sum(axis=0))
        length = np.hypot(held, away)
        # Where samples are below 0, they count in full.
        share = np.where(held > 0, held / np.where(length == 0, 1.0, length), 1.0)
        rise = np.where(length == 0, 0.0, 1 / np.where(length == 0, 1.0, length))
        result = []
        for axis in range(self.dimension):
            slope = np.where(beyond[axis] == 0, share * self._held(cells, weights, axis), beyond[axis] * rise)
            result.append(slope.reshape(shape))
        return tuple(result)

    def _cells(self, coordinates: list[Floats]) -> tuple[npt.NDArray[np.int64], Floats, Floats]:
        """For each axis the cell's number, the place in it from 0 to 1, and how far beyond the grid the point is."""
        counts = np.array(self.values.shape[::-1])[:, None]
        point = np.stack(coordinates)
        low = np.array(self.low)[:, None]
        held = np.clip(point, low, low + self.step * (counts - 1))
        places = np.clip((held - low) / self.step, 0.0, counts - 1.0)
        cells = np.minimum(np.floor(places), counts - 2.0).astype(np.int64)
        return cells, places - cells, point - held

    def _samples(self, cells: npt.NDArray[np.int64], corner: tuple[int, ...]) -> Floats:
        index = tuple(c + offset for c, offset in zip(cells, corner, strict=True))[::-1]
        samples: Floats = self.values[index].astype(np.float64)
        return samples


@attrs.frozen(eq=False)
class MeshData:
    """A triangle mesh: the distance to it, negative where its winding number is nearer to another number than to 0.

    `vertices` is (n, 3) float64, `triangles` (m, 3) int32. The winding number is the generalised one (Jacobson,
    Kavan, Sorkine-Hornung: "Robust Inside-Outside Segmentation using Generalized Winding Numbers", 2013), so that
    meshes with holes, overlaps and stray triangles have an inside too. Inside-out meshes count as the others. Beyond
    the box of the triangles all is outside, whatever the winding number of a mesh with holes is there.
    """

    vertices: npt.NDArray[np.float64]
    triangles: npt.NDArray[np.int32]

    @cached_property
    def prepared(self) -> Any:
        """The mesh as kernels ask it: accel/mesh_distance.py's MeshDistance."""
        return mesh_queries.prepared(self.vertices, self.triangles)

    @cached_property
    def bounds(self) -> Floats:
        """(2, 3): the box of the triangles."""
        corners = self.vertices[self.triangles].reshape(-1, 3)
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def _inside(self, points: Floats) -> npt.NDArray[np.bool_]:
        low, high = self.bounds
        inside: npt.NDArray[np.bool_] = ((points >= low) & (points <= high)).all(axis=1)
        inside[inside] = np.abs(mesh_queries.winding_numbers(self.prepared, points[inside])) > 0.5
        return inside

    @property
    def slope(self) -> float:
        """A Lipschitz constant of the value; infinite where the mesh has holes, for signs turn within them."""
        return 1.0 if self.prepared.closed else np.inf

    def value(self, x: Any, y: Any, z: Any) -> Floats:
        """Signed distance at (x, y, z)."""
        shape, coordinates = _flat(x, y, z)
        points = np.column_stack(coordinates)
        distance = mesh_queries.distances(self.prepared, points)
        return np.where(self._inside(points), -distance, distance).reshape(shape)

    def interval(self, x: Interval, y: Interval, z: Interval) -> Interval:
        """An interval that holds the values over boxes: of both signs where the sign may turn without a surface."""
        if self.prepared.closed:
            return _around(self.value, 1.0, x, y, z)
        _, high = _around(lambda *p: np.abs(self.value(*p)), 1.0, x, y, z)
        return -high, high

    def partials(self, x: Any, y: Any, z: Any) -> tuple[Floats, Floats, Floats]:
        """The gradient: away from the nearest point of the mesh, outside; toward it, inside; there, its normal."""
        shape, coordinates = _flat(x, y, z)
        points = np.column_stack(coordinates)
        places, triangles = mesh_queries.nearest(self.prepared, points)
        away = (points - places) * np.where(self._inside(points), -1.0, 1.0)[:, None]
        a, b, c = (self.vertices[self.triangles[triangles, k]] for k in range(3))
        on_surface = (away == 0).all(axis=1, keepdims=True)
        normals = np.where(on_surface, np.cross(b - a, c - a), away)
        size = np.linalg.norm(normals, axis=1, keepdims=True)
        normals /= np.where(size == 0, 1.0, size)
        return normals[:, 0].reshape(shape), normals[:, 1].reshape(shape), normals[:, 2].reshape(shape)
