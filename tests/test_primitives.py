"""Exact primitives in scenes: recognised, the silhouettes of their fields, no surface met twice, textures."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import isophote as iso
from isophote.errors import GeometryError, SceneError
from isophote.lower.primitive_table import primitive_of
from isophote.lower.primitives import KINDS
from scenes import WHITE_SKY, render

WHITE = iso.Matte((1, 1, 1))
CAMERA = iso.Camera((1.5, 1.6, 3.0), (0, 0, 0), fov_degrees=40)
RNG = np.random.default_rng(8)

SOLIDS = {
    "sphere": iso.sphere(0.8),
    "ellipsoid": iso.ellipsoid((0.5, 0.9, 0.7)),
    "box": iso.box((0.9, 0.6, 1.1)),
    "slab": iso.slab(0.4),
    "plane": iso.plane((1, 2, 0.5), 0.2),
    "pipe": iso.cylinder(0.4),
    "cylinder": iso.cylinder(0.5, 1.2),
    "cone": iso.cone(0.6, 1.3),
    "part of a cone": iso.cone(0.3, 1.0, 0.7),
    "torus": iso.torus(0.6, 0.25),
    "spindle": iso.torus(0.3, 0.5),
}
PLACES: dict[str, Callable[[iso.Field], iso.Field]] = {
    "as it is": lambda f: f,
    "moved": lambda f: f.rotate((1, 2, 3), 0.7).translate((0.1, -0.2, 0.3)).scale(1.3),
    "stretched": lambda f: f.scale((1, 1.8, 0.6)).along("z").mirror("x"),
    "sheared": lambda f: f.affine([[1, 0.4, 0, 0.1], [0, 0.8, -0.3, 0], [0.2, 0, 1.2, 0], [0, 0, 0, 1]]),
}


def followed(shape: iso.Field) -> iso.Field:
    """The same shape as a field."""
    return shape.offset(0)


def rays(count: int, reach: float = 3.0) -> tuple[np.ndarray, np.ndarray]:
    """From around and from within, in single precision."""
    origins = RNG.normal(size=(count, 3))
    origins *= reach / np.linalg.norm(origins, axis=1, keepdims=True)
    origins[::3] = RNG.uniform(-0.8, 0.8, origins[::3].shape)
    directions = RNG.uniform(-0.8, 0.8, (count, 3)) - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return origins.astype(np.float32), directions.astype(np.float32)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("name", SOLIDS)
def test_a_bare_solid_is_met_where_its_field_is(name: str, place: str) -> None:
    shape = PLACES[place](SOLIDS[name])
    assert primitive_of(shape) is not None
    o, d = rays(4000)
    exact, field = iso.Tracer(shape).closest(o, d), iso.Tracer(followed(shape)).closest(o, d)
    # Endless fields end, and rays along a rim may go either way.
    near = ~(np.maximum(np.where(exact.hit, exact.distance, 0), np.where(field.hit, field.distance, 0)) > 100)
    differ = (exact.hit != field.hit) & near
    assert differ.sum() <= 4
    both = exact.hit & field.hit & near
    assert both.sum() > 300
    # Fields are followed in single precision, which moves grazing crossings.
    error = np.abs(exact.distance[both] - field.distance[both])
    assert np.median(error) < 4e-6
    assert (error > 2e-3).mean() < 0.01
    along = np.abs((exact.normal[both] * field.normal[both]).sum(axis=1))
    assert (along < 0.999).mean() < 0.01
    step = 1e-3 * exact.normal[both]
    outward = (shape(exact.point[both] + step) > 0) & (shape(exact.point[both] - step) < 0)
    assert outward.mean() > 0.99
    assert np.abs(shape(exact.point[both])).max() < 5e-6
    assert (iso.Tracer(shape).occluded(o, d) == exact.hit).all()


def test_what_is_combined_or_deformed_stays_a_field() -> None:
    ball = iso.sphere(1)
    kept = [ball | iso.box(1), ball - iso.box(1), ball.union(iso.box(1), blend=0.1), ball.shell(0.1), ball.offset(0.1)]
    kept += [iso.box(1).round(0.1), iso.box(1).twist(1), ball.elongate((1, 0, 0)), ball.repeat((3, 0, 0), 2)]
    kept += [iso.capsule(0.3, 1), iso.rounded_box(1, 0.1), iso.frame(1, 0.1)]
    assert all(primitive_of(shape) is None for shape in kept)
    assert primitive_of(iso.union(ball)) is not None
    assert primitive_of(iso.Mesh(np.eye(3), [(0, 1, 2)])) is None


def test_every_kind_is_reached() -> None:
    shapes: list[Any] = [*SOLIDS.values(), iso.Disk(), iso.Quadric((1, 1, 1, 0, 0, 0, 0, 0, 0, -1)), TRIANGLE, RING]
    kinds = {primitive.kind for primitive in map(primitive_of, shapes) if primitive is not None}
    assert kinds == set(KINDS)


TRIANGLE = iso.Polygon([(0, 0, 0), (1, 0, 0), (0, 0, -1)])
SQUARE = [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]
RING = iso.Polygon(SQUARE, [(np.array(SQUARE) * 0.5).tolist()])


def test_many_primitives_are_met_as_each_alone() -> None:
    """Through the tree over their boxes, beside endless ones."""
    shapes = [SOLIDS[name] for name in ("sphere", "box", "cylinder", "cone", "torus")]
    items = [
        iso.Item(shapes[k % 5]).scale(0.3).rotate(RNG.normal(size=3), 1.0).translate(RNG.uniform(-2, 2, 3))
        for k in range(60)
    ]
    items += [iso.Item(iso.plane("y", -2.5)), iso.Item(iso.cylinder(0.1).along("x")), iso.Item(RING)]
    o, d = rays(3000, 6.0)
    together = iso.Tracer(iso.Scene(items)).closest(o, d)
    alone = [iso.Tracer(item).closest(o, d) for item in items]
    distances = np.stack([hits.distance for hits in alone])
    assert (together.distance == distances.min(axis=0)).all()
    met = together.hit
    assert 500 < met.sum() < 3000
    assert (together.item[met] == distances.argmin(axis=0)[met]).all()
    limit = distances.min(axis=0) * 0.5
    assert not iso.Tracer(iso.Scene(items)).closest(o, d, limit).hit.any()
    assert (iso.Tracer(iso.Scene(items)).occluded(o, d, limit * 4) == together.hit).all()


def test_primitives_stand_beside_meshes_and_fields() -> None:
    mesh = iso.to_mesh(iso.box(0.5), cell=0.1)
    items = [iso.Item(mesh).translate((-1, 0, 0)), iso.Item(iso.sphere(0.3)), iso.Item(followed(iso.box(0.5)))]
    items[2] = items[2].translate((1, 0, 0))
    hits = iso.Tracer(iso.Scene(items)).closest([(x, 0.1, 3) for x in (-1, 0, 1, 2)], [0, 0, -1])
    assert hits.item.tolist() == [0, 1, 2, -1]
    assert np.allclose(hits.point[:3, 2], [0.25, np.sqrt(0.09 - 0.01), 0.25], atol=1e-6)


@pytest.mark.parametrize("offset", [0, 100])
@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e5])
@pytest.mark.parametrize("name", ["sphere", "ellipsoid", "box", "cylinder", "cone", "part of a cone"])
def test_a_convex_primitive_never_shadows_itself(name: str, scale: float, offset: float) -> None:
    """In a white furnace a white body is exactly white: each ray that left it met it again would be darker."""
    move = np.array([1.0, -0.7, 0.4]) * offset * scale
    item = iso.Item(SOLIDS[name].rotate((1, 2, 3), 0.5), WHITE).scale(scale).translate(move)
    camera = iso.Camera(np.array([1.5, 2.5, 3.0]) * scale + move, move, fov_degrees=40)
    image = render([item], [WHITE_SKY], camera, size=(40, 40), samples=16)
    assert (image.channels["item"] == 0).mean() > 0.05
    assert np.abs(image.channels["colour"] - 1).max() < 1e-5


@pytest.mark.parametrize("offset", [0, 100])
@pytest.mark.parametrize("name", [name for name in SOLIDS if name not in ("plane", "slab", "pipe")])
def test_glass_loses_no_light(name: str, offset: float) -> None:
    """In a white furnace glass is as bright as all around; a ray that missed its way in or out would be darker."""
    move = np.array([1.0, -0.7, 0.4]) * offset
    item = iso.Item(SOLIDS[name].rotate((1, 2, 3), 0.5), iso.Glass(1.5)).translate(move)
    camera = iso.Camera(np.array([1.5, 2.5, 3.0]) + move, move, fov_degrees=40)
    image = render([item], [WHITE_SKY], camera, size=(40, 40), samples=16, max_depth=1000)
    lost = np.abs(image.channels["colour"] - 1).max(axis=2)
    # Where a thick tube crosses itself there is a crease, in which a path may lose its way.
    assert (lost > 1e-4).sum() <= (2 if name == "spindle" else 0)


@pytest.mark.parametrize("method", [iso.PathTrace(samples=64), iso.RayTrace()], ids=["path", "ray"])
@pytest.mark.parametrize(
    "material", [iso.Matte("tomato"), iso.Mirror(), iso.Glass(1.5)], ids=lambda m: type(m).__name__
)
def test_pictures_are_those_of_the_fields(method: Any, material: Any) -> None:
    shapes = [iso.sphere(0.4).translate((-0.8, 0.4, 0)), iso.torus(0.4, 0.15).rotate("x", 0.6).translate((0.2, 0.4, 0))]
    shapes += [iso.cone(0.4, 0.9).translate((1.1, 0.45, 0)), iso.cylinder(0.2, 0.6).translate((0.2, 0.3, -0.9))]
    lights = [iso.PointLight((2, 3, 2), 200.0), iso.Sky(strength=0.3)]
    pictures = []
    for change in (lambda f: f, followed):
        items = [iso.Item(change(shape), material) for shape in shapes]
        items.append(iso.Item(change(iso.plane()), iso.Matte((0.7, 0.6, 0.5))))
        pictures.append(iso.render(iso.Scene(items, lights, CAMERA), method, size=(64, 48)).channels)
    exact, field = pictures
    assert (exact["item"] == field["item"]).mean() > 0.998
    same = exact["item"] == field["item"]
    with np.errstate(invalid="ignore"):
        assert np.nanmax(np.abs(exact["depth"] - field["depth"])[same]) < 2e-3
    assert exact["colour"].mean() == pytest.approx(field["colour"].mean(), rel=0.02)
    assert np.quantile(np.abs(exact["colour"] - field["colour"]), 0.9) < 0.05


def test_sphere_tracing_still_marches_fields_and_meets_the_rest() -> None:
    items = [iso.Item(iso.sphere(0.5)), iso.Item(iso.Disk(2.0)).translate((0, -0.5, 0))]
    image = iso.render(iso.Scene(items, [iso.PointLight((1, 3, 1), 100)], CAMERA), iso.SphereTrace(), size=(64, 48))
    assert set(np.unique(image.channels["item"])) == {-1, 0, 1}
    assert image.channels["steps"][image.channels["item"] == 0].min() > 0
    exact = iso.render(iso.Scene(items, [iso.Sky()], CAMERA), iso.PathTrace(samples=1), size=(64, 48))
    assert (exact.channels["item"] == image.channels["item"]).mean() > 0.995


def test_shining_spheres_and_disks_are_aimed_at() -> None:
    """A ball of radiance L seen under the half angle α, or a disk, lights a floor by π L sin²α; at 16 samples the noise
    tells that it was aimed at."""
    shapes = {"sphere": iso.sphere(0.5), "disk": iso.Disk(0.5)}
    floor = iso.Item(iso.Disk(0.02), WHITE)
    camera = iso.Camera((0, 0.2, 0.0), (0, 0, 0), up=(0, 0, -1), fov_degrees=2)
    for name, sine2 in (("sphere", 0.25), ("disk", 0.2)):
        lamp = iso.Item(shapes[name], iso.Emitter((2, 2, 2), two_sided=True)).translate((0, 1, 0))
        image = render([lamp, floor], [], camera, size=(16, 16), samples=16, max_depth=2)
        assert image.channels["colour"].mean() == pytest.approx(2 * sine2, rel=0.01)
        assert image.channels["colour"].std() < 0.1 * 2 * sine2


def test_other_shining_primitives_are_met_by_chance() -> None:
    """The same light, by the closed form, from a ball that was squeezed to a ball by its item and from a torus."""
    lamp = iso.Item(iso.ellipsoid((0.5, 0.5000001, 0.5)).scale((1, 1.01, 1)), iso.Emitter((2, 2, 2))).translate(
        (0, 1, 0)
    )
    floor = iso.Item(iso.Disk(0.02), WHITE)
    camera = iso.Camera((0, 0.2, 0.0), (0, 0, 0), up=(0, 0, -1), fov_degrees=2)
    image = render([lamp, floor], [], camera, size=(16, 16), samples=1024, max_depth=2)
    assert image.channels["colour"].mean() == pytest.approx(2 * 0.5**2, rel=0.03)


UVS: list[tuple[Any, tuple[float, float, float], tuple[float, float, float], tuple[float, float], int]] = [
    (iso.sphere(2.0), (5, 0, 0), (-1, 0, 0), (0.0, 0.5), 0),
    (iso.sphere(2.0), (0, 0, -5), (0, 0, 1), (0.25, 0.5), 0),
    (iso.sphere(2.0), (0, 5, 0), (0, -1, 0), (0.0, 1.0), 0),
    (iso.plane(), (1.25, 3, -0.5), (0, -1, 0), (1.25, 0.5), 0),
    (iso.Disk(2.0), (1, 3, -1), (0, -1, 0), (0.75, 0.75), 0),
    (iso.cylinder(1, 4), (0, 1, -5), (0, 0, 1), (0.25, 0.75), 0),
    (iso.cylinder(1, 4), (0.5, 5, 0), (0, -1, 0), (0.75, 0.5), 1),
    (iso.cylinder(1, 4), (0.5, -5, 0.5), (0, 1, 0), (0.75, 0.75), 2),
    (iso.cylinder(2.0), (-9, np.pi, 0), (1, 0, 0), (0.5, 0.25), 0),
    (iso.cone(1, 2), (-9, 0, 0), (1, 0, 0), (0.5, 0.5), 0),
    (iso.torus(2, 0.5), (9, 0, 0), (-1, 0, 0), (0.0, 0.0), 0),
    (iso.torus(2, 0.5), (0, 9, -2), (0, -1, 0), (0.25, 0.25), 0),
    (iso.box((2, 4, 6)), (0.5, 1, 9), (0, 0, -1), (0.75, 0.75), 5),
    (iso.box((2, 4, 6)), (9, 1, 1.5), (-1, 0, 0), (0.25, 0.75), 1),
    (iso.box((2, 4, 6)), (0.5, 9, 1.5), (0, -1, 0), (0.75, 0.25), 3),
    (TRIANGLE, (0.25, 1, -0.5), (0, -1, 0), (0.25, 0.5), 0),
    (iso.Quadric((1, 0, 1, 0, 0, 0, 0, 0, 0, -1), [[-2, -1, -2], [2, 3, 2]]), (0, 2, -9), (0, 0, 1), (0.25, 0.75), 0),
]


@pytest.mark.parametrize("case", range(len(UVS)))
def test_texture_coordinates_and_parts(case: int) -> None:
    shape, origin, direction, uv, part = UVS[case]
    hits = iso.Tracer(shape).closest([origin], [direction])
    # The seam is 0 or 1.
    assert np.allclose((hits.uv[0] - uv + 0.5) % 1, 0.5, atol=1e-6)
    assert hits.primitive[0] == part


def test_textures_lie_as_they_say() -> None:
    """A disk with a picture of four colours, seen from above with −z up."""
    texels = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], np.uint8)
    picture = iso.ImageTexture(texels, "linear", filter="nearest")
    camera = iso.OrthographicCamera((0, 2, 0), (0, 0, 0), up=(0, 0, -1), height=1.0)
    item = iso.Item(iso.Disk(1.0), iso.Matte(picture))
    albedo = iso.render(iso.Scene([item], [iso.Sky()], camera), iso.PathTrace(1), size=(2, 2)).channels["albedo"]
    assert np.allclose(albedo, texels / 255, atol=1e-6)


def test_polygons_of_any_size() -> None:
    for size in (1e-4, 1.0, 1e4):
        square = iso.Polygon(np.array(SQUARE) * size + size)
        hits = iso.Tracer(square).closest(np.array([(1.5, 9, 1.5), (2.5, 9, 1)]) * size, [0, -1, 0])
        assert hits.item.tolist() == [0, -1]
        assert hits.normal[0].tolist() == [0, 1, 0]


def test_corners_that_are_off_the_plane_are_told_by_how_much() -> None:
    bent = [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0.1, 1)]
    with pytest.raises(GeometryError, match=r"lies 0.0249 off the plane of the others, 0.018 of the outline's size"):
        iso.Polygon(bent)
    mesh = iso.Polygon.triangulated(bent)
    assert (mesh.vertices == bent).all()
    assert len(iso.triangulate(mesh).triangles) == 2
    iso.Polygon(np.array(bent) * (1, 1e-6, 1))
    with pytest.raises(GeometryError, match="corner 1 of the hole 0"):
        iso.Polygon(SQUARE, [[(0, 0, 0), (0.1, 0.1, 0), (0.1, 0, 0.1)]])


def test_polygons_are_values() -> None:
    again = eval(repr(RING), {"Polygon": iso.Polygon})
    assert again == RING
    assert hash(again) == hash(RING)
    assert again != TRIANGLE
    assert RING.area == pytest.approx(3.0)
    assert TRIANGLE.is_convex
    assert not RING.is_convex
    assert not iso.Polygon([(0, 0, 0), (2, 0, 0), (1, 0, -0.5), (1, 0, -2)]).is_convex
    assert eval(repr(iso.Disk(2)), {"Disk": iso.Disk}) == iso.Disk(2.0)
    quadric = iso.Quadric((1, 1, 1, 0, 0, 0, 0, 0, 0, -1), closed=False)
    assert eval(repr(quadric), {"Quadric": iso.Quadric}) == quadric


BAD: list[tuple[Callable[[], Any], type[Exception], str]] = [
    (lambda: iso.Disk(0), GeometryError, "radius must be a finite number above 0"),
    (lambda: iso.Disk(np.nan), GeometryError, "radius must be a finite number above 0"),
    (lambda: iso.Disk("x"), GeometryError, "radius must be a finite number above 0"),  # type: ignore[arg-type]
    (lambda: iso.Polygon([(0, 0, 0), (1, 0, 0)]), GeometryError, "n ≥ 3"),
    (lambda: iso.Polygon([(0, 0, 0), (1, 0, 0), (0, np.nan, 0)]), GeometryError, "number 2 is not finite"),
    (lambda: iso.Polygon([(0, 0, 0), (1, 1, 1), (2, 2, 2)]), GeometryError, "no area"),
    (lambda: iso.Polygon(SQUARE, np.array(SQUARE)), GeometryError, "holes must be a list of rings"),  # type: ignore[arg-type]
    (lambda: iso.Quadric((1, 2, 3)), GeometryError, "ten finite numbers"),
    (lambda: iso.Quadric((1,) * 9 + (np.inf,)), GeometryError, "ten finite numbers"),
    (lambda: iso.Quadric((0,) * 10), GeometryError, "no surface"),
    (lambda: iso.Quadric((1,) * 10, [[0, 0, 0], [1, 0, 1]]), GeometryError, "greatest corner above its least"),
    (lambda: iso.Tracer(iso.sphere(1e20)), SceneError, "leaves no room for single precision"),
    (lambda: iso.sphere(0), GeometryError, "radius must be a finite number above 0"),
    (lambda: iso.plane((0, 0, 0)), GeometryError, "normal"),
]


@pytest.mark.parametrize("case", range(len(BAD)))
def test_bad_input_is_told(case: int) -> None:
    call, kind, message = BAD[case]
    with pytest.raises(kind, match=message):
        call()
