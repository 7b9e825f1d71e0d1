"""Spot lights: what arrives at sampled points against the formula, flux, edges, and what makes no sense."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from numba import njit

import isophote as iso
from isophote.kernels.base.vec import vec3
from isophote.kernels.light.emitter import LIGHTS, sample_light
from isophote.lower.lights import LightTable
from scenes import plane, render

open_lights = LIGHTS.open
RNG = np.random.default_rng(7)

SPOTS = {
    "hard": {"cone_degrees": 40.0},
    "smooth": {"cone_degrees": 70.0, "inner_degrees": 20.0},
    "power": {"cone_degrees": 180.0, "exponent": 8.0},
    "all": {"cone_degrees": 90.0, "inner_degrees": 30.0, "exponent": 2.5},
    "fades from the axis on": {"cone_degrees": 60.0, "inner_degrees": 0.0},
}


@njit(error_model="numpy")
def arriving(words, points, out):
    """Rows of direction, irradiance and density."""
    lights = open_lights(words)
    for i in range(len(points)):
        s = sample_light(lights, 0, vec3(points[i, 0], points[i, 1], points[i, 2]), np.float32(0.5), np.float32(0.5))
        out[i, 0], out[i, 1], out[i, 2] = s.x, s.y, s.z
        out[i, 3], out[i, 4], out[i, 5], out[i, 6] = s.red, s.green, s.blue, s.density


def samples(light: iso.SpotLight, points: np.ndarray) -> np.ndarray:
    table = LightTable()
    table.add(light, 1.0, 0)
    out = np.zeros((len(points), 7), np.float32)
    arriving(table.build(1.0).words, points.astype(np.float32), out)
    return out.astype(np.float64)


def formula(angle: np.ndarray, cone: float, inner: float, exponent: float) -> np.ndarray:
    """I / I₀ at an angle from the axis; cone and inner are full angles in degrees."""
    outer_cosine, inner_cosine = math.cos(math.radians(cone) / 2), math.cos(math.radians(inner) / 2)
    cosine = np.cos(angle)
    if inner_cosine > outer_cosine:
        u = np.clip((cosine - outer_cosine) / (inner_cosine - outer_cosine), 0, 1)
    else:
        u = (cosine >= outer_cosine).astype(float)
    return np.where(angle <= math.radians(cone) / 2, (3 * u**2 - 2 * u**3) * np.maximum(cosine, 0) ** exponent, 0)


@pytest.mark.parametrize("name", SPOTS)
def test_formula_at_sampled_points(name):
    settings = SPOTS[name]
    position, target = np.array([1.0, 4.0, -2.0]), np.array([0.0, 0.5, 1.0])
    light = iso.SpotLight(position, 50.0, (1, 0.5, 0.25), target=target, **settings)
    points = position + RNG.standard_normal((4000, 3)) * 2
    away = points - position
    distance = np.linalg.norm(away, axis=1)
    axis = (target - position) / np.linalg.norm(target - position)
    angle = np.arccos(np.clip(away @ axis / distance, -1, 1))
    inner = settings.get("inner_degrees", settings["cone_degrees"])
    expected = formula(angle, settings["cone_degrees"], inner, settings.get("exponent", 0.0))
    expected = expected[:, None] * np.array(light.intensity_rgb) / distance[:, None] ** 2
    found = samples(light, points)
    # Rounding decides on which side of the rim a point lies.
    clear = np.abs(angle - math.radians(settings["cone_degrees"]) / 2) > 1e-5
    lit = found[:, 6] == 0
    assert (lit == (expected[:, 0] > 0))[clear & ((expected[:, 0] == 0) | (expected[:, 0] > 1e-9))].all()
    assert np.allclose(np.where(lit[:, None], found[:, 3:6], 0)[clear], expected[clear], rtol=2e-4, atol=1e-6)
    assert np.allclose(found[lit, :3], -(away / distance[:, None])[lit], atol=1e-6)


@pytest.mark.parametrize("name", SPOTS)
def test_power_is_the_flux_through_a_sphere(name):
    light = iso.SpotLight((0, 0, 0), 30.0, target=(1, 2, 3), **SPOTS[name])
    n = 400_000
    heights = (np.arange(n) + 0.5) / n * 2 - 1
    turns = np.arange(n) * math.pi * (3 - math.sqrt(5))
    rims = np.sqrt(1 - heights**2)
    found = samples(light, np.stack([rims * np.cos(turns), heights, rims * np.sin(turns)], axis=1) * 2.0)
    flux = np.where(found[:, 6] == 0, found[:, 3], 0).mean() * 4 * math.pi * 2.0**2
    assert flux == pytest.approx(30.0, rel=2e-3)


def test_closed_forms_of_the_intensity_on_the_axis():
    hard = iso.SpotLight((0, 0, 0), 10.0, cone_degrees=60)
    assert hard.intensity_rgb[0] == pytest.approx(10 / (2 * math.pi * (1 - math.cos(math.pi / 6))))
    power = iso.SpotLight((0, 0, 0), 10.0, cone_degrees=180, exponent=5)
    assert power.intensity_rgb[0] == pytest.approx(10 * 6 / (2 * math.pi))
    narrow = iso.SpotLight((0, 0, 0), 10.0, cone_degrees=1e-3)
    assert narrow.intensity_rgb[0] == pytest.approx(10 / (math.pi * math.radians(0.5e-3) ** 2), rel=1e-6)
    given = iso.SpotLight.of_intensity((0, 1, 0), 7.0, cone_degrees=50, inner_degrees=10, exponent=3)
    assert given.intensity_rgb == pytest.approx((7.0, 7.0, 7.0))


def test_without_a_target_it_shines_straight_down():
    down = iso.SpotLight((1, 4, 2), target=(1, 0, 2))
    assert iso.SpotLight((1, 4, 2)).unit_axis == down.unit_axis == (0, -1, 0)


def test_path_traced_circle_of_light():
    """A spot above a ground lights a disk of radius h tan(half the cone) with ρ/π I cos³θ / h² and nothing else."""
    half = math.radians(25)
    light = iso.SpotLight((0, 3, 0), 20.0, cone_degrees=50)
    camera = iso.OrthographicCamera((0, 5, 0), (0, 0, 0), (0, 0, -1), height=4)
    image = render(
        [iso.Item(plane(10), iso.Matte(0.6))], [light], camera, size=(160, 160), samples=4, max_depth=2
    ).channels["colour"][..., 0]
    x = (np.arange(160) + 0.5) / 160 * 4 - 2
    radius = np.hypot(x[:, None], x)
    cosine = 3 / np.hypot(radius, 3)
    expected = 0.6 / math.pi * light.intensity_rgb[0] * cosine**3 / 9 * (radius < 3 * math.tan(half))
    clear = np.abs(radius - 3 * math.tan(half)) > 0.05
    assert np.allclose(image[clear], expected[clear], rtol=0.01, atol=1e-7)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"cone_degrees": 181}, "at most 180 degrees, not 181"),
        ({"cone_degrees": 0}, "above 0"),
        ({"cone_degrees": float("nan")}, "cone_degrees"),
        ({"inner_degrees": -1}, "inner_degrees"),
        ({"inner_degrees": 50}, "must not be above cone_degrees"),
        ({"exponent": -1}, "exponent"),
        ({"target": (0, 4, 0)}, "must not be the position itself"),
        ({"target": (0, float("inf"), 0)}, "target"),
        ({"power": -1}, "power"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, message):
    with pytest.raises(iso.SceneError, match=message):
        iso.SpotLight((0, 4, 0), **settings)


@pytest.mark.parametrize("name", SPOTS)
def test_spots_come_back_from_gltf(name, tmp_path):
    light = iso.SpotLight((1, 4, -2), 30, (1.0, 0.5, 0.25), target=(0.5, 1, 1), **SPOTS[name])
    iso.save(iso.Scene([iso.Item(plane(2))], [light]), tmp_path / "spot.gltf")
    (back,) = iso.load_scene(tmp_path / "spot.gltf").lights
    assert isinstance(back, iso.SpotLight)
    assert back.power == pytest.approx(light.power, rel=1e-3)
    assert back.intensity_rgb == pytest.approx(light.intensity_rgb)
    assert back.position == pytest.approx(light.position)
    assert back.target == pytest.approx(light.target)
    assert back.cone_degrees == pytest.approx(light.cone_degrees)
    assert (back.inner_degrees is None) == (light.inner_degrees is None)
    assert back.inner_degrees == (None if light.inner_degrees is None else pytest.approx(light.inner_degrees, abs=1e-9))
    assert back.exponent == light.exponent


def spot_file(path, spot: dict) -> iso.Light:
    light = {"type": "spot", "intensity": 5.0, **({"spot": spot} if spot is not None else {})}
    held = {"KHR_lights_punctual": {"light": 0}}
    root = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [light]}},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"extensions": held, "translation": [0, 2, 0], "rotation": [-math.sqrt(0.5), 0, 0, math.sqrt(0.5)]}],
    }
    path.write_text(json.dumps(root))
    return iso.load_scene(path).lights[0]


def test_spots_of_gltf_have_half_angles_and_shine_along_minus_z(tmp_path):
    light = spot_file(tmp_path / "a.gltf", {"innerConeAngle": 0.2, "outerConeAngle": 0.5})
    assert light.unit_axis == pytest.approx((0, -1, 0), abs=1e-12)
    assert light.cone_degrees == pytest.approx(2 * math.degrees(0.5))
    assert light.inner_degrees == pytest.approx(2 * math.degrees(0.2))
    assert light.intensity == pytest.approx(5)
    default = spot_file(tmp_path / "b.gltf", None)
    assert (default.inner_degrees, default.cone_degrees) == (0, 90)


@pytest.mark.parametrize("spot", [{"outerConeAngle": 2.0}, {"innerConeAngle": 0.6, "outerConeAngle": 0.5}])
def test_wrong_cones_in_gltf_are_refused(spot, tmp_path):
    with pytest.raises(iso.FileError, match="innerConeAngle < outerConeAngle"):
        spot_file(tmp_path / "a.gltf", spot)


def test_sphere_traced_spots_shine_like_path_traced_ones():
    light = iso.SpotLight((0.5, 3, 0), 20.0, cone_degrees=60, inner_degrees=20, exponent=2)
    camera = iso.OrthographicCamera((0, 5, 0), (0, 0, 0), (0, 0, -1), height=3)
    scene = iso.Scene([iso.Item(iso.plane(), iso.Matte(0.6))], [light], camera)
    ours = iso.render(scene, iso.SphereTrace(shadows="none"), size=(40, 40), progress=False).channels["colour"]
    path = iso.render(scene, iso.PathTrace(samples=64, max_depth=2), size=(40, 40), progress=False).channels["colour"]
    assert np.abs(ours - path).max() < 0.02 * path.max()
