"""Materials in path-traced pictures: light aimed at and met by chance, furnaces, tangents, textures, glowing."""

from __future__ import annotations

import math

import numpy as np
import pytest

import isophote as iso
from isophote.checks.materials import WHITE, probe_of
from reflectances import GLASSES, MATTE_OR_GLOSSY
from scenes import WHITE_SKY, box, icosphere, mean, plane, render

RADIANCE = (4.0, 3.0, 2.0)
EYE = np.array([-1.2, 1.0, 1.6])
# All pixels see one point of the floor.
SPOT = iso.Camera(tuple(EYE), (0, 0, 0), fov_degrees=1e-3)
ALONG_X = ((0, 0), (0, -1), (1, -1), (1, 0))
ALONG_Z = ((0, 0), (1, 0), (1, 1), (0, 1))
LAMP = iso.RectLight(size=(1.6, 1.0), radiance=RADIANCE)
BOTH_WAYS = iso.RectLight(size=(1.6, 1.0), radiance=RADIANCE, two_sided=True)


def floor(material: iso.Material, uvs: object = ALONG_X) -> iso.Item:
    return iso.Item(plane(8).with_(attributes={"uv": uvs}), material)


def close(image: iso.Image, wanted: object, tolerance: float) -> bool:
    """Whether the mean colour is as wanted, to 4.5 standard errors and a part of it."""
    variance = image.channels["variance"].astype(np.float64).mean(axis=(0, 1)) / np.prod(image.size)
    bound = 4.5 * np.sqrt(variance) + tolerance * np.abs(np.asarray(wanted, float)).max()
    return bool((np.abs(mean(image) - wanted) <= bound).all())


def local(v: np.ndarray) -> np.ndarray:
    """World to the floor's frame: x to x, up to z."""
    return np.stack([v[..., 0], -v[..., 2], v[..., 1]], -1)


def lit(material: iso.Material, centre: tuple[float, float, float], facing: float = -1.0) -> np.ndarray:
    """What the eye sees of a point lit by a horizontal rectangle, by quadrature over it."""
    n = 500
    x, z = np.meshgrid((np.arange(n) + 0.5) / n - 0.5, (np.arange(n) + 0.5) / n - 0.5)
    places = np.stack([1.6 * x, 0 * x, 1.0 * z], -1).reshape(-1, 3) + centre
    distance = np.linalg.norm(places, axis=1)
    into = places / distance[:, None]
    value = probe_of(material).evaluate(local(EYE / np.linalg.norm(EYE)), local(into)).value
    solid = np.maximum(into[:, 1] * -facing, 0) / distance**2 * 1.6 / n**2
    return (value * solid[:, None]).sum(axis=0) * np.array(RADIANCE)


@pytest.mark.parametrize("name", MATTE_OR_GLOSSY)
def test_a_lamp_is_seen_in_every_material(name: str) -> None:
    """The lamp stands where it mirrors, so that aiming at it and meeting it by chance count about the same."""
    material, at = MATTE_OR_GLOSSY[name], (1.1, 1.2, -1.3)
    # The lamp's rectangle is turned, so that its own axes are those of the world.
    image = render([floor(material)], [LAMP.at(at)], SPOT, samples=256, max_depth=2)
    assert close(image, lit(material, at), 0.004)


@pytest.mark.parametrize("name", ["metal", "brushed metal", "plastic", "mix", "principled half metal"])
def test_light_met_by_chance_alone_is_the_same(name: str) -> None:
    """A lamp of a kind that cannot be aimed at: a constant sky, seen through a hole in a lid."""
    material, half = MATTE_OR_GLOSSY[name], 0.8
    corners = [(x, 1.2, z) for x in (-60.0, 1.1 - half, 1.1 + half, 60.0) for z in (-60.0, -1.8, -0.8, 60.0)]
    faces = [
        (4 * i + j, 4 * i + j + 4, 4 * i + j + 5, 4 * i + j + 1) for i in range(3) for j in range(3) if (i, j) != (1, 1)
    ]
    lid = iso.Item(iso.Mesh(corners, faces), iso.Matte(0.0))
    image = render([floor(material), lid], [iso.Sky(RADIANCE)], SPOT, samples=2048, max_depth=2)
    assert close(image, lit(material, (1.1, 1.2, -1.3)), 0.006)


@pytest.mark.parametrize("name", GLASSES)
def test_lamps_behind_rough_glass(name: str) -> None:
    material, at = GLASSES[name], (0.6, -1.2, -0.5)
    image = render([floor(material)], [BOTH_WAYS.at(at)], SPOT, samples=1024, max_depth=2)
    wanted = lit(material, at, facing=1.0)
    assert wanted.min() > 0.003
    assert close(image, wanted, 0.004)


@pytest.mark.parametrize("name", WHITE)
def test_white_bodies_vanish_in_a_white_sky(name: str) -> None:
    image = render([iso.Item(icosphere(2), WHITE[name])], [WHITE_SKY], samples=256, size=(16, 16), max_depth=200)
    assert close(image, (1, 1, 1), 0.003)


def test_tangents_follow_texture_coordinates() -> None:
    """Turning the coordinates by a quarter is the same as swapping the two roughnesses."""
    at = (1.1, 1.2, -1.3)
    for material, swapped in (
        (iso.Metal("gold", (0.3, 0.7)), iso.Metal("gold", (0.7, 0.3))),
        (iso.Ward(0.3, 0.5, (0.3, 0.7)), iso.Ward(0.3, 0.5, (0.7, 0.3))),
    ):
        turned = render([floor(material, ALONG_Z)], [LAMP.at(at)], SPOT, samples=256, max_depth=2)
        assert close(turned, lit(swapped, at), 0.004)
        assert not close(turned, lit(material, at), 0.02)


def test_tangents_turn_with_items() -> None:
    at, brushed = (1.1, 1.2, -1.3), iso.Metal("gold", (0.3, 0.7))
    turned = floor(brushed).rotate("y", math.pi / 2)
    image = render([turned, iso.Item(box(0.1), iso.Matte()).translate((9, 9, 9))], [LAMP.at(at)], SPOT, samples=256)
    assert close(image, lit(iso.Metal("gold", (0.7, 0.3)), at), 0.004)


def test_balls_are_brushed_around_their_axis() -> None:
    """Primitives, fields and meshes with the same coordinates show the same highlight."""
    material, sun = iso.Metal("gold", (0.7, 0.25)), [iso.Sun((0.4, 0.3, 1), 3)]
    pictures = [
        mean_channels(render([iso.Item(shape, material)], sun, samples=64, size=(24, 24), max_depth=2))
        for shape in (iso.sphere(1), iso.sphere(1) | iso.sphere(0.2), globe(80))
    ]
    swapped = iso.Item(iso.sphere(1), iso.Metal("gold", (0.25, 0.7)))
    other = mean_channels(render([swapped], sun, samples=64, size=(24, 24), max_depth=2))
    for picture in pictures[1:]:
        assert np.abs(picture - pictures[0]).mean() < 0.03 * pictures[0].mean()
    assert np.abs(other - pictures[0]).mean() > 0.3 * pictures[0].mean()


def mean_channels(image: iso.Image) -> np.ndarray:
    return image.channels["colour"].astype(np.float64).mean(axis=2)


def globe(rows: int) -> iso.Mesh:
    """A unit sphere of quads with normals, whose u grows around the y axis."""
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, 2 * rows + 1), indexing="ij")
    polar, around = np.pi * (1 - v), 2 * np.pi * u
    points = np.stack([np.sin(polar) * np.cos(around), np.cos(polar), -np.sin(polar) * np.sin(around)], -1)
    here = np.arange(u.size).reshape(u.shape)
    faces = np.stack([here[:-1, :-1], here[:-1, 1:], here[1:, 1:], here[1:, :-1]], -1).reshape(-1, 4)
    uvs, points = np.stack([u, v], -1).reshape(-1, 2), points.reshape(-1, 3)
    return iso.Mesh(points, faces[2 * rows : -2 * rows], attributes={"normal": points, "uv": uvs})


def test_emitters_with_a_body_shine_and_reflect() -> None:
    at = (1.1, 1.2, -1.3)
    for body in (iso.Matte(0.5), iso.Plastic((0.6, 0.2, 0.1), 0.5)):
        glowing = floor(iso.Emitter((0.3, 0.2, 0.1), body=body))
        image = render([glowing], [LAMP.at(at)], SPOT, samples=256, max_depth=2)
        assert close(image, lit(body, at) + np.array([0.3, 0.2, 0.1]), 0.004)


def test_textures_reach_every_slot() -> None:
    halves = np.array([[[0.2] * 3, [0.8] * 3]], np.float32)
    texture = iso.ImageTexture(halves, filter="nearest")
    at = (1.1, 1.2, -1.3)
    for start, level in ((0.0, 0.2), (0.5, 0.8)):
        uvs = [(start + 0.1 + 0.3 * u, v) for u, v in ALONG_X]
        for textured, plain in (
            (iso.Plastic("red", texture), iso.Plastic("red", level)),
            (iso.Metal("iron", (texture, 0.6)), iso.Metal("iron", (level, 0.6))),
            (
                iso.Mix(iso.Matte(texture), iso.Metal("gold", 0.5), texture),
                iso.Mix(iso.Matte(level), iso.Metal("gold", 0.5), level),
            ),
        ):
            image = render([floor(textured, uvs)], [LAMP.at(at)], SPOT, samples=256, max_depth=2)
            assert close(image, lit(plain, at), 0.006)


def test_pictures_do_not_depend_on_threads() -> None:
    items = [
        iso.Item(iso.sphere(0.5), material).translate((k - 1.0, 0, 0))
        for k, material in enumerate((iso.Metal("gold", (0.2, 0.5)), iso.Glass(roughness=0.3), iso.Plastic("red")))
    ]
    one, two = (render(items, [WHITE_SKY], samples=8, size=(40, 40), threads=n) for n in (1, 2))
    assert (one.channels["colour"] == two.channels["colour"]).all()


def test_single_directions_are_taken_whole() -> None:
    """Smooth plastic under a white sky gives back all of it; a lacquered mirror what theory says."""
    for material, wanted in ((iso.Plastic(1.0, 0), 1.0), (iso.Mix(iso.Mirror(0.5), iso.Matte(0.3), 0.25), 0.45)):
        image = render([floor(material)], [WHITE_SKY], SPOT, samples=256, max_depth=3)
        assert close(image, (wanted,) * 3, 0.002)
