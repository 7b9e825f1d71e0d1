"""Textures that are formulas, in pictures and at places: patterns, mixtures, ramps, spaces, and what is refused."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso

Floats = npt.NDArray[np.float64]

RNG = np.random.default_rng(3)
PLACES = RNG.uniform(-4, 4, (500, 3)).astype(np.float32)


def red(texture: iso.Texture, own: npt.ArrayLike = PLACES, **more: npt.ArrayLike) -> npt.NDArray[np.float32]:
    return iso.texture_values(texture, own=own, **more)[:, 0]


def picture(items: list[iso.Item], camera: iso.Camera, method: object = None) -> npt.NDArray[np.float32]:
    """The albedo that is seen."""
    scene = iso.Scene(items, [iso.Sky("white", 1.0)], camera)
    return iso.render(scene, method or iso.PathTrace(samples=1), size=(48, 36), seed=1).channels["albedo"]


def test_checkers_alternate_along_all_axes() -> None:
    cells = np.floor(PLACES + 2.0**-10).sum(axis=1) % 2
    expected = np.where(cells[:, None] == 0, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    found = iso.texture_values(iso.Checker((1, 0, 0), (0, 0, 1)), own=PLACES)
    np.testing.assert_array_equal(found[:, :3], expected)


def test_ground_with_checkers_has_one_colour_in_each_square() -> None:
    ground = iso.Item(iso.plane(), iso.Matte(iso.Checker("white", "black")))
    seen = picture([ground], iso.Camera((0.5, 3, 0.5), (0.5, 0, 0.5), up=(0, 0, -1), fov_degrees=12))
    np.testing.assert_array_equal(seen, 1.0)


@pytest.mark.parametrize("shape", [iso.box(1.0), iso.to_mesh(iso.box(1.0), cell=0.2)], ids=["field", "mesh"])
def test_patterns_go_with_their_item(shape: iso.Field | iso.Mesh) -> None:
    noise = iso.Matte(iso.PerlinNoise(size=0.3))
    turn = iso.Transform.identity().rotate((1, 2, 3), 0.8).translate((5, -2, 1))
    eye, target = turn.apply([[2, 1.5, 2.5], [0, 0, 0]])
    moved = iso.Camera(eye, target, up=turn.matrix[:3, 1], fov_degrees=35)
    still = iso.Camera((2, 1.5, 2.5), (0, 0, 0), fov_degrees=35)
    here = picture([iso.Item(shape, noise)], still)
    there = picture([iso.Item(shape, noise, turn)], moved)
    assert here.std() > 0.02
    # Both have their own rounding, and pixels at edges may see one face or the other.
    assert np.median(np.abs(here - there)) < 1e-5
    assert (np.abs(here - there) > 1e-3).mean() < 0.01


PROFILES: dict[str, Callable[[Floats], Floats]] = {
    "sine": lambda x: 0.5 + 0.5 * np.sin(2 * np.pi * x),
    "saw": lambda x: x - np.floor(x),
    "triangle": lambda x: 1 - np.abs(2 * (x - np.floor(x)) - 1),
    "square": lambda x: (x - np.floor(x) < 0.3).astype(float),
}
ACROSS: dict[str, tuple[iso.Texture, Callable[[Floats], Floats]]] = {
    "checker": (iso.Checker(0.0, 1.0, 0.7), lambda p: np.floor(p / 0.7 + 2.0**-10).sum(axis=-1) % 2),
    "stripes": (iso.Stripes(1.0, 0.0, 0.7, "z", 0.2), lambda p: (p[..., 2] / 0.7 % 1 < 0.2).astype(float)),
    "grid": (
        iso.Grid(1.0, 0.0, 0.7, 0.2, "xz"),
        lambda p: (np.abs((p[..., ::2] / 0.7 + 0.5) % 1 - 0.5) < 0.1).any(axis=-1).astype(float),
    ),
} | {
    name: (iso.Waves("linear", name, 0.7, "z", share=0.3), lambda p, profile=profile: profile(p[..., 2] / 0.7))
    for name, profile in PROFILES.items()
}


@pytest.mark.parametrize("name", ACROSS)
def test_patterns_are_what_they_are_told_to_be(name: str) -> None:
    texture, formula = ACROSS[name]
    found, expected = red(texture), formula(PLACES.astype(np.float64))
    # Rounding may put a place on the other side of a border.
    assert (np.abs(found - expected) > 2e-5).mean() < 0.005


@pytest.mark.parametrize("name", ACROSS)
def test_patterns_are_averaged_over_what_is_seen(name: str) -> None:
    """Beside means of 10,000 samples over rectangles along the axes, from narrow to wider than many periods."""
    texture, formula = ACROSS[name]
    count = 60
    own = PLACES[:count].astype(np.float64)
    half = np.exp(RNG.uniform(np.log(0.01), np.log(4), (count, 2)))
    axes = np.zeros((count, 2, 3))
    axes[:, 0, 0], axes[:, 1, 2] = half.T
    # Points that fill the square evenly, by multiples of two irrational numbers (Roberts 2018).
    x, z = 2 * ((np.arange(10_000)[:, None] * (0.7548776662466927, 0.5698402909980532)) % 1).T - 1
    offsets = np.stack([x, 0 * x, z], axis=-1)
    means = [formula(p + offsets * (h[0], 0, h[1])).mean() for p, h in zip(own, half, strict=True)]
    np.testing.assert_allclose(red(texture, own, own_axes=axes), means, atol=0.004)


def test_checkers_seen_from_afar_are_grey() -> None:
    axes = np.array([[30.2, 0, 0.7], [0.3, 0, 25.1]])
    np.testing.assert_allclose(red(iso.Checker(0.0, 1.0), own_axes=axes), 0.5, atol=1e-3)


@pytest.mark.parametrize("axis", ["x", "y", "z", (1, 2, -2)])
def test_coordinates_of_gradients(axis: object) -> None:
    unit = np.array({"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}.get(axis, np.array((1, 2, -2)) / 3))  # type: ignore[call-overload]
    p = PLACES.astype(np.float64)
    along = p @ unit
    away = np.linalg.norm(p - along[:, None] * unit, axis=1)
    grey = [(-20, 0.0), (20, 40.0)]
    for shape, expected in (("linear", along), ("radial", away), ("spherical", np.linalg.norm(p, axis=1))):
        found = red(iso.Gradient(grey, shape, axis, 0.5)) - 20
        np.testing.assert_allclose(found, expected / 0.5, atol=2e-5, err_msg=shape)
    # Around the axis, a turn by an angle adds that angle.
    angle = 0.3
    turned = iso.Transform.identity().rotate(axis, angle).apply(p)
    added = red(iso.Gradient(grey, "angular", axis), turned) - red(iso.Gradient(grey, "angular", axis))
    np.testing.assert_allclose((added + 0.5) % 1 - 0.5, angle / (2 * np.pi), atol=1e-4)


def test_ramps_are_straight_smooth_or_constant_between_stops() -> None:
    stops = [(0.2, 0.1), (0.5, 0.9), (0.5, 0.3), (0.8, 0.6)]
    t = np.linspace(0.002, 0.998, 250)
    number = iso.Waves("linear", "saw")
    places = np.stack([t, 0 * t, 0 * t], axis=1)
    share = np.clip((t - 0.2) / 0.3, 0, 1), np.clip((t - 0.5) / 0.3, 0, 1)
    for between, bent in (("linear", lambda s: s), ("smooth", lambda s: s * s * (3 - 2 * s))):
        expected = np.where(t < 0.5, 0.1 + 0.8 * bent(share[0]), 0.3 + 0.3 * bent(share[1]))
        np.testing.assert_allclose(red(iso.Ramp(number, stops, between), places), expected, atol=4e-6)
    expected = np.where(t < 0.5, 0.1, np.where(t < 0.8, 0.3, 0.6))
    np.testing.assert_allclose(red(iso.Ramp(number, stops, "constant"), places), expected, atol=1e-6)


EVERYWHERE = [
    *(
        iso.Checker(size=1e-6),
        iso.Stripes(size=1e-6),
        iso.Grid(size=1e-6),
        iso.Gradient(shape="radial"),
        iso.Waves(size=1e-6),
    ),
    *(noise(size=1e-6) for noise in (iso.ValueNoise, iso.PerlinNoise, iso.SimplexNoise, iso.WorleyNoise)),
    *(iso.Fbm(kind=kind) for kind in ("fbm", "turbulence", "ridged")),
    *(iso.Marble(), iso.Wood(), iso.PerlinNoise(transform=iso.Transform.identity().scale(1e-6))),
]


@pytest.mark.parametrize("texture", EVERYWHERE, ids=repr)
def test_textures_are_colours_however_far_away(texture: iso.Texture) -> None:
    far = np.array([[1e7, -3e8, 2e9], [1e15, 1, -1e20], [3e38, -3e38, 3e38], [-1e30, 1e-30, 0]], np.float32)
    for axes in (0.0, np.full((2, 3), 1e-3), np.full((2, 3), 1e30)):
        found = iso.texture_values(texture, own=far, own_axes=axes)
        assert np.isfinite(found).all()
        assert found.min() >= 0
        assert found.max() <= 1


def test_patterns_go_with_instances(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a mesh that is used often, and stored once in its own space."""
    monkeypatch.setattr("isophote.lower.geometry._BAKED_TRIANGLES", 0)
    mesh, noise = iso.to_mesh(iso.box(1.0), cell=0.5), iso.Matte(iso.PerlinNoise(size=0.3))
    left = iso.Item(mesh, noise).translate((-1, 0, 0))
    right = iso.Item(mesh, noise).translate((1, 0, 0))
    seen = [picture([left, right], iso.OrthographicCamera((x, 0, 5), (x, 0, 0), height=0.9)) for x in (-1.0, 1.0)]
    assert seen[0].std() > 0.02
    np.testing.assert_allclose(*seen, atol=1e-4)
