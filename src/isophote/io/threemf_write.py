"""Writing 3MF: triangles with their unit, colours of vertices or corners, and names of materials."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterable
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt

from isophote.convert.triangulate import Triangles, triangulate
from isophote.errors import FileError
from isophote.io.dropped import warn_dropped
from isophote.io.files import StrPath
from isophote.io.srgb import to_srgb_bytes
from isophote.io.threemf_names import (
    CONTENT_TYPES,
    CORE,
    MATERIALS,
    MODEL,
    MODEL_RELATION,
    MODEL_TYPE,
    RELATIONS,
    RELATIONS_TYPE,
    UNITS,
)
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["encode_3mf"]

# Numbers of the resources.
_OBJECT, _PROPERTIES = 1, 2
_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
_GREY = "#B3B3B3"


def encode_3mf(mesh: Mesh, path: StrPath, *, unit: str = "millimeter") -> bytes:
    """The bytes of a 3MF file; `path` is for messages.

    `unit` is what a length of 1 is in the file: micron, millimeter, centimeter, inch, foot or meter; numbers are
    written as they are. Polygons are cut into triangles. Colours of vertices or of corners are written with eight bits
    a channel, or else names of materials. What 3MF cannot hold is left out, with an `IsophoteWarning`.
    """
    if unit not in UNITS:
        raise FileError(path, f"unit must be one of {', '.join(UNITS)}, but is {unit!r}")
    cut = triangulate(mesh)
    colour = mesh.colours
    if colour is not None and colour.values.shape[1] not in (3, 4):
        colour = None
    has_colour, has_material = colour is not None, colour is None and "material" in mesh.labels
    warn_dropped(
        mesh,
        path,
        "3MF",
        attributes=("colour",) if has_colour else (),
        labels=("material",) if has_material else (),
    )
    resources, properties = "", np.full(cut.triangles.shape, -1)
    if colour is not None:
        resources, properties = _colours(colour, mesh, cut)
    elif has_material:
        resources, properties = _materials(mesh, cut)
    parts = [
        f'{_HEAD}<model unit="{unit}" xml:lang="en" xmlns="{CORE}" xmlns:m="{MATERIALS}">\n',
        '<metadata name="Application">Isophote</metadata>\n<resources>\n',
        resources,
        f'<object id="{_OBJECT}" type="model"><mesh>\n<vertices>\n',
        *(f'<vertex x="{x!r}" y="{y!r}" z="{z!r}"/>\n' for x, y, z in mesh.vertices.tolist()),
        "</vertices>\n<triangles>\n",
        *_triangles(cut, properties),
        "</triangles>\n</mesh></object>\n</resources>\n",
        f'<build><item objectid="{_OBJECT}"/></build>\n</model>\n',
    ]
    return _package("".join(parts))


def _triangles(cut: Triangles, properties: npt.NDArray[Any]) -> Iterable[str]:
    plain = '<triangle v1="%d" v2="%d" v3="%d"/>\n'
    coloured = plain.replace("/", f' pid="{_PROPERTIES}" p1="%d" p2="%d" p3="%d"/')
    for corners, own in zip(cut.triangles.tolist(), properties.tolist(), strict=True):
        yield plain % tuple(corners) if min(own) < 0 else coloured % (*corners, *own)


def _colours(colour: Attribute, mesh: Mesh, cut: Triangles) -> tuple[str, npt.NDArray[Any]]:
    """A group of colours, each once, and the number of each corner's."""
    bytes_ = np.full((len(colour.values), 4), 255, np.uint8)
    bytes_[:, :3] = to_srgb_bytes(colour.values[:, :3])
    if colour.values.shape[1] == 4:
        bytes_[:, 3] = np.rint(np.clip(colour.values[:, 3], 0, 1) * 255)
    kinds, kind = np.unique(bytes_, axis=0, return_inverse=True)
    rows = (mesh.indices if colour.indices is None else colour.indices)[cut.corners]
    texts = (f'<m:color color="#{bytes(row).hex().upper()}"/>' for row in kinds)
    group = f'<m:colorgroup id="{_PROPERTIES}">{"".join(texts)}</m:colorgroup>\n'
    return group, np.where(rows >= 0, kind.reshape(-1)[rows], -1)


def _materials(mesh: Mesh, cut: Triangles) -> tuple[str, npt.NDArray[Any]]:
    """The materials' names, and the number of each corner's."""
    labels = mesh.labels["material"]
    texts = (f'<base name={quoteattr(name)} displaycolor="{_GREY}"/>' for name in labels.names)
    group = f'<basematerials id="{_PROPERTIES}">{"".join(texts)}</basematerials>\n'
    return group, np.repeat(labels.index[cut.face][:, None], 3, axis=1)


def _package(model: str) -> bytes:
    """The model in its zip archive. Without a time in it, equal meshes give equal files."""
    types = (
        f'{_HEAD}<Types xmlns="{CONTENT_TYPES}"><Default Extension="rels" ContentType="{RELATIONS_TYPE}"/>'
        f'<Default Extension="model" ContentType="{MODEL_TYPE}"/></Types>'
    )
    relations = (
        f'{_HEAD}<Relationships xmlns="{RELATIONS}">'
        f'<Relationship Target="/{MODEL}" Id="rel0" Type="{MODEL_RELATION}"/></Relationships>'
    )
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in (("[Content_Types].xml", types), ("_rels/.rels", relations), (MODEL, model)):
            archive.writestr(zipfile.ZipInfo(name), text.encode(), zipfile.ZIP_DEFLATED)
    return out.getvalue()
