"""Ray tracing after Whitted: direct light as the path tracer has it, mirrors to the depth, the same bits whatever the
threads, tiles and waves, and settings that make no sense."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from command_line import misused, succeeds
from isophote.rendering import passes, ray_tiles
from isophote.rendering.pool import tiles_of
from ray_traced import colour, log, ray_trace, seen_along
from scenes import box, icosphere, plane

MATTE = [
    iso.Item(plane(8), iso.Matte((0.7, 0.5, 0.3))),
    iso.Item(box(0.9), iso.Matte((0.9, 0.2, 0.2))).rotate("y", 0.4).translate((-0.8, 0.46, 0)),
]
CLEAR = [
    iso.Item(icosphere(2, 0.6, smooth=True), iso.Glass.tinted((0.5, 0.8, 0.6), at=1)).translate((0.7, 0.7, 0.3)),
    iso.Item(icosphere(2, 0.4, smooth=True), iso.Mirror(0.9)).translate((-0.2, 0.45, 1.1)),
    iso.Item(icosphere(2, 0.3, smooth=True), iso.Metal(roughness=0)).translate((0.3, 0.35, 1.5)),
]
CAMERA = iso.Camera((0, 2, 5), (0, 0.5, 0))
LIGHTS = [
    iso.RectLight(size=(1, 1), power=60).at((0, 2.5, 0)),
    iso.SpotLight((2, 3, 2), 30, target=(0, 0, 0), cone_degrees=50, inner_degrees=30),
    iso.Sky(strength=0.2),
]


def render(items, lights, camera=CAMERA, *, size=(48, 32), **settings) -> iso.Image:
    return ray_trace(items, lights, camera, size=size, **settings)


def shining_mesh() -> iso.Item:
    return iso.Item(icosphere(1, 0.3), iso.Emitter((5, 4, 3))).translate((1, 1.5, 0.5))


def environment() -> iso.Environment:
    pixels = np.random.default_rng(3).random((8, 16, 3)).astype(np.float32) ** 4
    return iso.Environment(iso.ImageTexture(pixels))


@pytest.mark.parametrize(
    "lights",
    {
        "point": [iso.PointLight((1, 3, 1), 100)],
        "sun": [iso.Sun((1, 2, 1), 2)],
        "spot": [iso.SpotLight((1, 3, 1), 50, cone_degrees=60, exponent=3)],
        "rectangle": [iso.RectLight(size=(1, 2), power=40).at((0.5, 2.5, 0))],
        "disk": [iso.DiskLight(radius=0.6, power=40).at((0, 2, 1), target=(0, 0, 0))],
        "sphere": [iso.SphereLight(radius=0.3, power=40).at((0, 2, 1))],
        "mesh": [shining_mesh()],
        "environment": [environment()],
        "many": [*LIGHTS[:2], iso.PointLight((-2, 1, 2), 10, "tomato")],
    }.items(),
    ids=lambda item: item[0],
)
def test_direct_light_is_that_of_the_path_tracer(lights):
    """Whole pictures and single pixels within three standard errors of paths of two rays."""
    items = MATTE + [light for light in lights[1] if isinstance(light, iso.Item)]
    lamps = [light for light in lights[1] if not isinstance(light, iso.Item)]
    ours = render(items, lamps, samples=64, light_samples=4, size=(24, 16))
    path = render(items, lamps, size=(24, 16), method=iso.PathTrace(samples=256, max_depth=2), seed=5)
    difference = ours.channels["colour"].astype(float) - path.channels["colour"]
    variance = ours.channels["variance"].astype(float) + path.channels["variance"]
    assert path.channels["colour"].mean() > 0.02
    assert np.abs(difference.mean(axis=(0, 1))).max() < 3 * np.sqrt(variance.mean() / variance[..., 0].size) + 1e-5
    beyond = np.abs(difference) > 4 * np.sqrt(variance) + 2e-3 * path.channels["colour"] + 1e-5
    assert beyond.mean() < 0.01


def test_rays_end_at_the_depth():
    """In a box of mirrors each sample's ray goes on to the depth, and no further."""
    mirrors, camera = [iso.Item(box(4, inward=True), iso.Mirror(1.0))], iso.Camera((0.1, 0.2, 1), (0.3, -0.1, -1))
    for depth in (1, 2, 7):
        image = render(mirrors, [], camera, size=(6, 4), samples=3, depth=depth)
        assert (image.channels["rays"] == 3 * depth).all()


@pytest.mark.parametrize(("share", "least", "rays"), [(0.5, 0.1, 4), (0.5, 1e-3, 10), (0.9, 0.5, 7), (1.0, 0.5, 20)])
def test_rays_end_that_carry_too_little(share, least, rays):
    """After k mirrors a ray carries shareᵏ; it is traced while that is `min_weight` or more."""
    mirrors, camera = [iso.Item(box(4, inward=True), iso.Mirror(share))], iso.Camera((0.1, 0.2, 1), (0.3, -0.1, -1))
    image = render(mirrors, [], camera, size=(4, 4), samples=1, depth=20, min_weight=least)
    assert (image.channels["rays"] == rays).all()


def test_light_by_two_mirrors():
    """A periscope: what shines behind two mirrors is seen, times both shares, from a depth of three."""
    mirrors = [
        iso.Item(plane(2), iso.Mirror(0.8)).rotate("z", -np.pi / 4).translate((0, 0, 0)),
        iso.Item(plane(2), iso.Mirror(0.5)).rotate("z", -np.pi / 4).translate((0, 3, 0)),
    ]
    lamp = iso.Item(plane(1), iso.Emitter((1, 2, 3), two_sided=True)).rotate("z", np.pi / 2).translate((-3, 3, 0))
    camera = iso.OrthographicCamera((3, 0, 0), (0, 0, 0), height=0.1)
    for depth, expected in ((2, 0.0), (3, 0.4), (9, 0.4)):
        found = colour(render([*mirrors, lamp], [], camera, size=(2, 2), samples=1, depth=depth))
        assert np.allclose(found, expected * np.array([1, 2, 3]), rtol=1e-6)


def test_smooth_metal_reflects_by_fresnels_equations():
    n, k = (0.2, 0.9, 1.4), (3.9, 2.4, 1.6)
    metal = iso.Item(plane(4), iso.Metal((n, k), roughness=0))
    sky = [iso.Environment(iso.ImageTexture(np.ones((1, 1, 3), np.float32)))]
    for degrees in (0.0, 40.0, 75.0):
        angle = np.radians(degrees)
        start = 3 * np.array([np.sin(angle), np.cos(angle), 0])
        found = colour(render([metal], sky, seen_along(start, -start), size=(1, 1), samples=1))[0, 0]
        expected = [float(iso.fresnel(angle, 1.0, complex(a, b))) for a, b in zip(n, k, strict=True)]
        assert np.allclose(found, expected, rtol=1e-4)


def test_a_constant_sky_is_ambient_light():
    """Albedo times radiance, shadowed by nothing; behind everything it is the background."""
    roofed = [iso.Item(plane(2), iso.Matte((0.2, 0.4, 0.6))), iso.Item(box(1), iso.Matte(0.5)).translate((0, 0.51, 0))]
    camera = iso.OrthographicCamera((0, 5, 0), (0, 0, 0), (0, 0, -1), height=4)
    image = colour(render(roofed, [iso.Sky((1, 2, 3), 0.5)], camera, size=(8, 8), samples=4))
    assert np.allclose(image[0, 0], (0.5, 1, 1.5), rtol=1e-6)
    assert np.allclose(image[2, 2], (0.1, 0.4, 0.9), rtol=1e-6)
    assert np.allclose(image[4, 4], (0.25, 0.5, 0.75), rtol=1e-6)


def same_bits(a: iso.Image, b: iso.Image) -> bool:
    return all(a.channels[name].tobytes() == b.channels[name].tobytes() for name in a.channels)


SCENE = (MATTE + CLEAR, LIGHTS)


@pytest.fixture(scope="module")
def reference() -> iso.Image:
    return render(*SCENE, size=(70, 45), samples=3)


def test_any_number_of_threads(reference):
    assert same_bits(render(*SCENE, size=(70, 45), samples=3, threads=1), reference)
    assert same_bits(render(*SCENE, size=(70, 45), samples=3, threads=3), reference)


@pytest.mark.parametrize(
    ("module", "name", "value"),
    [
        (passes, "_TILE", 8),
        (passes, "_TILE", 13),
        (passes, "_TILE", 256),
        (ray_tiles, "_WAVE", 1),
        (ray_tiles, "_WAVE", 20),
        (ray_tiles, "_WAVE", 100),
        (ray_tiles, "_WAVE", 5000),
    ],
)
def test_any_size_of_tiles_and_waves(module, name, value, reference, monkeypatch):
    assert hasattr(module, name)
    monkeypatch.setattr(module, name, value)
    assert same_bits(render(*SCENE, size=(70, 45), samples=3), reference)


def test_more_shadow_rays_than_a_wave_holds(reference, monkeypatch):
    many = [iso.RectLight(size=(1, 1), power=60).at((0, 2.5, 0)), iso.DiskLight(power=10).at((1, 3, 0))]
    whole = render(MATTE, many, size=(9, 7), samples=2, light_samples=40)
    monkeypatch.setattr(ray_tiles, "_WAVE", 30)
    assert same_bits(render(MATTE, many, size=(9, 7), samples=2, light_samples=40), whole)


def test_channels_and_facts(reference):
    assert set(reference.channels) >= {"colour", "variance", "samples", "rays", "depth", "normal", "item", "primitive"}
    rays = reference.channels["rays"]
    assert rays.dtype == np.int32
    assert rays.min() >= 3
    assert reference.metadata["rays"] == str(rays.sum())
    assert reference.metadata["method"].startswith("RayTrace(depth=6")


def test_adaptive_samples_by_noise():
    image = render(*SCENE, size=(40, 30), noise=0.02)
    assert image.channels["samples"].min() < image.channels["samples"].max()


@pytest.mark.parametrize(
    "settings", [{}, {"filter": "mitchell"}, {"depth": 2}, {"min_weight": 0.2}, {"shadows": "tinted"}]
)
def test_the_log_of_a_pixel_adds_up_to_its_colour(settings):
    items, lights = SCENE
    image = colour(render(items, lights, size=(24, 16), samples=5, **settings))
    for x in range(0, 24, 5):
        for y in range(1, 16, 4):
            found = log(items, lights, CAMERA, pixel=(x, y), size=(24, 16), samples=5, **settings)
            assert np.abs(np.array(found.colour) - image[y, x]).max() < 1e-6
            total = sum(np.array(r.weight) * r.colour for r in found.rays if r.kind == "camera")
            assert np.abs(total - image[y, x]).max() < 1e-5
            for number, ray in enumerate(found.rays):
                assert -1 <= ray.parent < number
                onward = sum((np.array(r.weight) * r.colour for r in found.rays if r.parent == number), np.zeros(3))
                lit = sum((np.array(term.colour) for term in ray.lights), np.zeros(3))
                whole = np.array(ray.tint) * (np.array(ray.emitted) + ray.ambient + lit + onward)
                assert np.allclose(ray.colour, 0 if ray.ended else whole, atol=1e-9)


def test_the_log_says_what_was_met():
    lamp = iso.DiskLight(radius=0.5, power=5).at((0, 3, 0))
    camera = iso.OrthographicCamera((0.3, 1, 0.2), (0.3, 0, 0.2), (0, 0, -1), height=1e-3)
    found = log(
        [iso.Item(box(1), iso.Matte(0.5)).translate((5, 0, 0)), iso.Item(plane(2), iso.Matte(0.5))],
        [iso.PointLight((0, 2, 0), 1), lamp],
        camera,
        samples=1,
        light_samples=3,
    )
    (ray,) = found.rays
    assert (ray.met, ray.item, ray.primitive, ray.ended, ray.level) == ("surface", 1, 0, None, 0)
    assert np.allclose(ray.place, (0.3, 0, 0.2), atol=1e-3)
    assert ray.normal == (0, 1, 0)
    assert ray.distance == pytest.approx(1, abs=1e-5)
    corners = np.array([(-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)])
    parts = [np.array(ray.barycentric) @ corners[list(t)] for t in ((0, 1, 2), (0, 2, 3))]
    assert min(np.abs(part - ray.place).max() for part in parts) < 1e-5
    # Lights are numbered on from the items; the disk stands where the point's light passes it by.
    assert [(term.light, term.trial) for term in ray.lights] == [(2, 0), (3, 0), (3, 1), (3, 2)]
    assert all(term.seen for term in ray.lights)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"depth": 0}, "depth must be a whole number from 1"),
        ({"depth": 1.5}, "depth"),
        ({"depth": 1000}, "depth"),
        ({"samples": 0}, "samples must be a whole number from 1"),
        ({"light_samples": 0}, "light_samples must be a whole number from 1"),
        ({"light_samples": "many"}, "light_samples"),
        ({"min_weight": 1.0}, "min_weight must be a number from 0 to below 1"),
        ({"min_weight": float("nan")}, "min_weight"),
        ({"min_weight": -0.1}, "min_weight"),
        ({"pattern": "stars"}, "pattern must be one of"),
        ({"shadows": "soft"}, "shadows must be one of opaque, tinted"),
        ({"seconds": 0}, "seconds"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings, message):
    with pytest.raises(iso.RenderError, match=message):
        iso.RayTrace(**settings)


def test_pixels_outside_are_refused():
    with pytest.raises(iso.RenderError, match="within 24 × 16"):
        log(MATTE, [], pixel=(24, 0), size=(24, 16))


def test_more_lights_than_can_be_aimed_at_are_refused():
    with pytest.raises(iso.RenderError, match="aims at every light"):
        render(MATTE, [iso.RectLight().at((0, k, 0)) for k in range(1, 301)], light_samples=4096, size=(1, 1))


def test_on_the_command_line(tmp_path):
    file, out = tmp_path / "scene.py", tmp_path / "out.exr"
    file.write_text("import isophote as iso\nshape = iso.sphere(1)\n")
    succeeds("render", file, "-o", out, "--method", "ray", "--depth", "3", "--light-samples", "2", "--size", "12x8")
    image = iso.load_image(out)
    assert "depth=3" in image.metadata["method"]
    assert image.channels["rays"].shape == (8, 12)
    assert "the method path has no --depth" in misused("render", file, "-o", out, "--depth", "3")


def half_covered(strength: float) -> iso.Principled:
    """A white surface whose occlusion texture tells 0.25 on the left and 1 on the right."""
    texels = np.array([[[0.25, 0.9, 0.1], [1.0, 0.0, 0.6]]], np.float32)
    covered = iso.ImageTexture(texels, colour_space="linear", filter="nearest")
    return iso.Principled(1.0, roughness=1.0, occlusion_texture=covered, occlusion_strength=strength)


@pytest.mark.parametrize("strength", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("glowing", [False, True])
def test_occlusion_textures_darken_ambient_light_and_no_other(strength, glowing):
    uvs = ((0, 0), (0, 1), (1, 1), (1, 0))
    material = half_covered(strength)
    item = iso.Item(plane(2).with_(attributes={"uv": uvs}), iso.Emitter(0.5, body=material) if glowing else material)
    camera = iso.OrthographicCamera((0, 3, 0), (0, 0, 0), up=(0, 0, -1), height=2)

    def sides(lights, **settings):
        image = colour(ray_trace([item], lights, camera, size=(8, 8), samples=64, **settings))
        return image[:, :4].mean(), image[:, 4:].mean()

    left, right = sides([iso.Sky(1.0)])
    emitted = 0.5 if glowing else 0.0
    assert right == pytest.approx(1.0 + emitted, abs=0.01)
    assert left - emitted == pytest.approx((1 + strength * (0.25 - 1)) * (right - emitted), rel=0.01)
    left, right = sides([iso.Sun((0, 1, 0), 2.0)])
    assert left == pytest.approx(right, rel=1e-4)
    left, right = sides([iso.Sky(1.0)], method=iso.PathTrace(samples=64))
    assert left == pytest.approx(right, rel=0.01)


def test_many_lights_are_traced_in_smaller_tiles_and_look_the_same(monkeypatch):
    """So progress is told, and an interruption obeyed, while the first tile would still be under way."""
    lights = [iso.PointLight((0.1 * k - 15, 3, 1), 1.0) for k in range(300)]
    tiles: list[int] = []

    def counted(size, edge):
        tiles.append(len(tiles_of(size, edge)))
        return tiles_of(size, edge)

    monkeypatch.setattr(passes, "tiles_of", counted)
    few = render(MATTE, lights[:10], samples=1)
    small = render(MATTE, lights, samples=1)
    assert tiles[1] >= 12 * tiles[0]
    monkeypatch.setattr(ray_tiles, "_MANY_JOBS", 1000)
    large = render(MATTE, lights, samples=1)
    assert tiles[2] == tiles[0]
    assert np.array_equal(small.channels["colour"], large.channels["colour"])
    assert not np.array_equal(small.channels["colour"], few.channels["colour"])
