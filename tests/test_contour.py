"""Meshes of fields: closed manifolds with the right measures, edges and holes, the same for any number of threads."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import isophote as iso
from closed_meshes import area, check_closed, euler, volume

TURN = ((1.0, 2.0, 3.0), 0.7)
PART = (iso.sphere(1) & iso.box(1.5)) - iso.cylinder(0.5) - iso.cylinder(0.5).along("x") - iso.cylinder(0.5).along("z")

# Field, volume, area, Euler characteristic.
SOLIDS: dict[str, tuple[Any, float, float, int]] = {
    "sphere": (iso.sphere(1), 4 / 3 * math.pi, 4 * math.pi, 2),
    "cylinder": (iso.cylinder(0.5, 1.2).rotate(*TURN), 0.3 * math.pi, 1.7 * math.pi, 2),
    "torus": (iso.torus(1, 0.3), 2 * math.pi**2 * 0.09, 4 * math.pi**2 * 0.3, 0),
    "two": (iso.sphere(0.5) | iso.sphere(0.5).translate((3, 0, 0)), math.pi / 3, 2 * math.pi, 4),
    "hollow": (iso.sphere(1) - iso.sphere(0.5), 7 / 6 * math.pi, 5 * math.pi, 4),
    "lens": (
        iso.sphere(1).translate((0.5, 0, 0)) & iso.sphere(1).translate((-0.5, 0, 0)),
        5 / 12 * math.pi,
        2 * math.pi,
        2,
    ),
}


@pytest.mark.parametrize("merging", [{"tolerance": 0}, {}], ids=["all cells", "merged"])
@pytest.mark.parametrize("name", SOLIDS)
def test_measures_converge_with_the_square_of_the_cell(name: str, merging: dict[str, float]) -> None:
    field, true_volume, true_area, true_euler = SOLIDS[name]
    errors = []
    for cell in (0.12, 0.06, 0.03):
        mesh = iso.to_mesh(field, cell=cell, **merging)
        check_closed(mesh)
        assert euler(mesh) == true_euler
        errors.append((abs(volume(mesh) / true_volume - 1), abs(area(mesh) / true_area - 1)))
    assert max(errors[2]) < 2e-3
    for coarse, fine in ((errors[0][k], errors[2][k]) for k in range(2)):
        # A quarter of the cell: a sixteenth of the error, and some room for how the grid happens to lie.
        assert fine < max(coarse / 8, 1e-6)


def test_a_turned_box_is_itself_at_any_cell() -> None:
    """Vertices lie on the edges and at the corners, so that the mesh has no other points than the box."""
    box = iso.box((1, 0.6, 0.8)).rotate(*TURN)
    for cell in (0.11, 0.05, 0.02):
        for merging in ({"tolerance": 0.0}, {}):
            mesh = iso.to_mesh(box, cell=cell, **merging)
            check_closed(mesh)
            assert abs(volume(mesh) / 0.48 - 1) < 1e-6
            assert abs(area(mesh) / (2 * (0.6 + 0.8 + 0.48)) - 1) < 2e-3
            assert np.abs(box(mesh.vertices)).max() < 1e-4
            assert len(np.unique(normals_of(mesh).round(3) + 0.0, axis=0)) == 6


def normals_of(mesh: iso.Mesh) -> Any:
    """Unit normals of triangles that are more than slivers."""
    p = mesh.vertices[mesh.faces]
    normals = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    size = np.linalg.norm(normals, axis=1)
    longest = np.linalg.norm(p - np.roll(p, 1, axis=1), axis=2).max(axis=1)
    kept = size > 1e-2 * longest**2
    return normals[kept] / size[kept, None]


def test_the_edge_of_a_cylinder_is_sharp() -> None:
    """Rounded edges would have vertices near the rim, and not on it."""
    mesh = iso.to_mesh(iso.cylinder(0.5, 1.0).rotate("x", 0.4), cell=0.04)
    y, z = mesh.vertices[:, 1], mesh.vertices[:, 2]
    along, across = y * math.cos(0.4) + z * math.sin(0.4), z * math.cos(0.4) - y * math.sin(0.4)
    radius = np.hypot(mesh.vertices[:, 0], across)
    rim = (np.abs(along) > 0.49) & (radius > 0.48)
    assert rim.sum() > 100
    near_cap, near_side = np.abs(np.abs(along[rim]) - 0.5) < 1e-3, np.abs(radius[rim] - 0.5) < 1e-3
    assert (near_cap & near_side).sum() > 50
    assert (near_cap | near_side).all()


def test_the_classic_part_has_five_holes_and_few_triangles() -> None:
    mesh = iso.to_mesh(PART, cell=1.5 / 60)
    check_closed(mesh)
    assert euler(mesh) == 2 - 2 * 5
    assert mesh.face_count < iso.to_mesh(PART, cell=1.5 / 60, tolerance=0).face_count / 2


def test_flat_parts_take_few_triangles() -> None:
    mesh = iso.to_mesh(iso.box(1).rotate(*TURN), cell=1 / 64)
    assert mesh.face_count < 7000
    assert iso.to_mesh(iso.box(1).rotate(*TURN), cell=1 / 64, tolerance=0).face_count > 40_000
    check_closed(mesh)


def test_no_triangle_is_folded_over() -> None:
    """On flat faces with a round hole, vertices of large cells must not be joined across it."""
    plate = iso.box((2, 0.2, 2)) - iso.cylinder(0.5) - iso.cylinder(0.2).translate((0.8, 0, 0.75))
    mesh = iso.to_mesh(plate, cell=0.04, tolerance=2e-4)
    p = mesh.vertices[mesh.faces]
    flat = (np.abs(np.abs(p[:, :, 1]) - 0.1) < 1e-6).all(axis=1)
    up = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 1] * np.sign(p[:, 0, 1])
    assert flat.sum() > 100
    assert up[flat].min() > -1e-4
    true_area = 2 * (4 - math.pi * 0.29)
    assert abs(np.abs(up[flat]).sum() / 2 - true_area) < 4e-3


@pytest.mark.parametrize("method", ["dual-contouring", "surface-nets"])
def test_the_mesh_is_the_same_for_any_number_of_threads(method: str) -> None:
    meshes = [iso.to_mesh(PART, cell=0.02, method=method, threads=n) for n in (1, 2, 5)]  # type: ignore[arg-type]
    assert meshes[0] == meshes[1] == meshes[2]


def test_surface_nets_are_closed_and_round() -> None:
    mesh = iso.to_mesh(iso.sphere(1), cell=0.05, method="surface-nets")
    check_closed(mesh)
    assert euler(mesh) == 2
    assert np.abs(np.linalg.norm(mesh.vertices, axis=1) - 1).max() < 0.05**2
    box = iso.to_mesh(iso.box(1), cell=0.05, method="surface-nets")
    check_closed(box)
    assert volume(box) < 1 - 1e-4


def test_a_shape_is_cut_off_and_closed_at_bounds() -> None:
    for field, box, inside in (
        (iso.cylinder(0.5), ((-1, -0.3, -1), (1, 0.5, 1)), 0.25 * math.pi * 0.8),
        (iso.plane(), ((0, -2, 0), (1, 3, 2)), 4.0),
        (iso.sphere(1), ((-2, 0, -2), (2, 2, 2)), 2 / 3 * math.pi),
    ):
        mesh = iso.to_mesh(field, cell=0.05, bounds=box)
        check_closed(mesh)
        assert abs(volume(mesh) / inside - 1) < 2e-3
        assert (mesh.bounds >= np.array(box)[0] - 1e-6).all()
        assert (mesh.bounds <= np.array(box)[1] + 1e-6).all()


def test_bounds_far_beyond_the_shape_change_nothing() -> None:
    wide = iso.to_mesh(iso.sphere(1), cell=0.1, bounds=((-50, -50, -50), (50, 50, 50)))
    assert wide == iso.to_mesh(iso.sphere(1), cell=0.1)


def test_progress_runs_from_nothing_to_all() -> None:
    told: list[tuple[str, float]] = []
    iso.to_mesh(PART, cell=0.02, progress=lambda stage, part: told.append((stage, part)))
    stages = list(dict.fromkeys(stage for stage, _ in told if "compiling" not in stage))
    assert stages == ["contouring", "joining"]
    for stage in stages:
        parts = [part for name, part in told if name == stage]
        assert parts == sorted(parts)
        assert parts[-1] == 1


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        (lambda: iso.to_mesh(iso.plane()), "the shape is endless"),
        (lambda: iso.to_mesh(iso.cylinder(1), cell=0.1), r"give bounds="),
        (lambda: iso.to_mesh(iso.sphere(1) & iso.sphere(1).translate((3, 0, 0))), "no surface found"),
        (lambda: iso.to_mesh(iso.sphere(1), bounds=((3, 3, 3), (4, 4, 4))), "no surface found"),
        (lambda: iso.to_mesh(iso.sphere(1), cell=1e-3, memory=1e8), r"GB of memory.*cell 0\.0\d+ fits"),
        (lambda: iso.to_mesh(iso.sphere(1), cell=1e-9), "too small"),
        (lambda: iso.to_mesh(iso.sphere(1).translate((1e6, 0, 0)), cell=0.01), "the same in single precision"),
        (lambda: iso.to_mesh(iso.sphere(1), cell=0), "cell must be a length above 0"),
        (lambda: iso.to_mesh(iso.sphere(1), cell=math.nan), "cell must be a length above 0"),
        (lambda: iso.to_mesh(iso.sphere(1), tolerance=0), "tolerance must be"),
        (lambda: iso.to_mesh(iso.sphere(1), tolerance=-1, cell=1), "tolerance must be"),
        (lambda: iso.to_mesh(iso.sphere(1), bounds=((0, 0, 0), (0, 1, 1))), "bounds must be"),
        (lambda: iso.to_mesh(iso.sphere(1), bounds="all"), "bounds must be"),
        (lambda: iso.to_mesh(iso.sphere(1), method="marching"), "method must be one of dual-contouring"),  # type: ignore[arg-type]
        (lambda: iso.to_mesh(iso.sphere(1), threads=0), "threads must be"),
        (lambda: iso.to_mesh(iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])), "takes a field"),  # type: ignore[arg-type]
    ],
)  # fmt: skip
def test_what_cannot_be_meshed_is_refused_with_a_remedy(call: Callable[[], object], reason: str) -> None:
    with pytest.raises(iso.GeometryError, match=reason):
        call()


def test_a_field_smaller_than_a_cell_is_not_found_silently() -> None:
    with pytest.raises(iso.GeometryError, match="smaller cell="):
        iso.to_mesh(iso.sphere(0.001).translate((0.3, 0.4, 0.2)) & iso.box(10), cell=10.0)
