"""Path tracing against closed forms: furnaces, direct light of every kind by both strategies, glass, mirrors."""

from __future__ import annotations

import math

import numpy as np
import pytest

import isophote as iso
from isophote.checks.lights import rectangle_irradiance, wall_irradiance
from isophote.lower import lights as lower_lights
from isophote.scene.light import uv_to_direction
from scenes import WHITE_SKY, box, icosphere, mean, plane, render

RHO = 0.5
RADIANCE = (4.0, 3.0, 2.0)
FLOOR = iso.Item(plane(20), iso.Matte((RHO,) * 3))
# All pixels see one point of the floor, from the side.
SPOT = iso.Camera((0.0, 1.0, 3.0), (0, 0, 0), fov_degrees=1e-3)


def close(image: iso.Image, wanted: object, tolerance: float = 2e-4) -> bool:
    """Whether the mean colour is as wanted, to 4.5 standard errors and a part for single precision."""
    variance = image.channels["variance"].astype(np.float64).mean(axis=(0, 1)) / np.prod(image.size)
    bound = 4.5 * np.sqrt(variance) + tolerance * np.abs(np.asarray(wanted, float)).max()
    return bool((np.abs(mean(image) - wanted) <= bound).all())


# --- direct light ---------------------------------------------------------------------------------


def lamp(width: float, depth: float, height: float, **fields: object) -> iso.Item:
    """A quad of an emitting material that faces down."""
    a, b = width / 2, depth / 2
    corners = [(-a, height, -b), (a, height, -b), (a, height, b), (-a, height, b)]
    return iso.Item(iso.Mesh(corners, [(0, 1, 2, 3)]), iso.Emitter(RADIANCE, **fields))


def in_triangles(item: iso.Item) -> iso.Item:
    return item.with_(shape=iso.Mesh(item.shape.vertices, [(0, 1, 2), (0, 2, 3)]))


WALL = iso.Item(
    iso.Mesh([(-1.5, 0, -2), (1.5, 0, -2), (1.5, 1.2, -2), (-1.5, 1.2, -2)], [(0, 1, 2, 3)]), iso.Emitter(RADIANCE)
)
SPHERE_AT = (1.0, 2.0, -0.5)
SPHERE_D2 = 1.0 + 4.0 + 0.25

# Items, lights, irradiance for radiance 1.
AREA_LIGHTS = {
    "rectangle": ([], [iso.RectLight(size=(2, 1), radiance=RADIANCE).at((0, 1.5, 0))], rectangle_irradiance(2, 1, 1.5)),
    "quad": ([lamp(2, 1, 1.5)], [], rectangle_irradiance(2, 1, 1.5)),
    "triangles": ([in_triangles(lamp(2, 1, 1.5))], [], rectangle_irradiance(2, 1, 1.5)),
    "two-sided": ([lamp(2, 1, 1.5, two_sided=True)], [], rectangle_irradiance(2, 1, 1.5)),
    "wall": ([WALL], [], wall_irradiance(3, 1.2, 2)),
    "disk": ([], [iso.DiskLight(radius=0.7, radiance=RADIANCE).at((0, 1.5, 0))], math.pi * 0.49 / (0.49 + 2.25)),
    "sphere": (
        [],
        [iso.SphereLight(radius=0.5, radiance=RADIANCE).at(SPHERE_AT)],
        math.pi * 0.25 / SPHERE_D2 * 2 / math.sqrt(SPHERE_D2),
    ),
    "near sphere": ([], [iso.SphereLight(radius=0.95, radiance=RADIANCE).at((0, 1.2, 0))], math.pi * (0.95 / 1.2) ** 2),
}


@pytest.mark.parametrize("name", AREA_LIGHTS)
@pytest.mark.parametrize("strategy", ["both", "scattered rays only"])
def test_irradiance_of_area_lights(name, strategy, monkeypatch):
    items, lights, irradiance = AREA_LIGHTS[name]
    if strategy != "both":
        # A dark light that is picked always: what shines is then found by scattered rays alone.
        lights = [*lights, iso.PointLight((0, 1, 0), 0.0)]
        monkeypatch.setattr(lower_lights, "_cumulative", lambda p: np.eye(len(p) + 1, dtype=np.float32)[-1])
    image = render([FLOOR, *items], lights, SPOT, samples=256, max_depth=2)
    assert close(image, np.array(RADIANCE) * irradiance * RHO / math.pi)


@pytest.mark.parametrize("radius", [0.3, 0.01, 1e-3])
def test_a_sphere_light_far_away_has_the_irradiance_of_a_point(radius):
    power = 4 * math.pi * math.pi * radius**2
    light = iso.SphereLight(radius=radius, radiance=(1, 1, 1)).at((0, 8, 6))
    wanted = power / math.pi / 4 / 100 * 0.8 * RHO / math.pi
    assert close(render([FLOOR], [light], SPOT, samples=64, max_depth=2), [wanted] * 3, 5e-5)


def test_irradiance_of_points_and_suns():
    point = iso.PointLight((1, 2, -2), 4 * math.pi * 9, colour=(1, 0.5, 2))
    image = render([FLOOR], [point], SPOT, samples=4, max_depth=2)
    assert np.allclose(mean(image), np.array([1, 0.5, 2]) * 2 / 3 * RHO / math.pi, rtol=1e-4)
    sun = iso.Sun((2, 1, 2), 5.0, colour=(1, 0.5, 2))
    image = render([FLOOR], [sun], SPOT, samples=4, max_depth=2)
    assert np.allclose(mean(image), 5 * np.array([1, 0.5, 2]) / 3 * RHO / math.pi, rtol=1e-4)


@pytest.mark.parametrize("strategy", ["both", "scattered rays only"])
def test_irradiance_of_a_picture_of_the_sky(strategy, monkeypatch):
    """A bright patch on a dim sky: by integration over a fine grid, and, a single texel being small, as by a sun."""
    height, width = 32, 64
    pixels = np.full((height, width, 3), 0.05, np.float32)
    pixels[8, 20] = (90, 60, 30)
    lights: list[object] = [iso.Environment(iso.ImageTexture(pixels), rotation=0.4)]
    if strategy != "both":
        lights.insert(0, iso.PointLight((0, 1, 0), 0.0))
        monkeypatch.setattr(
            lower_lights, "_cumulative", lambda p: np.minimum(np.arange(len(p) + 1), 1).astype(np.float32)
        )
    v = (np.arange(height * 8) + 0.5) / (height * 8)
    direction = uv_to_direction(np.stack(np.meshgrid((np.arange(width * 8) + 0.5) / (width * 8), 1 - v), 2), 0.4)
    # Bilinear interpolation spreads a texel over a tent of two texels' width.
    x = (np.arange(width * 8) + 0.5) / 8 - 0.5
    y = (np.arange(height * 8) + 0.5) / 8 - 0.5
    tent = np.maximum(1 - abs(x - 20), 0)[None, :, None] * np.maximum(1 - abs(y - 8), 0)[:, None, None]
    radiance = 0.05 + tent * (pixels[8, 20] - 0.05)
    measure = np.maximum(direction[..., 1], 0) * np.sin(np.pi * v)[:, None] * 2 * np.pi**2 / (len(v) * width * 8)
    irradiance = (radiance * measure[..., None]).sum(axis=(0, 1))
    image = render([FLOOR], lights, SPOT, samples=1024, max_depth=2)
    assert close(image, irradiance * RHO / math.pi, 2e-3)
    bright = (measure[..., None] * tent).sum(axis=(0, 1)) * (pixels[8, 20] - 0.05)
    centre = uv_to_direction([(20.5 / width, 1 - 8.5 / height)], 0.4)[0]
    sun = iso.Sun(centre, float(bright[0] / centre[1]), colour=bright / bright[0])
    by_sun = render([FLOOR], [sun, iso.Sky(strength=0.05)], SPOT, samples=1024, max_depth=2)
    assert close(by_sun, irradiance * RHO / math.pi, 1e-3)


@pytest.mark.parametrize("make", [iso.RectLight, iso.DiskLight])
@pytest.mark.parametrize("two_sided", [False, True])
def test_lights_shine_to_their_own_side(make, two_sided):
    """Lights below the floor's level facing down; and the same turned to face up, seen from above."""
    size = {"size": (1.0, 1.0)} if make is iso.RectLight else {"radius": 0.5}
    light = make(radiance=RADIANCE, two_sided=two_sided, **size)
    away = render([FLOOR], [light.at((0, 1, 0), target=(0, 2, 0))], SPOT, samples=32, max_depth=2)
    toward = render([FLOOR], [light.at((0, 1, 0))], SPOT, samples=32, max_depth=2)
    assert mean(toward).min() > 0.1
    if two_sided:
        assert close(away, mean(toward), 0.02)
    else:
        assert not mean(away).any()
    from_above = iso.Camera((0, 3, 0.2), (0, 1, 0), fov_degrees=1)
    seen = render([FLOOR], [light.at((0, 1, 0))], from_above, samples=4, max_depth=1)
    assert np.allclose(mean(seen), RADIANCE if two_sided else 0)


def test_a_light_below_the_floor_does_not_shine_on_it_but_what_is_between_blocks():
    below = [iso.PointLight((0, -1, 0), 100), iso.SphereLight(radius=0.2, power=100).at((0.3, -1, 0))]
    assert not mean(render([FLOOR], below, SPOT, samples=16, max_depth=2)).any()
    lid = iso.Item(plane(0.5), iso.Matte((0, 0, 0))).translate((0, 0.5, 0))
    assert not mean(render([FLOOR, lid], [iso.PointLight((0, 1, 0), 100)], SPOT, samples=16, max_depth=2)).any()
    ball = iso.SphereLight(radius=0.3, radiance=(0, 0, 0)).at((0, 0.5, 0))
    assert not mean(render([FLOOR], [iso.PointLight((0, 1, 0), 100), ball], SPOT, samples=16, max_depth=2)).any()


def test_max_depth_counts_rays():
    """1: what shines; 2: direct light; 3: one bounce more. In a closed box of albedo ρ they are E Σ ρ^k."""
    item = iso.Item(box(4, inward=True), iso.Emitter(RADIANCE, body=iso.Matte(RHO)))
    inside = iso.Camera((0.5, 0.1, 0.2), (-1, 0.3, -1), fov_degrees=90)
    for depth in (1, 2, 3, 5, 8):
        image = render([item], (), inside, samples=64, max_depth=depth)
        assert close(image, np.array(RADIANCE) * (1 - RHO**depth) / (1 - RHO))


# --- furnaces -------------------------------------------------------------------------------------


@pytest.mark.parametrize("rho", [0.2, 0.8])
@pytest.mark.parametrize("shape", ["box", "sphere"])
def test_closed_furnace(rho, shape):
    """Inside a closed body that emits E and reflects ρ all is E / (1 − ρ)."""
    mesh = box(4, inward=True) if shape == "box" else icosphere(3, 2.0)
    # A sphere seen from within shines from its back.
    item = iso.Item(mesh, iso.Emitter(RADIANCE, two_sided=True, body=iso.Matte(rho)))
    inside = iso.Camera((0.5, 0.1, 0.2), (-1, 0.3, -1), fov_degrees=90)
    image = render([item], (), inside, samples=64, max_depth=200)
    assert close(image, np.array(RADIANCE) / (1 - rho))


@pytest.mark.parametrize("mesh", [box(), icosphere(0), icosphere(3)])
def test_a_convex_white_body_vanishes_in_a_white_sky(mesh):
    image = render([iso.Item(mesh, iso.Matte((1, 1, 1)))], [WHITE_SKY], samples=16, size=(48, 48))
    assert (image.channels["item"] == 0).any()
    assert (image.channels["colour"] == 1).all()


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("material", [iso.Glass(1.5), iso.Glass(0.7), iso.Mirror()])
def test_mirrors_and_glass_vanish_in_a_white_sky(material, smooth):
    item = iso.Item(icosphere(3, smooth=smooth), material)
    image = render([item], [WHITE_SKY], samples=16, size=(48, 48), max_depth=1000)
    colour = image.channels["colour"]
    # Rays that are trapped in a faceted body, or at the rims of a smooth one, are few. Nothing outshines the sky.
    assert colour.max() < 1 + 1e-5
    assert mean(image).min() > 0.999
    if isinstance(material, iso.Mirror):
        assert colour.min() > 1 - 1e-5


def test_smooth_mirrors_never_reflect_into_themselves():
    """Two rays at most: at the rims too the second one must reach the sky."""
    image = render(
        [iso.Item(icosphere(1, smooth=True), iso.Mirror())], [WHITE_SKY], samples=16, size=(48, 48), max_depth=2
    )
    assert (image.channels["colour"] == 1).all()


def test_coloured_glass_box_and_mirror_by_their_factors():
    slab = iso.Item(plane(), iso.Mirror((0.5, 0.25, 0.125)))
    camera = iso.Camera((0, 3, 0.5), (0, 0, 0), fov_degrees=5)
    image = render([slab], [WHITE_SKY], camera, samples=4, max_depth=2)
    assert np.allclose(image.channels["colour"], (0.5, 0.25, 0.125))
    back = render([slab], [WHITE_SKY], iso.Camera((0, -3, 0.5), (0, 0, 0), fov_degrees=5), samples=4, max_depth=2)
    assert np.allclose(back.channels["colour"], (0.5, 0.25, 0.125))


# --- glass ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("degrees", [0, 30, 60, 80])
def test_a_slab_of_glass_shifts_the_view(degrees):
    """By t sinθ (1 − cosθ / √(n² − sin²θ)), aside from the ray: found with a narrow line to look for."""
    n, t, theta = 1.5, 0.5, math.radians(degrees)
    shift = t * math.sin(theta) * (1 - math.cos(theta) / math.sqrt(n * n - math.sin(theta) ** 2))
    slab = iso.Item(box(1), iso.Glass(n)).scale((40, t, 40))
    along = np.array([math.sin(theta), -math.cos(theta), 0])
    aside = np.array([math.cos(theta), math.sin(theta), 0])
    middle, half, z = 8 * along, 0.01 * aside, np.array([0, 0, 2.0])
    corners = [middle - half - z, middle + half - z, middle + half + z, middle - half + z]
    line = iso.Item(iso.Mesh(corners, [(0, 1, 2, 3)]), iso.Emitter((1, 1, 1), two_sided=True))
    camera = iso.OrthographicCamera(-8 * along, (0, 0, 0), up=(0, 0, 1), height=0.003)
    image = render([slab, line], (), camera, size=(401, 1), samples=1024, max_depth=3)
    colour = image.channels["colour"][0, :, 0].astype(np.float64)
    x = (np.arange(401) - 200) * 0.003
    seen = (x * colour).sum() / colour.sum()
    # Straight through is two refractions; reflections within would need more rays.
    assert abs(abs(seen) - shift) < 1e-3
    through = colour.sum() * 0.003 / 0.02
    share = reflectance(theta, n)
    assert through == pytest.approx((1 - share) ** 2, rel=0.02)


def reflectance(theta: float, n: float) -> float:
    inside = math.sqrt(1 - (math.sin(theta) / n) ** 2)
    c = math.cos(theta)
    return 0.5 * (((n * c - inside) / (n * c + inside)) ** 2 + ((c - n * inside) / (c + n * inside)) ** 2)


def test_glass_over_a_floor_keeps_radiance():
    """A floor lit by a sky of radiance 1, albedo 1, under a thick slab of glass: in a furnace all is 1."""
    slab = iso.Item(box(1), iso.Glass(1.5)).scale((200, 1, 200)).translate((0, 0.75, 0))
    floor = iso.Item(plane(200), iso.Matte((1, 1, 1)))
    image = render([floor, slab], [WHITE_SKY], iso.Camera((0, 4, 3), (0, 0, 0)), samples=256, max_depth=200)
    assert close(image, np.ones(3), 0.02)


# --- settings -------------------------------------------------------------------------------------

ROOM = [
    iso.Item(box(4, inward=True), iso.Matte((0.7, 0.5, 0.3))),
    iso.Item(icosphere(2, 0.6), iso.Glass(1.5)).translate((0.5, -1, 0.3)),
    iso.Item(box(0.9), iso.Mirror((0.9, 0.9, 0.9))).rotate("y", 0.4).translate((-0.8, -1.3, 0)),
]
ROOM_LIGHTS = [iso.RectLight(size=(1, 1), radiance=RADIANCE).at((0, 1.9, 0)), iso.PointLight((1, 0.5, 1), 10)]
ROOM_CAMERA = iso.Camera((0, 0, 1.9), (0, -0.2, 0), fov_degrees=80)


def room(**settings: object) -> iso.Image:
    return render(ROOM, ROOM_LIGHTS, ROOM_CAMERA, size=(24, 24), **settings)


def same_mean(a: iso.Image, b: iso.Image) -> bool:
    means, variances = [], []
    for image in (a, b):
        means.append(mean(image))
        variances.append(image.channels["variance"].astype(np.float64).mean(axis=(0, 1)) / np.prod(image.size))
    return bool((np.abs(means[0] - means[1]) < 4.5 * np.sqrt(variances[0] + variances[1])).all())


def test_patterns_have_the_same_mean():
    """ "regular" is left out: its middles of cells have an error of their own."""
    names = ("blue-noise", "sobol", "antithetic", "jittered", "independent")
    first, *others = (room(samples=256, pattern=name) for name in names)
    for other in others:
        assert same_mean(first, other)
