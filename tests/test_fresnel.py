"""Fresnel's equations over arrays: closed forms, conservation of energy, and what makes no sense."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import isophote as iso

ANGLES = np.linspace(0, math.pi / 2, 181)


@pytest.mark.parametrize("n", [1.33, 1.5, 2.4, 0.7])
def test_straight_on_and_along(n):
    assert iso.fresnel(0.0, 1.0, n) == pytest.approx(((n - 1) / (n + 1)) ** 2)
    assert iso.fresnel(math.pi / 2, 1.0, n) == pytest.approx(1.0)


@pytest.mark.parametrize(("n1", "n2"), [(1.0, 1.5), (1.33, 1.5), (1.5, 1.0), (1.0, 2.4)])
def test_reflected_and_transmitted_make_the_whole(n1, n2):
    """R + T = 1, with T from the amplitudes that go through: T = (n₂ cosθ₂ / n₁ cosθ₁) t²."""
    sine2 = n1 / n2 * np.sin(ANGLES[:-1])
    angles = ANGLES[:-1][sine2 < 1]
    c1, c2 = np.cos(angles), np.sqrt(1 - (n1 / n2 * np.sin(angles)) ** 2)
    flux = n2 * c2 / (n1 * c1)
    through_s = flux * (2 * n1 * c1 / (n1 * c1 + n2 * c2)) ** 2
    through_p = flux * (2 * n1 * c1 / (n2 * c1 + n1 * c2)) ** 2
    upright, flat = iso.fresnel(angles, n1, n2, polarised=True)
    assert np.allclose(upright + through_s, 1, atol=1e-12)
    assert np.allclose(flat + through_p, 1, atol=1e-12)
    assert np.allclose(iso.fresnel(angles, n1, n2), 1 - (through_s + through_p) / 2, atol=1e-12)


@pytest.mark.parametrize(("n1", "n2"), [(1.0, 1.5), (1.5, 1.0), (1.33, 2.4)])
def test_nothing_of_one_polarisation_at_brewsters_angle(n1, n2):
    _, flat = iso.fresnel(math.atan(n2 / n1), n1, n2, polarised=True)
    assert flat < 1e-30


def test_all_beyond_the_critical_angle():
    critical = math.asin(1 / 1.5)
    assert np.allclose(iso.fresnel(np.linspace(critical + 1e-9, math.pi / 2, 50), 1.5, 1.0), 1, atol=1e-12)
    assert iso.fresnel(critical - 1e-3, 1.5, 1.0) < 0.9


def test_equal_media_reflect_nothing():
    assert (iso.fresnel(ANGLES[:-1], 1.5, 1.5) == 0).all()


@given(st.floats(0, 1.57), st.floats(0.2, 4), st.floats(0.2, 4))
def test_the_way_back_reflects_as_much(angle, n1, n2):
    """Stokes: R is the same along the refracted ray from the other side."""
    sine = n1 / n2 * math.sin(angle)
    if sine >= 1 - 1e-9:
        return
    there, back = iso.fresnel(angle, n1, n2), iso.fresnel(math.asin(sine), n2, n1)
    assert there == pytest.approx(back, abs=1e-9, rel=1e-6)


def test_metals():
    """Straight on ((n − 1)² + k²) / ((n + 1)² + k²), whichever sign is in use for k; no loss as k grows."""
    n, k = 0.2, 3.4
    expected = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)
    assert iso.fresnel(0.0, 1.0, complex(n, k)) == pytest.approx(expected)
    assert iso.fresnel(0.3, 1.0, complex(n, -k)) == iso.fresnel(0.3, 1.0, complex(n, k))
    assert iso.fresnel(0.5, 1.0, 0.1 + 1e4j) > 0.9999
    shares = iso.fresnel(ANGLES, 1.0, 1.2 + 7j)
    assert (shares > 0).all()
    assert (shares <= 1 + 1e-12).all()


def test_weak_absorption_tends_to_clear():
    assert np.allclose(iso.fresnel(ANGLES, 1.0, 1.5 + 1e-12j), iso.fresnel(ANGLES, 1.0, 1.5), atol=1e-9)


def test_arrays_broadcast():
    assert iso.fresnel(ANGLES[:, None], 1.0, [1.3, 1.5, 2.0 + 1j]).shape == (len(ANGLES), 3)
    assert isinstance(float(iso.fresnel(0.2, 1.0, 1.5)), float)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-0.1, 1, 1.5), "radians from 0"),
        ((30, 1, 1.5), "radians from 0"),
        ((math.nan, 1, 1.5), "radians from 0"),
        ((0.1, 0, 1.5), "outside must be finite and above 0"),
        ((0.1, 1, -1.5), "inside must be finite and above 0"),
        ((0.1, 1, math.inf), "inside must be finite"),
        ((0.1, 1.5 + 1j, 1.5), "must be clear"),
    ],
)
def test_what_makes_no_sense_is_refused(arguments, message):
    with pytest.raises(iso.SceneError, match=message):
        iso.fresnel(*arguments)
