"""What the tests of mesh files share: meshes of every make-up, and their corners spelled out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from hypothesis import strategies as st

from isophote import Attribute, FaceLabels, Mesh

MODELS = Path(__file__).parents[1] / "../shared/models"

_COORDINATES = st.floats(-1e6, 1e6, allow_nan=False) | st.sampled_from([0.1, -0.0, 1e-300, 1.5e300, 1 / 3])
_NAMES = st.sampled_from(["steel", "Material.001", "dark wood", "größe", "a#b"])


@st.composite
def meshes(draw: st.DrawFn, single: bool = False) -> Mesh:
    """Polygon meshes with attributes at vertices, corners and faces, and labels; `single`: 32-bit coordinates."""
    count = draw(st.integers(3, 8))
    sizes = draw(st.lists(st.integers(3, 5), min_size=1, max_size=5))
    corners = sum(sizes)
    indices = draw(st.lists(st.integers(0, count - 1), min_size=corners, max_size=corners))
    number = st.floats(-1e6, 1e6, width=32) if single else _COORDINATES
    rows = st.lists(st.tuples(number, number, number), min_size=count, max_size=count)
    attributes = {
        name: draw(_attribute(count, corners, width, dtype))
        for name, width, dtype in (("normal", 3, float), ("uv", 2, float), ("colour", 3, np.float32))
        if draw(st.booleans())
    }
    labels = {name: draw(_labels(len(sizes))) for name in ("material", "group") if draw(st.booleans())}
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    return Mesh.from_polygons(draw(rows), indices, offsets, attributes=attributes, labels=labels)


@st.composite
def _attribute(draw: st.DrawFn, vertices: int, corners: int, width: int, dtype: Any) -> Attribute:
    at_corners = draw(st.booleans())
    count = draw(st.integers(1, 6)) if at_corners else vertices
    unit = st.floats(0, 1, width=32 if dtype is np.float32 else 64)
    values = draw(st.lists(st.lists(unit, min_size=width, max_size=width), min_size=count, max_size=count))
    if not at_corners:
        return Attribute(np.array(values, dtype))
    index = draw(st.lists(st.integers(-1, count - 1), min_size=corners, max_size=corners))
    return Attribute(np.array(values, dtype), np.array(index))


@st.composite
def _labels(draw: st.DrawFn, faces: int) -> FaceLabels:
    names = draw(st.lists(_NAMES, min_size=1, max_size=3, unique=True))
    index = draw(st.lists(st.integers(-1, len(names) - 1), min_size=faces, max_size=faces))
    return FaceLabels(tuple(names), np.array(index))


def at_corners(mesh: Mesh, name: str) -> npt.NDArray[Any]:
    """(corners, d) values of an attribute, NaN where a corner has none: the same however it is stored."""
    attribute = mesh.attributes[name]
    index = mesh.indices if attribute.indices is None else attribute.indices
    values = np.asarray(attribute.values, np.float64)
    return np.where((index < 0)[:, None], np.nan, values[index])


def label_names(mesh: Mesh, name: str) -> list[str | None]:
    """The label of each face, None where it has none."""
    labels = mesh.labels.get(name)
    if labels is None:
        return [None] * mesh.face_count
    return [labels.names[i] if i >= 0 else None for i in labels.index]


def same_faces(a: Mesh, b: Mesh) -> bool:
    return np.array_equal(a.indices, b.indices) and np.array_equal(a.offsets, b.offsets)
