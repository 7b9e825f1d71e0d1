"""Where a field is looked at: the bounds of its surface, and a grid of cubes over them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.kernels.measure.contour_tables import BLOCK, BRICK
from isophote.shapes.field.field import Field
from isophote.shapes.field.form import Box
from isophote.shapes.field.solids import box

__all__ = ["Grid", "corner_text", "grid_over", "region_of"]

# The grid starts off the middle by these parts of a cell, so that faces of shapes, which like round numbers, do not lie
# in planes of samples: there, rounding would decide on which side each sample is.
_OFF_MIDDLE = np.array([0.137, 0.219, 0.341])
# Cells along an axis, and bricks in all, that can be numbered.
_MOST_CELLS, _MOST_BRICKS = 1 << 20, 1 << 27


class Grid(NamedTuple):
    """Cubes of edge `cell`; the first one's low corner is `low`, and there are `cells` along the three axes."""

    low: npt.NDArray[np.float64]
    cell: float
    cells: tuple[int, int, int]

    @property
    def axes(self) -> list[npt.NDArray[np.float32]]:
        """Coordinates of the samples along each axis."""
        pairs = zip(self.low, self.cells, strict=True)
        return [(low + self.cell * np.arange(n + 1)).astype(np.float32) for low, n in pairs]

    @property
    def bricks(self) -> tuple[int, int, int]:
        """Bricks along the three axes."""
        x, y, z = (-(-n // BRICK) for n in self.cells)
        return x, y, z


def corner_text(point: npt.NDArray[np.float64]) -> str:
    """A point as messages show it."""
    return "(" + ", ".join(f"{c:.4g}" for c in point) + ")"


def region_of(shape: Field, bounds: npt.ArrayLike | None) -> tuple[Field, Box]:
    """A field, cut off at `bounds` where it reaches beyond, and the box that its surface lies in.

    Raises `GeometryError` for bounds that are no box, and for an endless shape without bounds.
    """
    own = shape.bounds
    if bounds is not None:
        given = _checked(bounds)
        if (own[0] < given[0]).any() or (own[1] > given[1]).any():
            shape = shape & box(tuple(given[1] - given[0])).translate(tuple((given[0] + given[1]) / 2))
        own = np.stack([np.maximum(own[0], given[0]), np.minimum(own[1], given[1])])
    if not np.isfinite(own).all():
        ends = f"{corner_text(own[0])} to {corner_text(own[1])}"
        raise GeometryError(f"the shape is endless, from {ends}; give bounds=((x, y, z), (x, y, z)) to cut it off at")
    if not (own[0] < own[1]).all():
        looked = f"{corner_text(own[0])} to {corner_text(own[1])}"
        raise GeometryError(f"no surface found: the shape is empty; the bounds looked at were {looked}")
    return shape, own


def _checked(bounds: npt.ArrayLike) -> Box:
    try:
        given = np.asarray(bounds, np.float64)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"bounds must be two corners, ((x, y, z), (x, y, z)): {error}") from error
    if given.shape != (2, 3) or not np.isfinite(given).all() or not (given[0] < given[1]).all():
        raise GeometryError(f"bounds must be a least and a greatest corner, (2, 3), but are {given.tolist()}")
    return given


def grid_over(region: Box, cell: float) -> Grid:
    """A grid of cubes of edge `cell` over a box, with some room at each side.

    Raises `GeometryError` where there would be more cells than can be numbered, or single precision cannot tell one
    from the next.
    """
    extent = region[1] - region[0]
    least = float(extent.max()) / _MOST_CELLS * 2
    # Sixty-four steps of single precision along a cell.
    finest = float(np.abs(region).max()) * 2.0**-17
    if cell < max(least, finest):
        why = "samples would be the same in single precision" if finest > least else "that are too many to number"
        raise GeometryError(f"cell {cell:g} is too small: {why}; {max(least, finest):.3g} is the least here")
    # Whole blocks, so that none is cut.
    cells = -(-(np.ceil(extent / cell).astype(np.int64) + 2) // BLOCK) * BLOCK
    bricks = int(np.prod(-(-cells // BRICK)))
    if bricks > _MOST_BRICKS:
        raise GeometryError(
            f"cell {cell:g} makes a grid of {' × '.join(map(str, cells.tolist()))} cells, more than can be numbered; "
            f"{cell * (bricks / _MOST_BRICKS) ** (1 / 3):.3g} is about the least here"
        )
    low = (region[0] + region[1] - cells * cell) / 2 + cell * _OFF_MIDDLE
    x, y, z = cells.tolist()
    return Grid(low, cell, (x, y, z))
