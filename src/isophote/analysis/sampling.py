"""Points spread over the surface of a mesh."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError
from isophote.kernels.measure.elimination import eliminate
from isophote.shapes.mesh import Mesh

__all__ = ["SurfacePoints", "sample_points"]

Floats: TypeAlias = npt.NDArray[np.float64]

_MOST = 50_000_000
# Candidates for each point that is kept; more make the spacing a little more even and take longer.
_CANDIDATES = 5
# The weight falls with this power of the distance; weights within this part of the largest radius count the same, which
# keeps elimination from leaving clumps. Both are Yuksel's.
_POWER, _CUT, _FALL = 8, 0.65, 1.5


@attrs.frozen(eq=False)
class SurfacePoints:
    """Points on a mesh: `points` (n, 3), the `face` (n,) that each lies on, and that face's unit `normal` (n, 3)."""

    points: Floats
    face: npt.NDArray[np.int32]
    normal: Floats


def sample_points(mesh: Mesh, count: int, method: str = "uniform", seed: int = 0) -> SurfacePoints:
    """`count` points on the surface of a mesh, as many a unit of area everywhere.

    `method`: "uniform", by chance, each independent of the others; "blue-noise", by chance but never close together:
    nearly as far apart as they can be. The same seed gives the same points. Raises `GeometryError` for counts that are
    no whole numbers above 0, and for meshes without area.

    Source of the spacing: Yuksel, "Sample Elimination for Generating Poisson Disk Sample Sets", 2015.
    """
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or not 0 < count <= _MOST:
        raise GeometryError(f"count must be a whole number from 1 to {_MOST:,}, not {count!r}")
    if method not in ("uniform", "blue-noise"):
        raise GeometryError(f'method must be "uniform" or "blue-noise", not {method!r}')
    random = np.random.default_rng(seed)
    if method == "uniform":
        return _uniform(mesh, int(count), random)[0]
    many, area = _uniform(mesh, _CANDIDATES * int(count), random)
    kept = _spread(many.points, int(count), area)
    return SurfacePoints(many.points[kept], many.face[kept], many.normal[kept])


def _uniform(mesh: Mesh, count: int, random: np.random.Generator) -> tuple[SurfacePoints, float]:
    cut = triangulate(mesh)
    corners = mesh.vertices[cut.triangles].astype(np.float64)
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(crosses, axis=1)
    total = np.cumsum(sizes)
    if len(total) == 0 or not total[-1] > 0:
        raise GeometryError("the mesh has no area to put points on")
    # One number in each of `count` equal parts of the area: still uniform, and nearer to its share everywhere.
    places = (np.arange(count) + random.random(count)) / count * total[-1]
    chosen = np.minimum(np.searchsorted(total, places, side="right"), len(total) - 1)
    u, v = random.random(count), random.random(count)
    over = u + v > 1
    u, v = np.where(over, 1 - u, u), np.where(over, 1 - v, v)
    a, b, c = (corners[chosen, k] for k in range(3))
    points = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    normals = crosses[chosen] / sizes[chosen, None]
    order = random.permutation(count)
    return SurfacePoints(points[order], cut.face[chosen][order], normals[order]), float(total[-1]) / 2


def _spread(points: Floats, wanted: int, area: float) -> npt.NDArray[np.int64]:
    """Numbers of the points that are kept, in increasing order."""
    from scipy.spatial import cKDTree

    # The radius of the densest packing of disks of equal size.
    radius = float(np.sqrt(area / (2 * np.sqrt(3) * wanted)))
    least = radius * (1 - (wanted / len(points)) ** _FALL) * _CUT
    pairs = cKDTree(points).query_pairs(2 * radius, output_type="ndarray").astype(np.int64)
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.lexsort((both[:, 1], both[:, 0]))]
    starts = np.concatenate([[0], np.cumsum(np.bincount(both[:, 0], minlength=len(points)))])
    distance = np.linalg.norm(points[both[:, 0]] - points[both[:, 1]], axis=1)
    crowding = (1 - np.clip(distance, 2 * least, 2 * radius) / (2 * radius)) ** _POWER
    heap, places = np.empty(len(points), np.int64), np.empty(len(points), np.int64)
    eliminate(starts, np.ascontiguousarray(both[:, 1]), crowding, wanted, heap, places, np.empty(len(points)))
    return np.sort(heap[:wanted])
