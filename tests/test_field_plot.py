"""Pictures of fields in the plane: every pixel against the closed form of its middle."""

from __future__ import annotations

import math

import numpy as np
import pytest

import isophote as iso

PLOT = iso.FieldPlot(bounds=[[-2, -1], [2, 1]], spacing=0.25, inside=(1, 0, 0), outside=(0, 0, 1), outline=(0, 1, 0))
DISC = iso.circle(0.6)


def middles(size, low, pixel):
    width, height = size
    x = low[0] + (np.arange(width) + 0.5) * pixel
    y = low[1] + (height - np.arange(height) - 0.5) * pixel
    return np.meshgrid(x, y)


def test_values_are_the_field_at_the_middles_of_pixels():
    image = iso.render(DISC, PLOT, size=(400, 200))
    x, y = middles((400, 200), (-2, -1), 0.01)
    assert image.channels["value"] == pytest.approx(np.hypot(x, y) - 0.6, abs=1e-6)
    assert image.metadata["units per pixel"] == "0.01"
    assert image.metadata["lower left corner"] == "-2, -1"
    assert image.metadata["isolines"] == "every 0.25"


def test_row_0_is_the_top():
    image = iso.render(iso.circle(0.2).translate((0, 0.7)), PLOT, size=(400, 200))
    assert image.channels["value"][30, 200] < 0
    assert image.channels["value"][170, 200] > 0.5


def test_inside_outside_and_outline_have_their_colours():
    image = iso.render(DISC, PLOT, size=(400, 200))
    colour, value = image.channels["colour"], image.channels["value"]
    turns = value / 0.25
    between = np.abs(turns - np.rint(turns)) * 25 > 2
    assert (colour[(value < -0.02) & between][:, 1:] == 0).all()
    assert (colour[(value > 0.02) & between][:, :2] == 0).all()
    assert colour[(value < -0.02) & between][:, 0].min() > 0.5
    on = np.abs(value) < 0.002
    assert on.sum() > 20
    assert colour[on] == pytest.approx(np.tile([0, 1, 0], (on.sum(), 1)), abs=1e-6)


def test_isolines_are_dark_where_the_value_is_a_multiple():
    image = iso.render(DISC, PLOT, size=(800, 400))
    colour, value = image.channels["colour"][..., 2], image.channels["value"]
    for level in (0.25, 0.5, 0.75):
        on, off = np.abs(value - level) < 0.001, np.abs(value - level - 0.1) < 0.01
        assert on.sum() > 20
        assert colour[on].max() < 0.7 * colour[off].min()


def test_lines_have_one_width_for_fields_that_are_no_distances():
    """Three times the distance: the same outline, and isolines three times as dense."""
    steep = iso.field2(lambda p: 3 * (np.hypot(p[:, 0], p[:, 1]) - 0.6), ([-1, -1], [1, 1]))
    plots = [iso.FieldPlot(bounds=PLOT.bounds, spacing=s, inside="red", outside="blue") for s in (0.25, 0.75)]
    first, second = (iso.render(f, p, size=(400, 200)) for f, p in zip((DISC, steep), plots, strict=True))
    assert first.channels["colour"] == pytest.approx(second.channels["colour"], abs=2e-3)


def test_without_isolines():
    image = iso.render(DISC, iso.FieldPlot(bounds=PLOT.bounds, spacing=0), size=(200, 100))
    assert image.metadata["isolines"] == "none"


@pytest.mark.parametrize("size", [(640, 480), (100, 300), (1, 1), (3, 1)])
def test_shapes_are_framed_with_room(size):
    field = iso.rectangle((2, 1)).translate((5, 5))
    image = iso.render(field, size=size)
    assert image.size == size
    pixel = float(image.metadata["units per pixel"])
    low = [float(c) for c in image.metadata["lower left corner"].split(",")]
    high = [low[0] + size[0] * pixel, low[1] + size[1] * pixel]
    assert low[0] < 4
    assert low[1] < 4.5
    assert high[0] > 6
    assert high[1] > 5.5
    assert low[0] + high[0] == pytest.approx(10, abs=1e-6)
    if min(size) > 50:
        assert (image.channels["value"] < 0).any()


def test_the_spacing_is_a_round_number():
    for scale in (1e-3, 0.7, 1, 40, 1e6):
        text = iso.render(iso.circle(scale), size=(64, 48)).metadata["isolines"]
        step = float(text.split()[1])
        digit = step / 10 ** math.floor(math.log10(step) + 1e-9)
        assert min(abs(digit - d) for d in (1, 2, 5, 10)) < 1e-6
        assert 0.02 * scale < step < 0.5 * scale


def test_progress_is_told():
    told = []
    iso.render(DISC, size=(64, 48), progress=lambda stage, fraction: told.append((stage, fraction)))
    assert told[0] == ("field", 0.0)
    assert told[-1] == ("field", 1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: iso.FieldPlot(bounds=[[1, 1], [0, 0]]), "a lower and an upper corner"),
        (lambda: iso.FieldPlot(bounds="all"), r"bounds must be \(2, 2\) numbers"),
        (lambda: iso.FieldPlot(spacing=-1), "spacing must be a finite number"),
        (lambda: iso.FieldPlot(inside="no colour"), "is not a colour"),
        (lambda: iso.render(DISC, iso.PathTrace()), "extrude or revolve it"),
        (lambda: iso.render(DISC, size=(0, 3)), "size must be"),
        (lambda: iso.render(iso.field2(lambda p: p[:, 0] * 1.0)), "give FieldPlot"),
        (lambda: iso.render(iso.sphere(1), iso.FieldPlot()), "method must be"),
    ],
)
def test_plots_that_cannot_be_are_refused(make, message):
    with pytest.raises(iso.RenderError, match=message):
        make()


def test_endless_fields_are_drawn_where_it_is_said():
    half = iso.field2(lambda p: p[:, 0] * 1.0)
    image = iso.render(half, iso.FieldPlot(bounds=[[-1, -1], [1, 1]]), size=(20, 20))
    assert (image.channels["value"][:, :10] < 0).all()
    assert (image.channels["value"][:, 10:] > 0).all()


def test_scenes_hold_no_fields_in_the_plane():
    with pytest.raises(iso.SceneError, match=r"circle.* is a field in the plane.*extrude or revolve it"):
        iso.Item(DISC)
