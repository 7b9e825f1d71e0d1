"""Bumps: their normals against those of surfaces that are displaced in truth, and on every kind of shape."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso

_CAMERA = iso.Camera(eye=(0, 0, 5), target=(0, 0, 0), fov_degrees=20)
_SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)


def _card(uv: npt.NDArray[np.float64] | None = _SQUARE) -> iso.Mesh:
    corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    return iso.Mesh(corners, [[0, 1, 2, 3]], attributes={} if uv is None else {"uv": uv})


def _normals(item: iso.Item, size: tuple[int, int] = (24, 18)) -> npt.NDArray[np.float32]:
    scene = iso.Scene([item], [iso.PointLight((1, 2, 3), 100)], _CAMERA)
    return iso.render(scene, iso.RayTrace(), size=size).channels["normal"]


def _picture(function: object, size: int = 512) -> iso.ImageTexture:
    u, v = np.meshgrid((np.arange(size) + 0.5) / size, 1 - (np.arange(size) + 0.5) / size)
    return iso.ImageTexture(function(u, v).astype(np.float32), "linear", "clamp")  # type: ignore[operator]


@pytest.mark.parametrize("angle", [0.0, 0.6, 2.5])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_ramp_turns_the_normal_by_its_slope(angle: float, mirrored: bool) -> None:
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    uv = (_SQUARE - 0.5) @ turn.T * ([1, -1] if mirrored else [1, 1]) / 2 + 0.5
    found = _normals(iso.Item(_card(uv), iso.Bump(iso.Matte(), _picture(lambda u, v: u), 2.0)))[9, 12]
    # The card is 2 wide, where u runs over 1/2: ∂u/∂P = 1/4 along the turned axis, and the height is 2 u.
    expected = np.array([-turn[0, 0] / 2, -turn[0, 1] / 2, 1])
    np.testing.assert_allclose(found, expected / np.linalg.norm(expected), atol=1e-4)


def test_small_bumps_have_the_normals_of_a_displaced_mesh() -> None:
    waves = _picture(lambda u, v: np.sin(4 * np.pi * u) * np.cos(6 * np.pi * v))
    for amplitude in (0.01, 0.04):
        # Pixels must be small beside the waves, since bumps are told over all of each.
        bumped = _normals(iso.Item(_card(), iso.Bump(iso.Matte(), waves, amplitude)), (192, 144))
        moved = _normals(iso.Item(iso.displace(_card(), waves, amplitude, edge=0.02), iso.Matte()), (192, 144))
        slopes = np.linalg.norm(bumped[..., :2], axis=2)
        assert slopes.max() > 3 * amplitude
        # To first order: what is left is of the second, and of the triangles.
        assert np.quantile(np.linalg.norm(bumped - moved, axis=2), 0.95) < 0.08 * slopes.max()


@pytest.mark.parametrize("factor", [1.0, 3.0])
def test_textures_of_space_need_no_texture_coordinates(factor: float) -> None:
    noise = iso.PerlinNoise()
    transform = iso.Transform.identity().scale(factor)
    scene = [iso.Item(shape, iso.Bump(iso.Matte(), noise, 0.2), transform) for shape in (_card(), _card(None))]
    with_uv, without = (_normals(item) for item in scene)
    np.testing.assert_allclose(with_uv, without, atol=1e-5)
    # The gradient of the noise at the pixel's place, which is told in the card's own space.
    y, x = (np.arange(18) - 8.5) / 9, (np.arange(24) - 11.5) / 9
    reach = 5 * np.tan(np.radians(10)) / factor
    places = np.stack([*np.meshgrid(x * reach, -y * reach), np.zeros((18, 24))], axis=2).reshape(-1, 3)
    step = 1e-3
    slopes = [
        (iso.texture_values(noise, own=places + e)[:, 0] - iso.texture_values(noise, own=places - e)[:, 0]) / (2 * step)
        for e in step * np.eye(3)[:2]
    ]
    expected = np.stack([-0.2 * slopes[0], -0.2 * slopes[1], np.ones(len(places))], axis=1)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    there = np.abs(places).max(axis=1) < 0.98
    assert there.sum() > 300
    np.testing.assert_allclose(without.reshape(-1, 3)[there], expected[there], atol=0.02)


@pytest.mark.parametrize("shape", [iso.sphere(0.7), iso.sphere(0.6).union(iso.box(0.9), blend=0.1)])
def test_primitives_and_fields_have_bumps(shape: object) -> None:
    plain = _normals(iso.Item(shape, iso.Matte()))
    bumped = _normals(iso.Item(shape, iso.Bump(iso.Matte(), iso.PerlinNoise(size=0.2), 0.05)))
    there = np.isfinite(plain).all(axis=2) & (np.linalg.norm(plain, axis=2) > 0.5)
    lean = (plain * bumped).sum(axis=2)[there]
    np.testing.assert_allclose(np.linalg.norm(bumped[there], axis=1), 1, atol=1e-5)
    assert 0.3 < lean.min() < 0.99
    assert lean.mean() > 0.8


def test_a_sphere_with_latitudes_is_turned_along_its_meridians() -> None:
    # v grows evenly from pole to pole, over π r: a ramp of it leans towards the lower pole.
    found = _normals(iso.Item(iso.sphere(0.7), iso.Bump(iso.Matte(), _picture(lambda u, v: v), 0.7 * np.pi)))
    plain = _normals(iso.Item(iso.sphere(0.7), iso.Matte()))
    up = np.array([0, 1, 0]) - plain * plain[..., 1:2]
    up /= np.linalg.norm(up, axis=2, keepdims=True)
    expected = plain - up
    expected /= np.linalg.norm(expected, axis=2, keepdims=True)
    middle = (slice(6, 12), slice(9, 15))
    np.testing.assert_allclose(found[middle], expected[middle], atol=0.03)


def test_even_heights_change_nothing() -> None:
    even = iso.ImageTexture(np.full((4, 4), 0.7, np.float32), "linear")
    for method in (iso.RayTrace(), iso.PathTrace(samples=4)):
        plain, bumped = (
            iso.render(
                iso.Scene([iso.Item(_card(), m)], [iso.PointLight((1, 2, 3), 100)], _CAMERA), method, size=(8, 6)
            )
            for m in (iso.Plastic("tomato"), iso.Bump(iso.Plastic("tomato"), even))
        )
        np.testing.assert_array_equal(bumped.channels["colour"], plain.channels["colour"])


@pytest.mark.parametrize("method", [iso.RayTrace(), iso.PathTrace(samples=64)])
def test_rippled_water_bends_light_and_keeps_it(method: object) -> None:
    water = iso.Glass(ior=1.33)
    rippled = iso.Bump(water, iso.PerlinNoise(size=0.3), 0.02)

    def seen(material: iso.Material) -> npt.NDArray[np.float32]:
        scene = iso.Scene([iso.Item(iso.box((2, 2, 1)), material)], [iso.Sky("white", 1.0)], _CAMERA)
        return iso.render(scene, method, size=(12, 9)).channels["colour"]

    np.testing.assert_allclose(seen(rippled).mean(), seen(water).mean(), atol=0.03)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: iso.Bump(iso.Matte(), 0.5), "height must be a Texture"),
        (lambda: iso.Bump(iso.Bump(iso.Matte(), iso.PerlinNoise()), iso.PerlinNoise()), "is turned by a Bump already"),
        (lambda: iso.Bump(iso.Emitter(1.0), iso.PerlinNoise()), "Emitter"),
        (lambda: iso.Bump(iso.Matte(), iso.PerlinNoise(), float("inf")), "scale"),
    ],
)
def test_bad_bumps_are_named(make: object, message: str) -> None:
    with pytest.raises(iso.SceneError, match=message):
        make()  # type: ignore[operator]
