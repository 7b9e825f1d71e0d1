"""Clear media: slabs and boundaries against closed forms, media within media, the same glass in both tracers."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import isophote as iso
from ray_traced import block, colour, log, ray_trace, seen_along
from scenes import icosphere

WALL = iso.Item(block((-5, -5, -3.1), (5, 5, -3)), iso.Emitter((1.0, 2.0, 4.0)))
STRAIGHT = iso.OrthographicCamera((0.05, 0.03, 5), (0.05, 0.03, 0), height=0.1)
BRIGHT = np.array([1.0, 2.0, 4.0])


def slab(thickness: float, glass: iso.Glass) -> iso.Item:
    """A plate from z = 0 down to z = −thickness."""
    return iso.Item(block((-2, -2, -thickness), (2, 2, 0)), glass)


def mean(items: list, camera: object = STRAIGHT, **settings: object) -> np.ndarray:
    return colour(ray_trace(items, [], camera, size=(2, 2), **settings)).mean(axis=(0, 1))


@pytest.mark.parametrize("thickness", [0.25, 1.0, 2.0])
def test_light_goes_straight_through_what_does_not_bend_it_tinted_by_thickness(thickness):
    """exp(−σ d) for an index of refraction of 1, and for slanted rays exp(−σ d / cosθ)."""
    sigma = np.array([0.3, 1.0, 2.0])
    plate = slab(thickness, iso.Glass(1.0, absorption=tuple(sigma)))
    assert np.allclose(mean([WALL, plate], samples=1), BRIGHT * np.exp(-sigma * thickness), rtol=1e-5)
    slanted = seen_along((0.1, 1.1, 3), (0.0, -0.3, -1.0))
    expected = BRIGHT * np.exp(-sigma * thickness * math.hypot(0.3, 1.0))
    assert np.allclose(mean([WALL, plate], slanted, samples=1), expected, rtol=1e-5)


def test_a_tint_is_the_colour_at_its_distance():
    tint = (0.2, 0.5, 0.9)
    plate = slab(0.5, iso.Glass.tinted(tint, at=0.5, ior=1.0))
    assert np.allclose(mean([WALL, plate], samples=1), BRIGHT * tint, rtol=2e-5)


@pytest.mark.parametrize("method", ["ray", "path"])
def test_a_slab_of_glass_in_closed_form(method):
    """T = (1 − F)² A / (1 − F² A²) with A = exp(−σ d): all ways to and fro inside added up."""
    sigma, f = np.array([0.2, 0.7, 1.5]), (0.8 / 2.8) ** 2
    plate = slab(1.0, iso.Glass(1.8, absorption=tuple(sigma)))
    a = np.exp(-sigma)
    expected = BRIGHT * (1 - f) ** 2 * a / (1 - f**2 * a**2)
    if method == "ray":
        assert np.allclose(mean([WALL, plate], samples=1, depth=24, min_weight=0), expected, rtol=2e-5)
    else:
        found = mean([WALL, plate], method=iso.PathTrace(samples=65536, max_depth=24))
        assert np.allclose(found, expected, rtol=5e-3)


@pytest.mark.parametrize("degrees", [10, 35, 60, 85])
@pytest.mark.parametrize("n", [1.33, 1.5, 2.4])
def test_the_offset_of_a_slab(degrees, n):
    """A ray leaves a plate of thickness t as it came, moved aside by t sinθ (1 − cosθ / √(n² − sin²θ))."""
    theta, t = math.radians(degrees), 0.4
    direction = np.array([0.0, -math.sin(theta), -math.cos(theta)])
    far = 3 / math.cos(theta)
    start = np.array([0.01, 0.02, 0.0]) - far * direction
    plate = iso.Item(block((-2, -2, -t), (2, 2, 0)), iso.Glass(n))
    rays = log([WALL, plate], camera=seen_along(start, direction), samples=1, depth=3).rays
    inside = next(ray for ray in rays if ray.kind == "refracted" and ray.parent == 0)
    outside = next(ray for ray in rays if ray.kind == "refracted" and ray.parent == rays.index(inside))
    sine = -inside.direction[1]
    assert sine == pytest.approx(math.sin(theta) / n, abs=1e-6)
    assert np.allclose(outside.direction, direction, atol=1e-6)
    moved = np.array(outside.origin) - np.array(rays[0].origin)
    aside = np.linalg.norm(moved - (moved @ direction) * direction)
    expected = t * math.sin(theta) * (1 - math.cos(theta) / math.sqrt(n**2 - math.sin(theta) ** 2))
    assert aside == pytest.approx(expected, abs=2e-5)


def prism(n: float) -> iso.Item:
    """A right-angled prism that stands on its long side; rays along −z meet that at right angles."""
    points = [(x, y, z) for x in (-1, 1) for y, z in ((-1, 0), (1, 0), (0, -1))]
    return iso.Item(iso.Mesh(points, [(0, 1, 2), (5, 4, 3), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)]), iso.Glass(n))


@pytest.mark.parametrize(("n", "total"), [(1.40, False), (1.4141, False), (1.4144, True), (1.5, True), (2.4, True)])
def test_total_reflection_beyond_the_critical_angle(n, total):
    """At 45° light stays inside for n > √2, whole; below, some goes on."""
    rays = log([WALL, prism(n)], camera=seen_along((0.1, 0.4, 3), (0, 0, -1)), samples=1, depth=3, min_weight=0).rays
    inside = next(number for number, ray in enumerate(rays) if ray.kind == "refracted" and ray.parent == 0)
    onward = [ray for ray in rays if ray.parent == inside]
    assert ("refracted" not in [ray.kind for ray in onward]) == total
    reflected = next(ray for ray in onward if ray.kind == "reflected")
    assert np.allclose(reflected.direction, (0, -1, 0), atol=1e-6)
    if total:
        assert reflected.weight == (1, 1, 1)
    else:
        # Radiance is squeezed by n² behind the boundary; flux is not lost.
        refracted = next(ray for ray in onward if ray.kind == "refracted")
        assert reflected.weight[0] + refracted.weight[0] / n**2 == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize("degrees", [0, 20, 56.31, 75])
def test_shares_are_fresnels(degrees):
    theta = math.radians(degrees)
    start = np.array([0.0, math.sin(theta), math.cos(theta)]) * 2
    rays = log([WALL, slab(1, iso.Glass(1.5))], camera=seen_along(start, -start), samples=1, depth=2).rays
    share = next(ray.weight[0] for ray in rays if ray.kind == "reflected")
    assert share == pytest.approx(float(iso.fresnel(theta, 1.0, 1.5)), abs=2e-6)


# --- media within media -------------------------------------------------------------------------------------------


def chain(*indices: float) -> float:
    """Share of light that goes straight on through boundaries between media of these indices, without detours."""
    share = 1.0
    for a, b in pairwise(indices):
        share *= 1 - ((b - a) / (b + a)) ** 2
    return share


GLASS, WATER, ICE = 1.5, 1.33, 1.31


@pytest.mark.parametrize("overlap", [0.05, 0.3])
def test_water_that_reaches_into_its_glass(overlap):
    """Glass from z = 0 to −0.5 and water behind it. Where the water reaches into the glass, of higher priority, there
    is glass: the boundary is the glass's own."""
    items = [
        WALL,
        iso.Item(block((-2, -2, -0.5), (2, 2, 0)), iso.Glass(GLASS, absorption=0.4, priority=1)),
        iso.Item(block((-2, -2, -1.5), (2, 2, -0.5 + overlap)), iso.Glass(WATER, absorption=1.2)),
    ]
    rays = log(items, camera=seen_along((0.1, 0.1, 3), (0, 0, -1)), samples=1, depth=5, min_weight=0).rays
    way = follow(rays)
    assert [ray.kind for ray in way] == ["camera", "refracted", "passed", "refracted", "refracted"]
    weight = np.prod([ray.weight[0] * ray.tint[0] for ray in way])
    assert weight == pytest.approx(chain(1, GLASS, WATER, 1) * math.exp(-0.4 * 0.5 - 1.2 * 1.0), rel=1e-4)


def follow(rays: tuple) -> list:
    """The ray that goes straight on, from the camera to what it meets last."""
    way = [rays[0]]
    while True:
        number = next(k for k, ray in enumerate(rays) if ray is way[-1])
        onward = [ray for ray in rays if ray.parent == number and ray.kind in ("refracted", "passed")]
        if not onward or onward[0].ended:
            return way
        way.append(onward[0])


def test_ice_within_water_within_glass():
    """Without priorities: each solid lies wholly within the next, and the one entered last counts."""
    items = [
        WALL,
        iso.Item(block((-2, -2, -2), (2, 2, 0)), iso.Glass(GLASS, absorption=0.1)),
        iso.Item(block((-1.5, -1.5, -1.7), (1.5, 1.5, -0.3)), iso.Glass(WATER, absorption=0.5)),
        iso.Item(block((-1, -1, -1.2), (1, 1, -0.8)), iso.Glass(ICE, absorption=1.5)),
    ]
    way = follow(log(items, camera=seen_along((0.1, 0.1, 3), (0, 0, -1)), samples=1, depth=8, min_weight=0).rays)
    assert [ray.kind for ray in way] == ["camera", *["refracted"] * 6]
    weight = np.prod([ray.weight[0] * ray.tint[0] for ray in way])
    assert weight == pytest.approx(
        chain(1, GLASS, WATER, ICE, WATER, GLASS, 1) * math.exp(-0.1 * 0.6 - 0.5 * 1.0 - 1.5 * 0.4), rel=1e-4
    )


def test_ice_that_sticks_out_of_water():
    """Of higher priority, ice is ice inside the water and above it; the water's surface within it is none."""
    items = [
        WALL,
        iso.Item(block((-2, -2, -2), (2, 2, -0.5)), iso.Glass(WATER, absorption=0.5)),
        iso.Item(block((-1, -1, -1), (1, 1, 0)), iso.Glass(ICE, absorption=1.5, priority=1)),
    ]
    way = follow(log(items, camera=seen_along((0.1, 0.1, 3), (0, 0, -1)), samples=1, depth=8, min_weight=0).rays)
    assert [ray.kind for ray in way] == ["camera", "refracted", "passed", "refracted", "refracted"]
    weight = np.prod([ray.weight[0] * ray.tint[0] for ray in way])
    assert weight == pytest.approx(chain(1, ICE, WATER, 1) * math.exp(-1.5 * 1.0 - 0.5 * 1.0), rel=1e-4)


def test_a_camera_under_water():
    """A ray that leaves what it never entered began inside: it is absorbed from the start, and refracted outward."""
    camera = seen_along((0.1, 0.1, -0.5), (0, 0, -1))
    items = [WALL, iso.Item(block((-2, -2, -1.5), (2, 2, 0)), iso.Glass(WATER, absorption=0.8))]
    way = follow(log(items, camera=camera, samples=1, depth=4, min_weight=0).rays)
    assert way[0].tint[0] == pytest.approx(math.exp(-0.8), rel=1e-5)
    # Looking outward, radiance grows by n².
    assert way[1].weight[0] == pytest.approx(chain(WATER, 1) * WATER**2, rel=1e-5)


@pytest.mark.parametrize("method", ["ray", "path"])
def test_a_camera_in_media_knows_them(method):
    """In ice within water: what is seen of a wall in the water is absorbed by both on the way."""
    wall = iso.Item(block((-1, -1, -2.1), (1, 1, -2)), iso.Emitter(1.0))
    items = [
        wall,
        iso.Item(block((-3, -3, -3), (3, 3, 3)), iso.Glass(1.0, absorption=0.3)),
        iso.Item(block((-1, -1, -1), (1, 1, 1)), iso.Glass(1.0, absorption=0.8)),
    ]
    camera = seen_along((0.1, 0.1, 0.5), (0, 0, -1))
    settings = {"samples": 1} if method == "ray" else {"method": iso.PathTrace(samples=4)}
    assert mean(items, camera, **settings) == pytest.approx(math.exp(-0.8 * 1.5 - 0.3 * 1.0), rel=1e-5)
    # The wall alone, in the water from the start.
    before = seen_along((0.1, 0.1, -1.5), (0, 0, -1))
    assert mean(items, before, **settings) == pytest.approx(math.exp(-0.3 * 0.5), rel=1e-5)


def test_light_inside_a_medium_is_absorbed_on_its_way_to_surfaces():
    """A lamp and a matte floor in one block of ice: exp(−σ d) between them, in both tracers."""
    sigma = 0.9
    ice = iso.Item(block((-3, -3, -3), (3, 3, 3)), iso.Glass(1.0, absorption=sigma))
    floor = iso.Item(block((-2, -2, -1), (2, 2, 0)), iso.Matte(0.5))
    lamp = iso.SphereLight(radius=0.001, power=10).at((0, 0, 2))
    origin, direction = np.array([0.7, 0.1, 6.0]), np.array([-0.2, 0.0, -1.0])
    camera = seen_along(origin, direction)
    way = 3 * np.linalg.norm(direction) + np.linalg.norm(origin + 6 * direction - (0, 0, 2))
    for method in (iso.RayTrace(samples=1, light_samples=16), iso.PathTrace(samples=1024, max_depth=3)):
        found, clear = (
            colour(ray_trace([floor, *extra], [lamp], camera, size=(1, 1), method=method)).mean()
            for extra in ([ice], [])
        )
        assert found / clear == pytest.approx(math.exp(-sigma * way), rel=5e-3)


@pytest.mark.parametrize("depth", [3, 9])
def test_both_tracers_see_the_same_glass(depth):
    """Spheres of glass, water and ice in each other and overlapping: pictures agree within their noise."""
    items = [
        iso.Item(icosphere(3, 1.0, smooth=True), iso.Glass(GLASS, absorption=(0.1, 0.5, 1.0), priority=1)),
        iso.Item(icosphere(3, 0.7, smooth=True), iso.Glass(WATER, absorption=(1.0, 0.2, 0.1), priority=2)).translate(
            (0.45, 0, 0)
        ),
        iso.Item(icosphere(2, 0.3), iso.Glass(ICE, colour=0.9, priority=3)).translate((-0.2, 0.3, 0)),
        iso.Item(icosphere(2, 0.2), iso.Mirror(0.8)).translate((0.2, -0.4, 0.2)),
    ]
    pixels = np.linspace(0.1, 2, 8 * 16 * 3).reshape(8, 16, 3).astype(np.float32)
    lights = [iso.Environment(iso.ImageTexture(pixels))]
    ours = ray_trace(items, lights, size=(20, 20), samples=64, depth=depth, min_weight=0)
    path = ray_trace(items, lights, size=(20, 20), method=iso.PathTrace(samples=1024, max_depth=depth), seed=7)
    difference = colour(ours) - colour(path)
    variance = ours.channels["variance"].astype(float) + path.channels["variance"]
    assert np.abs(difference.mean(axis=(0, 1))).max() < 3 * math.sqrt(variance.mean() / 400)
    assert (np.abs(difference) > 4 * np.sqrt(variance) + 0.02).mean() < 0.01


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: iso.Glass(ior=0), "ior"),
        (lambda: iso.Glass(ior=-1.5), "ior"),
        (lambda: iso.Glass(absorption=-1), "0 or above"),
        (lambda: iso.Glass(absorption="red"), "tinted takes a colour"),
        (lambda: iso.Glass(priority=math.inf), "priority"),
        (lambda: iso.Glass.tinted((0, 1, 1), at=1), "above 0"),
        (lambda: iso.Glass.tinted((2, 1, 1), at=1), "at most 1"),
        (lambda: iso.Glass.tinted("tomato", at=0), "number above 0"),
        (lambda: iso.Glass.tinted("tomato", at=1, absorption=1), "give no absorption"),
    ],
)
def test_what_makes_no_sense_is_refused(make, message):
    with pytest.raises(iso.SceneError, match=message):
        make()


# --- panes --------------------------------------------------------------------------------------------------------

PANE = iso.Mesh([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], [(0, 1, 2, 3)])


@pytest.mark.parametrize("method", ["ray", "path"])
@pytest.mark.parametrize("degrees", [0.0, 50.0])
def test_a_pane_is_a_slab_as_one_surface(degrees, method):
    """What a plate does with all its inner reflections, seen in front of a bright wall and a dark room."""
    theta, thickness, sigma, n = math.radians(degrees), 0.02, np.array([5.0, 20.0, 60.0]), 1.6
    direction = np.array([0.0, -math.sin(theta), -math.cos(theta)])
    camera = seen_along(-4.5 * direction, direction)
    pane = iso.Item(PANE, iso.ThinGlass(n, thickness=thickness, absorption=tuple(sigma)))
    f = float(iso.fresnel(theta, 1.0, n))
    a = np.exp(-sigma * thickness / math.sqrt(1 - (math.sin(theta) / n) ** 2))
    through = (1 - f) ** 2 * a / (1 - f**2 * a**2)
    if method == "ray":
        found = mean([WALL, pane], camera, samples=1, depth=3, min_weight=0)
        slab_of_both = [WALL, slab(thickness, iso.Glass(n, absorption=tuple(sigma)))]
        assert np.allclose(found, mean(slab_of_both, camera, samples=1, depth=20, min_weight=0), rtol=5e-4)
    else:
        found = mean([WALL, pane], camera, method=iso.PathTrace(samples=65536, max_depth=3))
    assert np.allclose(found, BRIGHT * through, rtol=2e-5 if method == "ray" else 5e-3)


def test_a_pane_reflects_the_rest_where_nothing_is_absorbed():
    rays = log([iso.Item(PANE, iso.ThinGlass(1.5))], camera=seen_along((0, 1, 2), (0, -1, -2)), samples=1).rays
    reflected, passed = (next(ray for ray in rays if ray.kind == kind) for kind in ("reflected", "passed"))
    assert reflected.weight[0] + passed.weight[0] == pytest.approx(1, abs=1e-6)
    assert np.allclose(passed.direction, rays[0].direction, atol=1e-6)


def test_a_tinted_sheet():
    sheet = iso.Item(PANE, iso.ThinGlass.tinted((0.25, 0.5, 0.75), ior=1.0))
    assert np.allclose(mean([WALL, sheet], samples=1), BRIGHT * (0.25, 0.5, 0.75), rtol=1e-5)
    with pytest.raises(iso.SceneError, match="give no absorption"):
        iso.ThinGlass.tinted("tomato", thickness=2)
    with pytest.raises(iso.SceneError, match="thickness"):
        iso.ThinGlass(thickness=-1)


# --- rough glass --------------------------------------------------------------------------------------------------


def test_rough_glass_has_its_index_relative_to_what_it_lies_in():
    """Ground glass in a liquid of the same index does not scatter: it is only tinted; in air it scatters."""
    ground = iso.Item(block((-1, -1, -1.4), (1, 1, -0.6)), iso.Glass(1.5, absorption=0.5, roughness=0.8))
    liquid = iso.Item(block((-2, -2, -2), (2, 2, 0)), iso.Glass(1.5))
    straight = mean([WALL, ground, liquid], method=iso.PathTrace(samples=16384, max_depth=12))
    f = 0.04
    assert np.allclose(straight, BRIGHT * (1 - f) ** 2 * math.exp(-0.5 * 0.8) / (1 - f**2 * math.exp(-0.8)), rtol=0.01)
    assert mean([WALL, ground], method=iso.PathTrace(samples=256, max_depth=12))[0] < 0.95 * straight[0]
