"""Boxes of accelerators: what levels hold, and pictures of them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import isophote as iso
from isophote.accel.accelerator import build_accelerator
from isophote.accel.bih import parts_finished
from isophote.accel.bsp_cells import bsp_levels
from isophote.accel.cells import MOST_BOXES, SHOWN, edges_of, levels_of
from isophote.errors import GeometryError, RenderError
from isophote.kernels.accel.layout import BLOCK, NUMBER
from scenes import icosphere

BALL = icosphere(3)


def levels(name: str, depth: int) -> list[np.ndarray]:
    built = build_accelerator(name, BALL.vertices.astype(np.float32), np.asarray(BALL.faces))
    return levels_of(name, built, depth)


@pytest.mark.parametrize("name", ["bvh", "kdtree", "grid", "bih"])
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


@pytest.mark.parametrize("name", ["bvh", "grid", "bih"])
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


def test_a_hierarchy_that_rays_build_is_shown_as_a_whole() -> None:
    built = build_accelerator("bih", BALL.vertices.astype(np.float32), np.asarray(BALL.faces))
    found = levels_of("bih", built, 64)
    done, parts = parts_finished(built)
    assert done == parts
    blocks = built.blocks.reshape(-1, BLOCK)
    used = blocks[(blocks[:, :NUMBER] != 0).any(axis=1)]
    # Beside every node's children there are leaves of some blocks each; none has more than seven.
    assert sum(len(boxes) for boxes in found) >= len(used) / 7
    for parents, children in itertools.pairwise(found):
        assert len(children) <= 8 * len(parents)
        inside = (children[:, None, 0] >= parents[:, 0]) & (children[:, None, 1] <= parents[:, 1])
        assert inside.all(axis=2).any(axis=1).all()


def test_cells_of_a_bsp_tree_fill_their_parents() -> None:
    """Polyhedra between planes: of two cells, volumes add up to that of the cell they were."""
    turned = iso.Item(iso.Mesh(BALL.vertices * (1, 0.4, 0.2), BALL.faces)).rotate((1, 2, 3), 0.7).transform.matrix
    points = (BALL.vertices * (1, 0.4, 0.2)) @ turned[:3, :3].T
    built = build_accelerator("bsp", points.astype(np.float32), np.asarray(BALL.faces))
    found = bsp_levels(built, 4, MOST_BOXES)
    volumes = [[ConvexHull(np.concatenate(cell)).volume for cell in cells] for cells in found]
    assert len(volumes) == 5
    for parents, children in itertools.pairwise(volumes):
        # Leaves have no parts.
        for whole in np.add.reduceat(children, np.arange(0, len(children), 2)):
            assert np.isclose(parents, whole, rtol=1e-9).any()
    slanted = [polygon for cell in found[-1] for polygon in cell if np.ptp(polygon, axis=0).min() > 1e-3]
    assert slanted
    for polygon in slanted:
        normal = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
        assert np.abs((polygon - polygon[0]) @ normal).max() < 1e-6


@pytest.mark.parametrize("name", SHOWN)
def test_edges_of_every_accelerator_lie_in_its_bounds(name: str) -> None:
    built = build_accelerator(name, BALL.vertices.astype(np.float32), np.asarray(BALL.faces))
    found = edges_of(name, built, 3)
    assert found[0].cells == 1
    assert len(np.unique(found[0].ends.reshape(-1, 3), axis=0)) == 8
    for level in found:
        assert level.ends.shape == (len(level.ends), 2, 3)
        assert np.abs(level.ends).max() < np.abs(BALL.vertices).max() * 1.01
    assert iso.show_tree(BALL, name, depth=2, size=(48, 36)).metadata["accelerator"] == name
