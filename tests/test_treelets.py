"""Binary trees cut into treelets: the same tree comes out again, and no cut of three levels costs less."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from accelerator_rays import rays_at
from isophote.accel.treelets import MISSING, PLANES, ROOT, Treelets, leaf_lanes, parted, plane_lanes, treelets_of
from trees import soup


class Binary:
    """A random binary tree: lower children, sizes of cells that shrink downward, first blocks and counts of leaves."""

    def __init__(self, seed: int, inner: int) -> None:
        rng = np.random.default_rng(seed)
        child, areas = [MISSING], [1.0]
        for _ in range(inner):
            leaves = [node for node, lower in enumerate(child) if lower == MISSING]
            # The last leaves more often than others: chains, as where space is empty.
            node = leaves[-1] if rng.random() < 0.4 else leaves[rng.integers(len(leaves))]
            child[node] = len(child)
            child += [MISSING, MISSING]
            areas += (areas[node] * rng.uniform(0.2, 1, 2)).tolist()
        # Children have to come after their parents, and do.
        self.child, self.areas = np.array(child, np.int32), np.array(areas, np.float32)
        self.counts = rng.choice([0, 1, 5, 31, 32, 1000], len(child)).astype(np.int32)
        self.firsts = rng.choice([0, 7, (1 << 26) - 1, 1 << 26, (1 << 31) - 1], len(child)).astype(np.int32)

    def cut(self) -> Treelets:
        return treelets_of(self.child, self.areas, self.firsts, self.counts)


def leaf_of(tree: Treelets, node: np.ndarray) -> tuple[int, int]:
    """First block and count of a leaf, by its code."""
    code = int(tree.codes[leaf_lanes(node)][0])
    if code == 0:
        return 0, 0
    first, count = divmod(-1 - code, 32)
    return (first, count) if count > 0 else (int(tree.leaves[first, 0]), int(tree.leaves[first, 1]))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 40))
def test_treelets_are_the_tree_that_they_were_made_from(seed: int, inner: int) -> None:
    binary = Binary(seed, inner)
    tree = binary.cut()
    places = np.where(tree.planes == MISSING, np.inf, tree.planes)
    places = np.column_stack([places, np.zeros(len(places))])
    pending, met = [(0, ROOT)], 0
    while pending:
        node, number = pending.pop()
        met += 1
        treelet, lane = plane_lanes(np.array([number]))
        if binary.child[node] == MISSING:
            assert lane[0] == PLANES or tree.planes[treelet, lane] == MISSING
            first, count = leaf_of(tree, np.array([number]))
            assert count == binary.counts[node]
            assert count == 0 or first == binary.firsts[node]
            continue
        assert tree.planes[treelet, lane] == node
        lower, upper = parted(np.array([number]), places, tree.codes)
        pending += [(binary.child[node], int(lower[0])), (binary.child[node] + 1, int(upper[0]))]
    assert met == len(binary.child)
    assert (tree.present == (tree.codes != 0)).all()
    assert np.count_nonzero(tree.codes > 0) == len(tree.codes) - 1
    assert np.count_nonzero(tree.planes != MISSING) == inner


def least_cost(binary: Binary) -> float:
    """What all treelets cost where every cut of three levels is tried."""

    @functools.cache
    def begun(node: int) -> float:
        if binary.child[node] == MISSING:
            return 0.0
        return float(binary.areas[node]) + sum(going(int(binary.child[node]) + side, 2) for side in (0, 1))

    @functools.cache
    def going(node: int, levels: int) -> float:
        if binary.child[node] == MISSING or levels == 0:
            return begun(node)
        return min(begun(node), sum(going(int(binary.child[node]) + side, levels - 1) for side in (0, 1)))

    return begun(0)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_no_cut_of_three_levels_costs_less(seed: int, inner: int) -> None:
    binary = Binary(seed, inner)
    tree = binary.cut()
    # The root of a treelet is its middle plane.
    assert binary.areas[tree.planes[:, 3]].astype(float).sum() == pytest.approx(least_cost(binary), rel=1e-6)


@pytest.mark.parametrize("name", ["kdtree", "bsp"])
@pytest.mark.parametrize("count", [1, 31, 32, 200])
def test_leaves_of_any_length_are_searched(name: str, count: int) -> None:
    """Triangles that lie so close to each other that no plane is worth its cost."""
    triangle = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)
    depth = np.linspace(0, 1e-6, count, dtype=np.float32)
    stack = triangle + depth[:, None, None] * np.array([0, 0, 1], np.float32)
    mesh = iso.Mesh(*soup(stack))
    rays = rays_at(mesh, 500)
    brute, tracer = iso.Tracer(mesh, accelerator="brute"), iso.Tracer(mesh, accelerator=name)
    assert (tracer.closest(*rays).distance == brute.closest(*rays).distance).all()
    assert (tracer.occluded(*rays) == brute.occluded(*rays)).all()
    assert tracer.count(*rays).primitives.max() == count
