"""Scenes: items, materials, lights, textures and the studio, as values."""

from __future__ import annotations

import math
from pathlib import Path

import attrs
import numpy as np
import OpenEXR
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isophote import *  # noqa: F403
from isophote import (
    Camera,
    DiskLight,
    Emitter,
    Environment,
    Glass,
    ImageTexture,
    Item,
    Matte,
    Mesh,
    Mirror,
    PointLight,
    Principled,
    RectLight,
    Scene,
    SceneError,
    Sky,
    SphereLight,
    Sun,
    Transform,
    studio,
)
from isophote.scene.light import direction_to_uv, uv_to_direction

MODELS = Path(__file__).parents[1] / "../shared/models"
TRIANGLE = Mesh([(0, 0, 0), (1, 0, 0), (0, 2, 3)], [(0, 1, 2)])
PICTURE = ImageTexture([[[0, 128, 255], [1, 2, 3]]], wrap="clamp", name="two pixels")
GREY_MAP = ImageTexture(np.ones((2, 4, 3), np.float32))


VALUES = [
    Matte("tomato"),
    Matte(PICTURE),
    Mirror(0.9),
    Glass(ior=1.33, colour="#eef"),
    Emitter((3, 2, 1), two_sided=True),
    Principled("gold", metallic=1, roughness=0.2, colour_texture=PICTURE, alpha_mode="mask"),
    PointLight((4, 6, 8), 400, "orange"),
    Sun((1, 2, 3), 5),
    RectLight(size=(1, 2), power=60).at((0, 3, 0), (1, 0, 0)),
    RectLight((0.5, 2), radiance=(12, 11, 10), two_sided=True),
    DiskLight(0.3, radiance=4),
    SphereLight(0.3, power=3).at((1, 1, 1)),
    Sky("skyblue", 0.3),
    Environment(PICTURE, 2, rotation=1.5),
    ImageTexture(np.float32([[0.1, 0.2], [0.3, 40]]), filter="nearest"),
    Item(TRIANGLE, Matte(0.5), name="a triangle").rotate("y", 0.3),
    Scene([Item(TRIANGLE)], [Sky()], Camera((0, 0, 5), (0, 0, 0)), "one"),
]


@pytest.mark.parametrize("value", VALUES, ids=lambda value: type(value).__name__)
def test_descriptions_are_values(value):
    again = eval(repr(value))
    assert again == value
    assert hash(again) == hash(value)
    assert value != "something else"
    assert len({value, again}) == 1
    with pytest.raises(attrs.exceptions.FrozenInstanceError):
        value.colour = 1


def test_other_values_are_not_equal():
    assert len(set(VALUES)) == len(VALUES)
    assert ImageTexture(np.zeros((2, 2), np.uint8)) != ImageTexture(np.zeros((2, 2), np.float32))
    assert Matte(PICTURE) != Matte(attrs.evolve(PICTURE, wrap="repeat"))


@pytest.mark.parametrize(
    ("message", "make"),
    [
        ("'tomatoe'", lambda: Matte("tomatoe")),
        ("Glass: ior", lambda: Glass(ior=0)),
        ("Glass: ior", lambda: Glass(ior=-1.5)),
        ("Glass: ior", lambda: Glass(ior=float("nan"))),
        ("Glass: ior", lambda: Glass(ior="1.5")),
        ("0 or above", lambda: Emitter((-1, 0, 0))),
        ("Principled: metallic", lambda: Principled(metallic=2)),
        ("Principled: normal_texture", lambda: Principled(normal_texture="n.png")),
        ("Principled: alpha_mode must be 'opaque' or 'mask'", lambda: Principled(alpha_mode="OPAQUE")),
        ("PointLight: position", lambda: PointLight((0, 0, float("inf")))),
        ("PointLight: power", lambda: PointLight((0, 0, 0), -1)),
        ("Sun: direction", lambda: Sun((0, 0, 0))),
        ("Sun: irradiance", lambda: Sun((0, 1, 0), float("nan"))),
        ("not both", lambda: RectLight(power=1, radiance=1)),
        ("RectLight: size", lambda: RectLight(size=(1, 0))),
        ("RectLight: size", lambda: RectLight(size=3)),
        ("RectLight: transform", lambda: RectLight(transform=Transform.identity().scale(2))),
        ("DiskLight: radius", lambda: DiskLight(0)),
        ("SphereLight: transform", lambda: SphereLight(1, transform="here")),
        ("apart", lambda: RectLight().at((0, 1, 0), (0, 1, 0))),
        ("Sky: strength", lambda: Sky(strength=-1)),
        ("Environment: texture", lambda: Environment("studio.hdr")),
        ("negative", lambda: Environment(ImageTexture(np.float32([[-1.0]])))),
        ("load_mesh", lambda: Item("bunny.obj")),
        ("Item: shape", lambda: Item(Item(TRIANGLE))),
        ("Item: shape", lambda: Item(Mesh)),
        ("Item: material", lambda: Item(TRIANGLE, "red")),
        ("Item: transform", lambda: Item(TRIANGLE, transform=np.eye(4))),
        ("Item: name", lambda: Item(TRIANGLE, name=3)),
        (r"items\[1\] must be an Item.*wrap", lambda: Scene([Item(TRIANGLE), TRIANGLE])),
        (r"write \[\.\.\.\]", lambda: Scene(Item(TRIANGLE))),
        ("items must be a list", lambda: Scene(3)),
        (r"lights\[0\] must be a light", lambda: Scene([], [Item(TRIANGLE)])),
        ("Scene: camera", lambda: Scene([], [], (0, 0, 5))),
        ("no bounds", lambda: Scene([]).bounds),
        ("pixel", lambda: ImageTexture(np.zeros((0, 4, 3), np.uint8))),
        ("pixels must be", lambda: ImageTexture(np.zeros((4, 4, 2), np.uint8))),
        ("pixels must be", lambda: ImageTexture(np.zeros(4, np.uint8))),
        ("uint8", lambda: ImageTexture(np.zeros((4, 4), np.uint16))),
        ("uint8", lambda: ImageTexture([[0, 256]])),
        ("row 1, column 0", lambda: ImageTexture(np.float32([[0, 1], [np.nan, 1]]))),
        ("row 0, column 1", lambda: ImageTexture(np.array([[0, 1e300]]))),
        ("regular", lambda: ImageTexture([[1, 2], [3]])),
        ("ImageTexture: colour_space", lambda: ImageTexture([[1]], "sRGB")),
        ("ImageTexture: wrap", lambda: ImageTexture([[1]], wrap=3)),
        ("studio takes", lambda: studio([])),
        ("studio takes", lambda: studio("bunny")),
        ("Item: shape", lambda: studio([3])),
    ],
)
def test_what_has_no_meaning_is_refused(message, make):
    with pytest.raises(SceneError, match=message):
        make()


def test_materials_have_plain_defaults():
    assert Matte().colour == (0.8, 0.8, 0.8)
    assert Mirror().colour == Glass().colour == (1, 1, 1)
    assert Matte(0.2) == Matte((0.2, 0.2, 0.2))


def test_textures():
    assert PICTURE.size == (2, 1)
    assert PICTURE.channels == 3
    assert PICTURE.colour_space == "srgb"
    assert GREY_MAP.colour_space == "linear"
    assert ImageTexture(np.zeros((3, 2), np.float64)).pixels.dtype == np.float32
    missing = ImageTexture.missing("wood.png")
    assert missing.pixels.tolist() == [[[255, 0, 255]]]
    assert missing.name == "wood.png"
    given = np.zeros((2, 2, 4), np.uint8)
    texture = ImageTexture(given)
    given[:] = 9
    assert not texture.pixels.any()


# Power: the emitted flux is π times radiance times area; for a point 4π times its intensity.
@pytest.mark.parametrize(
    ("light", "area"),
    [
        (RectLight((2, 3), power=7), 6),
        (RectLight((2, 3), power=7, two_sided=True), 12),
        (DiskLight(2, power=7), 4 * math.pi),
        (DiskLight(2, power=7, two_sided=True), 8 * math.pi),
        (SphereLight(2, power=7), 16 * math.pi),
    ],
)
def test_power_is_radiance_over_all_directions_and_all_of_the_area(light, area):
    assert [channel * math.pi * area for channel in light.radiance_rgb] == pytest.approx([7, 7, 7])
    red = attrs.evolve(light, colour=(1, 0.5, 0))
    assert [channel * math.pi * area for channel in red.radiance_rgb] == pytest.approx([7, 3.5, 0])


def test_other_units():
    assert [c * 4 * math.pi for c in PointLight((0, 0, 0), 5, (1, 2, 0)).intensity_rgb] == pytest.approx([5, 10, 0])
    assert RectLight((4, 4), radiance=(1, 2, 3), colour=(2, 2, 0)).radiance_rgb == (2, 4, 0)
    assert RectLight((2, 0.5)).radiance_rgb == pytest.approx([1 / math.pi] * 3)
    assert Sun((0, 3, 4), 2, (1, 0, 0.5)).irradiance_rgb == (2, 0, 1)
    assert Sun((0, 3, 4)).unit_direction == pytest.approx((0, 0.6, 0.8))
    assert Sun((0, 3e-300, 4e-300)).unit_direction == pytest.approx((0, 0.6, 0.8))
    assert Sky((1, 0, 0.5), 4).radiance_rgb == (4, 0, 2)


def test_lights_face_down_or_toward_their_target():
    down = RectLight().at((1, 2, 3))
    assert down.position == (1, 2, 3)
    assert np.allclose(down.transform.apply((0, -1, 0)), (1, 1, 3))
    assert np.allclose(
        RectLight().at((0, 5, 0), (0, 0, 0)).transform.matrix, RectLight().at((0, 5, 0)).transform.matrix
    )


@given(st.tuples(*[st.floats(-9, 9)] * 3), st.tuples(*[st.floats(-9, 9)] * 3))
def test_a_light_at_any_place_shines_at_its_target_with_its_width_level(position, target):
    away = np.subtract(target, position)
    distance = np.linalg.norm(away)
    if distance < 1e-3:
        return
    for light in (RectLight(), DiskLight()):
        placed = light.at(position, target).transform
        assert placed.is_rigid
        assert np.allclose(placed.matrix[:3, 1], -away / distance)
        assert abs(placed.matrix[1, 0]) < 1e-6


def test_a_light_that_shines_level_has_its_width_to_the_right_of_who_looks_along():
    x, y, z = RectLight().at((0, 0, 5), (0, 0, 0)).transform.matrix[:3, :3].T
    assert np.allclose(x, (1, 0, 0))
    assert np.allclose(y, (0, 0, 1))
    assert np.allclose(z, (0, -1, 0))


DIRECTIONS = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda d: np.linalg.norm(d) > 1e-3)


@given(DIRECTIONS, st.floats(-7, 7))
def test_directions_and_uv_are_inverse(direction, rotation):
    uv = direction_to_uv(direction, rotation)
    assert ((uv >= 0) & (uv <= 1)).all()
    unit = np.array(direction) / np.linalg.norm(direction)
    assert np.allclose(uv_to_direction(uv, rotation), unit, atol=1e-7)


@given(DIRECTIONS.filter(lambda d: math.hypot(d[0], d[2]) > 1e-3), st.floats(-3, 3))
def test_rotation_turns_the_surroundings_as_a_transform_does(direction, rotation):
    turned = Transform.identity().rotate("y", rotation).apply(direction)
    difference = direction_to_uv(turned, rotation) - direction_to_uv(direction)
    assert np.allclose(difference - [np.rint(difference[0]), 0], 0, atol=1e-6)


def test_where_the_axes_are_in_a_map():
    axes = [(0, 0, 1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)]
    uv = direction_to_uv(axes)
    assert uv[:3].tolist() == [[0.5, 0.5], [0.25, 0.5], [0.75, 0.5]]
    assert uv[3:, 1].tolist() == [1, 0]
    assert direction_to_uv((0, 0, -1))[0] == 0


@pytest.mark.skipif(not (MODELS / "env").is_dir(), reason="the environment maps are not here")
def test_orientation_against_a_labelled_map():
    """The map draws from +X a dark axis toward +Z, and from +Z one toward +X; nothing points the other way."""
    with OpenEXR.File(str(MODELS / "env/OrientationLatLong.exr")) as file:
        pixels = file.channels()["RGBA"].pixels[..., :3].astype(float).max(axis=2)
    height, width = pixels.shape[:2]

    def darkness(start, stop):
        steps = np.linspace(0.3, 0.45, 20)[:, None]
        u, v = direction_to_uv(np.array(start) + steps * (np.array(stop) - np.array(start))).T
        column, row = (u * width).astype(int), ((1 - v) * height).astype(int)
        # The axes are dark in all channels, the words on the map blue. A line may lie between two rows.
        return 1 - np.minimum(pixels[row, column], pixels[row - 1, column]).mean()

    x, y, z, minus_x = (1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0)
    assert darkness((0.99, 0, 0.1), (0.75, 0, 0.66)) > 0.5
    assert darkness((0.1, 0, 0.99), (0.66, 0, 0.75)) > 0.5
    assert darkness((0.99, 0, -0.1), (0.75, 0, -0.66)) < 0.2
    assert darkness((-0.1, 0, 0.99), (-0.66, 0, 0.75)) < 0.2
    for axis in (x, z, minus_x):
        assert darkness(axis, np.array(axis) + 0.6 * np.array(y)) > 0.5
        assert darkness(axis, np.array(axis) - 0.6 * np.array(y)) < 0.5


def test_items_move():
    item = Item(TRIANGLE).rotate("z", math.pi / 2).scale(2).translate((1, 0, 0))
    assert np.allclose(item.transform.apply((1, 0, 0)), (1, 2, 0))
    assert np.allclose(item.at((5, 5, 5)).transform.apply((1, 0, 0)), (5, 7, 5))
    assert item.shape is TRIANGLE
    assert item.with_(name="b").name == "b"


@given(st.floats(-7, 7), st.tuples(*[st.floats(-5, 5)] * 3))
def test_bounds_hold_everything(angle, offset):
    item = Item(TRIANGLE).rotate((1, 2, 3), angle).scale((1, -2, 0.5)).translate(offset)
    low, high = Scene([item, Item(TRIANGLE)]).bounds
    placed = np.concatenate([item.transform.apply(TRIANGLE.vertices), TRIANGLE.vertices])
    assert (placed >= low - 1e-9).all()
    assert (placed <= high + 1e-9).all()


def test_bounds_are_exact_without_turning():
    items = [Item(TRIANGLE), Item(TRIANGLE).scale((-1, 1, 2)).translate((0, 0, 5))]
    assert Scene(items).bounds.tolist() == [[-1, 0, 0], [1, 2, 11]]


class Ground:
    bounds = np.array([(-np.inf, -np.inf, -np.inf), (np.inf, 0, np.inf)])


def test_endless_shapes_have_endless_bounds_only_where_they_are_endless():
    bounds = Item(Ground()).translate((0, 2, 0)).bounds
    assert bounds.tolist() == [[-np.inf, -np.inf, -np.inf], [np.inf, 2, np.inf]]


def test_the_same_shape_is_measured_once():
    class Counted:
        asked = 0

        @property
        def bounds(self):
            Counted.asked += 1
            return np.array([(0, 0, 0), (1, 1, 1)])

    shape = Counted()
    items = [Item(shape).translate((i, 0, 0)) for i in range(50)]
    assert Scene(items).bounds.tolist() == [[0, 0, 0], [50, 1, 1]]
    assert Counted.asked == 1


@pytest.mark.parametrize("scale", [1e-4, 1, 1e5])
def test_the_studio_looks_the_same_at_any_scale(scale):
    reference, scene = studio(TRIANGLE), studio(TRIANGLE.with_(vertices=TRIANGLE.vertices * scale))
    assert np.allclose(np.array(scene.camera.eye), scale * np.array(reference.camera.eye), rtol=1e-12)
    assert scene.camera.fov_degrees == reference.camera.fov_degrees
    assert np.allclose(scene.items[-1].shape.vertices, scale * reference.items[-1].shape.vertices)
    for light, expected in zip(scene.lights, reference.lights, strict=True):
        assert light.radiance_rgb == expected.radiance_rgb
    assert np.allclose(scene.lights[0].position, scale * np.array(reference.lights[0].position))
    assert np.allclose(scene.lights[0].size, scale * np.array(reference.lights[0].size))


def test_the_studio():
    scene = studio(TRIANGLE)
    item, ground = scene.items
    assert item.shape is TRIANGLE
    assert ground.bounds[1, 1] < TRIANGLE.bounds[0, 1]
    # The ground faces up, and the horizon stays out of the picture.
    a, b, c = ground.shape.vertices[:3]
    assert np.cross(b - a, c - a)[1] > 0
    camera_map = scene.camera.linear_map((640, 480))
    assert camera_map.d[1] < 0
    assert (camera_map.d + 640 * camera_map.dx)[1] < 0
    # The key light faces what it lights and stays out of the picture, behind its top.
    key = scene.lights[0]
    pixel, depth = scene.camera.project(key.position, (640, 480))
    assert not (depth > 0 and 0 < pixel[0] < 640 and 0 < pixel[1] < 480)
    toward = TRIANGLE.bounds.mean(axis=0) - key.position
    assert np.allclose(-key.transform.matrix[:3, 1], toward / np.linalg.norm(toward))


def test_the_studio_takes_items_lists_and_scenes():
    red = Item(TRIANGLE, Matte("red"))
    assert studio(red).items[0] is red
    assert [item.material for item in studio([red, TRIANGLE]).items[:2]] == [
        Matte("red"),
        studio(TRIANGLE).items[0].material,
    ]
    camera = Camera((0, 0, 9), (0, 0, 0))
    assert studio(Scene([red], camera=camera)).camera is camera
    assert studio(Scene([red], camera=camera)).items == (red,)
    assert studio(Scene([red], camera=camera)).lights
    lit = Scene([Item(TRIANGLE, Emitter(1))])
    assert studio(lit).lights == ()
    assert studio(lit).camera is not None
    whole = Scene([], [Sky()], camera)
    assert studio(whole) == whole


def test_the_documented_example_runs():
    text = (Path(__file__).parents[1] / "docs/scenes.md").read_text()
    names: dict[str, object] = {}
    exec(text.split("```python")[1].split("```")[0], names)
    assert names["scene"].bounds.tolist() == [[-5, 0, -5], [5, 1, 5]]
