"""Reconstruction filters: their shapes, how offsets are drawn from them, what they make of edges and fine patterns."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import isophote as iso
from isophote.checks.statistics import chi_square_deviation
from isophote.errors import RenderError
from isophote.kernels.base.jit import kernel
from isophote.kernels.base.table import FLOATS, Table
from isophote.kernels.light.film import filter_offset, is_negative
from isophote.rendering.pixel_filter import FILTERS, filter_table
from scenes import WHITE_SKY, plane, render

NAMES = list(FILTERS)
CHOSEN = [iso.PixelFilter(name) for name in NAMES]
CHOSEN += [iso.PixelFilter("box", 1.5), iso.PixelFilter("gaussian", 1.2), iso.PixelFilter("lanczos", 2)]
SIGNED = ("mitchell", "lanczos")

OFFSETS = Table("Offsets", offsets=FLOATS, crossings=FLOATS, u=FLOATS, v=FLOATS, x=FLOATS, sign=FLOATS)
open_offsets = OFFSETS.open


@kernel
def draw_offsets(words):
    table = open_offsets(words)
    for i in range(table.u.rows):
        x = filter_offset(table.offsets, table.u[i])
        table.x[i] = x
        table.sign[i] = 1 - 2 * is_negative(table.crossings, x, filter_offset(table.offsets, table.v[i]))


def drawn(chosen: iso.PixelFilter, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Offsets along x, and the sign of f(x) f(y)."""
    table = filter_table(chosen)
    x, sign = np.zeros((2, len(u)), np.float32)
    arrays = {name: np.ascontiguousarray(a, np.float32) for name, a in (("u", u), ("v", v))}
    packed = OFFSETS.pack(offsets=table.offsets, crossings=table.crossings, x=x, sign=sign, **arrays)
    draw_offsets(packed.words)
    return x.astype(np.float64), sign.astype(np.float64)


def integral(chosen: iso.PixelFilter, low: float, high: float, *, absolute: bool = False) -> float:
    """Of f, or |f|, by the midpoint rule in pieces that end where f has a corner."""
    corners = np.arange(-64, 65) / 64 * chosen.reach
    ends = np.unique(np.clip(np.concatenate([[low, high], corners]), low, high))
    total = 0.0
    for a, b in pairwise(ends):
        value = chosen(a + (np.arange(256) + 0.5) / 256 * (b - a))
        total += float((np.abs(value) if absolute else value).mean() * (b - a))
    return total


# --- shapes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("chosen", CHOSEN, ids=str)
def test_filters_are_even_end_at_their_radius_and_have_an_integral_of_1(chosen):
    x = np.linspace(0, 1.2 * chosen.reach, 101)
    assert np.array_equal(chosen(x), chosen(-x))
    assert not chosen([chosen.reach, 1.1 * chosen.reach]).any()
    assert integral(chosen, -chosen.reach, chosen.reach) == pytest.approx(1, abs=2e-5)


def test_closed_forms():
    x = np.linspace(-1.99, 1.99, 200)
    a = np.abs(x)
    assert np.allclose(iso.PixelFilter("tent")(x), np.maximum(1 - a, 0), atol=1e-6)
    # Mitchell and Netravali's equation 8 for B = C = 1/3.
    b = c = 1 / 3
    near = (12 - 9 * b - 6 * c) * a**3 + (-18 + 12 * b + 6 * c) * a**2 + (6 - 2 * b)
    far = (-b - 6 * c) * a**3 + (6 * b + 30 * c) * a**2 + (-12 * b - 48 * c) * a + (8 * b + 24 * c)
    assert np.allclose(iso.PixelFilter("mitchell")(x), np.where(a < 1, near, far) / 6, atol=1e-6)
    gaussian = np.exp(-2 * x**2) * math.sqrt(2 / math.pi) / math.erf(2 * math.sqrt(2))
    assert np.allclose(iso.PixelFilter("gaussian")(x), gaussian, atol=1e-6)
    places = [0.5, 1, 1.5, 2, 2.5]
    sines = [9 * math.sin(math.pi * p) * math.sin(math.pi * p / 3) / (3 * (math.pi * p) ** 2) for p in places]
    lanczos = iso.PixelFilter("lanczos")(places)
    assert np.allclose(lanczos / lanczos[0], np.array(sines) / sines[0], atol=1e-6)
    # Of the four cosines two sum to nothing at half the radius.
    harris = iso.PixelFilter("blackman-harris", 2)([0, 1])
    assert harris[1] / harris[0] == pytest.approx(0.35875 - 0.14128, abs=1e-6)


@pytest.mark.parametrize("name", ["box", "tent", "mitchell"])
def test_shifted_filters_add_up_to_one(name):
    """Partition of unity, exact for box, tent and Mitchell's: flat colours stay flat however samples lie."""
    x = np.linspace(0, 1, 41)[:-1] - 0.49
    total = sum(iso.PixelFilter(name)(x + k) for k in range(-3, 4))
    assert np.allclose(total, 1, atol=1e-6)
    softer = iso.PixelFilter("gaussian", 2)
    assert np.abs(sum(softer(x + k) for k in range(-3, 4)) - 1).max() < 0.02


# --- offsets --------------------------------------------------------------------------------------


@pytest.mark.parametrize("chosen", CHOSEN, ids=str)
def test_offsets_are_distributed_as_the_absolute_value(chosen):
    """Chi-square over 64 bins, and the share of negative pairs."""
    rng = np.random.default_rng(3)
    u, v = np.minimum(rng.random((2, 400_000)), 1 - 2.0**-24)
    x, sign = drawn(chosen, u, v)
    edges = np.linspace(-chosen.reach, chosen.reach, 65)
    edges[[0, -1]] = -chosen.reach - 1e-6, chosen.reach + 1e-6
    expected = np.array([integral(chosen, a, b, absolute=True) for a, b in pairwise(edges)])
    whole = expected.sum()
    assert abs(chi_square_deviation(np.histogram(x, edges)[0], expected / whole * len(x))) < 4.5
    # ∫∫ f f = 1 of ∫∫ |f f| = whole²: negative pairs have the share (1 − 1/whole²) / 2.
    share = max(0.0, (1 - 1 / whole**2) / 2)
    assert (sign < 0).mean() == pytest.approx(share, abs=4.5 * math.sqrt(share * (1 - share) / len(x)) + 2e-4)
    excess = filter_table(chosen).excess
    assert excess == pytest.approx((whole**2 - 1) / 2, abs=1e-4)
    assert (excess > 0) == (chosen.name in SIGNED)


@pytest.mark.parametrize("chosen", CHOSEN, ids=str)
def test_offsets_grow_with_the_number_from_end_to_end(chosen):
    u = np.concatenate([[0], np.sort(np.random.default_rng(1).random(2000)), [1 - 2.0**-24]]).astype(np.float32)
    x, _ = drawn(chosen, u, np.full(len(u), 0.5))
    assert (np.diff(x) >= 0).all()
    assert x[0] == pytest.approx(-chosen.reach)
    assert x[-1] == pytest.approx(chosen.reach, abs=0.02 * chosen.reach)
    # Numbers are below 1; tables end there.
    turned = np.minimum(1 - u, u[-1])
    assert np.allclose(x, -drawn(chosen, turned, np.full(len(u), 0.5))[0], atol=2e-2 * chosen.reach)


# --- pictures -------------------------------------------------------------------------------------

EDGE = iso.Item(plane(40), iso.Emitter((1, 1, 1))).translate((-20, 0, 0))
FLAT = iso.OrthographicCamera((0, 3, 0), (0, 0, 0), up=(0, 0, -1), height=1)


@pytest.mark.parametrize("chosen", CHOSEN, ids=str)
@pytest.mark.parametrize("samples", [1, 2, 5, 64])
def test_a_flat_colour_stays_as_it_is(chosen, samples):
    floor = iso.Item(plane(20), iso.Matte((0.5, 0.25, 0.125)))
    image = render([floor], [WHITE_SKY], FLAT, samples=samples, filter=chosen, max_depth=2)
    assert np.allclose(image.channels["colour"], (0.5, 0.25, 0.125), rtol=1e-5)


@pytest.mark.parametrize("chosen", CHOSEN, ids=str)
def test_an_edge_is_blurred_by_the_filter(chosen):
    """The edge lies in the middle of column 6: what a pixel sees is the integral of its filter beyond the edge."""
    camera = iso.OrthographicCamera((0, 3, 0), (0, 0, 0), up=(0, 0, -1), height=1)
    image = render([EDGE], (), camera, size=(13, 13), samples=2048, filter=chosen)
    profile = image.channels["colour"][..., 0].astype(np.float64).mean(axis=0)
    wanted = [integral(chosen, -chosen.reach, float(np.clip(6 - x, -chosen.reach, chosen.reach))) for x in range(13)]
    assert np.abs(profile - wanted).max() < 2e-3
    if chosen.name in SIGNED:
        # A bright line on the bright side, a dark one, below black, on the dark side.
        assert profile[:6].max() > 1.01
        assert profile[7:].min() < -0.01
    else:
        assert profile.min() >= 0
        assert profile.max() <= 1 + 1e-6


@pytest.mark.parametrize("name", SIGNED)
def test_the_variance_of_signed_filters_is_that_of_the_pixel(name):
    """Over 400 pictures of independent samples, against what each tells of itself."""
    floor = iso.Item(plane(20), iso.Matte((0.5, 0.5, 0.5)))
    wall = iso.Item(plane(3), iso.Matte((0.9, 0.9, 0.9))).rotate("z", math.pi / 2).translate((0.3, 0, 0))
    camera = iso.Camera((0, 2, 3), (0, 0.2, 0))
    pictures = [
        render(
            [floor, wall], [WHITE_SKY], camera, samples=32, filter=name, pattern="independent", seed=seed, size=(6, 6)
        )
        for seed in range(400)
    ]
    colour = np.array([image.channels["colour"] for image in pictures], np.float64)
    told = np.array([image.channels["variance"] for image in pictures], np.float64).mean(axis=(0, 3))
    found = colour.var(axis=0, ddof=1).mean(axis=2)
    seen = told > 1e-6
    assert seen.sum() > 10
    assert found[seen].sum() / told[seen].sum() == pytest.approx(1, abs=0.1)


def zone_plate(filter_name: str) -> np.ndarray:
    """Rings whose frequency, in cycles a pixel, is the distance from the middle: 1 at the picture's edges."""
    n, size = 1536, 96
    y, x = (np.mgrid[:n, :n] + 0.5) / n * 2 - 1
    rings = 0.5 + 0.5 * np.cos(np.pi * size / 2 * (x * x + y * y))
    texture = iso.ImageTexture(np.repeat(rings[..., None], 3, axis=2).astype(np.float32))
    corners = [(-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)]
    floor = iso.Mesh(corners, [(0, 1, 2, 3)], attributes={"uv": [(0, 1), (0, 0), (1, 0), (1, 1)]})
    camera = iso.OrthographicCamera((0, 3, 0), (0, 0, 0), up=(0, 0, -1), height=2)
    plate = iso.Item(floor, iso.Matte(texture))
    image = render([plate], [WHITE_SKY], camera, samples=256, filter=filter_name, size=(size, size), max_depth=2)
    return image.channels["colour"][..., 0].astype(np.float64)


def response(chosen: iso.PixelFilter, frequency: np.ndarray) -> np.ndarray:
    """Fourier transform of f, frequencies in cycles a pixel."""
    x = ((np.arange(4000) + 0.5) / 4000 * 2 - 1) * chosen.reach
    weights = chosen(x) * 2 * chosen.reach / 4000
    return np.cos(2 * np.pi * frequency[..., None] * x) @ weights


@pytest.mark.parametrize("name", NAMES)
def test_fine_rings_fade_as_the_filters_spectrum_says(name):
    """What pixels can show is kept, and finer rings turn grey instead of into false ones, as well as the filter can."""
    y, x = (np.mgrid[:96, :96] + 0.5) / 48 - 1
    chosen = iso.PixelFilter(name)
    wanted = response(chosen, x[0])[None, :] * response(chosen, y[:, 0])[:, None] / 2
    picture = zone_plate(name)
    for least, most in ((0.15, 0.3), (0.3, 0.45), (0.55, 0.7), (0.7, 0.85)):
        ring = (np.hypot(x, y) > least) & (np.hypot(x, y) < most)
        expected = np.sqrt((wanted[ring] ** 2).mean() / 2)
        assert picture[ring].std() == pytest.approx(expected, rel=0.05, abs=0.02)


# --- input ----------------------------------------------------------------------------------------


def test_names_and_radii_that_make_no_sense_are_refused():
    for name in ("sinc", "", None, 3):
        with pytest.raises(RenderError, match="filter"):
            iso.PixelFilter(name)
        with pytest.raises(RenderError, match="filter"):
            iso.PathTrace(filter=name)
    for radius in (0, -1, math.nan, math.inf, "wide", True, 1000):
        with pytest.raises(RenderError, match="radius"):
            iso.PixelFilter("tent", radius)
    with pytest.raises(RenderError, match="from 1 to 64"):
        iso.PixelFilter("lanczos", 0.5)


def test_filters_are_values():
    assert iso.PixelFilter("tent", 2) == iso.PixelFilter("tent", 2.0)
    assert eval(repr(iso.PixelFilter("lanczos", 2)), {"PixelFilter": iso.PixelFilter}) == iso.PixelFilter("lanczos", 2)
    assert iso.PathTrace(filter=iso.PixelFilter("box")).filter.reach == 0.5
