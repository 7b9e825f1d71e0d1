"""Texture coordinates for meshes that have none: charts cut, flattened and packed by the library xatlas."""

from __future__ import annotations

import attrs
import numpy as np

from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["unwrap"]


def unwrap(mesh: Mesh, *, size: int = 1024, padding: int = 2) -> Mesh:
    """The mesh as triangles, with texture coordinates at its corners in which no two faces overlap.

    Coordinates fill the unit square; `padding` is the room between charts in texels of a texture of `size` × `size`
    texels. Vertices, their order and their attributes stay; attributes at corners and labels follow their faces.
    Faces without area get none (index −1).

    Needs the extra `uv` (`pip install isophote[uv]`). Raises `GeometryError` where it is not installed, for sizes
    without meaning, and for meshes without area.
    """
    if not isinstance(mesh, Mesh):
        raise GeometryError(
            f"unwrap: only a Mesh is unwrapped, not a {type(mesh).__name__}; to_mesh makes one of a field"
        )
    if not 8 <= size <= 65_536 or not 0 <= padding < size // 4:
        raise GeometryError(f"unwrap: size must be 8 to 65536 and padding below a quarter of it, not {size}, {padding}")
    try:
        import xatlas
    except ImportError:
        raise GeometryError("unwrap needs the library xatlas: pip install isophote[uv]") from None
    cut = triangulate(mesh)
    corners = mesh.vertices[cut.triangles].astype(np.float64)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    solid = np.flatnonzero(areas > 0)
    if len(solid) == 0:
        raise GeometryError("unwrap: the mesh has no area to unwrap")
    low, high = mesh.bounds
    scaled = ((mesh.vertices - low) / (high - low).max()).astype(np.float32)
    atlas = xatlas.Atlas()
    atlas.add_mesh(scaled, np.ascontiguousarray(cut.triangles[solid], np.uint32))
    options = xatlas.PackOptions()
    options.resolution, options.padding = size, padding
    atlas.generate(pack_options=options)
    _, faces, uvs = atlas[0]
    indices = np.full((len(cut.triangles), 3), -1, np.int32)
    indices[solid] = faces
    attributes = {
        name: a if a.indices is None else attrs.evolve(a, indices=a.indices[cut.corners].reshape(-1))
        for name, a in mesh.attributes.items()
    }
    attributes["uv"] = Attribute(np.asarray(uvs, np.float32), indices.reshape(-1))
    labels = {name: attrs.evolve(label, index=label.index[cut.face]) for name, label in mesh.labels.items()}
    return Mesh(mesh.vertices, cut.triangles, attributes=attributes, labels=labels)
