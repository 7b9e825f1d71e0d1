"""Lights: where samples of them fall, their densities, and what arrives, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit

import isophote as iso
from isophote.checks.statistics import chi_square_deviation
from isophote.kernels.base.table import Packed
from isophote.kernels.base.vec import normalise, vec3
from isophote.kernels.light import emitter
from isophote.kernels.light.emitter import LIGHTS, light_density, pick_light, sample_light
from isophote.kernels.light.environment import (
    ENVIRONMENT,
    environment_density,
    environment_radiance,
    sample_environment,
)
from isophote.lower.lights import LightTable, rectangle_mesh
from isophote.scene.light import direction_to_uv, uv_to_direction
from statistics_of_samples import stratified

open_lights, open_environment = LIGHTS.open, ENVIRONMENT.open
SQUARE = stratified(300)
COUNT = len(SQUARE)
RED = (3.0, 2.0, 0.5)


@njit(error_model="numpy")
def sample_many(words, k, place, square, out, again):
    """Rows of direction, distance, radiance, density; and `light_density` at the same place on the light."""
    lights = open_lights(words)
    point = vec3(place[0], place[1], place[2])
    for i in range(len(square)):
        s = sample_light(lights, k, point, square[i, 0], square[i, 1])
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = s.x, s.y, s.z, s.distance
        out[i, 4], out[i, 5], out[i, 6], out[i, 7] = s.red, s.green, s.blue, s.density
        reach = s.distance if s.distance < np.inf else np.float32(1)
        again[i] = light_density(lights, k, point, vec3(s.x, s.y, s.z) * reach) if s.density > 0 else s.density


@njit(error_model="numpy")
def pick_many(words, u, numbers, chances, rests):
    lights = open_lights(words)
    for i in range(len(u)):
        numbers[i], chances[i], rests[i] = pick_light(lights, u[i])


@njit(error_model="numpy")
def sky_many(words, square, directions, densities, radiances):
    sky = open_environment(words)
    for i in range(len(square)):
        d = sample_environment(sky, square[i, 0], square[i, 1])
        directions[i, 0], directions[i, 1], directions[i, 2] = d.x, d.y, d.z
    look_up_sky(words, directions, densities, radiances)


@njit(error_model="numpy")
def look_up_sky(words, directions, densities, radiances):
    sky = open_environment(words)
    for i in range(len(directions)):
        d = normalise(vec3(directions[i, 0], directions[i, 1], directions[i, 2]))
        densities[i] = environment_density(sky, d)
        c = environment_radiance(sky, d)
        radiances[i, 0], radiances[i, 1], radiances[i, 2] = c.x, c.y, c.z


class Samples:
    """Samples of light `k`, in double precision."""

    def __init__(self, table: Packed, k: int, place: tuple[float, ...], square: np.ndarray = SQUARE) -> None:
        rows, again = np.zeros((len(square), 8), np.float32), np.zeros(len(square), np.float32)
        sample_many(table.words, k, np.array(place, np.float32), square, rows, again)
        self.rows = rows.astype(np.float64)
        self.direction, self.distance = self.rows[:, :3], self.rows[:, 3]
        self.radiance, self.density, self.again = self.rows[:, 4:7], self.rows[:, 7], again.astype(np.float64)

    def places(self, point: tuple[float, ...]) -> np.ndarray:
        return np.array(point) + self.direction * self.distance[:, None]

    def integral(self, normal: tuple[float, ...] | None = None) -> float:
        """Solid angle of the light, or, with a normal, its projection ∫ cosθ dω."""
        cosine = 1.0 if normal is None else np.maximum(self.direction @ np.array(normal), 0)
        arrives = self.density > 0
        return float((np.where(arrives, cosine, 0) / np.where(arrives, self.density, 1)).mean())


def table_of(*lights: object) -> Packed:
    table = LightTable()
    for light in lights:
        if isinstance(light, iso.RectLight):
            table.add_mesh(rectangle_mesh(light), light.transform.matrix, light.radiance_rgb, light.two_sided)
        elif isinstance(light, iso.Item):
            table.add_mesh(light.shape, light.transform.matrix, light.material.radiance, light.material.two_sided)
        else:
            table.add(light, 1.0, 0)
    return table.build(1.0)


def solid_angle(corners: np.ndarray, point: tuple[float, ...]) -> float:
    """Of a triangle (van Oosterom, Strackee 1983)."""
    a, b, c = corners - np.array(point)
    la, lb, lc = (np.linalg.norm(v) for v in (a, b, c))
    below = la * lb * lc + a @ b * lc + b @ c * la + c @ a * lb
    return abs(2 * math.atan2(a @ np.cross(b, c), below))


def projected(corners: np.ndarray, point: tuple[float, ...], normal: tuple[float, ...]) -> float:
    """∫ cosθ dω over a polygon above the horizon (Lambert): ½ Σ angle of an edge · (its plane's normal · n)."""
    v = corners - np.array(point)
    v = v / np.linalg.norm(v, axis=1)[:, None]
    total = 0.0
    for p, q in zip(v, np.roll(v, -1, axis=0), strict=True):
        across = np.cross(p, q)
        total += math.atan2(np.linalg.norm(across), p @ q) * (across / np.linalg.norm(across)) @ np.array(normal)
    return abs(total) / 2


UP = (0.0, 1.0, 0.0)
TRIANGLE = np.array([(-1, 2, -0.5), (1.5, 2.5, 0), (0, 2, 1.5)])
RECTANGLE = iso.RectLight(size=(2, 0.7), radiance=RED).at((0.5, 2, 0.2), target=(0.2, 0, 0))
DISK = iso.DiskLight(radius=0.8, radiance=RED).at((0, 1.7, 0))
SPHERE = iso.SphereLight(radius=0.6, radiance=RED).at((0.3, 1.9, -0.4))


def rectangle_corners(light: iso.RectLight) -> np.ndarray:
    x, z = light.size[0] / 2, light.size[1] / 2
    return light.transform.apply([(-x, 0, -z), (x, 0, -z), (x, 0, z), (-x, 0, z)])


def check_area_light(samples: Samples, omega: float, lambert: float) -> None:
    assert (samples.density > 0).all()
    assert np.abs(np.linalg.norm(samples.direction, axis=1) - 1).max() < 1e-6
    assert np.allclose(samples.radiance, RED)
    assert np.allclose(samples.again, samples.density, rtol=2e-5)
    assert samples.integral() == pytest.approx(omega, rel=1e-4)
    assert samples.integral(UP) == pytest.approx(lambert, rel=1e-4)


def test_triangle():
    # Wound so that its normal looks down to the point.
    corners = TRIANGLE if np.cross(*(TRIANGLE[1:] - TRIANGLE[0]))[1] < 0 else TRIANGLE[::-1]
    table = table_of(iso.Item(iso.Mesh(corners, [(0, 1, 2)]), iso.Emitter(RED)))
    samples = Samples(table, 0, (0.1, 0, 0))
    check_area_light(samples, solid_angle(TRIANGLE, (0.1, 0, 0)), projected(TRIANGLE, (0.1, 0, 0), UP))
    edges = np.stack([corners[1] - corners[0], corners[2] - corners[0]])
    weights = (samples.places((0.1, 0, 0)) - corners[0]) @ np.linalg.pinv(edges)
    n = 8
    i, j = np.clip((weights * n).astype(int), 0, n - 1).T
    cells = np.zeros((n, n, 2))
    np.add.at(cells, (i, j, ((weights * n).sum(axis=1) - i - j > 1).astype(int)), 1)
    inside = np.add.outer(np.arange(n), np.arange(n))[:, :, None] + np.arange(2) < n
    assert chi_square_deviation(cells[inside], np.full(n * n, COUNT / (n * n))) < 3.72


@pytest.mark.parametrize("point", [(0, 0, 0), (2, 1, -1), (0.4, 1.9, 0.2)])
def test_rectangle(point):
    corners = rectangle_corners(RECTANGLE)
    if point == (2, 1, -1):
        assert (np.array(point) - corners[0]) @ -RECTANGLE.transform.matrix[:3, 1] > 0
    samples = Samples(table_of(RECTANGLE), 0, point)
    omega = sum(solid_angle(corners[list(t)], point) for t in ((0, 1, 2), (0, 2, 3)))
    lambert = projected(corners, point, UP)
    if point[1] > 1.5:
        # So close that stratified points converge slower, and the light reaches below the horizon.
        assert samples.integral() == pytest.approx(omega, rel=0.02)
        return
    check_area_light(samples, omega, lambert)
    local = (samples.places(point) - corners[0]) @ np.linalg.pinv(
        np.stack([corners[1] - corners[0], corners[3] - corners[0]])
    )
    cells = np.histogram2d(*local.T, bins=10, range=[[-1e-6, 1 + 1e-6], [-1e-6, 1 + 1e-6]])[0]
    assert cells.sum() == COUNT
    assert chi_square_deviation(cells, np.full(cells.shape, COUNT / cells.size)) < 3.72


def test_disk():
    r, h = 0.8, 1.7
    samples = Samples(table_of(DISK), 0, (0, 0, 0))
    check_area_light(samples, 2 * math.pi * (1 - h / math.hypot(r, h)), math.pi * r * r / (r * r + h * h))
    x, _, z = samples.places((0, 0, 0)).T
    cells = np.histogram2d((x * x + z * z) / (r * r), np.arctan2(x, z), bins=(10, 12))[0]
    assert chi_square_deviation(cells, np.full(cells.shape, COUNT / cells.size)) < 3.72


@pytest.mark.parametrize("radius", [0.6, 1.9, 1e-2, 1e-4, 1e-6])
def test_sphere(radius):
    """Solid angle 2π (1 − cos) and projection π (r/d)² cosθ; samples lie on the sphere, evenly over its cone."""
    light = iso.SphereLight(radius=radius, radiance=RED).at((0.3, 1.9, -0.4))
    point = (0.0, -1.0, 0.0)
    samples = Samples(table_of(light), 0, point)
    centre = np.array(light.position) - point
    d = float(np.linalg.norm(centre))
    sine2 = (radius / d) ** 2
    check_area_light(samples, 2 * math.pi * sine2 / (1 + math.sqrt(1 - sine2)), math.pi * sine2 * centre[1] / d)
    on = np.linalg.norm(samples.direction * samples.distance[:, None] - centre, axis=1)
    assert np.abs(on / radius - 1).max() < 1e-5 + 1e-6 * d / radius
    if radius < 1e-2:
        return
    axis = centre / d
    tangent = np.cross(axis, (1, 0, 0)) / np.linalg.norm(np.cross(axis, (1, 0, 0)))
    local = samples.direction @ np.stack([tangent, np.cross(axis, tangent), axis], 1)
    across2 = (local[:, :2] ** 2).sum(axis=1)
    below = across2 / (1 + np.sqrt(1 - across2)) / (sine2 / (1 + math.sqrt(1 - sine2)))
    cells = np.histogram2d(np.minimum(below, 1), np.arctan2(local[:, 0], local[:, 1]), bins=(10, 12))[0]
    assert chi_square_deviation(cells, np.full(cells.shape, COUNT / cells.size)) < 3.72


def test_inside_a_sphere_nothing_arrives():
    samples = Samples(table_of(SPHERE), 0, (0.3, 1.7, -0.4))
    assert (samples.density < 0).all()


@pytest.mark.parametrize("make", [iso.RectLight, iso.DiskLight])
@pytest.mark.parametrize("two_sided", [False, True])
def test_behind_a_light_nothing_arrives_unless_it_has_two_sides(make, two_sided):
    table = table_of(make(radiance=RED, two_sided=two_sided).at((0, 1, 0)))
    for height, shines in ((0, True), (2, two_sided), (1, False)):
        samples = Samples(table, 0, (0.1, height, 0))
        assert ((samples.density > 0) == shines).all()


@pytest.mark.parametrize("mirrored", [False, True])
def test_mesh_lights_shine_to_the_outer_side_under_any_transform(mirrored):
    quad = iso.Mesh([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)], [(0, 1, 2, 3)])  # faces −y
    item = iso.Item(quad, iso.Emitter(RED)).scale((-2 if mirrored else 2, 1, 3)).translate((0, 1, 0))
    table = table_of(item)
    assert (Samples(table, 0, (0.3, 0, 0.2)).density > 0).all()
    assert (Samples(table, 0, (0.3, 2, 0.2)).density < 0).all()
    corners = item.transform.apply(quad.vertices)
    assert Samples(table, 0, (0.3, 0, 0.2)).integral(UP) == pytest.approx(
        projected(corners, (0.3, 0, 0.2), UP), rel=1e-4
    )


def test_point_light():
    light = iso.PointLight((1, 2, 3), 8 * math.pi, colour=(1, 0.5, 0.25))
    samples = Samples(table_of(light), 0, (0.0, -1.0, 0.5), SQUARE[:10])
    d2 = 1 + 9 + 6.25
    assert np.allclose(samples.radiance, np.array([2, 1, 0.5]) / d2, rtol=1e-6)
    assert np.allclose(samples.places((0, -1, 0.5)), (1, 2, 3), atol=1e-6)
    assert (samples.density == 0).all()


def test_sun():
    samples = Samples(table_of(iso.Sun((1, 2, 2), 5.0)), 0, (7.0, 8.0, 9.0), SQUARE[:10])
    assert np.allclose(samples.direction, np.array([1, 2, 2]) / 3, atol=1e-7)
    assert np.allclose(samples.radiance, 5)
    assert np.isinf(samples.distance).all()
    assert (samples.density == 0).all()


def test_every_kind_of_light_is_tested_here_or_as_spots():
    kinds = {name for name in emitter.__all__ if name.isupper() and name != "LIGHTS"}
    assert kinds == {"TRIANGLE", "PARALLELOGRAM", "DISK", "SPHERE", "POINT", "SPOT", "SUN", "ENVIRONMENT"}


# --- picking --------------------------------------------------------------------------------------


@pytest.mark.parametrize("powers", [[1], [1, 0], [5, 1, 3, 1], [1e-9, 1, 1e9], list(range(1000))])
def test_lights_are_picked_as_often_as_their_chance_says(powers):
    table = table_of(*(iso.Sun((0, 1, 0), power) for power in powers))
    u = np.arange(2**20).astype(np.float32) / np.float32(2**20)
    numbers, chances, rests = np.zeros(len(u), np.int64), np.zeros(len(u), np.float32), np.zeros(len(u), np.float32)
    pick_many(table.words, u, numbers, chances, rests)
    cdf = np.diff(table.arrays["cdf"].astype(np.float64))
    assert cdf.sum() == 1
    assert cdf.min() >= 0.9e-3 / (len(powers) + 1)
    assert np.array_equal(chances, cdf[numbers].astype(np.float32))
    assert np.abs(np.bincount(numbers, minlength=len(powers)) - cdf * len(u)).max() <= 1
    assert rests.min() >= 0
    assert rests.max() < 1 + 1e-6
    share = np.array(powers, float) / max(sum(powers), 1e-300)
    assert np.abs(cdf - share).max() < 2.1e-3


def test_chances_of_very_many_lights_are_whole_multiples_of_the_steps_of_random_numbers():
    """Two hundred thousand lights of unequal power and a weak one behind them: no chance is 0 or off by rounding."""
    table = LightTable()
    for power in np.random.default_rng(1).random(200_000) ** 8:
        table._add(emitter.SUN, float(power))
    table._add(emitter.SUN, 1e-12)
    steps = np.diff(table.build(1.0).arrays["cdf"].astype(np.float64)) * 2**24
    assert np.array_equal(steps, np.rint(steps))
    assert steps.min() >= 1
    assert steps.sum() == 2**24


# --- the sky --------------------------------------------------------------------------------------


def sky_of(pixels: np.ndarray, rotation: float = 0.0, constant: float = 0.0) -> Packed:
    lights = [iso.Environment(iso.ImageTexture(pixels.astype(np.float32)), rotation=rotation)]
    if constant:
        lights.append(iso.Sky(strength=constant))
    return table_of(*lights).arrays["environment"]


def pictures() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(3)
    spot = np.zeros((16, 32, 3))
    spot[5, 20] = (50, 40, 30)
    pole = np.zeros((16, 32, 3))
    pole[0] = 1
    return {
        "noise": rng.random((16, 32, 3)) ** 4,
        "spot": spot,
        "pole": pole,
        "corner": np.eye(8)[:, :, None] * np.ones(3),
        "single": np.full((1, 1, 3), 2.0),
    }


def solid_angles(rows: int, columns: int) -> np.ndarray:
    """Of small equal steps of v and u: sinθ dθ dφ."""
    sines = np.sin(np.pi * (np.arange(rows) + 0.5) / rows)
    return np.repeat(sines[:, None], columns, axis=1) * 2 * np.pi**2 / (rows * columns)


@pytest.mark.parametrize("name", pictures())
@pytest.mark.parametrize(("rotation", "constant"), [(0.0, 0.0), (1.1, 0.2)])
def test_sky_is_sampled_by_the_density_it_claims(name, rotation, constant):
    picture = pictures()[name]
    height, width = picture.shape[:2]
    packed = sky_of(picture, rotation, constant)
    directions, densities = np.zeros((COUNT, 3), np.float32), np.zeros(COUNT, np.float32)
    radiances = np.zeros((COUNT, 3), np.float32)
    sky_many(packed.words, SQUARE, directions, densities, radiances)
    assert np.abs(np.linalg.norm(directions.astype(np.float64), axis=1) - 1).max() < 1e-6
    # Cells of a third of a texel each way, counted by the documented convention.
    rows, columns = 3 * height, 3 * width
    uv = direction_to_uv(directions, rotation)
    found = np.histogram2d(1 - uv[:, 1], uv[:, 0], bins=(rows, columns), range=[[0, 1], [0, 1]])[0]
    fine = 4
    v, u = np.meshgrid(
        (np.arange(rows * fine) + 0.5) / (rows * fine),
        (np.arange(columns * fine) + 0.5) / (columns * fine),
        indexing="ij",
    )
    centres = uv_to_direction(np.stack([u, 1 - v], 2).reshape(-1, 2), rotation).astype(np.float32)
    claimed, colours = np.zeros(len(centres), np.float32), np.zeros((len(centres), 3), np.float32)
    look_up_sky(packed.words, centres, claimed, colours)
    weights = solid_angles(rows * fine, columns * fine)
    mass = (claimed.reshape(weights.shape) * weights).reshape(rows, fine, columns, fine).sum(axis=(1, 3))
    assert mass.sum() == pytest.approx(1, abs=2e-3)
    assert chi_square_deviation(found, COUNT * mass / mass.sum()) < 3.72
    # What the sky sends in all, by samples and by midpoints.
    total = (radiances.astype(np.float64) / densities[:, None]).mean(axis=0)
    assert np.allclose(total, (colours * weights.reshape(-1, 1)).sum(axis=0), rtol=5e-3)


@pytest.mark.parametrize("rotation", [0.0, -2.0, 4.0])
def test_sky_is_looked_up_bilinearly_by_longitude_and_latitude(rotation):
    picture = pictures()["noise"]
    height, width = picture.shape[:2]
    directions = np.random.default_rng(5).normal(size=(5000, 3)).astype(np.float32)
    densities, radiances = np.zeros(5000, np.float32), np.zeros((5000, 3), np.float32)
    packed = sky_of(picture, rotation)
    look_up_sky(packed.words, directions, densities, radiances)
    u, v = direction_to_uv(directions, rotation).T
    x, y = u * width - 0.5, (1 - v) * height - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = (x - i)[:, None], (y - j)[:, None]
    above, below = np.clip(j, 0, height - 1), np.clip(j + 1, 0, height - 1)
    wanted = (1 - b) * ((1 - a) * picture[above, i % width] + a * picture[above, (i + 1) % width])
    wanted = wanted + b * ((1 - a) * picture[below, i % width] + a * picture[below, (i + 1) % width])
    assert np.abs(radiances - wanted).max() < 2e-4


def test_a_sun_in_a_picture_over_a_pale_sky_leaves_no_direction_without_density():
    """Shares of dark texels vanish beside a sun's; samples that rounding throws there must not count as exact."""
    picture = np.full((256, 512, 3), 1e-3)
    picture[60, 100] = 1e7
    lights = table_of(iso.Environment(iso.ImageTexture(picture.astype(np.float32))))
    samples = Samples(lights, 0, (0.0, 0.0, 0.0))
    assert not (samples.density == 0).any()
    arrives = samples.density > 0
    assert arrives.mean() > 0.999
    same = np.isclose(samples.again[arrives], samples.density[arrives], rtol=1e-4)
    # Rounding may move a direction on the line between two texels.
    assert same.mean() > 0.999
