"""Triangle meshes as forms."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np
import numpy.typing as npt

from isophote.shapes.field.data import MeshData
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, grown
from isophote.shapes.mesh import Mesh

__all__ = ["MeshForm"]


@attrs.frozen(repr=False)
class MeshForm(Form):
    """What a mesh winds round: the distance to its nearest face, negative inside.

    `triangles` (t, 3) int32 are the mesh's faces, cut. Of a closed mesh the value is the distance to the surface, but
    where faces lie within the solid, as they do where parts overlap, it is a bound. Of a mesh with holes only the sign
    is meant: it turns within the holes, where there is no face.
    """

    mesh: Mesh
    triangles: npt.NDArray[np.int32] = attrs.field(eq=False)

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        return Exactness.BOUND if self.data.prepared.closed else Exactness.SIGN

    @cached_property
    def data(self) -> MeshData:
        """The triangles, as operators take them."""
        return MeshData(self.mesh.vertices, self.triangles)

    def expression(self, p: Point) -> Value:
        data = self.data
        return p.bounded(p.graph.apply("MESH", p.x, p.y, p.z, constant=data), data.slope)

    @property
    def bounds(self) -> Box:
        return self.mesh.bounds

    def bounds_at(self, level: float) -> Box:
        # Values are distances to the faces, whatever their sign.
        return grown(self.bounds, max(level, 0.0))

    def spelled(self) -> str:
        return f"distance_field({self.mesh!r})"
