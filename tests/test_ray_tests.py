"""Rays against single shapes over arrays: exact rational arithmetic, closed forms, fine meshes, bad input."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import isophote as iso
from isophote.analysis import (
    ray_box,
    ray_cone,
    ray_cylinder,
    ray_plane,
    ray_polygon,
    ray_quadric,
    ray_sphere,
    ray_torus,
    ray_triangle,
)
from isophote.errors import GeometryError

NOTHING = float("inf")
STAR = [(0, 0), (4, 0), (4, 4), (2, 1), (0, 4)]
HOLE = [(1, 0.5), (1, 1.5), (1.5, 1)]


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def fractions(values: np.ndarray) -> list[Fraction]:
    return [Fraction(v) for v in np.asarray(values, float).tolist()]


def dot(a: list[Fraction], b: list[Fraction]) -> Fraction:
    return sum((p * q for p, q in zip(a, b, strict=True)), Fraction(0))


def exact_plane(o: np.ndarray, d: np.ndarray, p: np.ndarray, n: np.ndarray) -> Fraction | None:
    o, d, p, n = map(fractions, (o, d, p, n))
    across = dot(n, d)
    return None if across == 0 else dot(n, [a - b for a, b in zip(p, o, strict=True)]) / across


def exact_cross(a: list[Fraction], b: list[Fraction]) -> list[Fraction]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def exact_triangle(o: np.ndarray, d: np.ndarray, v: np.ndarray) -> Fraction | None:
    """Distance, or None: solved for distance and weights, with nothing rounded."""
    a, b, c = (fractions(corner) for corner in v)
    origin, direction = fractions(o), fractions(d)
    e1, e2 = ([x - y for x, y in zip(end, a, strict=True)] for end in (b, c))
    p = exact_cross(direction, e2)
    scale = dot(e1, p)
    if scale == 0:
        return None
    s = [x - y for x, y in zip(origin, a, strict=True)]
    q = exact_cross(s, e1)
    u, w = dot(s, p) / scale, dot(direction, q) / scale
    return dot(e2, q) / scale if u >= 0 and w >= 0 and u + w <= 1 else None


def rays(rng: np.random.Generator, count: int, reach: float = 3.0) -> tuple[np.ndarray, np.ndarray]:
    return rng.normal(size=(count, 3)) * reach, rng.normal(size=(count, 3))


def test_planes_are_met_where_rational_arithmetic_says(rng: np.random.Generator) -> None:
    o, d = rays(rng, 300)
    p, n = rng.normal(size=(300, 3)), rng.normal(size=(300, 3))
    # Some along the plane, exactly.
    n[::7], d[::7] = (0, 2, 0), rng.normal(size=(43, 3)) * (1, 0, 1)
    found = ray_plane(o, d, p, n)
    for i in range(300):
        exact = exact_plane(o[i], d[i], p[i], n[i])
        assert (exact is None) == np.isnan(found.distances[i, 0])
        if exact is not None:
            assert found.distances[i, 0] == pytest.approx(float(exact), rel=1e-12, abs=1e-13)
            assert found.hit[i] == (exact >= 0)
    assert found.hit.any()
    assert not found.hit[::7].any()
    met = found.hit
    assert np.abs(((found.point - p) * n).sum(axis=1))[met].max() < 1e-12
    assert np.allclose(np.linalg.norm(found.normal[met], axis=1), 1)


@pytest.mark.parametrize("grid", [True, False], ids=["grid", "anywhere"])
def test_triangles_are_met_where_rational_arithmetic_says(rng: np.random.Generator, grid: bool) -> None:
    """On a grid many rays pass through edges and corners, or in the triangle's plane."""
    shape: tuple[int, ...] = (600, 3)
    draw: Callable[..., np.ndarray] = (
        (lambda size: rng.integers(-2, 3, size).astype(float)) if grid else (lambda size: rng.normal(size=size))
    )
    o, v = draw(shape), draw((600, 3, 3))
    weights = rng.dirichlet((1, 1, 1), 600)
    d = draw(shape) if grid else (weights[:, :, None] * v).sum(axis=1) + rng.normal(size=shape) * 0.3 - o
    d[~d.any(axis=1)] = (1, 0, 0)
    found = ray_triangle(o, d, v)
    exact = [exact_triangle(*row) for row in zip(o, d, v, strict=True)]
    assert (~np.isnan(found.distances[:, 0])).tolist() == [t is not None for t in exact]
    met = [i for i, t in enumerate(exact) if t is not None]
    assert len(met) > 60
    for i in met:
        assert found.distances[i, 0] == pytest.approx(float(exact[i]), rel=1e-9, abs=1e-12)  # type: ignore[arg-type]


def test_no_ray_slips_between_triangles_that_share_an_edge(rng: np.random.Generator) -> None:
    """Rays at points of the edge of two triangles, which only rounding keeps from it."""
    a, b = rng.normal(size=(2, 2000, 3))
    left, right = rng.normal(size=(2, 2000, 3)) + np.array([[[0.0, 0, 5]], [[0, 0, -5]]])
    o = rng.normal(size=(2000, 3)) + np.array([30.0, 0, 0])
    share = rng.uniform(0.1, 0.9, (2000, 1))
    d = a + (b - a) * share - o
    first = ray_triangle(o, d, np.stack([a, b, left], axis=1)).hit
    second = ray_triangle(o, d, np.stack([b, a, right], axis=1)).hit
    # Seen from the side both may lie behind the edge's outline; then the ray leaves by it.
    opposite = np.sign(np.einsum("ni,ni->n", np.cross(d, a - o), left - o)) != np.sign(
        np.einsum("ni,ni->n", np.cross(d, a - o), right - o)
    )
    assert opposite.sum() > 500
    assert (first | second)[opposite].all()


def exact_inside(ring: list[tuple[Fraction, Fraction]], x: Fraction, y: Fraction) -> bool | None:
    """Whether a ring goes round a point an odd number of times; None on it."""
    odd = False
    for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1], strict=True):
        side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        if side == 0 and min(ax, bx) <= x <= max(ax, bx) and min(ay, by) <= y <= max(ay, by):
            return None
        if (ay > y) != (by > y) and (side > 0) == (by > ay):
            odd = not odd
    return odd


def test_polygons_are_met_where_rational_arithmetic_says(rng: np.random.Generator) -> None:
    """A concave polygon with a hole in the plane z = 1, hit at points of a grid, edges and corners among them."""
    outline, hole = [(*p, 1) for p in STAR], [(*p, 1) for p in HOLE]
    polygon = iso.Polygon(outline, [hole])
    x, y = np.meshgrid(np.arange(-0.5, 4.75, 0.25), np.arange(-0.5, 4.75, 0.25))
    target = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], axis=1)
    o = np.round(rng.normal(size=target.shape) * 4) / 4 + (0, 0, 8)
    found = ray_polygon(o, target - o, polygon)
    rings = [[(Fraction(a), Fraction(b)) for a, b in ring] for ring in (STAR, HOLE)]
    for place, hit in zip(target, found.hit, strict=True):
        sides = [exact_inside(ring, Fraction(place[0]), Fraction(place[1])) for ring in rings]
        assert hit == (None in sides or sides[0] != sides[1])
    assert found.distance[found.hit] == pytest.approx(1)
    # The same polygon, turned: the traced scene says the same, but for its rim.
    turn = iso.Transform.identity().rotate((1, 2, 3), 0.8).translate((5, -2, 1)).matrix
    points = [np.array(ring) @ turn[:3, :3].T + turn[:3, 3] for ring in (outline, hole)]
    turned = iso.Polygon(points[0], [points[1]])
    o, d = rays(rng, 4000)
    d = np.array([2, 2, 1]) + rng.uniform(-3, 3, (4000, 3)) * (1, 1, 0) - o
    o, d = (o @ turn[:3, :3].T + turn[:3, 3]).astype(np.float32), (d @ turn[:3, :3].T).astype(np.float32)
    traced = iso.Tracer(turned).closest(o, d)
    expected = ray_polygon(o, d, turned)
    assert (traced.hit != expected.hit).sum() <= 2
    both = traced.hit & expected.hit
    assert both.sum() > 500
    assert np.allclose(traced.distance[both], expected.distance[both], rtol=1e-6)


def test_spheres_against_the_quadratic_formula(rng: np.random.Generator) -> None:
    o, d = rays(rng, 2000, reach=1.5)
    c, r = rng.normal(size=(2000, 3)), rng.uniform(0.5, 2, 2000)
    found = ray_sphere(o, d, c, r)
    a, b, e = (d * d).sum(1), ((o - c) * d).sum(1), ((o - c) ** 2).sum(1) - r * r
    with np.errstate(invalid="ignore"):
        root = np.sqrt(b * b - a * e)
    expected = np.stack([(-b - root) / a, (-b + root) / a], axis=1)
    assert np.allclose(found.distances, expected, rtol=1e-9, atol=1e-9, equal_nan=True)
    assert 200 < found.hit.sum() < 1900
    gap = np.linalg.norm(found.point - c, axis=1) - r
    assert np.abs(gap[found.hit]).max() < 1e-13
    assert np.allclose(found.normal[found.hit], ((found.point - c) / r[:, None])[found.hit])


def test_a_far_sphere_loses_nothing() -> None:
    """From 10⁶ radii away the textbook's discriminant is off by the radius; the chord is that of the closed form."""
    far, off = 1e6, 0.6
    found = ray_sphere([0, off, -far], [0, 0, 1])
    half = np.sqrt(1 - off * off)
    assert np.abs(found.distances[0] - [far - half, far + half]).max() < 3e-10


def quartic_roots(o: np.ndarray, d: np.ndarray, tube: float) -> np.ndarray:
    """Real roots of the torus of radius 1 about y, from companion matrices polished in extended precision."""
    o, d = o.astype(np.longdouble), d.astype(np.longdouble)
    flat = [0, 2]
    square = [d @ d, 2 * (o @ d), o @ o + 1 - np.longdouble(tube) ** 2]
    ring = [d[flat] @ d[flat], 2 * (o[flat] @ d[flat]), o[flat] @ o[flat]]
    f = np.polysub(np.polymul(square, square), 4 * np.array(ring))
    roots = np.roots(f.astype(float))
    real = np.sort(roots.real[np.abs(roots.imag) < 1e-6]).astype(np.longdouble)
    slope = np.polyder(f)
    for _ in range(20):
        step = np.polyval(f, real) / np.polyval(slope, real)
        real = real - np.where(np.abs(step) < 1e-3, step, 0)
    return np.sort(real[np.abs(np.polyval(f, real)) < 1e-15]).astype(float)


@pytest.mark.parametrize("tube", [0.3, 0.01, 0.9])
def test_tori_against_extended_precision(rng: np.random.Generator, tube: float) -> None:
    angle = rng.uniform(0, 2 * np.pi, 400)
    on_ring = np.stack([np.cos(angle), np.zeros(400), np.sin(angle)], axis=1)
    o = rng.normal(size=(400, 3)) * 2
    d = on_ring + rng.uniform(-1.5, 1.5, (400, 3)) * tube - o
    found = ray_torus(o, d, (0, 0, 0), (0, 1, 0), 1, tube)
    counts = set()
    for i in range(400):
        expected = quartic_roots(o[i], d[i], tube)
        mine = found.distances[i][~np.isnan(found.distances[i])]
        # Two roots next to each other, or none there: a grazing ray, told by the next test.
        if len(expected) > 1 and np.diff(expected).min() < 1e-5:
            continue
        assert len(mine) == len(expected)
        counts.add(len(mine))
        assert np.allclose(mine, expected, rtol=1e-9, atol=1e-11)
    assert {0, 2, 4} <= counts


@pytest.mark.parametrize(
    ("tube", "gap"), [(0.3, 1e-3), (0.3, 1e-6), (0.3, 1e-9), (0.3, 1e-12), (1e-3, 1e-3), (1e-3, 1e-6), (1e-3, 1e-9)]
)
def test_rays_that_graze_a_torus_meet_it_or_not(rng: np.random.Generator, tube: float, gap: float) -> None:
    """Tangents of outer circles of the tube, moved in or out by a part `gap` of the tube's radius: two crossings half a
    chord off the touching point, or none there."""
    angle, round_tube = rng.uniform(0, 2 * np.pi, 200), rng.uniform(-1.2, 1.2, 200)
    out = np.stack([np.cos(angle), np.zeros(200), -np.sin(angle)], axis=1)
    normal = out * np.cos(round_tube)[:, None] + np.array([0, 1, 0]) * np.sin(round_tube)[:, None]
    across = np.cross(np.array([0, 1.0, 0]), out)
    along = np.cross(across, normal)
    for sign, count in ((-1, 2), (1, 0)):
        place = out + normal * tube * (1 + sign * gap)
        found = ray_torus(place - 5 * along, along, (0, 0, 0), (0, 1, 0), 1, tube)
        near = np.abs(found.distances - 5) < 0.5 * tube
        assert (near.sum(axis=1) == count).all()
        if count:
            half = tube * np.sqrt(2 * gap)
            chord = np.nanmax(np.where(near, found.distances, np.nan), axis=1) - 5
            assert np.allclose(chord, half, rtol=0.05 + 2 * gap, atol=2e-8 * tube**0.5)


SOLIDS: dict[str, tuple[Callable[..., Any], tuple[Any, ...], iso.Field]] = {
    "sphere": (ray_sphere, ((0.1, 0.2, 0), 0.7), iso.sphere(0.7).translate((0.1, 0.2, 0))),
    "box": (ray_box, ((-0.5, -0.2, -0.4), (0.6, 0.5, 0.3)), iso.box((1.1, 0.7, 0.7)).translate((0.05, 0.15, -0.05))),
    "cylinder": (ray_cylinder, ((0, -0.5, 0), (0, 0.9, 0), 0.4), iso.cylinder(0.4, 1.4).translate((0, 0.2, 0))),
    "cone": (ray_cone, ((0, 0, -0.5), (0, 0, 0.7), 0.6), iso.cone(0.6, 1.2).along("z").translate((0, 0, 0.1))),
    "part": (ray_cone, ((-0.6, 0, 0), (0.6, 0, 0), 0.3, 0.7), iso.cone(0.3, 1.2, 0.7).along("x")),
    "torus": (ray_torus, ((0, 0.1, 0), (0, 0, 2), 0.7, 0.2), iso.torus(0.7, 0.2).along("z").translate((0, 0.1, 0))),
    "spindle": (ray_torus, ((0, 0, 0), (0, 1, 0), 0.4, 0.6), iso.torus(0.4, 0.6)),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_crossings_are_where_the_distance_changes_its_sign(rng: np.random.Generator, name: str) -> None:
    """Between crossings the middle is inside or outside by turns; at each the distance is zero, and its gradient is the
    normal."""
    function, arguments, field = SOLIDS[name]
    o, d = rng.normal(size=(3000, 3)) * 1.5, rng.normal(size=(3000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    found = function(o, d, *arguments)
    distances = np.concatenate([np.full((3000, 1), -9.0), found.distances, np.full((3000, 1), np.nan)], axis=1)
    for k in range(distances.shape[1] - 1):
        start, end = distances[:, k], np.where(np.isnan(distances[:, k + 1]), 9.0, distances[:, k + 1])
        apart = end - start > 1e-3
        middle = field((o + ((start + end) / 2)[:, None] * d)[apart])
        assert ((middle < 0) == (k % 2 == 1)).all()
    assert (np.diff(found.distances, axis=1) >= 0)[~np.isnan(found.distances[:, 1:])].all()
    met = found.hit
    assert 100 < met.sum() < 2900
    assert np.abs(field(found.point[met])).max() < 1e-6
    assert np.allclose(found.point[met], (o + np.where(met, found.distance, 0)[:, None] * d)[met], atol=1e-9)
    outward = field(found.point[met] + 1e-3 * found.normal[met])
    assert np.quantile(np.abs(outward - 1e-3), 0.97) < 1e-5


def test_endless_cylinders_and_rays_along_them() -> None:
    found = ray_cylinder([(0, 0, 0), (2, 0, 0), (0, 0, 5)], [(0, 1, 0), (0, 1, 0), (0, 1, -1)], (0, 0, 0), (0, 2, 0), 1,
                         endless=True)  # fmt: skip
    assert found.distance.tolist() == [NOTHING, NOTHING, 4.0]
    assert found.point[2].tolist() == [0, 4, 1]


QUADRICS = {
    "hyperboloid": (1, -1, 1, 0, 0, 0, 0, 0, 0, -0.1),
    "two sheets": (1, -1, 1, 0, 0, 0, 0, 0, 0, 0.1),
    "paraboloid": (1, 0, 1, 0, 0, 0, 0, -1, 0, 0),
    "saddle": (1, 0, -1, 0, 0, 0, 0, -1, 0, 0),
    "cone": (1, -1, 1, 0, 0, 0, 0, 0, 0, 0),
    "turned": (1, 2, 3, 0.5, -0.7, 1.1, 0.2, -0.1, 0.3, -0.5),
    "planes": (0, 0, 0, 0, 0, 0, 1, 2, -1, 0.2),
}


@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("name", QUADRICS)
def test_quadrics_against_a_fine_walk(rng: np.random.Generator, name: str, closed: bool) -> None:
    """The solid within its box, told point by point along each ray; without lids, by the polynomial's sign alone."""
    box = np.array([[-1.0, -0.8, -0.6], [0.7, 1.0, 0.9]])
    quadric = iso.Quadric(QUADRICS[name], box, closed)
    o, d = rng.normal(size=(400, 3)), rng.normal(size=(400, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    found = ray_quadric(o, d, QUADRICS[name], box, closed=closed)
    steps = np.linspace(-6, 6, 24_001)
    walked = 0
    for i in range(400):
        points = o[i] + steps[:, None] * d[i]
        in_box = ((points >= box[0]) & (points <= box[1])).all(axis=1)
        negative = quadric(points) < 0
        inside = negative & in_box if closed else negative
        changes = inside[1:] != inside[:-1]
        if not closed:
            changes &= in_box[1:] & in_box[:-1]
        expected = steps[:-1][changes] + 2.5e-4
        mine = found.distances[i][~np.isnan(found.distances[i])]
        # Stretches shorter than a step may be stepped over.
        if len(mine) > 1 and np.diff(mine).min() < 2e-3:
            continue
        if len(mine) == len(expected):
            walked += 1
            assert np.allclose(mine, expected, atol=6e-4)
    assert walked > 380


BAD: list[tuple[Callable[[], Any], str]] = [
    (lambda: ray_sphere([0, 0, 0], [0, 0, 0]), "directions must not be zero, but number 0"),
    (lambda: ray_sphere([0, 0, np.nan], [0, 0, 1]), "origins must be finite, but number 0"),
    (lambda: ray_sphere([0, 0, 0], [[0, 0, 1], [0, np.inf, 1]]), "directions must be finite, but number 1"),
    (lambda: ray_sphere([0, 0], [0, 0, 1]), "origins must have shape"),
    (lambda: ray_sphere([[0, 0, 0]] * 3, [[0, 0, 1]] * 2), "not of one length"),
    (lambda: ray_sphere([0, 0, 0], [0, 0, 1], radius=0), "radius must be above 0"),
    (lambda: ray_sphere([0, 0, 0], [0, 0, 1], radius=np.nan), "radius must be finite"),
    (lambda: ray_plane([0, 0, 0], [0, 0, 1], [0, 0, 0], [0, 0, 0]), "normal must not be zero"),
    (lambda: ray_box([0, 0, 0], [0, 0, 1], [0, 0, 0], [1, 0, 1]), "high must be above low"),
    (lambda: ray_cylinder([0, 0, 0], [0, 0, 1], (1, 1, 1), (1, 1, 1), 1), "must be two points"),
    (lambda: ray_cone([0, 0, 0], [0, 0, 1], (0, 0, 0), (0, 1, 0), 1, -1), "top must not be below 0"),
    (lambda: ray_torus([0, 0, 0], [0, 0, 1], (0, 0, 0), (0, 0, 0), 1, 0.1), "axis must not be zero"),
    (lambda: ray_torus([0, 0, 0], [0, 0, 1], (0, 0, 0), (0, 1, 0), 1, -0.1), "tube must be above 0"),
    (lambda: ray_quadric([0, 0, 0], [0, 0, 1], [1, 2]), "ten finite numbers"),
    (lambda: ray_quadric([0, 0, 0], [0, 0, 1], [0] * 9 + [1]), "no surface"),
    (lambda: ray_triangle([0, 0, 0], [0, 0, 1], [[0, 0], [1, 0], [0, 1]]), "triangles must have shape"),
    (lambda: ray_polygon([0, 0, 0], [0, 0, 1], [(0, 0, 0), (1, 0, 0), (2, 0, 0)]), "no area"),
]


@pytest.mark.parametrize("case", range(len(BAD)))
def test_bad_input_is_told(case: int) -> None:
    call, message = BAD[case]
    with pytest.raises(GeometryError, match=message):
        call()
