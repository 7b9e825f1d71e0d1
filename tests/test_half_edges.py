"""Half-edges, and turning faces so that neighbours agree."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.analysis import area, half_edges, mass_properties, orient, topology
from surfaces import CUBE, Face, cube, klein_bottle, mesh_of, moebius, plate_with_holes, together, torus, turned

small_faces = st.lists(st.lists(st.integers(0, 6), min_size=3, max_size=5).map(tuple), min_size=1, max_size=8)


@settings(max_examples=300, deadline=None)
@given(small_faces)
def test_half_edges_of_anything(faces: list[Face]) -> None:
    mesh = mesh_of(faces)
    h = half_edges(mesh)
    here, ends = mesh.indices, mesh.indices[h.next]
    assert len(h) == sum(map(len, faces))
    assert h.vertex.tolist() == [v for face in faces for v in face]
    assert h.face.tolist() == [f for f, face in enumerate(faces) for _ in face]
    assert ends.tolist() == [v for face in faces for v in (*face[1:], face[0])]
    at: dict[tuple[int, int], list[int]] = {}
    for i, (a, b) in enumerate(zip(here.tolist(), ends.tolist(), strict=True)):
        if len(set(faces[h.face[i]])) == len(faces[h.face[i]]):
            at.setdefault((min(a, b), max(a, b)), []).append(i)
    for i, (a, b) in enumerate(zip(here.tolist(), ends.tolist(), strict=True)):
        others = at.get((min(a, b), max(a, b)), [])
        if i not in others:
            assert h.twin[i] == -4
        elif len(others) != 2:
            assert h.twin[i] == (-1 if len(others) == 1 else -2)
        else:
            other = sum(others) - i
            assert h.twin[i] == (other if here[other] == b else -3)
    paired = np.flatnonzero(h.twin >= 0)
    assert (h.twin[h.twin[paired]] == paired).all()
    assert (h.vertex[h.twin[paired]] == h.vertex[h.next[paired]]).all()


def test_half_edges_are_read_only() -> None:
    with pytest.raises(ValueError, match="read-only"):
        half_edges(cube()).twin[0] = 0


@given(st.sets(st.integers(0, 5)))
@settings(max_examples=64, deadline=None)
def test_cubes_are_turned_outward(chosen: set[int]) -> None:
    found = orient(turned(cube(), *chosen))
    assert topology(found).oriented
    assert mass_properties(found).volume == pytest.approx(1)
    # Each face begins at its own first corner.
    assert found.indices.reshape(-1, 4)[:, 0].tolist() == turned(cube(), *chosen).indices.reshape(-1, 4)[:, 0].tolist()


def test_what_is_oriented_comes_back_itself() -> None:
    mesh = cube()
    assert orient(mesh) is mesh


def test_open_parts_keep_the_side_of_most_faces() -> None:
    mesh = iso.Mesh(mesh_of(torus()).vertices, torus()[1:])
    for chosen in ((3, 7, 8), tuple(set(range(29)) - {2, 9})):
        found = orient(turned(mesh, *chosen))
        majority = mesh if len(chosen) < 15 else turned(mesh, *range(29))
        assert topology(found).oriented
        assert {frozenset(edges(face)) for face in found.faces} == {frozenset(edges(face)) for face in majority.faces}


def edges(face: np.ndarray) -> list[tuple[int, int]]:
    return list(zip(face.tolist(), np.roll(face, -1).tolist(), strict=True))


def test_every_shell_is_turned_outward_by_itself() -> None:
    shells = together(cube(10.0), cube(1.0, (4, 4, 4)), turned(cube(1.0, (20, 0, 0)), *range(6)))
    assert mass_properties(orient(shells)).volume == pytest.approx(1002)


def test_cavities_look_inward() -> None:
    # A hollow with a core in it, whose own hollow is empty, beside another solid.
    shells = together(
        cube(10.0), cube(8.0, (1, 1, 1)), cube(2.0, (4, 4, 4)), cube(1.0, (4.5, 4.5, 4.5)), cube(1.0, (20, 0, 0))
    )
    for mesh in (shells, turned(shells, 3, *range(6, 18), 29)):
        assert mass_properties(orient(mesh)).volume == pytest.approx(1000 + 512 + 8 + 1 + 1)
        hollow = orient(mesh, cavities=True)
        assert mass_properties(hollow).volume == pytest.approx(1000 - 512 + 8 - 1 + 1)
        assert orient(hollow, cavities=True) is hollow
        assert topology(hollow).oriented
    beside = together(cube(), cube(offset=(3, 0, 0)))
    assert orient(beside, cavities=True) is beside


def test_orientation_far_from_the_origin_and_at_any_scale() -> None:
    for scale, offset in ((1.0, 1e7), (1e-200, 0.0), (1e290, 0.0)):
        inward = turned(cube(), *range(6))
        mesh = iso.Mesh(inward.vertices * scale + offset, inward.faces)
        assert np.array_equal(
            orient(mesh).indices.reshape(-1, 4)[:, ::-1][:, [3, 0, 1, 2]], mesh.indices.reshape(-1, 4)
        )


def test_labels_and_attributes_stay_with_their_corners() -> None:
    mesh = turned(cube(), 1, 4)
    uv = np.arange(48.0).reshape(24, 2)
    kept = iso.Mesh(
        mesh.vertices,
        mesh.faces,
        attributes={"uv": iso.Attribute(uv, np.arange(24)), "height": mesh.vertices[:, 1:2]},
        labels={"material": iso.FaceLabels(tuple("abcdef"), np.arange(6))},
    )
    found = orient(kept)
    assert found.labels["material"] == kept.labels["material"]
    assert found.attributes["height"] == kept.attributes["height"]
    was = {(face, int(v)): row for face, v, row in zip(np.repeat(range(6), 4), kept.indices, uv.tolist(), strict=True)}
    values = found.attributes["uv"].values[found.attributes["uv"].indices].tolist()
    assert all(
        was[face, int(v)] == row for face, v, row in zip(np.repeat(range(6), 4), found.indices, values, strict=True)
    )


@pytest.mark.parametrize("faces", [moebius(), klein_bottle(), moebius(8), klein_bottle(6, 7)])
@pytest.mark.parametrize("seed", range(5))
def test_the_named_cycle_is_one_sided(faces: list[Face], seed: int) -> None:
    order = np.random.default_rng(seed).permutation(len(faces))
    shuffled = [faces[i][:: 1 if i % 3 else -1] for i in order]
    with pytest.raises(iso.GeometryError) as caught:
        orient(mesh_of(shuffled))
    told = re.search(r"by the (\d+) faces ([\d, ]+)", str(caught.value))
    assert told is not None
    cycle = [int(word) for word in told[2].split(",")]
    assert len(cycle) == int(told[1])
    # The band of these faces, each glued to the next only, cannot be turned to agree.
    sides = 0
    for f, g in zip(cycle, cycle[1:] + cycle[:1], strict=True):
        here, there = edges(np.array(shuffled[f])), edges(np.array(shuffled[g]))
        shared = [e for e in here if e in there or e[::-1] in there]
        assert len(shared) == 1
        sides += shared[0] in there
    assert sides % 2 == 1


def test_mass_of_a_box() -> None:
    a, b, c = 2.0, 3.0, 5.0
    box = iso.Mesh(cube().vertices * (a, b, c) + (7, -1, 2), CUBE)
    found = mass_properties(box)
    assert found.volume == pytest.approx(30, rel=1e-14)
    assert found.area == pytest.approx(2 * (a * b + b * c + c * a), rel=1e-14) == area(box)
    assert found.centroid == pytest.approx([8, 0.5, 4.5], rel=1e-14)
    moments = np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) * 30 / 12
    assert found.inertia == pytest.approx(moments, rel=1e-13, abs=1e-12)
    principal, axes = found.principal
    assert principal == pytest.approx(sorted(np.diag(moments)))
    assert np.abs(axes) == pytest.approx(np.eye(3)[::-1], abs=1e-12)


def test_mass_of_a_tetrahedron() -> None:
    # The unit corner: volume 1/6, centroid 1/4, ∫ x² = 1/60 and ∫ x y = 1/120 about the right angle.
    corner = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
    found = mass_properties(corner)
    assert (found.volume, found.area) == pytest.approx((1 / 6, 1.5 + 3**0.5 / 2))
    about_origin = np.full((3, 3), 1 / 120) + np.eye(3) / 120
    second = about_origin - found.volume * np.full((3, 3), 1 / 16)
    assert found.inertia == pytest.approx(np.trace(second) * np.eye(3) - second)


def test_mass_of_plates_and_far_away() -> None:
    for holes in (1, 4):
        found = mass_properties(plate_with_holes(holes))
        assert found.volume == pytest.approx(3 * (2 * holes + 1) - holes)
        assert found.centroid == pytest.approx([holes + 0.5, 1.5, 0.5])
    far = mass_properties(iso.Mesh(cube().vertices + 1e8, CUBE))
    assert far.inertia == pytest.approx(np.eye(3) / 6, abs=1e-6)


def test_what_bounds_no_solid_is_refused() -> None:
    opened = iso.Mesh(cube().vertices, CUBE[1:])
    assert area(opened) == pytest.approx(5)
    # Three squares on each of four edges: a wall within a box of two cells.
    lower, upper = ([tuple(3 * (v // 2) + v % 2 + k for v in face) for face in CUBE] for k in (0, 1))
    walled = mesh_of([*lower, *(face for face in upper if set(face) not in map(set, lower))])
    for mesh, reason in (
        (opened, "not closed: 4 edges"),
        (turned(cube(), 0), "two faces run the same way"),
        (walled, "not passed equally often"),
        (mesh_of([(0, 1, 2), (2, 1, 0)]), "no volume"),
        (mesh_of([(0, 1, 0)]), "degenerate"),
        (iso.Mesh(cube().vertices * 1e200, CUBE), "too large"),
    ):
        with pytest.raises(iso.GeometryError, match=reason):
            mass_properties(mesh)
    # Two cubes that share an edge pass it twice each way, and bound a solid.
    shared = together(cube(), cube(offset=(1, 1, 0)))
    faces_of_two = [tuple({8: 6, 9: 7}.get(int(v), int(v)) for v in face) for face in shared.faces]
    assert mass_properties(iso.Mesh(shared.vertices, faces_of_two)).volume == pytest.approx(2)
