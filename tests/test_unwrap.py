"""Texture coordinates made for meshes: within the square, without overlaps, on the same surface."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import isophote as iso
from curved_meshes import torus

pytest.importorskip("xatlas")

BOX = iso.Mesh(
    [(x, y, z) for x in (0, 2) for y in (0, 1) for z in (0, 1)],
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
)


def _flat(mesh: iso.Mesh) -> np.ndarray:
    """(m, 3, 2) texture coordinates of the triangles' corners."""
    return np.asarray(mesh.uvs.values)[mesh.uvs.indices].reshape(-1, 3, 2)


def _areas(triangles: np.ndarray) -> np.ndarray:
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


@pytest.mark.parametrize("mesh", [BOX, torus(12).mesh], ids=["box", "torus"])
def test_coordinates_fill_the_square_without_overlaps(mesh: iso.Mesh) -> None:
    found = iso.unwrap(mesh, size=256)
    flat = _flat(found)
    assert flat.min() >= 0
    assert flat.max() <= 1
    # Points by chance lie in one triangle at most: covered area = sum of areas.
    points = np.random.default_rng(0).random((4000, 1, 2))
    edges = np.roll(flat, -1, axis=1) - flat
    sides = np.stack([edges[:, k, 0] * (points - flat[:, k])[..., 1] - edges[:, k, 1] * (points - flat[:, k])[..., 0]
                      for k in range(3)])  # fmt: skip
    inside = ((sides > 0).all(axis=0) | (sides < 0).all(axis=0)).sum(axis=1)
    assert inside.max() == 1
    assert (inside > 0).mean() == pytest.approx(_areas(flat).sum(), abs=0.03)
    assert _areas(flat).sum() > 0.3


def test_a_box_is_flattened_without_stretch() -> None:
    found = iso.unwrap(BOX)
    corners = found.vertices[found.faces]
    true = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    ratio = _areas(_flat(found)) / true
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-3)


def test_what_a_mesh_has_stays() -> None:
    dressed = BOX.with_(attributes={"colour": np.random.default_rng(1).random((8, 3)).astype(np.float32)})
    parts = iso.FaceLabels(("lid", "side"), np.array([0, 0, 1, 1, 1, 1], np.int32))
    dressed = dressed.with_(labels={"material": parts})
    found = iso.unwrap(dressed)
    assert (found.vertices == BOX.vertices).all()
    assert found.attributes["colour"] == dressed.attributes["colour"]
    assert found.labels["material"].index.tolist() == [0] * 4 + [1] * 8


def test_sizes_without_meaning_and_meshes_without_area_are_refused() -> None:
    with pytest.raises(iso.GeometryError, match="size"):
        iso.unwrap(BOX, size=2)
    with pytest.raises(iso.GeometryError, match="no area"):
        iso.unwrap(iso.Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)]))


def test_without_the_library_the_message_tells_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xatlas", None)
    with pytest.raises(iso.GeometryError, match=r"isophote\[uv\]"):
        iso.unwrap(BOX)
