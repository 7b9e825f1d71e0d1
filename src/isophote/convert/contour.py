"""`to_mesh`: the surface of a field as a closed mesh of triangles."""

from __future__ import annotations

import math
from typing import Literal, TypeAlias, get_args

import numpy.typing as npt

from isophote.convert.contour_grid import corner_text, grid_over, region_of
from isophote.convert.contour_join import Triangles
from isophote.convert.contour_run import MEMORY, Options, contoured
from isophote.convert.contour_tolerance import within_tolerance
from isophote.convert.contour_warm import warm_up
from isophote.errors import GeometryError
from isophote.progress import ProgressLike, reporter
from isophote.shapes.field.field import Field
from isophote.shapes.mesh import Mesh

__all__ = ["Method", "sensible_cell", "to_mesh"]

Method: TypeAlias = Literal["dual-contouring", "surface-nets"]

# Cells along the longest side of a shape of which nothing else is told.
_CELLS = 128


def to_mesh(
    shape: Field,
    cell: float | None = None,
    tolerance: float | None = None,
    bounds: npt.ArrayLike | None = None,
    method: Method = "dual-contouring",
    *,
    memory: float = MEMORY,
    threads: int | None = None,
    progress: ProgressLike = None,
) -> Mesh:
    """The surface of a field as a closed, manifold mesh of triangles, anticlockwise from outside.

    `cell` is the edge of the cubes that the field is looked at in; features smaller than that may be lost. With dual
    contouring, edges and corners of the shape are edges and corners of the mesh, and cells are merged where that moves
    the surface by `tolerance` at most: cell² / longest side if it is not given, which merges what is nearly flat, and
    nothing at 0. With `tolerance` alone the cell is chosen such that mesh and surface are nowhere farther apart, as far
    as a look at half the cell tells. With neither, the longest side of the shape has 128 cells. Surface nets put each
    vertex in the middle of its cell's crossings: rounded edges, even triangles, nothing merged.

    `bounds`, (2, 3), is the box to look at, needed where the shape is endless; a shape that reaches beyond is cut off
    and closed there. The same mesh comes out for any number of `threads` (all processors if None).

    Raises `GeometryError` where there is no surface, the field is NaN, the shape is endless, or the mesh would take
    more than `memory` bytes (4 GB), which is estimated before the work starts.

    Source: Ju et al., "Dual contouring of Hermite data", 2002; Schaefer, Ju, Warren, "Manifold dual contouring", 2007;
    Gibson, "Constrained elastic surface nets", 1998.
    """
    _check(shape, cell, tolerance, method, memory, threads)
    whole, region = region_of(shape, bounds)
    longest = float((region[1] - region[0]).max())
    options = Options(method == "dual-contouring", memory, threads)
    with reporter(progress) as report:
        warm_up(report)
        if cell is None and tolerance is not None and options.sharp:
            found = within_tolerance(whole, region, tolerance, options, report)
        else:
            size = cell or math.sqrt((tolerance or 0) * longest) or longest / _CELLS
            reach = size * size / longest if tolerance is None else tolerance
            found = contoured(whole, grid_over(region, size), reach, options, report)
    if len(found.triangles) == 0:
        corners = " to ".join(corner_text(corner) for corner in region)
        raise GeometryError(f"no surface found; the bounds looked at were {corners}. Is a smaller cell= needed?")
    return _mesh(found)


def sensible_cell(shape: Field) -> float:
    """The cell that a shape is meshed with if nothing else is told: a 128th of its longest side."""
    _, region = region_of(shape, None)
    return float((region[1] - region[0]).max()) / _CELLS


def _check(
    shape: Field, cell: float | None, tolerance: float | None, method: Method, memory: float, threads: int | None
) -> None:
    if not isinstance(shape, Field):
        raise GeometryError(f"to_mesh takes a field in space, iso.sphere(1) say, not a {type(shape).__name__}")
    if method not in get_args(Method):
        raise GeometryError(f"method must be one of {', '.join(get_args(Method))}, not {method!r}")
    if cell is not None and not (math.isfinite(cell) and cell > 0):
        raise GeometryError(f"cell must be a length above 0, not {cell!r}")
    least = 0.0 if cell is not None else math.ulp(0.0)
    if tolerance is not None and not (math.isfinite(tolerance) and tolerance >= least):
        raise GeometryError(f"tolerance must be a length above 0, or 0 with a cell, not {tolerance!r}")
    if not memory > 0:
        raise GeometryError(f"memory must be a number of bytes, not {memory!r}")
    if threads is not None and threads < 1:
        raise GeometryError(f"threads must be 1 or more, not {threads!r}")


def _mesh(found: Triangles) -> Mesh:
    # What nobody can write to is not copied.
    found.vertices.flags.writeable = found.triangles.flags.writeable = False
    return Mesh(found.vertices, found.triangles)
