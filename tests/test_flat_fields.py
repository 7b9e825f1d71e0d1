"""Fields in the plane: primitives against their outlines, points by points; pictures against their pixels."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import cKDTree

import isophote as iso
from isophote.shapes.field.tape import numpy_values

T = np.linspace(0, 1, 20_001)[:, None]


def at(field: Any, points: Any) -> Any:
    return numpy_values(field.form, np.asarray(points, np.float64))


def lines(corners: Any) -> Any:
    """Points along a closed polygon."""
    corners = np.asarray(corners, np.float64)
    after = np.roll(corners, -1, axis=0)
    return np.concatenate([a + (b - a) * T for a, b in zip(corners, after, strict=True)])


def turn(middle: Any, radius: float, start: float, end: float) -> Any:
    angle = start + (end - start) * T
    return np.asarray(middle) + radius * np.concatenate([np.cos(angle), np.sin(angle)], axis=1)


def star_corners(points: int, radius: float, inner: float) -> Any:
    angle = np.arange(2 * points) * math.pi / points
    reach = np.where(np.arange(2 * points) % 2 == 0, radius, inner)
    return np.column_stack([reach * np.sin(angle), reach * np.cos(angle)])


def in_polygon(corners: Any, points: Any) -> Any:
    """By the even-odd rule: crossings of a ray to the right."""
    a, b = np.asarray(corners), np.roll(corners, -1, axis=0)
    x, y = points.T
    over = (a[:, 1, None] <= y) != (b[:, 1, None] <= y)
    with np.errstate(all="ignore"):
        cut = a[:, 0, None] + (y - a[:, 1, None]) / (b - a)[:, 1, None] * (b - a)[:, 0, None]
    return (over & (cut > x)).sum(axis=0) % 2 == 1


def stroke(radius: float, thickness: float, start: float, end: float) -> Any:
    half = thickness / 2
    parts = [turn((0, 0), r, start, end) for r in (radius - half, radius + half)]
    for angle, first in ((start, start + math.pi), (end, end)):
        middle = (radius * math.cos(angle), radius * math.sin(angle))
        parts.append(turn(middle, half, first, first + math.pi))
    return np.concatenate(parts)


BOX = [(-1, -0.5), (1, -0.5), (1, 0.5), (-1, 0.5)]


def cornered(field: Any, corners: Any) -> tuple[Any, Any, Any]:
    """A field, points along its outline, and what tells inside from outside."""
    return field, lines(corners), lambda p: in_polygon(corners, p)


SHAPES: dict[str, tuple[Any, Any, Any]] = {
    "circle": (iso.circle(0.7), turn((0, 0), 0.7, 0, 2 * math.pi), lambda p: np.hypot(*p.T) < 0.7),
    "rectangle": cornered(iso.rectangle((2, 1)), BOX),
    "square": cornered(iso.rectangle(1), np.array(BOX) * (0.5, 1)),
    "star": cornered(iso.star(5, 1.5, 0.6), star_corners(5, 1.5, 0.6)),
    "rhombus": cornered(iso.star(2, 1.5, 0.6), star_corners(2, 1.5, 0.6)),
    "gear": cornered(iso.star(12, 1.5, 1.2), star_corners(12, 1.5, 1.2)),
    "polygon": cornered(iso.polygon(star_corners(7, 1, 0.3)), star_corners(7, 1, 0.3)),
}
NAMES = ("arc", "circle", "image", "polygon", "rectangle", "rounded_rectangle", "segment", "star")
POINTS = np.random.default_rng(0).uniform(-2, 2, (2000, 2))


@pytest.mark.parametrize("name", SHAPES)
def test_values_are_signed_distances_to_the_outline(name):
    field, outline, inside = SHAPES[name]
    expected = np.where(inside(POINTS), -1, 1) * cKDTree(outline).query(POINTS)[0]
    assert np.abs(at(field, POINTS) - expected).max() < 1e-4
    assert field.exactness.name == "EXACT"
    assert field.lipschitz == 1.0


@pytest.mark.parametrize(("start", "end"), [(0.3, 1.2), (-1.0, 3.0), (2.0, 7.5), (-0.5, 0.5), (0.0, math.pi)])
def test_arcs_are_strokes_with_round_ends(start, end):
    field = iso.arc(1.0, 0.4, start, end)
    angle = np.linspace(start, end, 20001)
    centre = cKDTree(np.column_stack([np.cos(angle), np.sin(angle)])).query(POINTS)[0] - 0.2
    assert np.abs(at(field, POINTS) - centre).max() < 1e-4
    assert np.abs(np.abs(at(field, POINTS)) - cKDTree(stroke(1.0, 0.4, start, end)).query(POINTS)[0]).max() < 0.2 + 1e-4
    assert field.exactness.name == "EXACT"


def test_a_whole_arc_is_a_ring():
    assert at(iso.arc(1.0, 0.4), POINTS) == pytest.approx(np.abs(np.hypot(*POINTS.T) - 1) - 0.2)
    turned = iso.arc(1.0, 0.4, 1.0, 1.0 + math.tau)
    assert at(turned, POINTS) == pytest.approx(np.abs(np.hypot(*POINTS.T) - 1) - 0.2, abs=1e-9)


def test_segments_and_rounded_rectangles():
    field = iso.segment((-1, 0.5), (0.5, -0.5), 0.25)
    along = np.array([-1, 0.5]) + T * np.array([1.5, -1.0])
    assert np.abs(at(field, POINTS) - cKDTree(along).query(POINTS)[0] + 0.25).max() < 1e-4
    rounded = iso.rounded_rectangle((2, 1), 0.2)
    assert at(rounded, POINTS) == pytest.approx(at(iso.rectangle((1.6, 0.6)), POINTS) - 0.2)
    assert at(iso.rounded_rectangle(2, 1), POINTS) == pytest.approx(np.hypot(*POINTS.T) - 1)


@pytest.mark.parametrize("name", [*SHAPES, "arc", "segment", "rounded", "image"])
def test_bounds_are_tight_and_repr_pastes_back(name):
    more = {
        "arc": iso.arc(1, 0.4, 0.3, 2.5),
        "segment": iso.segment((-1, 0.5), (0.5, -0.5), 0.25),
        "rounded": iso.rounded_rectangle((2, 1), 0.2),
        "image": iso.image([[True, False, False], [True, True, False]], pixel=0.4),
    }
    field = SHAPES[name][0] if name in SHAPES else more[name]
    box = field.bounds
    dense = np.random.default_rng(1).uniform(box[0] - 0.2, box[1] + 0.2, (40_000, 2))
    held = dense[at(field, dense) <= 0]
    assert (held >= box[0]).all()
    assert (held <= box[1]).all()
    assert np.abs(held.min(axis=0) - box[0]).max() < 0.06
    assert np.abs(held.max(axis=0) - box[1]).max() < 0.06
    names = {name: getattr(iso, name) for name in NAMES}
    assert eval(repr(field), names) == field
    assert hash(eval(repr(field), names)) == hash(field)


def test_compiled_values_are_those_of_numpy():
    fields = [shape[0] for shape in SHAPES.values()]
    fields += [iso.arc(1, 0.4, 0.3, 2.5), iso.image(np.eye(4, dtype=bool), pixel=0.3)]
    for field in fields:
        assert np.abs(field(POINTS) - at(field, POINTS)).max() < 2e-6


def test_operations_in_the_plane():
    both = (iso.circle(1) | iso.rectangle(1).translate((1, 0))) - iso.circle(0.3)
    expected = np.maximum(
        np.minimum(at(iso.circle(1), POINTS), at(iso.rectangle(1), POINTS - (1, 0))), -at(iso.circle(0.3), POINTS)
    )
    assert at(both, POINTS) == pytest.approx(expected)
    turned = iso.rectangle((2, 1)).rotate(0.5)
    c, s = math.cos(0.5), math.sin(0.5)
    assert at(turned, POINTS) == pytest.approx(at(iso.rectangle((2, 1)), POINTS @ np.array([[c, -s], [s, c]])))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: iso.circle(-1), "radius must be a finite number above 0"),
        (lambda: iso.circle("wide"), "radius must be a finite number above 0"),
        (lambda: iso.rectangle((1, 0)), "size must be 2 finite numbers above 0"),
        (lambda: iso.rectangle((1, 2, 3)), "size must be 2 finite numbers above 0"),
        (lambda: iso.rounded_rectangle((1, 2), 0.6), "must not be above half of the shorter side, 0.5"),
        (lambda: iso.star(1, 1, 0.5), "points must be a whole number from 2"),
        (lambda: iso.star(5, 1, 1.5), "inner must not be above radius"),
        (lambda: iso.segment((0, 0), (0, 0), 1), "use a circle for a dot"),
        (lambda: iso.arc(1, 0.1, 1, 1), "end must be above start"),
        (lambda: iso.arc(1, 0.1, 0, 7), "by 2π at most"),
        (lambda: iso.circle(1)([[0, 0, 0]]), r"points must have shape \(n, 2\)"),
        (lambda: iso.circle(1) | iso.sphere(1), "extrude or revolve"),
    ],
)
def test_shapes_that_cannot_be_are_refused(make, message):
    with pytest.raises(iso.GeometryError, match=message):
        make()


# --- pictures -------------------------------------------------------------------------------------


def pixel_sides(mask: Any, pixel: float) -> Any:
    """(k, 4): the sides between black and white pixels, white around."""
    wide = np.pad(np.asarray(mask, bool), 1)
    height, width = np.shape(mask)
    sides = []
    for i, j in np.ndindex(wide.shape):
        x, y = j - 1 - width / 2, height / 2 - (i - 1)
        if j + 1 < wide.shape[1] and wide[i, j] != wide[i, j + 1]:
            sides.append((x + 1, y, x + 1, y - 1))
        if i + 1 < wide.shape[0] and wide[i, j] != wide[i + 1, j]:
            sides.append((x, y - 1, x + 1, y - 1))
    return np.array(sides) * pixel


def pixel_distance(mask: Any, pixel: float, points: Any) -> Any:
    sides = pixel_sides(mask, pixel)
    start, along = sides[:, :2], sides[:, 2:] - sides[:, :2]
    t = np.clip(((points[:, None] - start) * along).sum(axis=2) / (along**2).sum(axis=1), 0, 1)
    distance = np.linalg.norm(points[:, None] - start - t[..., None] * along, axis=2).min(axis=1)
    height, width = np.shape(mask)
    column, row = np.floor(points[:, 0] / pixel + width / 2), np.floor(height / 2 - points[:, 1] / pixel)
    held = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    black = np.zeros(len(points), bool)
    black[held] = np.asarray(mask, bool)[row[held].astype(int), column[held].astype(int)]
    return np.where(black, -distance, distance)


@pytest.mark.parametrize("seed", range(4))
def test_pictures_are_the_outline_of_their_pixels(seed):
    rng = np.random.default_rng(seed)
    mask = rng.random((rng.integers(1, 12), rng.integers(1, 12))) < 0.4
    mask[0, 0] = True
    field = iso.image(mask, pixel=0.5)
    points = rng.uniform(-4, 4, (3000, 2))
    expected = pixel_distance(mask, 0.5, points)
    found = at(field, points)
    assert (np.sign(found) == np.sign(expected)).all()
    held = (np.abs(points) <= (np.array(mask.shape[::-1]) / 2 + 1) * 0.5).all(axis=1)
    assert np.abs(found - expected)[held].max() <= 0.5 * math.sqrt(2) / 4
    # Outside it promises no more space than there is.
    assert (np.abs(found) / field.lipschitz <= np.abs(expected) + 1e-7).all()
    lattice = np.stack(np.meshgrid(*[np.arange(-n - 2, n + 3) * 0.25 for n in mask.shape[::-1]]), axis=-1).reshape(
        -1, 2
    )
    lattice = lattice[(np.abs(lattice) <= (np.array(mask.shape[::-1]) + 2) * 0.25).all(axis=1)]
    exact = np.abs(pixel_distance(mask, 0.5, lattice))
    assert np.abs(np.abs(at(field, lattice)) - exact).max() < 1e-6


def test_files_arrays_and_thresholds(tmp_path):
    grey = np.array([[0, 100, 200, 255]], np.uint8)
    Image.fromarray(grey).save(tmp_path / "grey.png")
    for threshold, width in ((0.3, 1), (0.5, 2), (0.8, 3)):
        for picture in (tmp_path / "grey.png", grey, grey / 255):
            field = iso.image(picture, threshold)
            assert field.bounds.tolist() == [[-2, -0.5], [-2 + width, 0.5]]
    clear = np.zeros((2, 2, 4), np.uint8)
    clear[0, 0, 3] = 255
    Image.fromarray(clear).save(tmp_path / "clear.png")
    field = iso.image(tmp_path / "clear.png", pixel=2)
    assert field.bounds.tolist() == [[-2, 0], [0, 2]]
    assert repr(field) == f"image({str(tmp_path / 'clear.png')!r}, pixel=2)"


@pytest.mark.parametrize(
    ("image", "options", "kind", "message"),
    [
        (np.ones((3, 3)), {}, iso.GeometryError, "there is no inside; raise threshold="),
        (np.zeros((2, 2, 3)), {}, iso.GeometryError, r"must be \(h, w\)"),
        (np.zeros((0, 3)), {}, iso.GeometryError, "from 1 to"),
        ([[float("nan")]], {}, iso.GeometryError, r"pixel \(0, 0\) is nan"),
        ([[1, 2], [3]], {}, iso.GeometryError, r"must be \(h, w\)"),
        (np.zeros((2, 2)), {"threshold": 0}, iso.GeometryError, "threshold must be above 0"),
        (np.zeros((2, 2)), {"pixel": -1}, iso.GeometryError, "pixel must be a finite number above 0"),
        ("nowhere.png", {}, iso.FileError, "No such file"),
        (__file__, {}, iso.FileError, "no picture that can be read"),
    ],
)
def test_pictures_that_cannot_be_read_are_refused(image, options, kind, message):
    with pytest.raises(kind, match=message):
        iso.image(image, **options)
