"""Meshes within a tolerance of the surface, both ways; and fields that break what they promise."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso
from closed_meshes import check_closed
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.field import Field
from isophote.shapes.field.form import Box, Form
from isophote.shapes.field.functions import length, log

Points = npt.NDArray[np.float64]
COUNT = 20_000
POLE = iso.cylinder(0.5)
PART = (iso.sphere(1) & iso.box(1.5)) - POLE - POLE.along("x") - POLE.along("z")


def directions(random: np.random.Generator) -> Points:
    drawn = random.normal(size=(COUNT, 3))
    return drawn / np.linalg.norm(drawn, axis=1, keepdims=True)


def on_sphere(random: np.random.Generator) -> Points:
    return directions(random)


def on_torus(random: np.random.Generator) -> Points:
    u, v = random.uniform(0, 2 * np.pi, (2, COUNT))
    return np.column_stack([(1 + 0.3 * np.cos(v)) * np.cos(u), 0.3 * np.sin(v), (1 + 0.3 * np.cos(v)) * np.sin(u)])


def on_box(random: np.random.Generator, half: float = 0.5) -> Points:
    points = random.uniform(-half, half, (COUNT, 3))
    points[np.arange(COUNT), random.integers(0, 3, COUNT)] = half * random.choice([-1, 1], COUNT)
    return points


def on_pole(random: np.random.Generator, axis: int) -> Points:
    angle = random.uniform(0, 2 * np.pi, COUNT)
    around = np.column_stack([random.uniform(-0.75, 0.75, COUNT), 0.5 * np.cos(angle), 0.5 * np.sin(angle)])
    return np.roll(around, axis, axis=1)


def on_part(random: np.random.Generator) -> Points:
    """Points of all its surfaces, less those that another part of it has taken away."""
    points = np.concatenate([on_sphere(random), on_box(random, 0.75), *(on_pole(random, axis) for axis in range(3))])
    x, y, z = points.T
    kept = (np.linalg.norm(points, axis=1) <= 1 + 1e-9) & (np.abs(points).max(axis=1) <= 0.75 + 1e-9)
    for a, b in ((x, y), (y, z), (x, z)):
        kept &= np.hypot(a, b) >= 0.5 - 1e-9
    return points[kept]


def from_sphere(points: Points) -> Points:
    return np.abs(np.linalg.norm(points, axis=1) - 1)


def from_torus(points: Points) -> Points:
    return np.abs(np.hypot(np.hypot(points[:, 0], points[:, 2]) - 1, points[:, 1]) - 0.3)


def from_box(points: Points) -> Points:
    beyond = np.abs(points) - 0.5
    return np.abs(np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0))


def from_part(points: Points) -> Points:
    """No more than the distance: the field of such a part is a bound."""
    return np.abs(PART(points)).astype(np.float64)


SHAPES: dict[str, tuple[Any, Any, Any]] = {
    "sphere": (iso.sphere(1), on_sphere, from_sphere),
    "torus": (iso.torus(1, 0.3), on_torus, from_torus),
    "box": (iso.box(1), on_box, from_box),
    "part": (PART, on_part, from_part),
}


@pytest.mark.parametrize("tolerance", [0.01, 0.001])
@pytest.mark.parametrize("name", SHAPES)
def test_mesh_and_surface_are_within_the_tolerance(name: str, tolerance: float) -> None:
    field, surface, distance = SHAPES[name]
    mesh = iso.to_mesh(field, tolerance=tolerance)
    check_closed(mesh)
    random = np.random.default_rng(3)
    face = random.integers(0, mesh.face_count, COUNT)
    weights = random.dirichlet((1, 1, 1), COUNT)
    on_mesh = np.einsum("ij,ijk->ik", weights, mesh.vertices[mesh.faces[face]])
    assert distance(on_mesh).max() <= tolerance
    assert distance(mesh.vertices).max() <= tolerance
    assert iso.analysis.distance(mesh, surface(random)).max() <= tolerance


def test_a_smaller_tolerance_takes_more_triangles() -> None:
    counts = [iso.to_mesh(PART, tolerance=t).face_count for t in (0.02, 0.005, 0.00125)]
    assert counts == sorted(counts)
    # Of a smooth surface, a sixteenth of the distance takes sixteen times as many.
    assert counts[2] < 40 * counts[0]


@attrs.frozen(repr=False)
class _Ball(Form):
    """A ball of radius 1 that says that it is smaller, and that is NaN where x is below −`defined`."""

    promised: float
    defined: float | None = None

    def expression(self, p: Point) -> Value:
        ball = length(p.x, p.y, p.z) - 1
        return ball if self.defined is None else ball + log(p.x + self.defined) * 1e-3

    @property
    def bounds(self) -> Box:
        return np.array([[-self.promised] * 3, [self.promised] * 3])

    def spelled(self) -> str:
        return "ball"


def test_a_field_that_is_no_number_somewhere_is_refused_with_the_place() -> None:
    with pytest.raises(iso.GeometryError, match=r"not a number \(NaN\) at a point between \("):
        iso.to_mesh(Field(_Ball(1.2, 0.2)), cell=0.1)


def test_a_field_larger_than_its_bounds_is_refused() -> None:
    with pytest.raises(iso.GeometryError, match="reaches beyond its bounds"):
        iso.to_mesh(Field(_Ball(0.6)), cell=0.1)
