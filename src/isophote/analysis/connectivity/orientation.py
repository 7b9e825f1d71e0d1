"""Turning faces so that neighbours agree and solids look outward."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.sheets import Sheets, find_sheets, one_sided_cycle
from isophote.analysis.connectivity.stars import Faces, Ints, Longs, as_mesh, gather, pick_sound_faces
from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["orient", "turn_faces"]

Flags = npt.NDArray[np.bool_]

_MOST_NAMED = 12


def orient(mesh: Mesh, *, cavities: bool = False) -> Mesh:
    """The mesh with its faces turned so that neighbours run opposite ways along their edge, and solids look outward.

    Faces agree across edges of two faces; a part that these connect is turned as a whole. A closed part is turned so
    that its signed volume is positive, each part by itself: of one shell inside another, both look outward. With
    `cavities` a closed part inside an odd number of others looks inward: it bounds a hollow of what is around it. An
    open part, and one without volume, keeps the side of most of its faces. A turned face keeps its first corner.
    Attributes and labels are kept, normals as they are. Faces that name a vertex twice stay as they are. The mesh
    itself comes back if nothing is to be turned.

    Raises `GeometryError` where no consistent sides exist, naming the faces of a Möbius band.
    """
    faces = pick_sound_faces(mesh)
    sheets = find_sheets(faces, gather(faces))
    if len(sheets.conflicts):
        raise GeometryError(_one_sided(faces, sheets))
    turn = _outward(mesh, faces, sheets, cavities)
    if not turn.any():
        return mesh
    chosen = np.zeros(mesh.face_count, np.bool_)
    chosen[faces.number(np.flatnonzero(turn))] = True
    return turn_faces(mesh, chosen)


def turn_faces(mesh: Mesh, chosen: Flags) -> Mesh:
    """The mesh with the faces of the mask `chosen`, (faces,), run through the other way, from their first corner."""
    sizes = mesh.face_sizes
    start, size = np.repeat(mesh.offsets[:-1], sizes), np.repeat(sizes, sizes)
    corner = np.arange(len(mesh.indices))
    order = np.where(np.repeat(chosen, sizes), start + (size - (corner - start)) % size, corner)
    attributes = {
        name: a if a.indices is None else Attribute(a.values, a.indices[order]) for name, a in mesh.attributes.items()
    }
    return Mesh.from_polygons(
        mesh.vertices, mesh.indices[order], mesh.offsets, attributes=attributes, labels=mesh.labels
    )


def _one_sided(faces: Faces, sheets: Sheets) -> str:
    cycle = faces.number(np.array(one_sided_cycle(sheets, int(sheets.conflicts[0])))).tolist()
    named = ", ".join(map(str, cycle[:_MOST_NAMED])) + (", ..." if len(cycle) > _MOST_NAMED else "")
    more = f" ({len(sheets.conflicts)} parts are like that)" if len(sheets.conflicts) > 1 else ""
    return (
        f"the mesh cannot be oriented: going around by the {len(cycle)} faces {named} one comes back on the other "
        f"side, as on a Möbius band{more}; cut it there, or leave it as it is"
    )


def _outward(mesh: Mesh, faces: Faces, sheets: Sheets, cavities: bool) -> Flags:
    """(sound faces,) which faces are to be turned."""
    if faces.total == 0:
        return np.zeros(0, np.bool_)
    turned = np.bincount(sheets.of_face[sheets.turn], minlength=sheets.total)
    whole = np.bincount(sheets.of_face, minlength=sheets.total)
    closed = np.ones(sheets.total, np.bool_)
    closed[sheets.of_face[sheets.face[sheets.twin < 0]]] = False
    volume = _volumes(mesh, faces, sheets) if closed.any() else np.zeros(sheets.total)
    by_volume = closed & (volume != 0)
    inside_out: Flags = np.where(by_volume, volume < 0, 2 * turned > whole)
    if cavities:
        solids = np.flatnonzero(by_volume)
        inside_out[solids] ^= _hollows(mesh, faces, sheets, solids)
    return sheets.turn ^ inside_out[sheets.of_face]


def _hollows(mesh: Mesh, faces: Faces, sheets: Sheets, solids: Longs) -> Flags:
    """(solids,) which of these sheets bound a hollow."""
    if len(solids) < 2:
        return np.zeros(len(solids), np.bool_)
    # Loaded here: trees for distances are needed by few.
    from isophote.analysis.connectivity.nesting import lie_inside

    triangles, sheet = _consistent_triangles(mesh, faces, sheets)
    return lie_inside(mesh.vertices, triangles, sheet, solids)


def _consistent_triangles(mesh: Mesh, faces: Faces, sheets: Sheets) -> tuple[Ints, Ints]:
    """The triangles of the sound faces, turned so that those of a sheet agree, and the sheet of each."""
    sound = as_mesh(mesh, faces)
    assert sound is not None
    triangles, face, _ = triangulate(sound)
    agreeing = np.where(sheets.turn[face, None], triangles[:, ::-1], triangles)
    return agreeing, sheets.of_face[face]


def _volumes(mesh: Mesh, faces: Faces, sheets: Sheets) -> npt.NDArray[np.float64]:
    """(sheets,) signed volumes, in a unit of their own, of sheets whose faces were made to agree; any for open ones."""
    triangles, sheet = _consistent_triangles(mesh, faces, sheets)
    # One vertex of each sheet is its origin, and a power of two brings all to about 1.
    origin = np.empty(sheets.total, np.int64)
    origin[sheet[::-1]] = triangles[::-1, 0]
    exponent = int(np.frexp(np.abs(mesh.bounds).max())[1]) + 1
    points = np.ldexp(mesh.vertices, -exponent)
    a, b, c = (points[triangles[:, k]] - points[origin[sheet]] for k in range(3))
    det = np.einsum("ti,ti->t", a, np.cross(b, c))
    return np.bincount(sheet, det, sheets.total).astype(np.float64)
