"""Sphere tracing: where rays arrive, what fixed steps miss, shadows and occlusion against closed forms."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from command_line import refuses, succeeds
from isophote.accel import field_tree
from isophote.errors import RenderError
from isophote.lower import scene as lower_scene
from isophote.lower.latest import LatestScene
from scenes import plane

WHITE = iso.Matte((1, 1, 1))
PART = (iso.sphere(1) & iso.box(1.5)) - iso.cylinder(0.5) - iso.cylinder(0.5).along("x")
ABOVE = iso.OrthographicCamera((0, 2, 0), (0, 0, 0), up=(0, 0, -1), height=4.0)


def picture(
    items: list[iso.Item],
    lights: object = (),
    camera: object = None,
    size: tuple[int, int] = (64, 64),
    threads: int | None = None,
    **settings: object,
) -> dict[str, np.ndarray]:
    """Channels of items and lights."""
    camera = camera or iso.Camera((1.5, 1.6, 3.0), (0, 0, 0), fov_degrees=40)
    scene = iso.Scene(items, lights=lights, camera=camera)
    image = iso.render(scene, iso.SphereTrace(**settings), size=size, progress=False, threads=threads)
    return dict(image.channels)


def places(size: int, height: float = 4.0) -> np.ndarray:
    """(size, size): x of each pixel of the camera ABOVE, and z."""
    x = ((np.arange(size) + 0.5) / size - 0.5) * height
    return np.stack(np.meshgrid(x, x), axis=-1)


@pytest.mark.parametrize("relaxation", [1.0, 1.4, 1.9])
@pytest.mark.parametrize(
    "shape",
    [PART, iso.torus(0.7, 0.25), iso.box((0.5, 1.6, 0.3)).twist(1.5), iso.plane() | iso.sphere(0.5)],
    ids=["part", "torus", "twist", "plane"],
)
def test_rays_arrive_where_the_crossings_are(shape: iso.Field, relaxation: float) -> None:
    camera = iso.Camera((1.5, 1.6, 3.0), (0, 0, 0), fov_degrees=40)
    found = picture([iso.Item(shape)], [iso.Sky()], camera, relaxation=relaxation)
    m = camera.linear_map((64, 64))
    y, x = np.mgrid[0:64, 0:64] + 0.5
    directions = (m.d + x[..., None] * m.dx + y[..., None] * m.dy).reshape(-1, 3)
    exact = iso.Tracer(iso.Scene([iso.Item(shape)])).closest(m.o, directions)
    depth, normal = found["depth"].reshape(-1), found["normal"].reshape(-1, 3)
    assert (np.isfinite(depth) != exact.hit).mean() < 0.001
    both = np.isfinite(depth) & exact.hit
    assert np.abs(depth[both] / exact.distance[both] - 1).max() < 1e-4
    facing = np.where((normal * exact.normal).sum(1, keepdims=True) < 0, -1, 1) * exact.normal
    assert np.quantile(np.abs(normal - facing)[both], 0.99) < 1e-3
    assert (found["steps"].reshape(-1)[both] > 0).all()
    assert found["steps"].max() < 200


def test_over_relaxation_takes_fewer_steps() -> None:
    ring = [iso.Item(iso.torus(0.7, 0.25))]
    plain, relaxed = (picture(ring, relaxation=r, size=(128, 128))["steps"].sum() for r in (1.0, 1.3))
    assert relaxed < 0.95 * plain


def test_regions_change_nothing_but_the_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(5)
    spheres = zip(rng.uniform(-1, 1, (100, 3)).tolist(), rng.uniform(0.05, 0.2, 100).tolist(), strict=True)
    shape = iso.union(*(iso.sphere(radius).translate(place) for place, radius in spheres), blend=0.05)
    pruned = picture([iso.Item(shape)])
    monkeypatch.setattr(field_tree, "_SHORT", 10**9)
    monkeypatch.setattr(lower_scene, "_latest", LatestScene())
    whole = picture([iso.Item(shape)])
    assert (np.isfinite(pruned["depth"]) != np.isfinite(whole["depth"])).mean() < 0.001
    both = np.isfinite(pruned["depth"]) & np.isfinite(whole["depth"])
    assert np.abs(pruned["depth"][both] - whole["depth"][both]).max() < 1e-4
    assert pruned["steps"].sum() < whole["steps"].sum()


def test_fixed_steps_miss_what_is_thinner() -> None:
    """A wall of 1 mm before a thick one: steps of 5 cm step over it nearly everywhere, spheres nowhere."""
    wall, behind = iso.box((2, 2, 0.001)), iso.box((2, 2, 0.5)).translate((0, 0, -1))
    camera = iso.Camera((0.2, 0.1, 3), (0, 0, 0), fov_degrees=20)
    items = [iso.Item(wall), iso.Item(behind)]
    fixed = picture(items, camera=camera, marcher="fixed", step=0.05)
    sphere = picture(items, camera=camera)
    fine = picture(items, camera=camera, marcher="fixed", step=0.0005, max_steps=100_000)
    assert (sphere["item"] == 0).all()
    assert (fine["item"] == 0).all()
    assert (fixed["item"] == 1).mean() > 0.9
    assert np.abs(fine["depth"] - sphere["depth"]).max() < 1e-5
    # Where it is seen at all, the crossing itself is found.
    alone = picture(items[1:], camera=camera)["depth"]
    assert np.abs(fixed["depth"] - alone)[fixed["item"] == 1].max() < 1e-5


def test_limits_of_steps_and_distance() -> None:
    assert not np.isfinite(picture([iso.Item(PART)], max_distance=1.0)["depth"]).any()
    few = picture([iso.Item(PART)], max_steps=2)
    assert few["steps"].max() <= 2
    assert np.isfinite(few["depth"]).sum() < np.isfinite(picture([iso.Item(PART)])["depth"]).sum()


LIGHT = (0.0, 3.0, 0.5)
BALL = [iso.Item(iso.plane(), WHITE), iso.Item(iso.sphere(0.5).translate((0, 1, 0)), WHITE)]
BELOW_BALL = iso.OrthographicCamera((0, 0.4, 0), (0, 0, 0), up=(0, 0, -1), height=4.0)


def test_hard_shadows_have_their_analytic_edge() -> None:
    found = picture(BALL, [iso.PointLight(LIGHT, 100.0)], BELOW_BALL, (128, 128), shadows="hard", occlusion=0.0)
    place = np.zeros((128, 128, 3))
    place[..., [0, 2]] = places(128)
    ray = place - LIGHT
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    to_ball = np.array([0, 1, 0]) - LIGHT
    apart = np.sqrt(to_ball @ to_ball - (ray @ to_ball) ** 2)
    dark = found["colour"][..., 0] == 0
    sure = np.abs(apart - 0.5) > 1e-4
    assert (dark == (apart < 0.5))[sure].all()
    # What is lit has the light of a point: I cosθ / (π d²).
    distance = np.linalg.norm(place - LIGHT, axis=-1)
    expected = 100 / (4 * math.pi) * 3.0 / distance**3 / math.pi
    lit = apart > 0.51
    assert np.allclose(found["colour"][..., 0][lit], expected[lit], rtol=1e-4)


def test_soft_shadows_grow_with_the_light_and_shrink_to_hard_ones() -> None:
    lights = [iso.PointLight(LIGHT, 100.0)]
    widths = (0.0, 0.002, 0.02, 0.1, 0.3)
    pictures = [
        picture(BALL, lights, BELOW_BALL, softness=width, occlusion=0.0, max_steps=4096)["colour"][..., 0]
        for width in widths
    ]
    hard = picture(BALL, lights, BELOW_BALL, shadows="hard", occlusion=0.0)["colour"][..., 0]
    assert np.array_equal(pictures[0], hard)
    assert (np.abs(pictures[1] - hard) > 0.02 * hard.max()).mean() < 0.03
    for smaller, larger in itertools.pairwise(pictures):
        assert (larger <= smaller + 0.03 * hard.max()).all()
        assert larger.mean() < smaller.mean()


def test_a_soft_shadow_is_the_nearest_approach_in_parts_of_the_light() -> None:
    """Of a plane lit past a ball, by a sun: min over the way of h / (w t), of which the ball's part is known."""
    width = 0.2
    found = picture(BALL, [iso.Sun((0, 1, 0), math.pi)], BELOW_BALL, softness=width, occlusion=0.0, max_steps=4096)
    away = np.linalg.norm(places(64), axis=-1)
    t = np.linspace(1e-3, 3, 20_000)[:, None]
    h = np.minimum(np.sqrt(away.reshape(-1) ** 2 + (t - 1) ** 2) - 0.5, t)
    expected = np.clip((h / (width * t)).min(axis=0), 0, 1).reshape(away.shape)
    assert np.abs(found["colour"][..., 0] - expected).max() < 0.06
    assert np.abs(found["colour"][..., 0] - expected).mean() < 0.01


def test_occlusion_leaves_the_open_alone_and_darkens_corners() -> None:
    sky = [iso.Sky("white", 1.0)]
    flat = picture([iso.Item(iso.plane(), WHITE)], sky, ABOVE, occlusion=0.5)
    assert np.abs(flat["colour"] - 1).max() < 1e-5
    wall = iso.box((1, 10, 10)).translate((-1.5, 0, 0))
    corner = picture([iso.Item(iso.plane() | wall, WHITE)], sky, ABOVE, occlusion=0.5)["colour"][32, :, 0]
    x = places(64)[32, :, 0]
    floor = x > -0.98
    openness = corner[floor]
    # At the distance x from a wall the field above the floor is min(h, x + 1): Σ wᵢ max(hᵢ − x − 1, 0) / hᵢ.
    h = 0.5 * np.arange(1, 6) / 5
    weight = 2.0 ** -np.arange(1, 6)
    missing = np.maximum(h - (x[floor, None] + 1), 0) / h @ weight / weight.sum()
    assert np.abs(openness - (1 - missing)).max() < 1e-3
    none = picture([iso.Item(iso.plane() | wall, WHITE)], sky, ABOVE, occlusion=0.0)["colour"][32, :, 0]
    assert np.abs(none[floor] - 1).max() < 1e-5


def test_area_lights_shine_from_their_middles() -> None:
    """Far above a floor each has the irradiance of its middle: L A cosθ cosθ' / d²."""
    floor = [iso.Item(iso.plane(), WHITE)]
    lights = {
        "rectangle": iso.RectLight(size=(0.2, 0.1), power=50).at((0, 3, 0)),
        "disk": iso.DiskLight(radius=0.1, power=50).at((0, 3, 0)),
        "ball": iso.SphereLight(radius=0.1, power=50).at((0, 3, 0)),
    }
    for name, light in lights.items():
        found = picture(floor, [light], iso.OrthographicCamera((0, 1, 0), (0, 0, 0), up=(0, 0, -1), height=0.01))
        area = math.pi * 0.1**2 if name == "ball" else light.area
        expected = light.radiance_rgb[0] * area / 9 / math.pi
        assert found["colour"][32, 32, 0] == pytest.approx(expected, rel=1e-3), name


def test_meshes_are_drawn_and_shadow() -> None:
    items = [
        iso.Item(iso.plane(), WHITE),
        iso.Item(plane(1.0), iso.Matte("tomato")).translate((0, 1, 0)),
        iso.Item(iso.sphere(0.3), WHITE).translate((1.2, 0.3, 0)),
    ]
    found = picture(items, [iso.Sun((0, 1, 0), math.pi)], BELOW_BALL, shadows="hard")
    x, z = np.moveaxis(places(64), -1, 0)
    under = (np.abs(x) < 0.49) & (np.abs(z) < 0.49)
    assert not found["colour"][under].any()
    assert (found["colour"][(np.abs(x) > 0.52) & (x < 0)] > 0.9).all()
    seen = picture(items, [iso.Sun((0, 1, 0), math.pi)], ABOVE)
    assert set(np.unique(seen["item"])) == {0, 1, 2}
    assert (seen["item"] == 1).sum() == pytest.approx(16 * 16, abs=40)


def test_what_shines_is_bright_and_skies_are_seen() -> None:
    ball = iso.Item(iso.sphere(0.5), iso.Emitter((3, 2, 1)))
    found = picture([ball], [iso.Sky("white", 0.25)])
    met = found["item"] == 0
    assert np.allclose(found["colour"][met], (3, 2, 1))
    assert np.allclose(found["colour"][~met], 0.25)
    assert (found["item"][~met] == -1).all()


def test_the_same_bits_for_any_threads() -> None:
    one, two = (
        picture([iso.Item(PART), iso.Item(iso.plane().translate((0, -1, 0)))],
                [iso.RectLight(power=60).at((1, 3, 2), target=(0, 0, 0)), iso.Sky(strength=0.3)],
                size=(70, 45), threads=threads)
        for threads in (1, 3)
    )  # fmt: skip
    for name, channel in one.items():
        assert channel.tobytes() == two[name].tobytes(), name


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"relaxation": 2.5}, "relaxation must be a number from 1 to 2"),
        ({"max_steps": 0}, "max_steps must be a whole number"),
        ({"epsilon": 0.0}, "epsilon must be a number above 0"),
        ({"marcher": "cone"}, "marcher must be one of sphere, fixed"),
        ({"step": 0.1}, 'give marcher="fixed" too'),
        ({"shadows": "dark"}, "shadows must be one of none, hard, soft"),
        ({"softness": -0.1}, "softness must be a number from 0 to 1"),
        ({"occlusion": -1.0}, "occlusion must be a number, 0 or above"),
        ({"max_distance": 0.0}, "max_distance must be a number above 0"),
    ],
)
def test_settings_without_meaning_are_refused(settings: dict[str, object], message: str) -> None:
    with pytest.raises(RenderError, match=message):
        iso.SphereTrace(**settings)


def test_a_part_on_the_command_line(tmp_path: Path) -> None:
    file = tmp_path / "thing.py"
    file.write_text("import isophote as iso\npart = iso.sphere(1) - iso.box(1.2)\n")
    out = tmp_path / "out.exr"
    succeeds("render", file, "-o", out, "--method", "sphere", "--size", "32x24")
    found = iso.load_image(out).channels
    assert found["steps"].max() > 0
    assert set(np.unique(found["item"])) == {0, 1}
    file.write_text("import isophote as iso\nanything = iso.sphere(1)\n")
    succeeds("render", file, "-o", out, "--method", "sphere", "--size", "8x6")
    file.write_text("import isophote as iso\na = iso.sphere(1)\nb = iso.box(1)\n")
    assert "several shapes (a, b)" in refuses("render", file, "-o", out, "--size", "8x6")
