"""Principal curvatures by polynomials of height, fitted around each vertex."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.analysis.curvature.fan import fans
from isophote.errors import GeometryError
from isophote.kernels.measure.jets import MOST_NEIGHBOURS, SCRATCH, fit_vertices
from isophote.shapes.mesh import Mesh

__all__ = ["PrincipalCurvatures", "principal_curvatures"]

Floats: TypeAlias = npt.NDArray[np.float64]

_PIECE = 4096
_MOST_RINGS = 8


@attrs.frozen(eq=False)
class PrincipalCurvatures:
    """Principal curvatures at n vertices: `k1` ≥ `k2` (n,), in 1 / length, positive where bent like a sphere.

    `direction1`, `direction2` (n, 3) are unit tangents along which the surface has these curvatures, without a sense;
    with `normal`, the fit's, they are a frame. `degree` (n,) is that of the polynomial that the vertices around
    determined; where it is 0, curvatures are NaN.
    """

    k1: Floats
    k2: Floats
    direction1: Floats
    direction2: Floats
    normal: Floats
    degree: npt.NDArray[np.int8]

    def shape_operator(self) -> Floats:
        """(n, 3, 3) the operator that takes a tangent to the change of the normal along it: k1 d1 d1ᵀ + k2 d2 d2ᵀ."""
        first = self.direction1[:, :, None] * self.direction1[:, None, :]
        second = self.direction2[:, :, None] * self.direction2[:, None, :]
        return self.k1[:, None, None] * first + self.k2[:, None, None] * second


def principal_curvatures(mesh: Mesh, degree: int = 3, rings: int = 2) -> PrincipalCurvatures:
    """Principal curvatures and directions at the vertices of a mesh, by fits of a polynomial of height.

    `degree` 2, 3 or 4: the error is of order degree − 1 in the size of the triangles, on irregular meshes too. The fit
    takes the vertices within `rings` edges (1 to 8), and more where these are too few, as on a boundary; where the
    vertices don't determine the polynomial, a lower degree is taken. More rings smooth noise. It needs no closed mesh.

    Raises `GeometryError` for other degrees and rings. Source: Cazals, Pouget, 2005.
    """
    for name, value, low, high in (("degree", degree, 2, 4), ("rings", rings, 1, _MOST_RINGS)):
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not low <= value <= high:
            raise GeometryError(f"{name} must be a whole number from {low} to {high}, not {value!r}")
    fan = fans(mesh)
    count = len(fan.positions)
    normals, around = fan.normals("angle"), fan.neighbours
    values, degrees = np.empty((count, 2)), np.empty(count, np.int8)
    first_axes, second_axes, fitted = (np.empty((count, 3)) for _ in range(3))

    def work(first: int, last: int) -> None:
        mark, found = np.full(count, -1, np.int32), np.empty(MOST_NEIGHBOURS + 1, np.int32)
        fit_vertices(
            fan.positions, *around, normals, degree, rings, first, last, mark, found,
            np.zeros(SCRATCH), values, first_axes, second_axes, fitted, degrees,
        )  # fmt: skip

    run(work, pieces(count, max(_PIECE, count // 8)))
    return PrincipalCurvatures(values[:, 0], values[:, 1], first_axes, second_axes, fitted, degrees)
