"""Remeshing to an edge length."""

from __future__ import annotations

import math
import warnings
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.closeness import closest_point
from isophote.analysis.remeshing.split import split_long
from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError, IsophoteWarning
from isophote.kernels.measure.remesh import collapse_short, flip_edges, relax, tell_kinds
from isophote.kernels.measure.rings import MOST_AROUND, fill_rings
from isophote.shapes.mesh import Mesh

__all__ = ["remesh"]

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int32]

# Edges are split above, and collapsed below, these parts of the length that is wanted.
_LONG, _SHORT = 4 / 3, 4 / 5
_MOST_TRIANGLES = 50_000_000


class _Rings(NamedTuple):
    heads: Ints
    following: Ints


def remesh(mesh: Mesh, length: float, *, iterations: int = 8, crease_degrees: float = 40.0) -> Mesh:
    """A mesh of the same surface whose edges are all about `length` long, and its triangles nearly equilateral.

    Long edges are split, short ones collapsed, edges flipped toward six triangles at each vertex, and vertices moved
    along the surface and back onto it, `iterations` times. Edges whose faces meet at more than `crease_degrees`, and
    boundaries, stay lines, their ends corners. The mesh is connected as before; it should be a manifold. Polygons are
    cut into triangles first. Attributes and labels are left out, with an `IsophoteWarning`.

    Raises `GeometryError` for lengths that are not above 0 or would make more than 50 million triangles.
    Source: Botsch, Kobbelt, "A Remeshing Approach to Multiresolution Modeling", 2004.
    """
    if isinstance(length, bool) or not isinstance(length, int | float) or not 0 < length < math.inf:
        raise GeometryError(f"remesh: length must be a finite number above 0, not {length!r}")
    if isinstance(iterations, bool) or not isinstance(iterations, int) or not 1 <= iterations <= 1000:
        raise GeometryError(f"remesh: iterations must be a whole number from 1 to 1000, not {iterations!r}")
    if not 0 < crease_degrees <= 180:
        raise GeometryError(f"remesh: crease_degrees must be above 0 and at most 180, not {crease_degrees!r}")
    if mesh.attributes or mesh.labels:
        left_out = ", ".join([*mesh.attributes, *mesh.labels])
        warnings.warn(f"remesh leaves out attributes and labels: {left_out}", IsophoteWarning, stacklevel=2)
    triangles = np.array(triangulate(mesh).triangles, np.int32)
    surface = Mesh(mesh.vertices, triangles)
    positions = np.array(mesh.vertices, np.float64)
    _check_size(positions, triangles, length)
    cosine = math.cos(math.radians(crease_degrees))
    for _ in range(iterations):
        positions, triangles = split_long(positions, triangles, _LONG * length)
        positions, triangles = _even_out(surface, positions, triangles, length, cosine)
    return Mesh(positions, triangles)


def _check_size(positions: Floats, triangles: Ints, length: float) -> None:
    p = positions[triangles]
    area = float(np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()) / 2
    wanted = area / (math.sqrt(3) / 4 * length**2)
    if wanted > _MOST_TRIANGLES:
        raise GeometryError(
            f"remesh: an edge length of {length:g} would make some {wanted:,.0f} triangles; "
            f"{math.sqrt(area / _MOST_TRIANGLES * 4 / math.sqrt(3)):.2g} makes {_MOST_TRIANGLES:,}"
        )


def _even_out(surface: Mesh, positions: Floats, triangles: Ints, length: float, cosine: float) -> tuple[Floats, Ints]:
    """Collapse, flip, relax and project; unused vertices are left out."""
    rings = _Rings(np.full(len(positions), -1, np.int32), np.empty(triangles.size, np.int32))
    fill_rings(triangles, *rings)
    kinds, on_rim = np.empty(len(positions), np.uint8), np.empty(len(positions), np.uint8)
    near = np.empty(MOST_AROUND, np.int32), np.empty(MOST_AROUND, np.int32)
    tell_kinds(positions, triangles, *rings, cosine, kinds, on_rim, near[0])
    collapse_short(positions, triangles, *rings, kinds, on_rim, cosine, _SHORT * length, _LONG * length, *near)
    flip_edges(positions, triangles, *rings, on_rim, cosine, near[0])
    tell_kinds(positions, triangles, *rings, cosine, kinds, on_rim, near[0])
    moved = np.empty_like(positions)
    relax(positions, triangles, *rings, kinds, 0, len(positions), moved)
    kept = triangles[triangles[:, 0] >= 0]
    used, renumbered = np.unique(kept, return_inverse=True)
    positions = np.array(closest_point(surface, moved[used]).points)
    return np.ascontiguousarray(positions), np.ascontiguousarray(renumbered.reshape(-1, 3), np.int32)
