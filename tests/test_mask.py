"""Pictures of the inside of fields in the plane: as evaluating each pixel, whatever is decided by regions."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.convert import mask as module
from isophote.convert.mask import pixel_centres
from isophote.shapes.field.field2 import Field2

BOX = ((-2.0, -1.5), (2.0, 1.5))

FIELDS = {
    "disc": iso.circle(1),
    "part": iso.circle(1) - iso.rectangle((0.5, 0.3)),
    "ring": iso.arc(1, 0.2, 0.3, 5.0).translate((0.2, -0.1)),
    "star": iso.star(5, 1.2, 0.5),
    "blended": iso.circle(0.7).union(iso.rectangle((2, 0.3)).rotate(0.4), blend=0.3),
    "strokes": iso.union(*(iso.segment((x / 8, -1), (-x / 9, 1), 0.02) for x in range(-12, 12))),
    "text": iso.text("Qg&8"),
    "inside": iso.circle(100),
    "nothing": iso.circle(1).translate((50, 0)),
    "grid": iso.circle(0.05).repeat((0.25, 0.25)),
}


def by_pixels(field: Field2, bounds: npt.ArrayLike, size: tuple[int, int]) -> npt.NDArray[np.bool_]:
    """The picture by the field's value at each pixel's middle."""
    xs, ys = pixel_centres(np.asarray(bounds, float), size)
    columns, rows = np.meshgrid(xs, ys)
    inside: npt.NDArray[np.bool_] = field(np.column_stack([columns.reshape(-1), rows.reshape(-1)])) < 0
    return inside.reshape(rows.shape)


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize("size", [(200, 150), (1025, 70)])
def test_pictures_are_those_of_pixels(name: str, size: tuple[int, int]) -> None:
    found = iso.mask(FIELDS[name], size, BOX)
    assert found.dtype == np.bool_
    assert found.shape == size[::-1]
    wanted = by_pixels(FIELDS[name], BOX, size)
    assert (found == wanted).all()
    assert found.all() == (name == "inside")
    assert found.any() == (name != "nothing")


@pytest.mark.parametrize(
    "size", [(1, 1), (1, 5), (15, 17), (16, 16), (17, 65), (64, 64), (65, 64), (300, 3), (257, 1030)]
)
def test_sizes(size: tuple[int, int]) -> None:
    assert (iso.mask(FIELDS["part"], size, BOX) == by_pixels(FIELDS["part"], BOX, size)).all()


@given(
    st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1, 1), st.floats(0.01, 0.8)), min_size=1, max_size=8),
    st.sampled_from(["union", "intersection", "difference"]),
    st.sampled_from([0.0, 0.2]),
)
@settings(max_examples=40, deadline=None)
def test_discs_put_together(discs: list[tuple[float, float, float]], how: str, blend: float) -> None:
    parts = [iso.circle(r).translate((x, y)) for x, y, r in discs]
    field = getattr(parts[0], how)(*parts[1:], blend=blend) if parts[1:] else parts[0]
    assert (iso.mask(field, (120, 90), BOX) == by_pixels(field, BOX, (120, 90))).all()


def test_rows_count_from_the_top_and_columns_from_the_left() -> None:
    found = iso.mask(iso.circle(0.5).translate((-1, 1)), (40, 30), BOX)
    rows, columns = np.nonzero(found)
    # The pixel at the disc's middle: x = −1 is a quarter of the way, y = 1 a sixth from the top.
    assert abs(columns.mean() - 9.5) < 0.1
    assert abs(rows.mean() - 4.5) < 0.1


def test_pixels_are_square_and_the_field_in_the_middle_without_bounds() -> None:
    found = iso.mask(iso.rectangle((2, 1)).translate((7, -3)), (400, 400))
    rows, columns = np.nonzero(found)
    assert abs(rows.mean() - 199.5) < 0.5
    assert abs(columns.mean() - 199.5) < 0.5
    assert abs(found.sum() / 160_000 - 0.5 / 1.1**2) < 0.01
    assert np.ptp(columns) > 1.9 * np.ptp(rows)


def test_a_disc_has_its_area() -> None:
    found = iso.mask(iso.circle(1), (2000, 1500), BOX)
    assert abs(found.mean() * 12 - np.pi) < 1e-3


def test_threads_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    pictures = []
    for threads in (1, 2, 7):
        monkeypatch.setattr(module, "processors", lambda threads=threads: threads)
        pictures.append(iso.mask(FIELDS["strokes"], (700, 500), BOX))
    assert all((picture == pictures[0]).all() for picture in pictures)


@pytest.mark.parametrize("size", [(0, 5), (5, -1), (1.5, 2), "ab", (3,), (1 << 16, 1 << 16)])
def test_sizes_that_are_refused(size: object) -> None:
    with pytest.raises(iso.GeometryError, match="size must be"):
        iso.mask(FIELDS["disc"], size)  # type: ignore[arg-type]


@pytest.mark.parametrize("bounds", [((0, 0), (0, 1)), ((1, 1), (0, 0)), ((0, 0), (np.inf, 1)), (0, 1), "x"])
def test_bounds_that_are_refused(bounds: object) -> None:
    with pytest.raises(iso.GeometryError, match="bounds must be"):
        iso.mask(FIELDS["disc"], (8, 8), bounds)  # type: ignore[arg-type]


def test_endless_fields_need_bounds_and_fields_in_space_have_none() -> None:
    with pytest.raises(iso.GeometryError, match="endless"):
        iso.mask(FIELDS["grid"])
    with pytest.raises(iso.GeometryError, match="in the plane"):
        iso.mask(iso.sphere(1))  # type: ignore[arg-type]
