"""Sixteen vectors at once, against NumPy, and lights as sixteen places see them, against one place after another."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.kernels.base.jit import kernel
from isophote.kernels.base.simd import splat16, square_root
from isophote.kernels.base.table import FLOAT_ROWS, Table
from isophote.kernels.base.vec import vec3
from isophote.kernels.base.wide import (
    load_lanes,
    load_wide,
    spread,
    store_lanes,
    store_wide,
    wide,
    wide_cross,
    wide_dot,
    wide_select,
)
from isophote.kernels.light.emitter import LIGHTS, sample_light
from isophote.kernels.light.emitter_lanes import sample_lanes, sampled_in_lanes
from isophote.lower.scene import lower_scene

LANES = 16
ROWS = Table("Rows", given=FLOAT_ROWS, found=FLOAT_ROWS)
open_rows, open_lights = ROWS.open, LIGHTS.open


@kernel
def arithmetic(words, column):
    table = open_rows(words)
    given, found = table.given, table.found
    a, b, s = load_wide(given, 0, column), load_wide(given, 3, column), load_lanes(given, 6, column)
    results = (a + b, a - b, a * b, a / b, a * s, a / s, wide_cross(a, b), spread(vec3(1, 2, 3)), wide(s, a.x, b.y))
    for k in range(9):
        store_wide(found, 3 * k, column, results[k])
    store_wide(found, 27, column, wide_select(a.x > s, a, b))
    store_lanes(found, 30, column, wide_dot(a, b))
    store_lanes(found, 31, column, square_root(wide_dot(a, a)) * splat16(2))


def test_vectors_by_lanes():
    rng = np.random.default_rng(1)
    given = rng.uniform(0.5, 2, (7, 40)).astype(np.float32) * rng.choice([-1, 1], (7, 40)).astype(np.float32)
    found = np.zeros((32, 40), np.float32)
    arithmetic(ROWS.pack(given=given, found=found).words, 5)
    assert not found[:, :5].any()
    assert not found[:, 5 + LANES :].any()
    here = given[:, 5 : 5 + LANES].astype(np.float64)
    a, b, s = here[:3], here[3:6], here[6]
    told = np.broadcast_to(np.array([[1.0], [2.0], [3.0]]), a.shape)
    cross = np.cross(a, b, axis=0)
    wanted = [a + b, a - b, a * b, a / b, a * s, a / s, cross, told, np.stack([s, a[0], b[1]])]
    wanted += [np.where(a[0] > s, a, b), (a * b).sum(axis=0)[None], 2 * np.linalg.norm(a, axis=0)[None]]
    assert np.allclose(found[:, 5 : 5 + LANES], np.concatenate(wanted), rtol=0, atol=3e-6)


@kernel
def both_ways(light_words, words, row, group, share):
    """Rows 0–2 places, 3–4 sample numbers. By lanes and one by one: direction, distance, arriving, factor."""
    lights, table = open_lights(light_words), open_rows(words)
    given, found = table.given, table.found
    u, v = load_lanes(given, 3, 0), load_lanes(given, 4, 0)
    into, distance, arriving, factor = sample_lanes(lights, row, load_wide(given, 0, 0), u, v, share)
    store_wide(found, 0, 0, into)
    store_lanes(found, 3, 0, distance)
    store_wide(found, 4, 0, arriving)
    store_lanes(found, 7, 0, factor)
    for k in range(LANES):
        one = sample_light(lights, row, vec3(given[0, k], given[1, k], given[2, k]), given[3, k], given[4, k])
        found[8, k], found[9, k], found[10, k], found[11, k] = one.x, one.y, one.z, one.distance
        found[12, k], found[13, k], found[14, k], found[15, k] = one.red, one.green, one.blue, one.density
    return sampled_in_lanes(lights, group)


LIT = {
    "rectangle": iso.RectLight(size=(2, 1), power=60).at((0.5, 1, 0.2)),
    "both sides": iso.RectLight(size=(1, 3), power=60, two_sided=True).at((0.5, 1, 0.2)),
    "point": iso.PointLight((0.3, 2, 1), 20),
    "sun": iso.Sun((1, 2, 3), 2),
}


def lit_by(light):
    scene = iso.Scene([iso.Item(iso.sphere())], [light], iso.Camera((0, 0, 5), (0, 0, 0)))
    return lower_scene(scene, (8, 8)).arrays["lights"]


@pytest.mark.parametrize("name", LIT)
def test_lights_by_lanes_are_those_one_by_one(name):
    lights = lit_by(LIT[name])
    given, found = np.zeros((5, LANES), np.float32), np.zeros((16, LANES), np.float32)
    rng = np.random.default_rng(2)
    given[:3], given[3:] = rng.uniform(-2, 2, (3, LANES)), rng.random((2, LANES))
    assert both_ways(lights.words, ROWS.pack(given=given, found=found).words, 0, 0, np.float32(0.25))
    density, factor = found[15], found[7]
    shines = density >= 0
    assert np.array_equal(shines, factor > 0)
    assert shines.sum() >= 4
    assert np.allclose(found[:7, shines], found[8:15, shines], rtol=2e-6, atol=1e-7)
    single = name in ("point", "sun")
    wanted = np.ones(LANES) if single else 0.25 / density
    assert np.allclose(factor[shines], wanted[shines], rtol=2e-6)


@pytest.mark.parametrize("light", [iso.SphereLight(power=3).at((0, 3, 0)), iso.DiskLight(power=3).at((0, 3, 0))])
def test_other_lights_go_one_by_one(light):
    given, found = np.zeros((5, LANES), np.float32), np.zeros((16, LANES), np.float32)
    assert not both_ways(lit_by(light).words, ROWS.pack(given=given, found=found).words, 0, 0, np.float32(1))
