"""What pictures say besides colour, and what transforms, instances, textures and normals do to them."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.lower import geometry as lower_geometry
from scenes import WHITE_SKY, box, icosphere, mean, plane, render

TOP = iso.OrthographicCamera((0, 5, 0), (0, 0, 0), up=(0, 0, -1), height=2)


def test_depth_is_along_the_axis_and_distance_along_the_ray():
    camera = iso.Camera((0, 2, 0), (0, 0, 0), up=(0, 0, -1), fov_degrees=60)
    image = render([iso.Item(plane(2))], [WHITE_SKY], camera, size=(33, 33), samples=1)
    depth, distance = image.channels["depth"], image.channels["distance"]
    hit = image.channels["item"] == 0
    assert hit.any()
    assert (~hit).any()
    assert np.allclose(depth[hit], 2, rtol=1e-6)
    y, x = (np.mgrid[:33, :33] - 16) / 16.5 * np.tan(np.radians(30)) * 2
    assert np.allclose(distance[hit], np.sqrt(x * x + y * y + 4)[hit], rtol=1e-5)
    for name in ("depth", "distance"):
        assert np.isposinf(image.channels[name][~hit]).all()
    for name in ("item", "primitive"):
        assert (image.channels[name][~hit] == -1).all()
    for name in ("normal", "albedo", "uv"):
        assert not image.channels[name][~hit].any()


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("flip", [1, -1])
def test_normals_face_the_viewer(smooth, flip):
    item = iso.Item(icosphere(2, smooth=smooth)).scale((flip, 1, 1))
    image = render([item], [WHITE_SKY], size=(64, 64), samples=1)
    hit = image.channels["item"] == 0
    normal = image.channels["normal"].astype(np.float64)
    assert np.allclose(np.linalg.norm(normal[hit], axis=1), 1, atol=1e-5)
    y, x = (np.mgrid[:64, :64] - 31.5) / 32 * np.tan(np.radians(20))
    rays = np.stack([x, -y, -np.ones_like(x)], 2)
    assert ((normal * rays).sum(axis=2)[hit] < 0).all()
    distance = image.channels["distance"].astype(np.float64)
    point = (0, 0, 4) + rays / np.linalg.norm(rays, axis=2)[..., None] * np.where(hit, distance, 0)[..., None]
    # The true sphere's normal, to the coarseness of the mesh; the interpolated one is closer.
    error = np.abs(normal - point / np.linalg.norm(point, axis=2)[..., None])[hit].max(axis=1)
    assert np.quantile(error, 0.9) < (0.02 if smooth else 0.25)


def test_ids_of_polygons_items_and_lights_are_exact():
    rng = np.random.default_rng(1)
    corners = np.array([(x, 0, z) for z in range(5) for x in range(5)], float) / 4 * 2 - (1, 0, 1)
    corners[:, [0, 2]] += rng.uniform(-0.1, 0.1, (25, 2)) * (np.abs(corners[:, [0, 2]]) < 0.9)
    faces: list[list[int]] = []
    for z in range(4):
        for x in range(4):
            a, b, c, d = 5 * z + x, 5 * z + 5 + x, 5 * z + 6 + x, 5 * z + 1 + x
            faces += [[a, b, c, d]] if (x + z) % 2 else [[a, b, c], [a, c, d]]
    mesh = iso.Mesh(corners, faces)
    lights = [
        iso.PointLight((0, 3, 0)),
        iso.SphereLight(radius=0.2).at((-0.5, 1, 0.5)),
        iso.RectLight(size=(0.3, 0.3)).at((0.5, 1, 0.5)),
    ]
    image = render([iso.Item(box(0.1)).translate((0, -3, 0)), iso.Item(mesh)], lights, TOP, size=(101, 101), samples=1)
    item, primitive = image.channels["item"], image.channels["primitive"]
    assert set(np.unique(item)) == {1, 3, 4}
    z, x = (np.mgrid[:101, :101] + 0.5) / 101 * 2 - 1
    for number, at in ((3, (-0.5, 0.5)), (4, (0.5, 0.5))):
        seen = item == number
        assert abs(x[seen].mean() - at[0]) < 0.02
        assert abs(z[seen].mean() - at[1]) < 0.02
    checked = 0
    for p, q, face in zip(x[item == 1], z[item == 1], primitive[item == 1], strict=True):
        outline = corners[faces[face]][:, [0, 2]]
        edges = np.roll(outline, -1, axis=0) - outline
        sides = edges[:, 0] * (q - outline[:, 1]) - edges[:, 1] * (p - outline[:, 0])
        assert (sides <= 1e-6).all() or (sides >= -1e-6).all()
        checked += 1
    assert checked > 8000
    assert set(np.unique(primitive[item == 1])) == set(range(len(faces)))


@pytest.mark.parametrize("wrap", ["repeat", "clamp", "mirror"])
@pytest.mark.parametrize("pixels", ["bytes", "floats"])
def test_albedo_shows_the_texels_of_a_texture(wrap, pixels):
    rng = np.random.default_rng(2)
    values = rng.integers(0, 256, (4, 3, 3), np.uint8) if pixels == "bytes" else rng.random((4, 3, 3), np.float32)
    texture = iso.ImageTexture(values, wrap=wrap, filter="nearest")
    linear = values.astype(np.float64)
    if pixels == "bytes":
        c = values / 255
        linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    # Texture coordinates from −1 to 2 over the plane, u to the right and v up (−z).
    uv = [(-1, 2), (-1, -1), (2, -1), (2, 2)]
    mesh = iso.Mesh(plane(2).vertices, plane(2).faces, attributes={"uv": np.array(uv, float)})
    image = render([iso.Item(mesh, iso.Matte(texture))], [WHITE_SKY], TOP, size=(90, 120), samples=1)
    rows, columns = np.mgrid[:120, :90]
    u, v = (columns + 0.5) / 90 * 3 * 0.75 - 1 + 3 * 0.125, 2 - (rows + 0.5) / 120 * 3
    assert np.allclose(image.channels["uv"], np.stack([u, v], 2), atol=1e-5)
    i, j = np.floor(u * 3).astype(int), np.floor((1 - v) * 4).astype(int)

    def place(k: np.ndarray, n: int) -> np.ndarray:
        if wrap == "clamp":
            return np.clip(k, 0, n - 1)
        if wrap == "repeat":
            return k % n
        return np.where(k % (2 * n) < n, k % (2 * n), 2 * n - 1 - k % (2 * n))

    assert np.abs(image.channels["albedo"] - linear[place(j, 4), place(i, 3)]).max() < 1e-6


def test_bilinear_texture_on_a_ramp():
    texture = iso.ImageTexture(np.array([[[0.0] * 3, [1.0] * 3]], np.float32), wrap="clamp")
    mesh = iso.Mesh(
        plane(2).vertices, plane(2).faces, attributes={"uv": np.array([(0, 1), (0, 0), (1, 0), (1, 1)], float)}
    )
    image = render([iso.Item(mesh, iso.Matte(texture))], [WHITE_SKY], TOP, size=(64, 64), samples=1)
    u = (np.arange(64) + 0.5) / 64
    assert np.allclose(image.channels["albedo"][..., 0], np.clip(2 * u - 0.5, 0, 1), atol=1e-5)


def test_variance_is_that_of_the_mean():
    """Over 32 seeds, independent samples: the mean of the claimed variances is the variance of the pictures."""
    items = [iso.Item(plane(4)), iso.Item(box(0.6)).translate((0.2, 0.3, 0))]
    lights = [iso.RectLight(size=(1, 1), power=20).at((0.5, 2, 0.5)), iso.Sky(strength=0.3)]
    runs = [render(items, lights, TOP, size=(16, 16), samples=16, seed=s, pattern="independent") for s in range(32)]
    found = np.var([run.channels["colour"].astype(np.float64) for run in runs], axis=0, ddof=1)
    claimed = np.mean([run.channels["variance"].astype(np.float64) for run in runs], axis=0)
    # Each pixel's estimate has 31 degrees of freedom; all together they are good to some percent.
    assert found.sum() / claimed.sum() == pytest.approx(1, abs=0.06)
    noisy = claimed > np.median(claimed)
    ratio = found[noisy] / claimed[noisy]
    assert np.quantile(ratio, 0.001) > 0.2
    assert np.quantile(ratio, 0.999) < 2.6


# --- instances and transforms ---------------------------------------------------------------------


def instance_scene(shared: bool) -> list[iso.Item]:
    """Seven spheres of 20,480 triangles with normals, texture coordinates and lights among them."""
    sphere = icosphere(5, 0.4, smooth=True)
    attributes = {"normal": sphere.normals, "uv": sphere.vertices[:, :2] * 3}
    materials = [
        iso.Matte(iso.ImageTexture(np.random.default_rng(1).random((8, 8, 3), np.float32), filter="nearest")),
        iso.Mirror((0.9, 0.8, 0.7)),
        iso.Matte((0.9, 0.1, 0.1)),
        iso.Emitter((2, 1, 0.5)),
    ]
    base = sphere.with_(attributes=attributes)
    items = []
    for k in range(7):
        mesh = base if shared else iso.Mesh(base.vertices, base.faces, attributes=attributes)
        turn = iso.Transform.identity().rotate((1, k, 2), k).scale((1 - 2 * (k % 2), 1, 0.5 + k / 5))
        items.append(iso.Item(mesh, materials[k % 4], turn.rotate("y", k / 3)).translate((k % 3 - 1, 0.5, k // 3 - 1)))
    return [*items, iso.Item(plane(6))]


def test_instances_look_like_copies():
    lights = [iso.Sky(strength=0.5), iso.PointLight((1, 3, 2), 50)]
    camera = iso.Camera((0.5, 3, 4), (0, 0.3, 0))
    pair = [
        render(instance_scene(s), lights, camera, size=(72, 56), samples=64, pattern="independent")
        for s in (True, False)
    ]
    a, b = (image.channels for image in pair)
    assert (a["item"] != b["item"]).mean() < 2e-3
    same = (a["item"] == b["item"]) & (a["primitive"] == b["primitive"]) & (a["item"] >= 0)
    assert same.mean() > 0.6
    assert np.abs(a["depth"][same] - b["depth"][same]).max() < 1e-4
    assert np.quantile(np.abs(a["normal"] - b["normal"])[same].max(axis=1), 0.995) < 1e-3
    assert np.quantile(np.abs(a["albedo"] - b["albedo"])[same].max(axis=1), 0.99) < 1e-5
    deviation = (a["colour"] - b["colour"]) / np.sqrt(a["variance"] + b["variance"] + 1e-8)
    assert np.abs(deviation[same]).mean() < 0.3
    assert np.allclose(mean(pair[0]), mean(pair[1]), rtol=5e-3)


@pytest.mark.parametrize("baked", [True, False])
@pytest.mark.parametrize("mirrored", [True, False])
def test_emitters_shine_outward_under_any_transform(baked, mirrored, monkeypatch):
    """A closed box shines outside and is dark inside; one of glass keeps its inside and vanishes in a furnace."""
    monkeypatch.setattr(lower_geometry, "_BAKED_TRIANGLES", 10**9 if baked else 0)
    mesh = box(1)
    scale = (-1.0, 1.2, 0.8) if mirrored else (1.0, 1.2, 0.8)
    items = [iso.Item(mesh, iso.Emitter((3, 2, 1))).scale(scale).rotate("y", 0.3).translate((x, 0, 0)) for x in (0, 9)]
    outside = render(items, (), iso.Camera((0.5, 1, 4), (0, 0, 0), fov_degrees=5), samples=2)
    assert np.allclose(mean(outside), (3, 2, 1))
    inside = render(items, (), iso.Camera((0, 0, 0), (0.2, 0.1, -1), fov_degrees=80), samples=2)
    assert not mean(inside).any()
    near_floor = iso.Item(plane(3), iso.Matte((1, 1, 1))).translate((0, -0.7, 0))
    lit = render(
        [*items, near_floor], (), iso.Camera((0.9, 1, 4), (0.8, -0.7, 0), fov_degrees=1), samples=64, max_depth=2
    )
    assert mean(lit).min() > 0.05
    glass = [item.with_(material=iso.Glass(1.5)) for item in items]
    image = render(glass, [WHITE_SKY], iso.Camera((0.5, 1, 4), (0, 0, 0), fov_degrees=20), samples=16, max_depth=1000)
    assert np.abs(image.channels["colour"] - 1).max() < 1e-4


def test_items_that_share_a_mesh_have_their_own_materials(monkeypatch):
    monkeypatch.setattr(lower_geometry, "_BAKED_TRIANGLES", 0)
    mesh = plane(0.5)
    colours = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    items = [iso.Item(mesh, iso.Matte(c)).translate((k - 1) * np.array([0.6, 0, 0])) for k, c in enumerate(colours)]
    image = render(items, [WHITE_SKY], TOP, size=(60, 60), samples=1)
    for k, c in enumerate(colours):
        seen = image.channels["item"] == k
        assert seen.any()
        assert (image.channels["albedo"][seen] == c).all()
        # Pixels at the rim see the sky too.
        assert np.allclose(np.median(image.channels["colour"][seen], axis=0), c)
