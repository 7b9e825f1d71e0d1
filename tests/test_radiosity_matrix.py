"""Radiosity with the whole matrix of form factors: its rows, gathering and shooting, against each other, closed forms
and the hierarchy."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import isophote as iso
from isophote.errors import RenderError
from isophote.lower.scene import lower_scene
from isophote.progress import Reporter
from isophote.rendering.occlusion.directions import hemisphere
from isophote.rendering.radiosity.coverage import Coverage
from isophote.rendering.radiosity.faces import faces_of
from isophote.rendering.radiosity.matrix import DirectionRows, PairRows
from isophote.rendering.radiosity.tree import PatchTree
from isophote.rendering.radiosity.uniform import cut_evenly, settle_evenly
from scenes import box
from test_radiosity import CAMERA, lamp, quad, room

SILENT = Reporter(lambda stage, part: None)
WAYS = ["rays", "hemicube", "hemisphere"]


def per_item(found: iso.RadiositySolution) -> np.ndarray:
    """Mean irradiance of each item."""
    power = np.bincount(found.item, found.irradiance[:, 0] * found.areas)
    return power / np.bincount(found.item, found.areas)


def cut(scene: iso.Scene, patch: float, **changes: float) -> tuple[object, PatchTree]:
    """Tables and even patches of a scene, all of one emission and albedo if these are given."""
    faces = faces_of(scene, patch)
    faces = attrs.evolve(faces, **{name: np.full((len(faces.sides), 3), value) for name, value in changes.items()})
    camera = iso.Camera((0, 0, 1), (0, 0, 0))
    tables = lower_scene(iso.Scene([iso.Item(mesh) for mesh in faces.meshes], camera=camera), (1, 1), 2)
    tree = PatchTree(faces, Coverage(tables, faces.solid, 2))
    cut_evenly(tree, patch)
    return tables, tree


def test_the_hemisphere_is_even_in_form_factors() -> None:
    rows = hemisphere(128).astype(np.float64)
    x, y, z, weight = rows.T
    assert weight.sum() == pytest.approx(1)
    np.testing.assert_allclose(np.linalg.norm(rows[:, :3], axis=1), 1, atol=1e-6)
    # ∫ cosθ · cosθ / π dω = 2/3, ∫ x² cosθ / π dω = 1/4.
    assert weight @ z == pytest.approx(2 / 3, abs=1e-3)
    assert weight @ (x * x) == pytest.approx(1 / 4, abs=1e-3)
    assert weight @ (y * y) == pytest.approx(1 / 4, abs=1e-3)
    assert abs(weight @ x) < 1e-6


@pytest.mark.parametrize("way", WAYS)
def test_rows_equal_closed_forms(way: str) -> None:
    tables, tree = cut(iso.Scene([iso.Item(box(2.0, inward=True), iso.Matte(0.5))]), 0.5)
    leaves = tree.leaves
    inside = np.flatnonzero((tree.normals[leaves] * tree.centres[leaves]).sum(axis=1) < 0)
    numbers = inside[[17, 3, 40]]
    rows = PairRows(tables, tree, 2) if way == "rays" else DirectionRows(tree, way, 200_000, 2)
    found = rows(numbers)
    for number, row in zip(numbers, found, strict=True):
        corners = tree.corners[leaves[number]]
        # Directions leave the middle of a patch, pairs of patches are averaged over all of it.
        size = 1.0 if way == "rays" else 1e-4
        own = tree.centres[leaves[number]] + size * (corners - tree.centres[leaves[number]])
        exact = [iso.form_factor(own, tree.corners[leaves[k]]) for k in inside]
        np.testing.assert_allclose(row[inside], exact, atol=3e-4)
        assert row.sum() == pytest.approx(1, abs=0.005)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("method", ["gathering", "shooting"])
def test_a_closed_room_of_equal_walls(method: str, way: str) -> None:
    tables, tree = cut(iso.Scene(room(closed=True)), 0.5, emission=2.0, albedo=0.6)
    found = settle_evenly(
        tables, tree, method=method, form_factors=way, directions=4096, residual=1e-5, report=SILENT, threads=2
    )
    leaves = tree.leaves
    inside = (tree.normals[leaves] * (tree.centres[leaves] - (0, 1, 0))).sum(axis=1) < 0
    # B = E / (1 − ρ).
    light = found.light[leaves][inside]
    assert light.mean() == pytest.approx(5, rel=0.003)
    np.testing.assert_allclose(light, 5, rtol=0.04)


@pytest.fixture(scope="module")
def furnished() -> iso.Scene:
    """A room with a solid box that stands on the floor, and a sheet with two sides."""
    sheet = quad((-0.8, 0.2, -0.4), (-0.2, 0.2, -0.4), (-0.2, 1.2, -0.2), (-0.8, 1.2, -0.2))
    items = [
        *room(colour=(0.7, 0.7, 0.7)),
        iso.Item(box(0.6), iso.Matte((0.5, 0.5, 0.5))).translate((0.4, 0.3, 0.2)),
        iso.Item(sheet, iso.Matte(0.8)),
    ]
    return iso.Scene(items, lights=[lamp(1.5)])


@pytest.fixture(scope="module")
def linked(furnished: iso.Scene) -> iso.RadiositySolution:
    return iso.radiosity(furnished, iso.Radiosity(patch=0.1), progress=False)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("method", ["gathering", "shooting"])
def test_all_ways_agree_with_the_hierarchy(
    furnished: iso.Scene, linked: iso.RadiositySolution, method: str, way: str
) -> None:
    settings = iso.Radiosity(patch=0.26, method=method, form_factors=way)
    found = iso.radiosity(furnished, settings, progress=False)
    assert found.areas.sum() == pytest.approx(linked.areas.sum())
    assert found.areas.max() <= 0.26**2
    # One place stands for a patch of which a box may cover a part, or that is as large as its distance.
    np.testing.assert_allclose(per_item(found), per_item(linked), rtol=0.03 if way == "rays" else 0.05)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("method", ["gathering", "shooting"])
def test_all_ways_agree_in_an_empty_room(method: str, way: str) -> None:
    scene = iso.Scene(room(), lights=[lamp(1.5)])
    settings = iso.Radiosity(patch=0.26, method=method, form_factors=way)
    found, linked = (iso.radiosity(scene, s, progress=False) for s in (settings, iso.Radiosity(patch=0.1)))
    np.testing.assert_allclose(per_item(found)[:5], per_item(linked)[:5], rtol=0.02)


def test_shooting_keeps_energy_and_tells_what_is_left() -> None:
    stages: list[str] = []
    scene = iso.Scene(room(closed=True), lights=[lamp(1.0)])
    settings = iso.Radiosity(patch=0.25, method="shooting", residual=1e-3)
    found = iso.radiosity(scene, settings, progress=lambda stage, part: stages.append(stage))
    absorbed = (found.irradiance * (1 - found.albedo) * found.areas[:, None]).sum(axis=0)
    np.testing.assert_allclose(absorbed, np.pi * 15 * 0.25, rtol=0.01)
    assert found.residuals[-1] <= 1e-3
    assert (np.diff(found.residuals) < 0).all()
    assert any("ambient" in stage for stage in stages)


@pytest.mark.parametrize("method", ["gathering", "shooting"])
def test_pictures_and_bounces(method: str) -> None:
    scene = iso.Scene(room(), lights=[lamp(), iso.PointLight((0, 1, 0), power=10)], camera=CAMERA)
    ours = iso.render(scene, iso.Radiosity(patch=0.25, method=method), size=(32, 32), progress=False)
    linked = iso.render(scene, iso.Radiosity(patch=0.1), size=(32, 32), progress=False)
    blocks = [image.channels["colour"].reshape(4, 8, 4, 8, 3).mean(axis=(1, 3)) for image in (ours, linked)]
    np.testing.assert_allclose(blocks[0], blocks[1], rtol=0.08)
    found = iso.radiosity(scene, iso.Radiosity(patch=0.3, method=method), progress=False)
    light = [found.bounce(k).colours.values.astype(np.float64).sum() for k in range(found.bounce_count + 1)]
    assert (np.diff(light) > 0).all()
    np.testing.assert_array_equal(found.bounce(found.bounce_count).colours.values, found.mesh.colours.values)


def test_too_many_form_factors_are_refused_before_any_is_made() -> None:
    scene = iso.Scene(room(), lights=[lamp()])
    with pytest.raises(RenderError, match=r"form factors, some .* MB.*hierarchical"):
        iso.radiosity(scene, iso.Radiosity(patch=1e-5, method="gathering", max_links=2**31), progress=False)
    with pytest.raises(RenderError, match="at most 1,000 may"):
        iso.radiosity(scene, iso.Radiosity(patch=0.5, method="shooting", max_links=1000), progress=False)
    with pytest.raises(RenderError, match="nothing shines"):
        iso.radiosity(iso.Scene(room()), iso.Radiosity(patch=0.5, method="gathering"), progress=False)
    for settings in ({"method": "magic"}, {"form_factors": "guess"}, {"directions": 0}):
        with pytest.raises(RenderError):
            iso.Radiosity(**settings)  # type: ignore[arg-type]


@pytest.mark.parametrize("patch", [1e-3, 1e-9])
def test_what_memory_cannot_hold_is_told_in_few_digits(patch: float) -> None:
    with pytest.raises(RenderError) as caught:
        iso.radiosity(
            iso.Scene(room(), lights=[lamp()]), iso.Radiosity(patch=patch, method="gathering"), progress=False
        )
    words = str(caught.value)
    assert " MB; at most 50,000,000 may be kept" in words
    assert max(len(word) for word in words.split()) < 30
