"""Radiosity against closed forms, path tracing and its own bookkeeping."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from isophote.errors import IsophoteWarning, RenderError, SceneError
from scenes import box, plane

CAMERA = iso.Camera((0, 1, 4.4), (0, 1, 0), fov_degrees=34)


def quad(*corners: tuple[float, float, float]) -> iso.Mesh:
    """One parallelogram."""
    return iso.Mesh(corners, [(0, 1, 2, 3)])


def room(closed: bool = False, colour: object = (0.6, 0.6, 0.6)) -> list[iso.Item]:
    """A room from −1 to 1 and from y = 0 to 2, open to +Z unless `closed`."""
    walls = [
        quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)),
        quad((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)),
        quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)),
        quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)),
        quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)),
    ]
    front = [quad((-1, 0, 1), (-1, 2, 1), (1, 2, 1), (1, 0, 1))] if closed else []
    return [iso.Item(wall, iso.Matte(colour)) for wall in walls + front]


def lamp(height: float = 1.98) -> iso.RectLight:
    return iso.RectLight(size=(0.5, 0.5), radiance=(15, 15, 15)).at((0, height, 0))


@pytest.mark.parametrize("albedo", [0.0, 0.5, 0.8])
def test_within_a_box_that_shines_all_is_as_bright_as_its_series_says(albedo: float) -> None:
    # Of the sides that face inward B = E + ρ B, so B = E / (1 − ρ), and what arrives is as much: the box sees itself.
    body = iso.Matte((albedo, albedo, albedo)) if albedo > 0 else None
    shine = iso.Scene([iso.Item(box(2.0, inward=True), iso.Emitter(1.0, body=body))])
    found = iso.radiosity(shine, iso.Radiosity(residual=1e-6), progress=False)
    inside = found.form_factor_sums > 0.5
    exact = np.pi / (1 - albedo)
    np.testing.assert_allclose(found.irradiance[inside], exact, rtol=1e-4)
    weights = found.areas[inside, None]
    assert (found.irradiance[inside] * weights).sum() / weights.sum() / 3 == pytest.approx(exact, rel=1e-5)


def test_surfaces_that_reflect_and_shine_do_both() -> None:
    lit = iso.Item(plane(2.0), iso.Emitter(0.5, body=iso.Matte((0.4, 0.4, 0.4))))
    found = iso.radiosity(iso.Scene([lit], lights=[iso.Sun((0, 1, 0), irradiance=3.0)]), progress=False)
    up = found.irradiance[:, 0] > 0
    np.testing.assert_allclose(found.radiosity[up], 0.5 * np.pi + 0.4 * 3.0, rtol=1e-4)


def test_energy_in_a_closed_room_is_kept() -> None:
    scene = iso.Scene(room(closed=True), lights=[lamp(1.0)])
    found = iso.radiosity(scene, iso.Radiosity(patch=0.1, error=0.005), progress=False)
    sent = np.pi * 15 * 0.25
    absorbed = (found.irradiance * (1 - found.albedo) * found.areas[:, None]).sum(axis=0)
    # The back of the light is black and takes its share, which is counted with the rest.
    np.testing.assert_allclose(absorbed, sent, rtol=0.01)


def test_form_factor_sums_of_patches_in_a_closed_room_are_one() -> None:
    scene = iso.Scene(room(closed=True), lights=[lamp(1.0)])
    found = iso.radiosity(scene, iso.Radiosity(patch=0.1, error=0.005), progress=False)
    middle = found.corners[:, :3].mean(axis=1)
    inner = (np.abs(middle[:, [0, 2]]) < 1 + 1e-9).all(axis=1) & (found.form_factor_sums > 0.3)
    weights = found.areas[inner]
    assert (found.form_factor_sums[inner] * weights).sum() / weights.sum() == pytest.approx(1, abs=0.01)
    assert np.percentile(found.form_factor_sums[inner], [5, 95]) == pytest.approx([1, 1], abs=0.05)


@pytest.mark.parametrize("boxes", [False, True])
def test_pictures_equal_those_of_path_tracing(boxes: bool) -> None:
    items = room(colour=(0.7, 0.5, 0.3))
    if boxes:
        items.append(iso.Item(box(0.6), iso.Matte((0.6, 0.6, 0.6))).rotate("y", 0.3).translate((0.3, 0.3, 0.2)))
    scene = iso.Scene(items, lights=[lamp()], camera=CAMERA)
    settled = iso.render(scene, iso.Radiosity(patch=0.06, error=0.005), size=(80, 80), progress=False)
    traced = iso.render(scene, iso.PathTrace(samples=256, max_depth=64), size=(80, 80), progress=False)
    ours, theirs = (
        image.channels["colour"].astype(np.float64).reshape(10, 8, 10, 8, 3).mean(axis=(1, 3))[1:-1, 1:-1]
        for image in (settled, traced)
    )
    errors = np.abs(ours - theirs) / theirs
    assert np.median(errors) < 0.01
    assert np.percentile(errors, 90) < 0.03


def test_direct_light_of_a_point_falls_with_the_square_and_the_cosine() -> None:
    ground = iso.Item(plane(4.0), iso.Matte((0.5, 0.5, 0.5)))
    scene = iso.Scene([ground], lights=[iso.PointLight((0, 1, 0), power=4 * np.pi)])
    found = iso.radiosity(scene, iso.Radiosity(patch=0.05, error=0.01), progress=False)
    middle = found.corners.mean(axis=1)
    up = found.irradiance[:, 0] > 0
    exact = (1 + (middle[up] ** 2).sum(axis=1)) ** -1.5
    np.testing.assert_allclose(found.irradiance[up, 0], exact, atol=0.01)
    assert found.bounce_count >= 1


def test_bounces_add_up_and_residuals_fall() -> None:
    scene = iso.Scene(room(), lights=[lamp()])
    found = iso.radiosity(scene, iso.Radiosity(patch=0.2, residual=1e-3), progress=False)
    assert found.residuals[-1] <= 1e-3
    light = [found.bounce(k).colours.values.astype(np.float64).sum() for k in range(found.bounce_count + 1)]
    assert (np.diff(light) > 0).all()
    np.testing.assert_array_equal(found.bounce(found.bounce_count).colours.values, found.mesh.colours.values)
    with pytest.raises(RenderError, match="bounces 0 to"):
        found.bounce(found.bounce_count + 1)


def test_patches_are_small_where_light_changes_fast() -> None:
    items = [*room(), iso.Item(box(0.6), iso.Matte((0.6, 0.6, 0.6))).translate((0.3, 0.3, 0.2))]
    found = iso.radiosity(iso.Scene(items, lights=[lamp()]), iso.Radiosity(patch=0.02, error=0.2), progress=False)
    middle = found.corners[:, :3].mean(axis=1)
    floor = (found.item == 0) & (found.form_factor_sums > 0.1)
    distance = np.linalg.norm(middle[:, [0, 2]] - (0.3, 0.2), axis=1)
    near, far = floor & (distance < 0.5), floor & (distance > 1.0)
    assert np.median(found.areas[near]) < 0.3 * np.median(found.areas[far])


def test_the_mesh_has_no_cracks_within_a_plane() -> None:
    scene = iso.Scene(room(), lights=[lamp()])
    found = iso.radiosity(scene, iso.Radiosity(patch=0.02, error=0.1), progress=False)
    assert len(np.unique(np.round(found.areas, 9))) > 3
    faces = np.asarray(found.mesh.faces)
    triangles = found.mesh.vertices[faces]
    areas = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1) / 2
    assert areas.sum() == pytest.approx(found.areas.sum(), rel=1e-4)
    edges, counts = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_counts=True)
    ends = found.mesh.vertices[edges[counts == 1]]
    # Edges of one triangle lie on the rims of walls and of the lamp: no vertex is in the middle of another's edge.
    walls = np.stack([np.abs(ends[..., 0]), np.abs(ends[..., 2]), np.abs(ends[..., 1] - 1)], axis=-1)
    on_walls = (np.abs(walls - 1) < 1e-3).sum(axis=-1) >= 2
    on_lamp = (np.abs(ends[..., 1] - 1.98) < 1e-3) & (np.abs(ends[..., [0, 2]]).max(axis=-1) > 0.249)
    assert (on_walls | on_lamp).all()


def test_corners_that_rounding_moved_are_one() -> None:
    moved = iso.Item(iso.to_mesh(iso.box(0.6), cell=0.15), iso.Matte((0.6, 0.6, 0.6))).rotate("y", 0.3)
    scene = iso.Scene([*room(), moved.translate((0.2, 0.3, 0))], lights=[lamp()])
    found = iso.radiosity(scene, iso.Radiosity(patch=0.1, error=0.1), progress=False)
    triangles = found.mesh.vertices[np.asarray(found.mesh.faces)]
    areas = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1) / 2
    assert areas.sum() == pytest.approx(found.areas.sum(), rel=1e-4)


def test_colours_are_saved_and_read_again(tmp_path: Path) -> None:
    found = iso.radiosity(iso.Scene(room(), lights=[lamp()]), iso.Radiosity(patch=0.3), progress=False)
    found.save(tmp_path / "room.ply")
    again = iso.load_mesh(tmp_path / "room.ply")
    np.testing.assert_allclose(again.colours.values, found.mesh.colours.values, atol=1e-6)


def test_threads_make_no_difference() -> None:
    scene = iso.Scene(room(), lights=[lamp()])
    one, two = (iso.radiosity(scene, iso.Radiosity(patch=0.1), threads=t, progress=False) for t in (1, 2))
    np.testing.assert_array_equal(one.radiosity, two.radiosity)


def test_fields_and_many_triangles_take_part() -> None:
    ball = iso.Item(iso.sphere(0.4), iso.Matte((0.8, 0.2, 0.2))).translate((0, 0.5, 0))
    scene = iso.Scene([*room(), ball], lights=[lamp()], camera=CAMERA)
    image = iso.render(scene, iso.Radiosity(patch=0.1, error=0.05), size=(40, 40), progress=False)
    own = image.channels["colour"][image.channels["item"] == 5]
    assert len(own) > 20
    assert own[:, 0].mean() > 3 * own[:, 1].mean()


def test_what_makes_no_sense_is_refused() -> None:
    for settings in ({"patch": 0}, {"error": 0}, {"residual": -1}, {"samples": 0}):
        with pytest.raises(RenderError):
            iso.Radiosity(**settings)  # type: ignore[arg-type]
    with pytest.raises(RenderError, match="nothing shines"):
        iso.radiosity(iso.Scene(room()), progress=False)
    with pytest.raises(RenderError, match="links are needed"):
        iso.radiosity(iso.Scene(room(), lights=[lamp()]), iso.Radiosity(patch=0.05, max_links=100), progress=False)
    with pytest.raises((RenderError, SceneError), match=r"from 0 to 1"):
        iso.radiosity(iso.Scene([iso.Item(box(1.0), iso.Matte((1.2, 0.5, 0.5)))], lights=[lamp()]), progress=False)
    with pytest.raises(RenderError, match="endless"):
        iso.radiosity(iso.Scene([*room(), iso.Item(iso.cylinder(0.1))], lights=[lamp()]), progress=False)
    with pytest.warns(IsophoteWarning, match="diffuse"):
        iso.radiosity(iso.Scene([*room(), iso.Item(box(0.2), iso.Mirror())], lights=[lamp()]), progress=False)
