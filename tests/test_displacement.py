"""Displaced meshes: against surfaces that formulas give, and without cracks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso
from isophote.convert.dice import dice
from isophote.errors import GeometryError


def _height_map(function: object, size: int = 256) -> iso.ImageTexture:
    """A picture whose texels at (u, v) hold a function of them."""
    u, v = np.meshgrid((np.arange(size) + 0.5) / size, 1 - (np.arange(size) + 0.5) / size)
    return iso.ImageTexture(function(u, v).astype(np.float32), "linear", "clamp")  # type: ignore[operator]


def _square() -> iso.Mesh:
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    return iso.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]], attributes={"uv": uv})


def _ball(rings: int = 12, across: int = 24) -> iso.Mesh:
    """A sphere of radius 1 with a seam where u goes from 1 to 0, and with normals."""
    u, v = (a.reshape(-1) for a in np.meshgrid(np.linspace(0, 1, across + 1), np.linspace(0, 1, rings + 1)))
    around, up = 2 * np.pi * (u % 1), np.pi * v
    points = np.stack([np.sin(up) * np.cos(around), -np.cos(up), -np.sin(up) * np.sin(around)], axis=1)
    points[v == 0], points[v == 1] = (0, -1, 0), (0, 1, 0)
    i = np.arange((across + 1) * rings).reshape(rings, across + 1)[:, :-1].reshape(-1)
    j = i + across + 1
    faces = np.concatenate([np.stack([i, i + 1, j + 1], 1), np.stack([i, j + 1, j], 1)])
    corners = points[faces]
    whole = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 1e-9
    return iso.Mesh(points, faces[whole], attributes={"uv": np.stack([u, v], 1), "normal": points})


def _volume(mesh: iso.Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))  # type: ignore[call-overload]
    return float((a * np.cross(b, c)).sum() / 6)


def _white(value: float = 1.0) -> iso.ImageTexture:
    return iso.ImageTexture(np.full((1, 1), value, np.float32), "linear")


def _longest(mesh: iso.Mesh) -> float:
    corners = mesh.vertices[mesh.faces]  # type: ignore[index]
    return float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max())


def test_a_displaced_square_has_the_heights_of_the_map() -> None:
    waves = _height_map(lambda u, v: 0.5 + 0.3 * np.sin(2 * np.pi * u) * np.cos(np.pi * v))
    mesh = iso.displace(_square(), waves, 0.4, midlevel=0.5, edge=0.05)
    x, y, z = mesh.vertices.T
    inside = (np.minimum(x, y) > 0.01) & (np.maximum(x, y) < 0.99)
    np.testing.assert_allclose(z[inside], (0.12 * np.sin(2 * np.pi * x) * np.cos(np.pi * y))[inside], atol=1e-4)
    assert inside.sum() > 200
    assert mesh.normals is not None
    # ∇ of that height, at the same vertices, to the accuracy of the triangles.
    slope = np.stack(
        [
            0.24 * np.pi * np.cos(2 * np.pi * x) * np.cos(np.pi * y),
            -0.12 * np.pi * np.sin(2 * np.pi * x) * np.sin(np.pi * y),
        ],
        1,
    )
    expected = np.concatenate([-slope, np.ones((len(x), 1))], axis=1)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    normals = np.zeros_like(mesh.vertices)
    normals[mesh.indices] = mesh.normals.values[mesh.normals.indices]
    assert (normals * expected).sum(axis=1)[inside].min() > 0.999


def test_a_tilted_roof_has_the_area_that_its_slope_gives() -> None:
    ramp = _height_map(lambda u, v: np.abs(2 * u - 1), 512)
    mesh = iso.displace(_square(), ramp, 0.5, edge=0.02)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))  # type: ignore[call-overload]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(np.sqrt(2), rel=5e-3)


@pytest.mark.parametrize("by", [0.25, -0.5])
def test_a_sphere_displaced_evenly_is_a_larger_or_smaller_sphere(by: float) -> None:
    mesh = iso.displace(_ball(24, 48), _white(), by, edge=0.05)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    # Chords of the ball that was given stay chords; normals are blended along them.
    assert radius.max() <= 1 + by + 1e-6
    assert radius.min() > 1 + by - 0.01
    assert iso.analysis.topology(mesh).closed
    assert _volume(mesh) == pytest.approx(4 / 3 * np.pi * (1 + by) ** 3, rel=0.02)


@pytest.mark.parametrize("texture", [iso.PerlinNoise(), _height_map(lambda u, v: u * (1 - v))])
@pytest.mark.parametrize("edge", [0.31, 0.08])
def test_closed_stays_closed_across_seams_that_disagree(texture: iso.Texture, edge: float) -> None:
    mesh = iso.displace(_ball(), texture, 0.3, edge=edge)
    report = iso.analysis.topology(mesh)
    assert report.closed
    assert report.manifold
    assert report.oriented
    assert report.genus == 0
    assert np.ptp(np.linalg.norm(mesh.vertices, axis=1)) > 0.05


def test_a_cube_with_sharp_edges_stays_closed_and_keeps_its_edges() -> None:
    cube = iso.Mesh(
        np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float),
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
    )
    faces = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]], float)
    sharp = cube.with_(attributes={"normal": iso.Attribute(faces, np.repeat(np.arange(6), 4))})
    mesh = iso.displace(sharp, _white(0.0), 1.0, edge=0.3)
    assert iso.analysis.topology(mesh).closed
    assert _volume(mesh) == pytest.approx(1.0, rel=1e-9)
    assert mesh.normals is not None
    found = np.unique(np.round(mesh.normals.values, 5) + 0.0, axis=0)
    np.testing.assert_allclose(np.sort(found, axis=0), np.sort(faces, axis=0), atol=1e-5)


def test_edges_are_no_longer_than_wanted_and_faces_are_covered_once() -> None:
    mesh = iso.displace(_square(), _white(0.0), edge=0.07)
    assert _longest(mesh) <= 0.07
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))  # type: ignore[call-overload]
    across = np.cross(b - a, c - a)[:, 2] / 2
    assert across.min() > 0
    assert across.sum() == pytest.approx(1.0)
    assert len(mesh.faces) < 12 / 0.07**2


def test_dicing_blends_what_corners_hold() -> None:
    points = np.array([[0, 0, 0], [4, 0, 0], [0, 1, 0]], float)

    def measure(a: npt.NDArray[np.float64], b: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.linalg.norm(b - a, axis=1) / 0.3

    diced = dice(points, np.array([[0, 1, 2]]), points[None] * 2 + 1, measure, 10_000)
    np.testing.assert_allclose(diced.values, diced.points[diced.triangles] * 2 + 1, atol=1e-12)


def test_attributes_and_labels_are_carried_along() -> None:
    square = _square()
    colour = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], np.float32)
    labels = {"material": iso.FaceLabels(("stone",), np.array([0]))}
    mesh = iso.displace(
        square.with_(attributes={**square.attributes, "colour": colour}, labels=labels), _white(), edge=0.3
    )
    assert mesh.uvs is not None
    assert mesh.colours is not None
    np.testing.assert_allclose(mesh.uvs.values[mesh.uvs.indices], mesh.vertices[mesh.indices][:, :2], atol=1e-6)
    assert mesh.labels["material"].names == ("stone",)
    assert (mesh.labels["material"].index == 0).all()
    np.testing.assert_allclose(mesh.vertices[:, 2], 1.0)


_CAMERA = iso.Camera(eye=(0, 0, 4), target=(0, 0, 0), fov_degrees=40)


@pytest.mark.parametrize("method", [iso.PathTrace(samples=4), iso.RayTrace(), iso.AmbientOcclusion(samples=16)])
def test_pictures_show_the_displaced_surface(method: object) -> None:
    grown = iso.Item(_ball(24, 48), iso.Matte(), displacement=iso.Displacement(_white(), 0.2))
    real = iso.Item(iso.sphere(1.2), iso.Matte())
    found, expected = (
        iso.render(iso.Scene([item], [iso.PointLight((2, 3, 4), 100)], _CAMERA), method, size=(48, 36)).channels
        for item in (grown, real)
    )
    both = (found["item"] == 0) & (expected["item"] == 0)
    assert both.sum() > 500
    assert ((found["item"] == 0) != (expected["item"] == 0)).mean() < 0.02
    assert np.median(np.abs(found["depth"][both] - expected["depth"][both])) < 0.005
    assert np.median((found["normal"] * expected["normal"]).sum(axis=2)[both]) > 0.9995
    assert abs(found["colour"].mean() - expected["colour"].mean()) < 0.02 * expected["colour"].mean()


def test_items_are_cut_as_finely_as_the_picture_shows_them() -> None:
    from isophote.lower.displaced import displaced

    def triangles(size: tuple[int, int], place: tuple[float, float, float] = (0, 0, 0)) -> int:
        item = iso.Item(_square(), displacement=iso.Displacement(_white(), 0.1)).translate(place)
        return displaced(iso.Scene([item], camera=_CAMERA), size).items[0].shape.face_count

    coarse, fine = triangles((80, 60)), triangles((160, 120))
    assert 2.5 < fine / coarse < 6
    # About one a pixel of those that the square fills: 160 by 160 at 160 pixels for 2.9 of width.
    pixels = (160 / (2 * 4 * np.tan(np.radians(20)) * 4 / 3)) ** 2
    assert 0.3 < fine / pixels < 3
    assert triangles((160, 120), (0, 0, -8)) < fine / 4
    assert triangles((160, 120), (60, 0, 0)) < fine / 16


def test_items_of_one_mesh_share_what_becomes_of_it() -> None:
    from isophote.lower.displaced import displaced

    mesh, rough = _square(), iso.Displacement(_white(), 0.1, edge=0.1)
    items = [iso.Item(mesh, displacement=rough).translate((k, 0, 0)) for k in range(3)]
    scene = iso.Scene(items, camera=_CAMERA)
    first, *rest = displaced(scene).items
    assert all(item.shape is first.shape for item in rest)
    assert displaced(scene).items[0].shape is first.shape
    assert displaced(iso.Scene([iso.Item(mesh)])).items[0].shape is mesh


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: iso.displace(_square(), _white(), edge=1e-5), "4,000,000 triangles"),
        (lambda: iso.displace(_square(), _white(), edge=0.1, most=10), "more than 10 triangles"),
        (lambda: iso.displace(_square(), _white(1e38), 1e300, edge=0.5), "smaller scale"),
    ],
)
def test_too_much_is_refused(make: object, message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        make()  # type: ignore[operator]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: iso.Displacement("noise"), "texture must be a Texture"),
        (lambda: iso.Displacement(_white(), edge=0.0), "edge"),
        (lambda: iso.Displacement(_white(), most=0), "most"),
        (lambda: iso.Item(iso.sphere(1), displacement=iso.Displacement(_white())), "only a Mesh"),
        (lambda: iso.Item(_square(), displacement=0.3), "Displacement or None"),
    ],
)
def test_bad_displacements_are_named(make: object, message: str) -> None:
    with pytest.raises(iso.SceneError, match=message):
        make()  # type: ignore[operator]


def test_bounds_have_room_for_what_is_displaced() -> None:
    item = iso.Item(_square(), displacement=iso.Displacement(_white(), 0.5, midlevel=0.25)).scale(2.0)
    np.testing.assert_allclose(item.bounds, [[-0.75, -0.75, -0.75], [2.75, 2.75, 0.75]])
    np.testing.assert_allclose(iso.Scene([item]).bounds, item.bounds)


@pytest.mark.parametrize("name", ["a.glb", "a.obj"])
def test_files_say_that_displacements_are_left_out(tmp_path: Path, name: str) -> None:
    item = iso.Item(_square(), displacement=iso.Displacement(_white()))
    with pytest.warns(iso.IsophoteWarning, match=r"displacement of items 0.*isophote\.displace"):
        iso.save(iso.Scene([item]), tmp_path / name)


def test_what_is_displaced_in_pictures_alone_is_not_baked() -> None:
    with pytest.raises(iso.RenderError, match=r"isophote\.displace"):
        iso.bake_occlusion(iso.Item(_square(), displacement=iso.Displacement(_white())), size=8)


def test_a_picture_that_would_need_too_many_triangles_names_the_item() -> None:
    item = iso.Item(_square(), displacement=iso.Displacement(_white(), edge=0.01, most=100))
    with pytest.raises(iso.SceneError, match=r"items\[0\].*100 triangles"):
        iso.render(iso.Scene([item], [iso.Sky("white", 1)], _CAMERA), iso.RayTrace(), size=(8, 6))
