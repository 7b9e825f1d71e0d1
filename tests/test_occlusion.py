"""Ambient occlusion against closed forms, its ways against each other, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.errors import RenderError
from isophote.rendering.occlusion.directions import hemicube
from scenes import icosphere, plane

UP = (0.0, 1.0, 0.0)
# What a half cube of 128 pixels and 4,096 even random rays may be off.
NEAR = 4e-3


def wall(height: float, distance: float) -> iso.Scene:
    """A ground, and a wall on it that is as good as endless to both sides."""
    far = 300.0
    corners = [(distance, 0, -far), (distance, 0, far), (distance, height, far), (distance, height, -far)]
    return iso.Scene([iso.Item(iso.Mesh(corners, [(0, 1, 2, 3)]))])


@pytest.mark.parametrize(("by", "samples"), [("rays", 4096), ("hemicube", 128)])
@pytest.mark.parametrize(("height", "distance"), [(1.0, 0.5), (0.3, 1.0), (3.0, 0.2)])
def test_beside_a_wall(by: str, samples: int, height: float, distance: float) -> None:
    found = iso.ambient_occlusion(wall(height, distance), [(0, 0, 0)], [UP], by=by, samples=samples, bias=1e-4)
    exact = 1 - 0.5 * (1 - distance / np.hypot(distance, height))
    assert found.visibility[0] == pytest.approx(exact, abs=NEAR)
    assert found.occlusion[0] == pytest.approx(1 - exact, abs=NEAR)
    bent = found.bent_normal[0]
    assert bent[0] < 0 < bent[1]
    assert abs(bent[2]) < 0.01
    assert np.linalg.norm(bent) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize(("by", "samples"), [("rays", 4096), ("hemicube", 128)])
@pytest.mark.parametrize("opening", [0.0, 0.5])
def test_within_a_bowl_all_places_see_as_much(by: str, samples: int, opening: float) -> None:
    # The opening's cap over the whole sphere's area: 2πR (R − y) / 4πR².
    bowl = (iso.sphere(1.2) - iso.sphere(1)) & iso.plane().translate((0, opening, 0))
    polar = np.array([0.0, 0.4, 0.8, 1.2, 1.5])
    points = np.stack([np.sin(polar), -np.cos(polar), np.zeros(5)], axis=1)
    found = iso.ambient_occlusion(bowl, points, -points, by=by, samples=samples, bias=1e-3)
    np.testing.assert_allclose(found.visibility, (1 - opening) / 2, atol=2 * NEAR)


@pytest.mark.parametrize("ball", [iso.sphere(0.5), icosphere(4, radius=0.5)])
def test_below_a_ball(ball: iso.Field | iso.Mesh) -> None:
    item = iso.Item(ball).translate((0, 1, 0))
    points, normals = [(0.0, 0.0, 0.0)], [UP]
    found = iso.ambient_occlusion(item, points, normals, samples=4096)
    assert found.occlusion[0] == pytest.approx(0.25, abs=NEAR)
    even = iso.ambient_occlusion(item, points, normals, samples=4096, weights="uniform")
    assert even.occlusion[0] == pytest.approx(1 - np.sqrt(0.75), abs=NEAR)


def test_rays_end_where_they_are_told_to() -> None:
    scene = wall(1.0, 0.5)
    assert iso.ambient_occlusion(scene, [(0, 0, 0)], [UP], max_distance=0.49).visibility[0] == 1
    some = iso.ambient_occlusion(scene, [(0, 0, 0)], [UP], max_distance=0.8, samples=1024).visibility[0]
    assert iso.ambient_occlusion(scene, [(0, 0, 0)], [UP], samples=1024).visibility[0] < some < 1


def test_the_weights_of_a_half_cube_are_form_factors() -> None:
    rows = hemicube(256).astype(np.float64)
    np.testing.assert_allclose(np.linalg.norm(rows[:, :3], axis=1), 1, atol=1e-6)
    assert rows[:, 3].sum() == pytest.approx(1, abs=1e-6)
    # ∫ cosθ · cosθ dω / π = 2/3, and a cone of half angle α gets sin²α.
    assert rows[:, 2] @ rows[:, 3] == pytest.approx(2 / 3, abs=1e-4)
    narrow = rows[:, 2] > np.cos(0.5)
    assert rows[narrow, 3].sum() == pytest.approx(np.sin(0.5) ** 2, abs=2e-3)


def test_a_closed_convex_mesh_is_open_at_all_vertices_and_a_closed_room_at_none() -> None:
    ball = icosphere(3)
    np.testing.assert_array_equal(iso.ambient_occlusion(ball, samples=64).visibility, 1)
    inside = iso.ambient_occlusion(ball, 0.9 * ball.vertices, -ball.vertices, samples=64)
    np.testing.assert_array_equal(inside.visibility, 0)
    np.testing.assert_array_equal(inside.bent_normal, 0)


def test_items_are_seen_where_they_stand() -> None:
    ball = icosphere(2)
    placed = iso.Item(ball).scale(3).translate((5, 0, 0))
    scene = iso.Scene([placed, iso.Item(plane(100.0)).translate((0, -3.5, 0))])
    found = iso.ambient_occlusion(placed, samples=32)
    np.testing.assert_array_equal(found.visibility, 1)
    points = ball.vertices * 3 + (5, 0, 0)
    over = iso.ambient_occlusion(scene, points, ball.vertices, samples=256)
    low, high = np.argmin(points[:, 1]), np.argmax(points[:, 1])
    assert over.visibility[low] < 0.05
    assert over.visibility[high] == 1


def test_any_number_of_threads_gives_the_same_and_another_seed_does_not() -> None:
    scene = wall(1.0, 0.5)
    points = np.stack([np.linspace(-3, 0.4, 300), np.zeros(300), np.zeros(300)], axis=1)
    normals = np.broadcast_to(UP, (300, 3))
    one, two, other = (
        iso.ambient_occlusion(scene, points, normals, samples=512, threads=t, seed=s).visibility
        for t, s in ((1, 4), (2, 4), (2, 5))
    )
    np.testing.assert_array_equal(one, two)
    assert (one != other).any()


def test_taps_along_the_normal_of_a_field() -> None:
    ground = iso.plane()
    scene = iso.union(ground, iso.sphere(0.5).translate((0, 0.5, 0)))
    points = np.array([(0.1, 0, 0), (0.5, 0, 0), (5.0, 0, 0)])
    found = iso.ambient_occlusion(scene, points, np.broadcast_to(UP, (3, 3)), by="field", max_distance=0.5).visibility
    assert found[0] < found[1] < found[2]
    assert found[2] == pytest.approx(1, abs=1e-6)
    # One ray's worth of arithmetic: beside a wall half as far away as the highest tap is high.
    wall_field = iso.union(ground, iso.box((1, 9, 99)).translate((0.75, 0, 0)))
    heights = 0.5 * np.arange(1, 6) / 5
    weights = 0.5 ** np.arange(1, 6)
    exact = 1 - (weights * np.clip((heights - 0.25) / heights, 0, 1)).sum() / weights.sum()
    beside = iso.ambient_occlusion(wall_field, [(0, 0, 0)], [UP], by="field", max_distance=0.5).visibility
    assert beside[0] == pytest.approx(exact, abs=1e-5)


def dunes(n: int) -> iso.Mesh:
    """A wavy ground that a camera above sees all of."""
    x, z = np.meshgrid(np.linspace(-2, 2, n), np.linspace(-2, 2, n), indexing="ij")
    y = 0.25 * np.cos(3 * x) * np.cos(4 * z) + 0.1 * np.cos(9 * x + 2 * z)
    k = np.arange(n * n).reshape(n, n)
    quads = np.stack([k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]], axis=-1).reshape(-1, 4)
    mesh = iso.Mesh(np.stack([x, y, z], axis=-1).reshape(-1, 3), quads)
    return mesh.with_(attributes={"normal": iso.analysis.vertex_normals(mesh)})


@pytest.mark.parametrize("perspective", [True, False])
def test_depth_alone_tells_what_rays_tell_where_a_picture_shows_everything(perspective: bool) -> None:
    camera = (
        iso.Camera((0, 6, 0.01), (0, 0, 0), fov_degrees=30)
        if perspective
        else iso.OrthographicCamera((0, 6, 0.01), (0, 0, 0), height=3.2)
    )
    scene = iso.Scene([iso.Item(dunes(80))], camera=camera)
    reach, size = 8.0, (96, 96)
    exact = iso.render(scene, iso.AmbientOcclusion(samples=256), size=size)
    rays = exact.channels["visibility"][8:-8, 8:-8]
    errors = {}
    for by in ("horizon", "classic"):
        found = iso.screen_occlusion(exact, camera, reach, by=by, samples=96, slices=8)[8:-8, 8:-8]
        errors[by] = float(np.sqrt(np.mean((found - rays) ** 2)))
    assert errors["horizon"] < 0.05
    assert errors["horizon"] < 0.7 * errors["classic"]


def test_a_flat_ground_is_open_by_depth_too() -> None:
    camera = iso.Camera((0, 1, 4), (0, 0, 0), fov_degrees=40)
    scene = iso.Scene([iso.Item(plane(60.0))], camera=camera)
    for by in ("horizon", "classic"):
        grey = iso.render(scene, iso.AmbientOcclusion(by=by, max_distance=0.5), size=(64, 48)).channels["visibility"]
        assert grey.min() > 0.9
        assert grey.mean() > 0.995


def test_a_picture_shows_what_points_are_told() -> None:
    camera = iso.OrthographicCamera((-2, 5, 0), (-2, 0, 0), up=(0, 0, -1), height=3)
    ground = iso.Item(plane(60.0))
    scene = wall(1.0, 0.5)
    scene = scene.with_(items=(*scene.items, ground), camera=camera)
    image = iso.render(scene, iso.AmbientOcclusion(samples=256), size=(30, 30), seed=3)
    x = -2 + (np.arange(30) + 0.5 - 15) / 10
    exact = 1 - 0.5 * (1 - (0.5 - x) / np.hypot(0.5 - x, 1.0))
    np.testing.assert_allclose(image.channels["visibility"].mean(axis=0), exact, atol=0.01)
    np.testing.assert_array_equal(image.channels["colour"][..., 1], image.channels["visibility"])
    again = iso.render(scene, iso.AmbientOcclusion(samples=256), size=(30, 30), seed=3, threads=1)
    for name, values in image.channels.items():
        np.testing.assert_array_equal(values, again.channels[name])


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"samples": 0}, "samples"),
        ({"by": "magic"}, "by must be"),
        ({"weights": "sine"}, "weights"),
        ({"max_distance": -1.0}, "max_distance"),
        ({"max_distance": float("nan")}, "max_distance"),
        ({"bias": -1.0}, "bias"),
        ({"points": [(0, 0, 0)]}, "together"),
        ({"points": [(0, 0, 0)], "normals": [(0, 0, 0)]}, "zero"),
        ({"points": [(0, 0, float("nan"))], "normals": [UP]}, "finite"),
        ({"by": "hemicube", "samples": 63}, "even"),
        ({"by": "field"}, "needs a Field"),
    ],
)
def test_what_makes_no_sense_is_refused(change: dict[str, object], word: str) -> None:
    with pytest.raises(RenderError, match=word):
        iso.ambient_occlusion(icosphere(1), **change)  # type: ignore[arg-type]


def test_methods_and_pictures_are_checked() -> None:
    for settings in ({"samples": 0}, {"by": "hemicube"}, {"max_distance": 0}):
        with pytest.raises(RenderError):
            iso.AmbientOcclusion(**settings)  # type: ignore[arg-type]
    bare = iso.Image({"colour": np.zeros((4, 4, 3))})
    camera = iso.Camera((0, 0, 1), (0, 0, 0))
    with pytest.raises(RenderError, match="channel depth, normal"):
        iso.screen_occlusion(bare, camera, 1.0)
    with pytest.raises(RenderError, match="radius"):
        iso.screen_occlusion(bare, camera, 0.0)
    with pytest.raises(RenderError, match="only a Mesh has vertices"):
        iso.ambient_occlusion(iso.sphere(1))
