"""Tables of data in tapes, outlines, grids and meshes, in every interpreter, against NumPy in double precision."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from field_tapes import bounds_of, gradients_of, tape_row, values_of
from isophote import GeometryError
from isophote.kernels.forms import opcodes
from isophote.shapes.field import evaluate
from isophote.shapes.field.data import GridData, MeshData, OutlineData
from isophote.shapes.field.outline import line_arcs, outline_data
from isophote.shapes.field.tape import Tape


def ring(rng: np.random.Generator, arcs: int) -> Any:
    """A closed curve of quadratic arcs round a wobbling circle."""
    angles = (np.arange(arcs) + rng.uniform(0, 0.8, arcs)) * (2 * np.pi / arcs)
    ends = (rng.uniform(0.4, 1.2, arcs) * np.array([np.cos(angles), np.sin(angles)])).T
    following = np.roll(ends, -1, axis=0)
    return np.column_stack([ends, (ends + following) / 2 + rng.normal(0, 0.3 / arcs, (arcs, 2)), following])


def loops(*polygons: Any) -> list[Any]:
    """Polygons as loops of arcs."""
    return [line_arcs(np.asarray(p, np.float64)) for p in polygons]


SQUARE = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
HOLE = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)]
STAR = [(np.cos(0.8 * np.pi * k), np.sin(0.8 * np.pi * k)) for k in range(5)]


def outlines() -> dict[str, OutlineData]:
    """Few arcs and many, lines and curves, holes, corners that touch, outlines that overlap."""
    rng = np.random.default_rng(1)
    places = np.stack(np.meshgrid(np.arange(8), np.arange(5)), axis=-1).reshape(-1, 2) - (3.5, 2)
    rings = [ring(rng, 8) * 0.25 + np.tile(place, 3) for place in places]
    return {
        "square": outline_data(loops(SQUARE), "square"),
        "hole": outline_data(loops(SQUARE, HOLE), "hole"),
        "star": outline_data(loops(STAR), "star"),
        "touching": outline_data(loops(SQUARE, np.array(SQUARE) + 2), "touching"),
        "needle": outline_data(loops([(-1, -1e-4), (1, 0), (-1, 1e-4)]), "needle"),
        "ring": outline_data([ring(rng, 9)], "ring"),
        "rings": outline_data(rings, "rings"),
        "many": outline_data([ring(rng, 700)], "many"),
    }


OUTLINES = outlines()


def grids() -> dict[str, GridData]:
    """Smooth and rough samples, few and many, in the plane and in space."""
    rng = np.random.default_rng(2)
    x, y, z = np.meshgrid(*[np.linspace(-1, 1, n) for n in (9, 7, 5)], indexing="ij")
    ball = np.sqrt(x * x + y * y + z * z) - 0.7
    return {
        "plane": GridData(rng.normal(size=(6, 9)), (-1.0, -0.5), 0.25),
        "least": GridData(np.array([[0.0, 1], [2, -1]]), (0.0, 0.0), 1.0),
        "space": GridData(ball.transpose(2, 1, 0), (-1.0, -0.75, -0.5), 0.25),
        "rough": GridData(rng.normal(size=(4, 3, 2)), (0.0, 0.5, -1.0), 0.5),
    }


GRIDS = grids()


def meshes() -> dict[str, MeshData]:
    """A closed mesh, the same without a side, and the same turned inside out."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float) * 0.75
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))], np.int32)
    return {
        "closed": MeshData(corners, triangles),
        "open": MeshData(corners, triangles[:-2]),
        "inside out": MeshData(corners, triangles[:, ::-1].copy()),
    }


MESHES = meshes()
CASES = [
    *[("OUTLINE", name, OUTLINES[name]) for name in OUTLINES],
    *[(f"GRID{GRIDS[name].dimension}", name, GRIDS[name]) for name in GRIDS],
    *[("MESH", name, MESHES[name]) for name in MESHES],
]
NAMES = [f"{operator} {name}" for operator, name, _ in CASES]
TABLES = pytest.mark.parametrize(("operator", "name", "table"), CASES, ids=NAMES)


def tape_of_table(operator: str, table: Any) -> tuple[Any, Any]:
    """A tape of the table at the point, and what its functions read, which must be kept."""
    row = tape_row(getattr(opcodes, operator), 0, (0, 1, 2) if operator in ("GRID3", "MESH") else (0, 1))
    row[0, opcodes.IMM] = 0
    return row, evaluate.packed_data(Tape(row, (table,)))


def points_about(table: Any, count: int, seed: int) -> Any:
    """Single-precision points within a table's box, near it and far from it, in three dimensions."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.5, 1.5, (count, 3))
    points[::7] *= 20
    if isinstance(table, OutlineData):
        # Some on the boundary, or nearly; some at the ends of arcs.
        arcs = table.segments[rng.integers(len(table.segments), size=count // 3)]
        points[: len(arcs), :2] = arcs[:, :2] + rng.normal(size=(len(arcs), 2)) * 10.0 ** rng.uniform(
            -7, 0, (len(arcs), 1)
        )
        points[: len(arcs) // 4, :2] = arcs[: len(arcs) // 4, :2]
    return points.astype(np.float32)


def size_of(points: Any) -> Any:
    """How large coordinates are, which rounding is measured by."""
    return 2 + np.abs(points).sum(axis=1)


@TABLES
def test_values(operator: str, name: str, table: Any) -> None:
    row, data = tape_of_table(operator, table)
    points = points_about(table, 3000, 3)
    arguments = points.astype(float).T[: 3 if operator in ("GRID3", "MESH") else 2]
    wanted = table.value(*arguments)
    slope = min(table.slope, 1e9) if operator.startswith("GRID") else 1
    np.testing.assert_array_less(np.abs(values_of(row, points, data.words) - wanted), 4e-7 * slope * size_of(points))


@TABLES
def test_intervals(operator: str, name: str, table: Any) -> None:
    rng = np.random.default_rng(4)
    row, data = tape_of_table(operator, table)
    for _ in range(12):
        middles = points_about(table, 32, int(rng.integers(1 << 30)))[rng.permutation(32)[:16]]
        halves = 10.0 ** rng.uniform(-6, 0, (16, 3))
        low, high = (middles - halves).astype(np.float32), (middles + halves).astype(np.float32)
        found = bounds_of(row, low, high, data.words)
        inside = low[:, None] + rng.random((16, 100, 3)) * (high - low)[:, None]
        points = np.clip(inside.astype(np.float32), low[:, None], high[:, None]).reshape(-1, 3)
        arguments = points.astype(float).T[: 3 if operator in ("GRID3", "MESH") else 2]
        for values in (values_of(row, points, data.words), table.value(*arguments)):
            assert (values.reshape(16, -1) >= found.low[:, None]).all()
            assert (values.reshape(16, -1) <= found.high[:, None]).all()
        if np.isfinite(table.slope):
            radius = np.linalg.norm((high - low)[:, : len(arguments)], axis=1) / 2
            assert (found.high - found.low <= 2.1 * table.slope * radius + 1e-4 * (1 + table.slope)).all()


@TABLES
def test_gradients(operator: str, name: str, table: Any) -> None:
    row, data = tape_of_table(operator, table)
    points = points_about(table, 3200, 5)
    arguments = points.astype(float).T[: 3 if operator in ("GRID3", "MESH") else 2]
    found = gradients_of(row, points, data.words)
    # The value is the same, but for the bound that points pass on to the next.
    assert (found[:, 0] == values_of(row, points, data.words)).all()
    wanted = np.zeros((len(points), 3))
    for axis, part in enumerate(table.partials(*arguments)):
        wanted[:, axis] = part
    # Where the nearest point is another, or the point itself nearly on the boundary, directions differ.
    clear = np.abs(found[:, 0]) > 1e-3 * size_of(points)
    same = np.abs(found[:, 1:] - wanted).max(axis=1) < 2e-3 * (1 + min(table.slope, 100))
    assert same[clear].mean() > 0.99
    assert same.mean() > 0.85


@TABLES
def test_points_that_are_not_finite_have_no_value(operator: str, name: str, table: Any) -> None:
    row, data = tape_of_table(operator, table)
    points = np.zeros((32, 3), np.float32)
    points[::4, 0], points[1::4, 1] = np.nan, np.inf
    assert np.isnan(values_of(row, points, data.words)).reshape(-1, 4)[:, :2].all()
    gradients = gradients_of(row, points, data.words)
    assert np.isfinite(gradients[2::4]).all()


CORNERS = st.lists(st.tuples(st.integers(-8, 8), st.integers(-8, 8)), min_size=3, max_size=12)


# The last two edges run along each other: both must be met, or neither.
@example([(0, 0), (1, -4), (8, -1), (-8, -5), (8, -1)], 123)
@example([(1, -8), (0, 0), (3, -6), (8, -1)], 1679)
@given(CORNERS, st.integers(0, 1 << 30))
@settings(max_examples=60, deadline=None)
def test_polygons_of_any_kind(corners: list[tuple[int, int]], seed: int) -> None:
    polygon = np.array(corners, float)
    try:
        table = outline_data([line_arcs(polygon)], "polygon")
    except GeometryError:
        # It encloses nothing.
        assume(False)
    row, data = tape_of_table("OUTLINE", table)
    rng = np.random.default_rng(seed)
    points = np.concatenate([rng.integers(-40, 40, (200, 3)) / 4, rng.uniform(-9, 9, (300, 3))]).astype(np.float32)
    wanted = table.value(*points.astype(float).T[:2])
    np.testing.assert_allclose(values_of(row, points, data.words), wanted, atol=1e-5)


def test_a_mesh_far_from_the_origin_keeps_its_distances() -> None:
    closed = MESHES["closed"]
    moved = MeshData(closed.vertices + 1000.0, closed.triangles)
    row, data = tape_of_table("MESH", moved)
    points = (np.random.default_rng(6).integers(-16, 16, (200, 3)) / 8 + 1000).astype(np.float32)
    wanted = closed.value(*(points.astype(float) - 1000).T)
    np.testing.assert_allclose(values_of(row, points, data.words), wanted, atol=1e-6)
