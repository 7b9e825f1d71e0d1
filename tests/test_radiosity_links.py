"""What radiosity makes of many faces: groups of them, links between these, and what light along links comes to."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.kernels.trace.local_factors import near_factors
from isophote.rendering.radiosity.balance import Balance
from isophote.rendering.radiosity.clusters import grouped, measured
from isophote.rendering.radiosity.expansion import Expansion
from isophote.rendering.radiosity.links import Links
from isophote.rendering.radiosity.tree import PatchTree
from isophote.rendering.tracer import Tracer
from scenes import box, icosphere


def grid(corner: tuple[float, ...], along: tuple[float, ...], across: tuple[float, ...], count: int) -> iso.Mesh:
    """A parallelogram as count × count of them."""
    i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
    steps = np.stack([i.reshape(-1), j.reshape(-1)], axis=1) / count
    number = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    faces = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    return iso.Mesh(np.asarray(corner, float) + steps @ np.array([along, across], float), faces)


def room(count: int, *things: iso.Item) -> iso.Scene:
    """Five walls in count × count faces each, with a lamp below the ceiling."""
    walls = [
        grid((-1, 0, -1), (0, 0, 2), (2, 0, 0), count),
        grid((-1, 2, -1), (2, 0, 0), (0, 0, 2), count),
        grid((-1, 0, -1), (2, 0, 0), (0, 2, 0), count),
        grid((-1, 0, 1), (0, 0, -2), (0, 2, 0), count),
        grid((1, 0, -1), (0, 0, 2), (0, 2, 0), count),
    ]
    lamp = iso.RectLight(size=(0.5, 0.5), radiance=15).at((0, 1.8, 0))
    return iso.Scene([*(iso.Item(wall, iso.Matte(0.6)) for wall in walls), *things], lights=[lamp])


def per_item(found: iso.RadiositySolution) -> np.ndarray:
    """Mean irradiance of each item."""
    power = np.bincount(found.item, found.irradiance[:, 0] * found.areas)
    return power / np.bincount(found.item, found.areas)


@pytest.mark.parametrize("count", [1, 3, 26, 4001])
def test_groups_hold_each_face_once_and_are_runs_of_the_order(count: int) -> None:
    random = np.random.default_rng(count)
    centres, normals = random.random((count, 3)), random.normal(size=(count, 3))
    centres[: count // 2] = centres[0]
    normals[: count // 2] = normals[0]
    found = grouped(centres, normals)
    np.testing.assert_array_equal(np.sort(found.order), np.arange(count))
    owned = np.zeros(count + len(found.first), int)
    first = np.concatenate([np.arange(count), found.first])
    last = np.concatenate([np.arange(1, count + 1), found.last])
    for k, (child, children) in enumerate(zip(found.first_child, found.children, strict=True)):
        inner = np.arange(child, child + children)
        owned[inner] += 1
        assert 1 <= children <= 4
        assert (first[inner[0]], last[inner[-1]]) == (found.first[k], found.last[k])
        np.testing.assert_array_equal(last[inner[:-1]], first[inner[1:]])
    assert owned[count] == 0
    assert (np.delete(owned, count) == 1).all()


def test_walls_are_groups_of_their_own_and_know_their_planes() -> None:
    meshes = [grid((0, 0, 0), (0, 0, 1), (1, 0, 0), 12), grid((0, 0, 0), (1, 0, 0), (0, 1, 0), 12)]
    corners = np.concatenate([mesh.vertices[np.asarray(mesh.indices).reshape(-1, 4)] for mesh in meshes])
    normals = np.repeat([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0)], 144, axis=0)
    centres = corners.mean(axis=1)
    groups = grouped(centres, normals)
    order = groups.order
    found = measured(groups, corners[order], normals[order], np.full(288, 1 / 144), centres[order])
    assert found.flat[0] == 0
    assert found.flat[1:].all()
    halves = np.arange(1, 5)
    np.testing.assert_array_equal((groups.last - groups.first)[halves], 72)
    for wall in halves:
        assert found.areas[wall] == pytest.approx(0.5)
        np.testing.assert_allclose(found.centres[wall] @ found.normals[wall], 0, atol=1e-12)
        along, across = found.axes[wall].reshape(2, 3)
        assert np.linalg.norm(np.cross(along, across)) == pytest.approx(0.125)
        assert found.radii[wall] == pytest.approx(1.25**0.5 / 2)


def brute_force(expansion: Expansion, tree: PatchTree, links: tuple[np.ndarray, ...], light: np.ndarray) -> np.ndarray:
    """Irradiance of leaves, each by itself averaged over all links of the nodes that it is part of."""
    receivers, sources, visible = links
    order = np.argsort(receivers, kind="stable")
    starts = np.searchsorted(receivers[order], np.arange(len(tree) + 1))
    rows, counts = [], []
    for leaf in expansion.leaves:
        node, count = int(leaf), 0
        while node >= 0:
            rows.append(order[starts[node] : starts[node + 1]])
            count += len(rows[-1])
            node = int(tree.parent[node])
        counts.append(count)
    row = np.concatenate(rows)
    own, shares = sources[row].astype(np.int32), visible[row].astype(np.float32)
    ends, factors = np.concatenate([[0], np.cumsum(counts)]), np.zeros(len(row), np.float32)
    near_factors(tree.packed().words, expansion.leaves, ends, own, shares, np.zeros(0), factors, 0, len(counts))
    leaf = np.repeat(np.arange(len(counts)), counts)
    return np.bincount(leaf, factors * light[own, 0], minlength=len(counts))


# Groups are measured by less, and the nearer the groups that leaves are linked to, the less is that.
@pytest.mark.parametrize(("count", "ball", "mean", "most"), [(1, False, 1e-3, 0.005), (5, True, 0.01, 0.05)])
def test_light_along_links_is_what_each_leaf_would_get_by_itself(
    count: int, ball: bool, mean: float, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []
    build = Expansion.__init__

    def kept(self: Expansion, tree: PatchTree, *rest: object, whole: bool = False) -> None:
        build(self, tree, *rest, whole=whole)  # type: ignore[arg-type]
        if not whole:
            made.append((self, tree, rest))

    monkeypatch.setattr(Expansion, "__init__", kept)
    balls = [iso.Item(icosphere(2, radius=0.4), iso.Matte(0.5)).translate((0.2, 0.5, 0.1))] if ball else []
    solution = iso.radiosity(room(count, *balls), iso.Radiosity(patch=0.1, error=0.05), progress=False)
    # The last but one, in which nodes shine evenly.
    expansion, tree, (receivers, sources, visible, bright, _) = made[-2]
    assert bright.size == 0
    light = np.random.default_rng(1).random((len(tree), 3))
    light = Balance.pulled(solution._settled.balance, light)
    found = expansion.gathered(light)[:, 0]
    exact = brute_force(expansion, tree, (receivers, sources, visible), light)
    assert np.sqrt(np.mean((found - exact) ** 2)) < mean * exact.mean()
    assert np.abs(found - exact).max() < most * exact.mean()


def joined(meshes: tuple[iso.Mesh, ...]) -> iso.Mesh:
    """All triangles of several meshes."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    cut = [iso.triangulate(mesh).triangles for mesh in meshes]
    faces = np.concatenate([triangles + start for triangles, start in zip(cut, starts[:-1], strict=True)])
    return iso.Mesh(np.concatenate([mesh.vertices for mesh in meshes]), faces)


def places(tree: PatchTree, node: int, random: np.random.Generator) -> np.ndarray:
    """Places on a patch."""
    u, v = random.random((2, 64, 1))
    corners, last = tree.corners[node], int(tree.sides[node]) - 1
    if last == 2:
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return corners[0] + u * (corners[1] - corners[0]) + v * (corners[last] - corners[0])


def test_between_pairs_in_plain_sight_no_ray_is_blocked(monkeypatch: pytest.MonkeyPatch) -> None:
    kept = []
    refine = Links.refine

    def refined(self: Links, *rest: object) -> None:
        refine(self, *rest)  # type: ignore[arg-type]
        kept.append((self, self._tree))

    monkeypatch.setattr(Links, "refine", refined)
    things = [
        iso.Item(box(0.5), iso.Matte(0.5)).rotate("y", 0.4).translate((0.4, 0.25, 0.2)),
        iso.Item(icosphere(2, radius=0.3), iso.Matte(0.5)).translate((-0.4, 0.9, 0.1)),
    ]
    scene = room(2, *things)
    iso.radiosity(scene, iso.Radiosity(patch=0.15, error=0.02), progress=False)
    links, tree = kept[-1]
    tracer = Tracer(joined(tree.faces.meshes))
    plain = links.pairs[(links.seen[:, 0] == 1) & (links.seen[:, 2] == 0)]
    plain = plain[(tree.sides[plain] > 0).all(axis=1)]
    random = np.random.default_rng(2)
    checked = 0
    for p, q in plain[random.choice(len(plain), 300, replace=False)]:
        start, end = places(tree, p, random), places(tree, q, random)
        way = end - start
        facing = ((way * tree.normals[p]).sum(axis=1) > 1e-3) & ((way * tree.normals[q]).sum(axis=1) < -1e-3)
        start, way = start[facing] + 1e-4 * way[facing], way[facing]
        if len(way):
            hits = tracer.closest(start, way)
            assert not (hits.hit & (hits.distance < 0.999)).any()
            checked += len(way)
    assert checked > 5000


def test_a_small_sheet_before_a_wall_has_its_shadow() -> None:
    # Its shadow is a sixtieth of the wall: sixteen rays between lamp and wall would mostly miss it.
    sheet = iso.Item(grid((-0.95, 0.6, -0.1), (0, 0, 0.2), (0, 0.2, 0), 1), iso.Matte(0.0))
    with_sheet, without = (
        iso.radiosity(room(1, *things), iso.Radiosity(patch=0.1), progress=False) for things in ((sheet,), ())
    )

    def behind(found: iso.RadiositySolution) -> float:
        middle = found.corners.mean(axis=1)
        own = (found.item == 3) & (found.irradiance[:, 0] > 0) & (np.abs(middle[:, 2]) < 0.1)
        own &= np.abs(middle[:, 1] - 0.65) < 0.06
        return float(np.average(found.irradiance[own, 0], weights=found.areas[own]))

    assert behind(with_sheet) < 0.5 * behind(without)


def test_walls_in_many_faces_are_as_bright_as_whole_ones() -> None:
    whole = iso.radiosity(room(1), iso.Radiosity(patch=0.05, error=0.002), progress=False)
    cut = iso.radiosity(room(20), iso.Radiosity(patch=1.0), progress=False)
    assert len(cut.areas) > 4000
    assert cut.links < 20 * len(cut.areas)
    np.testing.assert_allclose(per_item(cut)[:5], per_item(whole)[:5], rtol=0.005)


def test_what_is_visible_of_a_source_counts_by_how_bright_it_is() -> None:
    # A sheet hides the dark half of the ground from the sheet's other side; what is seen is the bright half.
    bright, dark = (iso.Emitter(value) for value in (1.0, 0.001))
    ground = [
        iso.Item(grid((0, 0, 0), (0, 0, 1), (1, 0, 0), 8), bright),
        iso.Item(grid((-1, 0, 0), (0, 0, 1), (1, 0, 0), 8), dark),
    ]
    curtain = iso.Item(grid((0, 0, -3), (0, 0, 7), (0, 0.4, 0), 1), iso.Matte(0.0))
    above = iso.Item(grid((1, 0.4, 0), (1, 0, 0), (0, 0, 1), 8), iso.Matte(0.5))
    found = iso.radiosity(iso.Scene([*ground, curtain, above]), iso.Radiosity(patch=1.0), progress=False)
    facing = (found.item == 3) & (found.irradiance[:, 0] > 0)
    weights = found.areas[facing]
    mean = (found.irradiance[facing, 0] * weights).sum() / weights.sum()
    plate = [(1, 0.4, 0), (2, 0.4, 0), (2, 0.4, 1), (1, 0.4, 1)]
    seen = iso.form_factor(plate, [(0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 0, 0)])
    assert mean == pytest.approx(np.pi * seen, rel=0.02)
