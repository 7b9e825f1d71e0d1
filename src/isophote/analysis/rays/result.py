"""What rays meet: distances, points and normals."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

__all__ = ["RayCrossings"]

Floats: TypeAlias = npt.NDArray[np.float64]


@attrs.frozen(eq=False)
class RayCrossings:
    """Where n rays cross a shape; distances are in lengths of the direction.

    `distance` (n,): the first crossing at 0 or beyond, inf where there is none. `distances` (n, k): all crossings of
    the lines, before the origin too, in order, NaN behind them. `point`, `normal` (n, 3): the place and the outward
    unit normal at the first crossing, NaN where there is none.
    """

    distance: Floats
    distances: Floats
    point: Floats
    normal: Floats

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """(n,): whether a ray meets the shape."""
        return np.isfinite(self.distance)
