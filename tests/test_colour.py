"""Colours: what may be written, and what linear values it means."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from isophote import SceneError
from isophote.scene.colour import colour, linear_to_srgb, srgb_to_linear


def test_names_and_hexadecimal_are_decoded_from_srgb():
    assert colour("white") == (1, 1, 1)
    assert colour("black") == (0, 0, 0)
    assert colour("#c84") == colour("#cc8844") == colour(" #CC8844 ")
    # Tomato is #ff6347; by the formula, 0x63 / 255 = 0.388 decodes to ((0.388 + 0.055) / 1.055)^2.4.
    expected = (1, ((0x63 / 255 + 0.055) / 1.055) ** 2.4, ((0x47 / 255 + 0.055) / 1.055) ** 2.4)
    assert colour("tomato") == pytest.approx(expected, rel=1e-12)


def test_numbers_and_triples_are_linear_already():
    assert colour(0.25) == (0.25, 0.25, 0.25)
    assert colour((0.1, 2, 30)) == (0.1, 2, 30)
    assert colour(np.float32([0.5, 0, 1])) == (0.5, 0, 1)
    assert all(type(channel) is float for channel in colour(np.array([1, 2, 3])))


@pytest.mark.parametrize(
    "wrong",
    [
        "tomatoe",
        "",
        "#12",
        "#11223344",
        (1, 2),
        (1, 2, 3, 4),
        -0.1,
        (0, float("nan"), 0),
        float("inf"),
        None,
        ("a", "b", "c"),
        [[1, 2, 3]],
        [(1, 2), 3, 4],
    ],
)
def test_what_is_no_colour_is_refused(wrong):
    with pytest.raises(SceneError):
        colour(wrong)


def test_curve_at_known_points():
    # IEC 61966-2-1: the two pieces meet at 0.04045 and 0.0031308 to within 1e-7.
    assert srgb_to_linear([0.0, 0.04045, 1.0]) == pytest.approx([0, 0.04045 / 12.92, 1])
    assert linear_to_srgb([0.0, 0.0031308, 1.0]) == pytest.approx([0, 0.0031308 * 12.92, 1])
    assert srgb_to_linear(np.nextafter(0.04045, 1)) == pytest.approx(0.04045 / 12.92, abs=1e-7)
    assert srgb_to_linear(0.5) == pytest.approx(0.2140411, abs=1e-7)


@given(st.floats(-4, 16))
def test_encoding_undoes_decoding(value):
    assert float(linear_to_srgb(srgb_to_linear(value))) == pytest.approx(value, rel=1e-6, abs=1e-9)


def test_every_byte_survives_a_round_trip_in_single_precision():
    byte = np.arange(256, dtype=np.uint8)
    linear = srgb_to_linear(byte.astype(np.float32) / np.float32(255))
    assert linear.dtype == np.float32
    assert (np.rint(linear_to_srgb(linear) * 255).astype(np.uint8) == byte).all()
    assert (np.diff(linear) > 0).all()
