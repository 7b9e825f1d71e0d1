"""Normal maps: what they turn, what they leave, and that no light is made or lost by them."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso
from isophote.lower.lights import rectangle_mesh

_CAMERA = iso.Camera(eye=(0, 0, 5), target=(0, 0, 0), fov_degrees=40)
_MODELS = Path(__file__).parents[1] / "../shared/models"
_SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)


def _map(*normal: float) -> iso.ImageTexture:
    """One normal everywhere."""
    unit = np.array(normal) / np.linalg.norm(normal)
    return iso.ImageTexture(((unit + 1) / 2).astype(np.float32).reshape(1, 1, 3), "linear", "repeat", "nearest")


_FLAT = iso.ImageTexture(np.array([[[0.5, 0.5, 1.0]]], np.float32), "linear")


def _card(uv: npt.NDArray[np.float64] = _SQUARE) -> iso.Mesh:
    return iso.Mesh([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]], attributes={"uv": uv})


def _seen(
    shape: object,
    material: iso.Material,
    method: object = None,
    lights: object = None,
    camera: iso.Camera = _CAMERA,
    size: tuple[int, int] = (16, 12),
    transform: iso.Transform | None = None,
) -> dict[str, npt.NDArray[np.float32]]:
    item = iso.Item(shape, material, iso.Transform.identity() if transform is None else transform)
    scene = iso.Scene([item], [iso.PointLight((1, 2, 3), 100)] if lights is None else lights, camera)
    return iso.render(scene, method or iso.RayTrace(), size=size).channels


_BASES = [
    iso.Matte("tomato"),
    iso.Plastic("tomato", 0.4),
    iso.Principled("gold", metallic=1.0, roughness=0.4),
    iso.Mirror(),
    iso.Glass(roughness=0.4),
    iso.Glass.tinted((0.5, 0.9, 0.5), at=0.5),
    iso.Ward("tomato", roughness=(0.2, 0.5)),
]


@pytest.mark.parametrize("base", _BASES)
@pytest.mark.parametrize("method", [iso.RayTrace(), iso.PathTrace(samples=16)])
def test_a_flat_map_changes_nothing(base: iso.Material, method: object) -> None:
    shape, lights = iso.sphere(1), [iso.PointLight((1, 2, 3), 100), iso.Sky("white", 0.5)]
    plain = _seen(shape, base, method, lights)
    flat = _seen(shape, iso.NormalMap(base, _FLAT), method, lights)
    # Mirrors that are compiled into the tiles round in another way.
    np.testing.assert_allclose(flat["colour"], plain["colour"], rtol=2e-4, atol=1e-6)
    np.testing.assert_array_equal(flat["normal"], plain["normal"])


@pytest.mark.parametrize("way", [iso.RayTrace(), iso.PathTrace(samples=1)])
def test_the_normal_channel_shows_the_turned_normal(way: object) -> None:
    seen = _seen(_card(), iso.NormalMap(iso.Matte(), _map(0.6, 0.0, 0.8)), way)["normal"]
    np.testing.assert_allclose(seen[6, 8], [0.6, 0, 0.8], atol=1e-6)
    seen = _seen(_card(), iso.Principled(normal_texture=_map(0.0, -0.6, 0.8)), way)["normal"]
    np.testing.assert_allclose(seen[6, 8], [0, -0.6, 0.8], atol=1e-6)


def test_scale_stretches_the_map_along_the_surface() -> None:
    seen = _seen(_card(), iso.NormalMap(iso.Matte(), _map(0.6, 0.0, 0.8), scale=2.0))["normal"][6, 8]
    expected = np.array([1.2, 0, 0.8])
    np.testing.assert_allclose(seen, expected / np.linalg.norm(expected), atol=1e-6)
    seen = _seen(_card(), iso.Principled(normal_texture=_map(0.6, 0.0, 0.8), normal_scale=-1.0))["normal"][6, 8]
    np.testing.assert_allclose(seen, [-0.6, 0, 0.8], atol=1e-6)


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_map_goes_with_the_texture_coordinates(mirrored: bool) -> None:
    angle = 0.7
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    uv = _SQUARE @ turn.T * ([1, -1] if mirrored else [1, 1])
    seen = _seen(_card(uv), iso.NormalMap(iso.Matte(), _map(0.48, 0.36, 0.8)))["normal"][6, 8]
    # ∂P/∂u and ∂P/∂v of texture coordinates (u, v) = turn (x, y), v mirrored or not.
    u, v = turn[0], turn[1] * (-1 if mirrored else 1)
    np.testing.assert_allclose(seen[:2], 0.48 * u + 0.36 * v, atol=1e-5)
    np.testing.assert_allclose(seen[2], 0.8, atol=1e-5)


@pytest.mark.parametrize("factors", [(1, 1, 1), (0.7, 0.7, 0.7), (-1, 1, 1), (1, -1, 1), (-0.5, 0.5, -0.5)])
@pytest.mark.parametrize("copies", [1, 2])
def test_the_map_moves_with_the_item(factors: tuple[float, float, float], copies: int) -> None:
    # Many triangles, so that copies become instances.
    u, v = (a.reshape(-1) for a in np.meshgrid(np.linspace(0, 1, 190), np.linspace(0, 1, 190), indexing="ij"))
    i = np.arange(189 * 190).reshape(189, 190)[:, :-1].reshape(-1)
    faces = np.concatenate([np.stack([i, i + 190, i + 191], 1), np.stack([i, i + 191, i + 1], 1)])
    attributes = {"uv": np.stack([u, v], 1), "normal": np.tile([0.0, 0.0, 1.0], (len(u), 1))}
    mesh = iso.Mesh(np.stack([2 * u - 1, 2 * v - 1, 0 * u], 1), faces, attributes=attributes)
    turn = iso.Transform.identity().scale(factors).rotate("z", 0.4).rotate("y", 0.5)
    material = iso.NormalMap(iso.Matte(), _map(0.48, 0.36, 0.8))
    items = [iso.Item(mesh, material, turn)]
    items += [iso.Item(mesh, material, turn.translate((9.0 * k, 0, -50))) for k in range(1, copies)]
    scene = iso.Scene(items, [iso.PointLight((1, 2, 3), 100)], _CAMERA)
    seen = iso.render(scene, iso.RayTrace(), size=(16, 12)).channels["normal"][6, 8]
    linear = turn.matrix[:3, :3]
    # The relief is carried along: its tangent and bitangent by the transform, its normal to the side that is seen.
    t, b = linear @ [1, 0, 0], linear @ [0, 1, 0]
    n = np.linalg.inv(linear).T @ [0, 0, 1]
    t, b, n = (a / np.linalg.norm(a) for a in (t, b, n))
    expected = 0.48 * t + 0.36 * b + 0.8 * n
    expected *= np.sign(expected[2]) if abs(expected[2]) > 0.2 else 1
    np.testing.assert_allclose(seen, expected, atol=1e-4)


def test_round_primitives_have_tangents_around_their_axis() -> None:
    seen = _seen(iso.sphere(1), iso.NormalMap(iso.Matte(), _map(0.6, 0.0, 0.8)))["normal"][6, 8]
    # Where (x, y, z) is the normal, u grows along (z, 0, −x).
    x, y, z = _seen(iso.sphere(1), iso.Matte())["normal"][6, 8]
    expected = 0.6 * np.array([z, 0, -x]) / np.hypot(x, z) + 0.8 * np.array([x, y, z])
    np.testing.assert_allclose(seen, expected, atol=1e-5)


_TILTS = [(0.3, 0.1, 1.0), (1.0, 0.0, 0.5), (2.0, 1.0, 0.5)]


@pytest.mark.parametrize("tilt", _TILTS)
@pytest.mark.parametrize("base", [iso.Matte(1.0), iso.Mirror(), iso.Principled(1.0, metallic=1.0, roughness=0.5)])
def test_under_a_white_sky_white_stays_white(tilt: tuple[float, float, float], base: iso.Material) -> None:
    # Of glTF's metal, Schlick's approximation and a table are off by as much.
    tolerance = 0.03 if isinstance(base, iso.Principled) else 1e-3
    # From above, and so flat that some facets look away: from every side.
    for eye in ((0, 0, 5), (4.8, 0, 1.2), (-4.8, 0, 1.2), (0, 4.9, 0.8)):
        camera = iso.Camera(eye=eye, target=(0, 0, 0), fov_degrees=5, up=(0, 1, 0.1))
        material = iso.NormalMap(base, _map(*tilt))
        seen = _seen(_card(), material, iso.PathTrace(samples=1024), [iso.Sky("white", 1.0)], camera, (4, 3))["colour"]
        assert seen.mean() == pytest.approx(1.0, abs=tolerance)


@pytest.mark.parametrize(
    "base", [iso.Matte(0.8), iso.Principled("gold", metallic=1.0, roughness=0.5), iso.Plastic("tomato", 0.3)]
)
def test_light_that_is_aimed_at_and_met_is_the_same(base: iso.Material) -> None:
    # A cut-out of opacity 1 that shines is met by chance alone.
    material = iso.NormalMap(base, _map(0.35, 0.15, 0.9))
    lamp = iso.RectLight(size=(3, 3), radiance=(2, 2, 2)).at((2, 1, 3), target=(0, 0, 0))
    turned = iso.Item(rectangle_mesh(lamp), iso.Cutout(iso.Emitter(2.0), 1.0), lamp.transform)
    card = iso.Item(_card(), material)
    method, camera = (
        iso.PathTrace(samples=4096, max_depth=2),
        iso.Camera(eye=(0, 0, 5), target=(0, 0, 0), fov_degrees=4),
    )
    aimed = iso.render(iso.Scene([card], [lamp], camera), method, size=(4, 3)).channels["colour"]
    met = iso.render(iso.Scene([card, turned], [iso.Sky("white", 0.0)], camera), method, size=(4, 3)).channels["colour"]
    np.testing.assert_allclose(met.mean(axis=(0, 1)), aimed.mean(axis=(0, 1)), rtol=0.02)


def test_maps_lie_inside_coats_and_mixtures() -> None:
    lean = iso.NormalMap(iso.Matte(0.8), _map(0.6, 0.0, 0.8))
    alone, none = _seen(_card(), lean)["colour"], _seen(_card(), iso.Matte(0.8))["colour"]
    mixed = _seen(_card(), iso.Mix(lean, iso.Matte(0.8), 0.25))["colour"]
    np.testing.assert_allclose(mixed, 0.75 * alone + 0.25 * none, rtol=1e-4, atol=1e-6)
    # A coat of index 1 or nearly so is none, and stays flat where its base is not.
    coated = _seen(_card(), iso.Coated(lean, ior=1.0001))["colour"]
    np.testing.assert_allclose(coated, alone, rtol=1e-3, atol=1e-6)


def test_nothing_that_can_be_seen_is_black() -> None:
    # A mirror-like relief on a sphere, lit by a sky alone, out to its rim.
    generator = np.random.default_rng(1)
    texels = generator.uniform(0.2, 0.8, (16, 16, 3)).astype(np.float32)
    texels[..., 2] = 0.9
    bumpy = iso.NormalMap(iso.Matte(0.8), iso.ImageTexture(texels, "linear"))
    seen = _seen(iso.sphere(1), bumpy, iso.PathTrace(samples=64, max_depth=4), [iso.Sky("white", 1.0)], size=(48, 36))
    on = seen["item"] == 0
    assert on.sum() > 200
    assert seen["colour"][on].min() > 0.45
    assert seen["colour"].max() < 1.05


def test_a_real_model_with_a_normal_map() -> None:
    path = _MODELS / "gltf/TwoSidedPlane/TwoSidedPlane.gltf"
    if not path.exists():
        pytest.skip("the model is not there")
    scene = iso.load_scene(path)
    item = scene.items[0]
    assert isinstance(item.material, iso.Principled)
    assert item.material.normal_texture is not None
    # Its relief is fine, and means of it over pixels finer still.
    item = item.with_(material=attrs.evolve(item.material, normal_scale=20.0))
    scene, flat = scene.with_(items=[item]), item.with_(material=iso.Matte())
    camera = iso.studio(scene).camera
    with_map = iso.render(iso.studio(scene.with_(camera=camera)), iso.RayTrace(), size=(64, 48)).channels["normal"]
    without = iso.render(iso.studio(iso.Scene([flat], camera=camera)), iso.RayTrace(), size=(64, 48)).channels["normal"]
    there = np.isfinite(without).all(axis=2) & (np.abs(without).sum(axis=2) > 0)
    lean = (with_map * without).sum(axis=2)[there]
    assert lean.min() < 0.99
    assert lean.mean() > 0.9
    np.testing.assert_allclose(np.linalg.norm(with_map[there], axis=1), 1, atol=1e-5)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: iso.NormalMap(iso.Matte(), iso.ImageTexture(np.zeros((2, 2, 3), np.uint8))), "colour_space='linear'"),
        (lambda: iso.NormalMap(iso.Matte(), "blue"), "texture must be a Texture"),
        (lambda: iso.NormalMap(iso.Cutout(iso.Matte(), 0.5), _FLAT), r"Cutout\(NormalMap"),
        (lambda: iso.NormalMap(iso.Emitter(1.0), _FLAT), "Emitter"),
        (lambda: iso.NormalMap(iso.NormalMap(iso.Matte(), _FLAT), _FLAT), "is turned by a NormalMap already"),
        (lambda: iso.NormalMap(iso.Matte(), _FLAT, scale=float("nan")), "scale"),
    ],
)
def test_bad_normal_maps_are_named(make: object, message: str) -> None:
    with pytest.raises(iso.SceneError, match=message):
        make()  # type: ignore[operator]
