"""Rays against fields: analytic crossings, normals, nothing skipped, no surface met twice, at any scale and place."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import isophote as iso
from isophote.accel import field_tree
from isophote.errors import RenderError, SceneError
from isophote.lower import scene as lower_scene
from isophote.lower.latest import LatestScene
from isophote.shapes.field.tape import numpy_values

RNG = np.random.default_rng(11)


def followed(shape: iso.Field) -> iso.Field:
    """The same shape, followed as a field: a bare solid is traced as an exact primitive, one that was offset is not."""
    return shape.offset(0)


def rays(count: int, reach: float = 3.0, within: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Single-precision rays from a sphere of radius `reach` to points in a ball, and from within that ball."""
    origins = RNG.normal(size=(count, 3))
    origins *= reach / np.linalg.norm(origins, axis=1, keepdims=True)
    targets = RNG.uniform(-within, within, (count, 3))
    origins[: count // 3] = RNG.uniform(-within, within, (count // 3, 3))
    directions = targets - origins
    directions *= RNG.uniform(0.5, 2.0, (count, 1)) / np.linalg.norm(directions, axis=1, keepdims=True)
    return origins.astype(np.float32), directions.astype(np.float32)


def first_positive(roots: np.ndarray) -> np.ndarray:
    """The least root above 0 of each row, inf where there is none."""
    return np.where(roots > 1e-6, roots, np.inf).min(axis=1)


def quadratic(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(b * b - a * c)
        return np.nan_to_num(np.stack([(-b - root) / a, (-b + root) / a], axis=1), nan=-1.0)


def sphere_roots(o: np.ndarray, d: np.ndarray) -> np.ndarray:
    return quadratic((d * d).sum(1), (o * d).sum(1), (o * o).sum(1) - 0.8**2)


def box_roots(o: np.ndarray, d: np.ndarray) -> np.ndarray:
    half = np.array([0.5, 0.3, 0.7])
    near, far = np.sort(np.stack([(-half - o) / d, (half - o) / d]), axis=0)
    near, far = near.max(axis=1), far.min(axis=1)
    return np.where((near <= far)[:, None], np.stack([near, far], axis=1), -1.0)


def torus_roots(o: np.ndarray, d: np.ndarray) -> np.ndarray:
    """(|p|² + R² − r²)² = 4 R² (x² + z²), radii 0.7 and 0.25 about +y."""
    R, r = 0.7, 0.25
    found = np.full((len(o), 4), -1.0)
    for i, (p, v) in enumerate(zip(o, d, strict=True)):
        square = np.polynomial.Polynomial([p @ p + R * R - r * r, 2 * p @ v, v @ v])
        ring = np.polynomial.Polynomial([p[0] ** 2 + p[2] ** 2, 2 * (p[0] * v[0] + p[2] * v[2]), v[0] ** 2 + v[2] ** 2])
        roots = (square**2 - 4 * R * R * ring).roots()
        real = roots.real[np.abs(roots.imag) < 1e-7]
        found[i, : len(real)] = real
    return found


def cylinder_roots(o: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Radius 0.4, endless along y."""
    flat = [0, 2]
    return quadratic((d[:, flat] ** 2).sum(1), (o[:, flat] * d[:, flat]).sum(1), (o[:, flat] ** 2).sum(1) - 0.4**2)


def plane_roots(o: np.ndarray, d: np.ndarray) -> np.ndarray:
    return (-o[:, 1] / d[:, 1])[:, None]


SHAPES: dict[str, tuple[Callable[[], iso.Field], Callable[[np.ndarray, np.ndarray], np.ndarray]]] = {
    "sphere": (lambda: followed(iso.sphere(0.8)), sphere_roots),
    "box": (lambda: followed(iso.box((1.0, 0.6, 1.4))), box_roots),
    "torus": (lambda: followed(iso.torus(0.7, 0.25)), torus_roots),
    "cylinder": (lambda: followed(iso.cylinder(0.4)), cylinder_roots),
    "plane": (lambda: followed(iso.plane()), plane_roots),
}


@pytest.mark.parametrize("name", SHAPES)
def test_crossings_are_the_analytic_ones(name: str) -> None:
    shape, roots = SHAPES[name]
    o, d = rays(400 if name == "torus" else 4000)
    hits = iso.Tracer(shape()).closest(o, d)
    expected = first_positive(roots(o.astype(np.float64), d.astype(np.float64)))
    # Rays along a rim may go either way; anything else must not.
    differ = np.isfinite(expected) != hits.hit
    assert differ.sum() <= 2
    both = np.isfinite(expected) & hits.hit
    assert both.sum() > len(o) / 4
    length = expected[both] * np.linalg.norm(d[both], axis=1)
    error = np.abs(hits.distance[both] / expected[both] - 1) * np.minimum(length, 1)
    assert np.quantile(error, 0.95) < 2e-6
    assert error.max() < 1e-4
    assert (iso.Tracer(shape()).occluded(o, d) == hits.hit).all()


@pytest.mark.parametrize("name", ["sphere", "torus", "cylinder"])
def test_normals_are_those_of_the_shape(name: str) -> None:
    o, d = rays(2000)
    hits = iso.Tracer(SHAPES[name][0]()).closest(o, d)
    p = hits.point[hits.hit]
    flat = p * [1, 0, 1]
    axis = {"sphere": 0 * p, "cylinder": p * [0, 1, 0]}.get(name)
    if axis is None:
        axis = 0.7 * flat / np.linalg.norm(flat, axis=1, keepdims=True)
    normal = (p - axis) / np.linalg.norm(p - axis, axis=1, keepdims=True)
    assert np.linalg.norm(hits.normal[hits.hit] - normal, axis=1).max() < 1e-4


@pytest.mark.parametrize("offset", [0.0, 100.0])
@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e5])
def test_a_field_may_have_any_size_and_stand_anywhere(scale: float, offset: float) -> None:
    move = np.array([1.0, -0.7, 0.4]) * offset * scale
    o, d = rays(2000)
    expected = first_positive(sphere_roots(o.astype(np.float64), d.astype(np.float64))) * scale
    inside = iso.Tracer(followed(iso.sphere(0.8 * scale)).translate(move))
    placed = iso.Tracer(iso.Item(followed(iso.sphere(0.8))).scale(scale).translate(move))
    origins = (o * scale + move).astype(np.float32)
    # Single precision moves a ray this far sideways, and a grazing one by its root.
    slip = 4e-7 * (1 + offset)
    for tracer in (inside, placed):
        distance = tracer.closest(origins, d).distance
        both = np.isfinite(expected) & np.isfinite(distance)
        assert (both == np.isfinite(expected)).mean() > 0.998
        error = np.abs(distance[both] - expected[both]) / scale * np.linalg.norm(d[both], axis=1)
        assert np.median(error) < 2 * slip
        assert error.max() < 10 * np.sqrt(slip)


def test_an_item_that_is_stretched_is_an_ellipsoid() -> None:
    transform = iso.Transform.identity().scale((2.0, 0.5, 1.0)).rotate((1, 2, 3), 0.7).translate((0.3, -0.2, 0.1))
    o, d = rays(3000, within=1.5)
    inverse = np.linalg.inv(transform.matrix)
    local_o, local_d = o @ inverse[:3, :3].T + inverse[:3, 3], d @ inverse[:3, :3].T
    expected = first_positive(sphere_roots(local_o, local_d))
    hits = iso.Tracer(iso.Item(followed(iso.sphere(0.8)), transform=transform)).closest(o, d)
    assert (np.isfinite(expected) != hits.hit).sum() <= 2
    both = hits.hit & np.isfinite(expected)
    assert np.abs(hits.distance[both] - expected[both]).max() < 1e-4
    local = hits.point[both] @ inverse[:3, :3].T + inverse[:3, 3]
    normal = local @ inverse[:3, :3]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert np.abs(hits.normal[both] - normal).max() < 1e-3


def test_thin_walls_are_never_stepped_over() -> None:
    """A shell of 10⁻⁵ and discs as thin, from everywhere: each ray that goes through must meet them."""
    shell = iso.sphere(0.8) - iso.sphere(0.8 - 1e-5)
    o, d = rays(3000)
    expected = first_positive(sphere_roots(o.astype(np.float64), d.astype(np.float64)))
    hits = iso.Tracer(shell).closest(o, d)
    through = np.isfinite(expected)
    assert hits.hit[through].mean() > 0.999
    both = through & hits.hit
    assert np.abs(hits.distance[both] - expected[both]).max() < 1e-3
    fins = iso.box((1.0, 2e-5, 1.0)).repeat((0, 0.1, 0), count=(1, 9, 1))
    o = np.stack([RNG.uniform(-0.4, 0.4, 3000), np.full(3000, 2.0), RNG.uniform(-0.4, 0.4, 3000)], axis=1)
    hits = iso.Tracer(fins).closest(o, (0.05, -1.0, 0.02))
    assert hits.hit.all()
    assert np.abs(hits.distance - 1.6).max() < 1e-4


BENT = {
    "twisted": iso.box((0.6, 1.6, 0.4)).twist(1.5),
    "blended": iso.union(*(iso.sphere(0.3).translate((x, 0.2 * x * x, 0)) for x in (-0.6, -0.2, 0.2, 0.6)), blend=0.2),
    "rounded": iso.box(1.2).round(0.1) - iso.cylinder(0.3),
    "pierced": (iso.sphere(0.9) & iso.box(1.4)) - iso.cylinder(0.4) - iso.cylinder(0.4).along("x"),
}


@pytest.mark.parametrize("name", BENT)
def test_the_first_change_of_sign_is_found(name: str) -> None:
    """Against a dense walk along each ray, in double precision."""
    field = BENT[name]
    o, d = rays(300)
    hits = iso.Tracer(field).closest(o, d)
    length = np.linalg.norm(d, axis=1)
    places = np.linspace(0, 5, 4001)
    points = o[:, None].astype(np.float64) + (places[:, None] / length[:, None, None]) * d[:, None]
    values = numpy_values(field.form, points.reshape(-1, 3)).reshape(points.shape[:2])
    changed = (values < 0) != (values[:, :1] < 0)
    expected = np.where(changed.any(axis=1), places[changed.argmax(axis=1)], np.inf)
    found = hits.distance * length
    step = places[1]
    # What the walk sees must not be missed, and what is met must be a crossing.
    assert (found <= expected + 1e-5).all()
    early = hits.hit & (found < expected - step)
    at = o[hits.hit].astype(np.float64) + hits.distance[hits.hit, None] * d[hits.hit].astype(np.float64)
    assert np.abs(numpy_values(field.form, at)).max() < 2e-6
    assert early.mean() < 0.02


def blobs(count: int = 200) -> iso.Field:
    rng = np.random.default_rng(5)
    parts = zip(rng.uniform(-1, 1, (count, 3)).tolist(), rng.uniform(0.05, 0.15, count).tolist(), strict=True)
    return iso.union(*(iso.sphere(radius).translate(place) for place, radius in parts), blend=0.05)


def without_regions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(field_tree, "_SHORT", 10**9)
    monkeypatch.setattr(lower_scene, "_latest", LatestScene())


def test_regions_with_shorter_tapes_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    shape = blobs()
    o, d = rays(4000)
    pruned = iso.Tracer(shape).closest(o, d)
    without_regions(monkeypatch)
    whole = iso.Tracer(shape).closest(o, d)
    assert (pruned.hit == whole.hit).mean() > 0.9995
    both = pruned.hit & whole.hit
    assert np.abs(pruned.distance[both] - whole.distance[both]).max() < 1e-4


def test_trees_are_the_same_for_any_threads() -> None:
    from isophote.lower.scene import lower_scene

    tables = []
    for threads in (1, 2, 5):
        scene = iso.Scene([iso.Item(blobs())], camera=iso.Camera((0, 0, 3), (0, 0, 0)))
        arrays = lower_scene(scene, (1, 1), threads).arrays["fields"].arrays
        tables.append([arrays[name].tobytes() for name in ("rows", "tapes", "nodes")])
    assert tables[0] == tables[1] == tables[2]


def test_many_items_are_found_through_the_tree_over_their_boxes() -> None:
    """Against each of them alone, meshes among them."""
    rng = np.random.default_rng(3)
    ball, cube = followed(iso.sphere(0.12)), followed(iso.box(0.2))
    mesh = iso.Mesh([(-1, -1, 0), (1, -1, 0), (0, 1, 0)], [(0, 1, 2)])
    items = [
        iso.Item(ball if i % 2 else cube).rotate((1, 1, 0), 0.3 * i).translate(place)
        for i, place in enumerate(rng.uniform(-1, 1, (40, 3)))
    ]
    items += [iso.Item(mesh).scale(0.4).translate(place) for place in rng.uniform(-1, 1, (5, 3))]
    o, d = rays(3000)
    together = iso.Tracer(iso.Scene(items)).closest(o, d)
    alone = np.stack([iso.Tracer(item).closest(o, d).distance for item in items])
    assert (together.hit == np.isfinite(alone.min(axis=0))).all()
    met = together.hit
    assert np.abs(together.distance[met] - alone.min(axis=0)[met]).max() < 1e-5
    assert (alone[together.item[met], np.flatnonzero(met)] - together.distance[met] < 1e-5).all()
    assert (iso.Tracer(iso.Scene(items)).occluded(o, d) == met).all()
    assert np.abs(np.linalg.norm(together.normal[met], axis=1) - 1).max() < 1e-5


def test_a_limit_hides_what_lies_beyond() -> None:
    tracer = iso.Tracer(followed(iso.sphere(1)))
    assert tracer.closest([0, 0, 3], [0, 0, -1], 1.9).item[0] == -1
    assert tracer.closest([0, 0, 3], [0, 0, -1], 2.1).distance[0] == pytest.approx(2, abs=1e-6)
    assert not tracer.occluded([0, 0, 3], [0, 0, -1], 1.9)[0]


def test_endless_fields_end_at_a_stated_distance() -> None:
    scene = iso.Scene([iso.Item(followed(iso.plane())), iso.Item(iso.sphere(0.5).translate((0, 0.5, 0)))])
    tracer = iso.Tracer(scene)
    grazing = tracer.closest([0, 1, 5], [0, -0.01, 1])
    assert grazing.distance[0] == pytest.approx(100, rel=1e-5)
    assert tracer.closest([0, 1, 5], [0, 0.01, 1]).item[0] == -1
    with pytest.raises(RenderError, match="beyond which endless shapes are not followed, but number 1 is"):
        tracer.closest([(0, 1, 5), (0, 1e6, 0)], [0, -1, 0])


def test_flat_fields_have_no_body() -> None:
    with pytest.raises(SceneError, match="extrude or revolve it"):
        iso.Tracer(iso.circle(1.0))
