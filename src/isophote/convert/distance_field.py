"""Signed distance fields of shapes that are not fields."""

from __future__ import annotations

from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError
from isophote.shapes.field.field import Field
from isophote.shapes.field.mesh_form import MeshForm
from isophote.shapes.mesh import Mesh

__all__ = ["distance_field"]


def distance_field(mesh: Mesh) -> Field:
    """The field of a mesh: the distance to its nearest face, negative inside, where the mesh winds round the point.

    Inside is where the generalised winding number is nearer to another whole number than to 0 (Jacobson, Kavan,
    Sorkine-Hornung: "Robust Inside-Outside Segmentation using Generalized Winding Numbers", 2013). So it does not
    matter whether the mesh is closed, overlaps itself or is inside out; of a mesh with holes the sign turns within
    them, and such a field's `exactness` is `SIGN`. Faces of four corners and more are cut into triangles.

    Raises `GeometryError` for what is no mesh.
    """
    if not isinstance(mesh, Mesh):
        raise GeometryError(f"distance_field takes a Mesh, but not {type(mesh).__name__}; to_mesh makes one of a field")
    return Field(MeshForm(mesh, triangulate(mesh).triangles))
