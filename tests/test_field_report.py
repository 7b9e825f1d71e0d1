"""The report on a field: exact fields are found exact, bounds bounds, and false claims are refuted at real points."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
import pytest

import isophote as iso
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Exactness, Form
from isophote.shapes.field.functions import length, select

CUBE = iso.Mesh(
    [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)],
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
)


@attrs.frozen(repr=False)
class Ball(Form):
    """A ball of radius 1 whose value is `factor` times the distance, and what it claims to be."""

    factor: float
    claimed: float
    exactness: Exactness = Exactness.BOUND

    def expression(self, p: Point) -> Value:
        return p.bounded((length(p.x, p.y, p.z) - 1.0) * self.factor, self.claimed)

    @property
    def bounds(self) -> Any:
        return np.array([[-1.0] * 3, [1.0] * 3])

    def spelled(self) -> str:
        return "ball"


@attrs.frozen(repr=False)
class Torn(Ball):
    """A ball with a jump of 0.3 across x = 0.2, outside and inside."""

    def expression(self, p: Point) -> Value:
        value = length(p.x, p.y, p.z) - 1.0
        return p.bounded(select(p.x - 0.2, value, value + 0.3), self.claimed)


EXACT = {
    "sphere": iso.sphere(1),
    "box": iso.box((1, 2, 3)),
    "star": iso.star(5, 1, 0.4),
    "arc": iso.arc(1, 0.2, 0, 4),
    "polygon": iso.polygon([(0, 0), (2, 0), (1, 0.5), (0.5, 2)]),
    "prism": iso.star(5, 1, 0.4).extrude(0.3),
    "torus": iso.circle(0.3).revolve(1),
}
BOUNDS = {
    "ellipsoid": iso.ellipsoid((1, 2, 0.5)),
    "cut": (iso.sphere(1) & iso.box(1.5)) - iso.cylinder(0.5),
    "sweep": iso.rectangle((0.3, 0.2)).sweep([(0, 0, 0), (0, 0, 1), (1, 0, 1)]),
    "picture": iso.image([[True, False, True], [True, True, False]]),
}


@pytest.mark.parametrize("name", EXACT)
def test_distances_are_found_to_be_distances(name):
    report = iso.analysis.field_report(EXACT[name], samples=2000)
    assert report.exactness is Exactness.EXACT
    assert report.holds
    assert report.claimed_lipschitz == 1.0
    assert 0.99 < report.measured_lipschitz <= 1.001
    assert 0.999 <= report.least_ratio <= report.greatest_ratio <= 1.001
    assert len(report.too_near) == 0


@pytest.mark.parametrize("name", BOUNDS)
def test_bounds_are_found_to_be_bounds(name):
    report = iso.analysis.field_report(BOUNDS[name], samples=2000)
    assert report.exactness is Exactness.BOUND
    assert report.claimed_exactness is Exactness.BOUND
    assert report.holds
    assert report.least_ratio < 0.95


def test_what_is_better_than_claimed_holds():
    report = iso.analysis.field_report(iso.distance_field(CUBE), samples=1000)
    assert report.exactness is Exactness.EXACT
    assert report.claimed_exactness is Exactness.BOUND
    assert report.holds


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_slopes_and_ratios_are_measured(factor):
    report = iso.analysis.field_report(iso.Field(Ball(factor, 3.0)), samples=2000)
    assert report.measured_lipschitz == pytest.approx(factor, rel=1e-3)
    assert report.least_ratio == pytest.approx(factor, rel=1e-2)
    assert report.greatest_ratio == pytest.approx(factor, rel=1e-2)
    assert report.exactness is Exactness.BOUND
    assert report.holds


def test_a_false_claim_is_refuted_by_points():
    """The value promises three times the free space that there is."""
    report = iso.analysis.field_report(iso.Field(Ball(3.0, 1.0, Exactness.EXACT)), samples=2000)
    assert not report.holds
    assert report.exactness is Exactness.SIGN
    assert len(report.too_near) > 1000
    distance = np.abs(np.linalg.norm(report.too_near, axis=1) - 1)
    assert (3 * distance > distance).all()
    # The worst comes first.
    assert distance[0] == pytest.approx(distance.max(), rel=1e-3)


def test_bounds_that_claim_to_be_exact_are_refuted():
    report = iso.analysis.field_report(iso.Field(Ball(0.5, 1.0, Exactness.EXACT)), samples=1000)
    assert report.exactness is Exactness.BOUND
    assert not report.holds


def test_a_jump_is_found():
    report = iso.analysis.field_report(iso.Field(Torn(1.0, 1.0)), samples=2000)
    assert not report.holds
    assert report.measured_lipschitz > 1e3
    assert report.steepest[:, 0].min() <= 0.2 <= report.steepest[:, 0].max()
    assert np.linalg.norm(report.steepest[1] - report.steepest[0]) < 1e-5


def test_signs_of_a_mesh_with_a_hole():
    report = iso.analysis.field_report(iso.distance_field(iso.Mesh(CUBE.vertices, CUBE.faces[:5])), samples=1500)
    assert report.claimed_exactness is Exactness.SIGN
    assert report.exactness is Exactness.SIGN
    assert report.claimed_lipschitz == math.inf
    assert report.measured_lipschitz > 1e3
    assert report.holds


def test_the_same_seed_gives_the_same_report():
    first, second = (iso.analysis.field_report(iso.ellipsoid((1, 2, 0.5)), samples=500, seed=3) for _ in range(2))
    assert str(first) == str(second)
    assert str(first) != str(iso.analysis.field_report(iso.ellipsoid((1, 2, 0.5)), samples=500, seed=4))


def test_it_prints_as_a_table():
    lines = str(iso.analysis.field_report(iso.Field(Ball(3.0, 1.0, Exactness.EXACT)), samples=500)).splitlines()
    assert lines[0].split() == ["claimed", "measured"]
    assert lines[1].split() == ["values", "are", "exact", "distances", "signs", "alone"]
    assert lines[2].split()[:3] == ["Lipschitz", "constant", "1"]
    assert lines[4].split()[:4] == ["points", "that", "fail", "0"]
    assert sum(line.startswith("promises too much at (") for line in lines) == 10
    assert lines[0].index("measured") == lines[2].index(lines[2].split()[3])


@pytest.mark.parametrize(
    ("shape", "options", "message"),
    [
        (iso.plane(), {}, "give bounds=, finite"),
        (3, {}, "takes a field, not int"),
        (CUBE, {}, "distance_field makes one of a mesh"),
        (iso.sphere(1), {"bounds": [[3, 3, 3], [4, 4, 4]]}, "lie outside, so there is no surface"),
        (iso.sphere(1), {"bounds": [[-0.1] * 3, [0.1] * 3]}, "lie inside, so there is no surface"),
        (iso.sphere(1), {"bounds": [[0, 0], [1, 1]]}, r"\(2, 3\)"),
        (iso.sphere(1), {"bounds": [[1] * 3, [0] * 3]}, "nothing to look at"),
        (iso.sphere(1), {"samples": 3}, "samples must be"),
    ],
)
def test_what_cannot_be_measured_is_refused(shape, options, message):
    with pytest.raises(iso.GeometryError, match=message):
        iso.analysis.field_report(shape, **options)


def test_endless_fields_are_looked_at_where_it_is_said():
    report = iso.analysis.field_report(iso.plane(), [[-1, -1, -1], [1, 1, 1]], samples=500)
    assert report.exactness is Exactness.EXACT
