"""Boxes of accelerators: what levels hold, and pictures of them."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.accel.accelerator import build_accelerator
from isophote.accel.cells import levels_of
from isophote.errors import GeometryError, RenderError
from scenes import icosphere

BALL = icosphere(3)


def levels(name: str, depth: int) -> list[np.ndarray]:
    built = build_accelerator(name, BALL.vertices.astype(np.float32), np.asarray(BALL.faces))
    return levels_of(name, built, depth)


@pytest.mark.parametrize("name", ["bvh", "kdtree", "grid"])
def test_every_level_lies_within_the_root(name: str) -> None:
    found = levels(name, 6)
    assert len(found) > 1
    assert found[0].shape == (1, 2, 3)
    root = found[0][0]
    for boxes in found:
        assert (boxes[:, 0] <= boxes[:, 1]).all()
        if name != "grid":
            assert (boxes[:, 0] >= root[0]).all()
            assert (boxes[:, 1] <= root[1]).all()


def test_cells_of_a_kd_tree_fill_their_parents() -> None:
    found = levels("kdtree", 5)
    assert found[1].shape[0] == 2
    volumes = [np.prod(boxes[:, 1] - boxes[:, 0], axis=1).sum() for boxes in found]
    assert volumes[1] == pytest.approx(volumes[0])
    assert (np.diff(volumes) <= 1e-9).all()


@pytest.mark.parametrize("name", ["bvh", "grid"])
def test_boxes_of_a_level_hold_all_vertices(name: str) -> None:
    boxes = levels(name, 1)[1]
    points = BALL.vertices[:, None]
    inside = ((points >= boxes[:, 0] - 1e-6) & (points <= boxes[:, 1] + 1e-6)).all(axis=2).any(axis=1)
    assert inside.all()


def test_pictures_have_lines_over_the_mesh() -> None:
    bare = iso.render(BALL, iso.RayTrace(samples=4), size=(96, 72), progress=False).channels["colour"] * 0.6
    image = iso.show_tree(BALL, "kdtree", depth=2, size=(96, 72))
    changed = np.abs(image.channels["colour"] - bare).max(axis=2) > 0.1
    assert 0.01 < changed.mean() < 0.5
    assert image.metadata["boxes by level"] == "1, 2, 4"
    only = iso.show_tree(BALL, "kdtree", depth=2, levels=[2], size=(96, 72))
    assert (only.channels["colour"] != image.channels["colour"]).any()


def test_what_has_no_tree_is_refused() -> None:
    with pytest.raises(RenderError, match="mesh"):
        iso.show_tree(iso.sphere(1))  # type: ignore[arg-type]
    with pytest.raises(RenderError, match="depth"):
        iso.show_tree(BALL, depth=-1)
    with pytest.raises(GeometryError, match="show_tree knows"):
        iso.show_tree(BALL, "octree")
