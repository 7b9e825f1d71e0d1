"""Repair of meshes, step by step, and what is kept and told."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.analysis import mass_properties, orient, repair, topology
from surfaces import CUBE, Face, annulus, cube, mesh_of, plate_with_holes, strip, together, torus

NOTHING = {"weld": None, "degenerate": False, "duplicates": False, "split": False, "holes": False, "unused": False}


def only(**steps: object) -> dict[str, object]:
    return {**NOTHING, **steps}


def soup(mesh: iso.Mesh) -> iso.Mesh:
    """The mesh with a vertex for each corner."""
    return iso.Mesh.from_polygons(mesh.vertices[mesh.indices], np.arange(len(mesh.indices)), mesh.offsets)


def test_a_sound_mesh_is_left_alone() -> None:
    mesh, report = repair(cube())
    assert mesh == cube()
    assert not report.changed
    assert str(report) == "nothing to repair"
    assert report.vertex_source.tolist() == list(range(8))


def test_welding_makes_a_solid_of_a_soup() -> None:
    mesh, report = repair(soup(plate_with_holes(3)))
    assert topology(mesh).genus == 3
    assert mass_properties(mesh).volume == pytest.approx(18)
    assert len(report.welded) == 4 * mesh.face_count - len(mesh.vertices)
    given_points = soup(plate_with_holes(3)).vertices
    assert np.array_equal(given_points[report.welded[:, 0]], given_points[report.welded[:, 1]])
    assert (report.welded[:, 1] < report.welded[:, 0]).all()
    assert "vertices welded" in str(report)


def test_welding_within_a_tolerance() -> None:
    noisy = soup(plate_with_holes(2))
    noise = np.random.default_rng(0).uniform(-1, 1, noisy.vertices.shape) * 0.01
    noisy = noisy.with_(vertices=noisy.vertices + noise)
    assert not topology(repair(noisy, holes=False)[0]).closed
    mesh, report = repair(noisy, weld=0.05)
    assert topology(mesh).genus == 2
    moved = noisy.vertices[report.welded[:, 0]] - noisy.vertices[report.welded[:, 1]]
    assert np.linalg.norm(moved, axis=1).max() <= 0.05


def test_a_chain_of_near_vertices_does_not_collapse() -> None:
    # Each point is within the tolerance of the next: every other one leads, none moves farther than allowed.
    points = [(0.1 * i, 0, 0) for i in range(10)] + [(0, 5, 0), (1, 5, 0)]
    chain = iso.Mesh(points, [(i, i + 1, 10 + i % 2) for i in range(9)])
    mesh, report = repair(chain, **only(weld=0.11))
    assert mesh.vertices[:, 0].tolist() == pytest.approx([0, 0.2, 0.4, 0.6, 0.8, 0, 1])
    assert report.welded.tolist() == [[1, 0], [3, 2], [5, 4], [7, 6], [9, 8]]


def test_minus_zero_is_zero() -> None:
    mesh, _ = repair(
        iso.Mesh([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (-0.0, 0, 0)], [(0, 1, 2), (3, 2, 1)]), **only(weld=0)
    )
    assert len(mesh.vertices) == 3


def test_a_tolerance_without_meaning_is_refused() -> None:
    for weld in (-1, float("nan"), float("inf"), "much", True):
        with pytest.raises(iso.GeometryError, match="weld must be"):
            repair(cube(), weld=weld)  # type: ignore[arg-type]
    points = np.random.default_rng(0).random((3000, 3))
    with pytest.raises(iso.GeometryError, match="too large for this mesh"):
        repair(iso.Mesh(points, np.arange(3000).reshape(-1, 3)), weld=10.0)
    for holes in (-1, 2.5, "all", None):
        with pytest.raises(iso.GeometryError, match="holes must be"):
            repair(cube(), holes=holes)  # type: ignore[arg-type]


def test_degenerate_faces_are_dropped_or_cut() -> None:
    faces = [(0, 1, 1), (0, 1, 2, 2), (3, 4, 5, 3, 6, 7), (0, 1, 0, 2), (5, 6, 7)]
    mesh, report = repair(mesh_of(faces), **only(degenerate=True))
    assert report.degenerate_faces.tolist() == [0, 1, 2, 3]
    assert [set(map(int, face)) for face in mesh.faces] == [{0, 1, 2}, {3, 4, 5}, {3, 6, 7}, {5, 6, 7}]
    assert report.face_source.tolist() == [1, 2, 2, 4]
    with pytest.raises(iso.GeometryError, match="nothing is left"):
        repair(mesh_of([(0, 1, 0)]))


def test_duplicate_faces() -> None:
    faces = [(0, 1, 2), (1, 2, 0), (2, 1, 0), (0, 1, 2, 3), (0, 2, 1, 3), (3, 2, 1, 0), (4, 5, 6)]
    mesh, report = repair(mesh_of(faces), **only(duplicates=True))
    # Other cycles through the same vertices are other faces.
    assert report.duplicate_faces.tolist() == [1, 2, 5]
    assert report.face_source.tolist() == [0, 3, 4, 6]
    assert [len(face) for face in mesh.faces] == [3, 4, 4, 3]


def test_pinched_vertices_come_apart() -> None:
    two = together(cube(), cube(offset=(1, 1, 1)))
    shared = iso.Mesh(two.vertices, [tuple(7 if v == 8 else int(v) for v in face) for face in two.faces])
    mesh, report = repair(shared, **only(split=True))
    found = topology(mesh)
    assert report.split_vertices.tolist() == [7]
    assert report.vertex_source.tolist() == [*range(16), 7]
    assert found.manifold
    assert len(found.components) == 2
    assert mass_properties(mesh).volume == pytest.approx(2)


def test_edges_of_three_faces_come_apart() -> None:
    shared = together(cube(), cube(offset=(1, 1, 0)))
    faces = [tuple({8: 6, 9: 7}.get(int(v), int(v)) for v in face) for face in shared.faces]
    mesh, report = repair(iso.Mesh(shared.vertices, faces))
    assert report.split_vertices.tolist() == [6, 7]
    assert topology(mesh).closed
    assert topology(mesh).manifold
    assert topology(mesh).components.euler.tolist() == [2, 2]


small_faces = st.lists(st.lists(st.integers(0, 6), min_size=3, max_size=5).map(tuple), min_size=0, max_size=8).map(
    lambda faces: [(0, 1, 2), *faces]
)


@settings(max_examples=200, deadline=None)
@given(small_faces)
def test_everything_becomes_manifold(faces: list[Face]) -> None:
    given_mesh = mesh_of(faces)
    mesh, report = repair(given_mesh)
    found = topology(mesh)
    assert found.manifold
    assert len(found.degenerate_faces) == len(found.unused_vertices) == 0
    # What stays open are rims of single triangles.
    assert found.loop_count == len(report.open)
    assert all(len(loop) == 3 for loop in report.open)
    again, second = repair(mesh, weld=None)
    assert again == mesh
    assert not second.changed
    old = np.flatnonzero(report.face_source >= 0)
    assert all(set(map(int, given_mesh.faces[report.face_source[f]])) >= origin(mesh, report, f) for f in old)
    assert np.array_equal(mesh.vertices[report.vertex_source >= 0], given_mesh.vertices[report.vertex_source])


def origin(mesh: iso.Mesh, report: iso.analysis.RepairReport, face: int) -> set[int]:
    return {int(report.vertex_source[v]) for v in mesh.faces[face]}


def test_holes_are_filled_flat_and_outward() -> None:
    opened = iso.Mesh(cube().vertices, CUBE[1:])
    mesh, report = repair(opened)
    assert mass_properties(mesh).volume == pytest.approx(1)
    assert mass_properties(mesh).area == pytest.approx(6)
    assert [sorted(map(int, loop)) for loop in report.filled] == [[0, 1, 2, 3]]
    assert report.face_source.tolist() == [0, 1, 2, 3, 4, -1, -1]


def test_only_small_holes() -> None:
    opened = mesh_of([face for i, face in enumerate(torus(9, 9)) if i not in (0, 40, 41)])
    mesh, report = repair(opened, holes=4)
    assert [len(loop) for loop in report.filled] == [4]
    assert [len(loop) for loop in report.open] == [6]
    assert topology(mesh).loop_count == 1
    _, report = repair(opened, holes=False)
    assert sorted(len(loop) for loop in report.open) == [4, 6]
    assert not report.changed


def test_a_lid_of_least_area_uses_no_edge_twice() -> None:
    # An arrowhead of two triangles: its rim has one diagonal inside, which is an edge already, and one outside.
    head = iso.Mesh([(0, 0, 0), (-1, -1, 0), (0, 2, 0), (1, -1, 0)], [(1, 0, 2), (3, 2, 0)])
    mesh, _ = repair(head)
    found = topology(mesh)
    assert found.closed
    assert found.manifold
    assert found.edges == 6
    assert {frozenset(map(int, face)) for face in mesh.faces[2:]} == {frozenset({0, 1, 3}), frozenset({1, 2, 3})}


def test_large_holes_get_a_middle() -> None:
    count = 1200
    angle = 2 * np.pi * np.arange(count) / count
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = np.concatenate([np.insert(ring, 2, z, axis=1) for z in (0.0, 1.0)])
    i, j = np.arange(count), np.roll(np.arange(count), -1)
    heat = np.linspace(0, 1, 2 * count)[:, None]
    tube = iso.Mesh(points, np.stack([i, j, j + count, i + count], axis=1), attributes={"heat": heat})
    mesh, report = repair(tube)
    assert topology(mesh).genus == 0
    assert mass_properties(mesh).volume == pytest.approx(count / 2 * np.sin(2 * np.pi / count))
    assert (report.vertex_source < 0).sum() == 2
    assert mesh.vertices[-2:, :2] == pytest.approx(np.zeros((2, 2)), abs=1e-12)
    assert mesh.attributes["heat"].values[-2:, 0] == pytest.approx([heat[:count].mean(), heat[count:].mean()])
    small, _ = repair(iso.Mesh(tube.vertices, tube.faces[:-2]))
    assert topology(small).genus == 0


def test_an_annulus_becomes_a_sphere_and_a_disc_a_double_one() -> None:
    assert topology(repair(mesh_of(annulus()))[0]).genus == 0
    assert topology(repair(mesh_of(strip(3, 3)))[0]).genus == 0
    mesh, report = repair(mesh_of([(0, 1, 2)]))
    assert mesh.face_count == 1
    assert len(report.open) == 1


def labelled() -> iso.Mesh:
    """A cube of six loose squares with everything that a mesh can carry, one of them twice and one missing."""
    points = np.concatenate([cube().vertices[list(face)] for face in (*CUBE[:5], CUBE[0])])
    faces = np.arange(24).reshape(6, 4)
    return iso.Mesh(
        points,
        faces,
        attributes={
            "height": points[:, 2:],
            "side": np.repeat(np.arange(6), 4)[:, None],
            "uv": iso.Attribute(np.arange(48.0).reshape(24, 2), np.arange(24)[::-1]),
        },
        labels={"material": iso.FaceLabels(("a", "b"), np.array([0, 1, 0, 1, -1, 1]))},
    )


def test_attributes_and_labels_are_kept() -> None:
    before = labelled()
    mesh, report = repair(before)
    assert topology(mesh).closed
    assert report.duplicate_faces.tolist() == [5]
    assert mesh.labels["material"].index.tolist() == [0, 1, 0, 1, -1, -1, -1]
    # Welded vertices have one height, so it stays at vertices; their sides differ, so these go to corners.
    assert mesh.attributes["height"].indices is None
    assert mesh.attributes["height"].values[:, 0].tolist() == mesh.vertices[:, 2].tolist()
    side, uv = mesh.attributes["side"], mesh.attributes["uv"]
    assert side.indices is not None
    assert uv.indices is not None
    assert side.values[side.indices[:20], 0].tolist() == np.repeat(range(5), 4).tolist()
    assert uv.values[uv.indices[:20]].tolist() == before.attributes["uv"].values[::-1][:20].tolist()
    assert (side.indices[20:] == -1).all()
    assert (uv.indices[20:] == -1).all()
    assert orient(mesh) is mesh


def test_booleans_of_boxes() -> None:
    a, b = cube(), cube(offset=(0.5, 0.5, 0.5))
    for operation, volume in (("union", 1.875), ("intersection", 0.125), ("difference", 0.875)):
        found = iso.analysis.boolean(a, b, operation)
        assert mass_properties(found).volume == pytest.approx(volume)
        assert topology(found).genus == 0
    drilled = iso.analysis.boolean(cube(3.0), iso.Mesh(cube().vertices + (1, 1, 0) * np.array(1.0), CUBE), "union")
    assert mass_properties(drilled).volume == pytest.approx(27)
    rod = iso.Mesh(cube().vertices * (1, 1, 9) + (1, 1, -3), CUBE)
    assert topology(iso.analysis.boolean(cube(3.0), rod, "difference")).genus == 1


def test_booleans_keep_labels() -> None:
    names = iso.FaceLabels(("side", "end"), np.array([0, 0, 0, 0, 1, 1]))
    a = iso.Mesh(cube().vertices, CUBE, labels={"group": names})
    b = iso.Mesh(
        cube(offset=(0.25, 0.25, 0.5)).vertices, CUBE, labels={"group": iso.FaceLabels(("b",), np.zeros(6, int))}
    )
    found = iso.analysis.boolean(a, b, "union")
    label = found.labels["group"]
    middle = found.vertices[found.faces].mean(axis=1)
    for name, point in zip(np.array([*label.names, ""])[label.index], middle, strict=True):
        if name == "end":
            assert point[2] in (0, 1)
        elif name == "side":
            assert np.isin(point[:2], (0, 1)).any()
        else:
            assert name == "b"
            assert (point >= (0.25, 0.25, 0.5)).all()
    assert set(label.index) == {0, 1, 2}
    plain = iso.analysis.boolean(a, cube(offset=(0.5, 0.5, 0.5)), "difference")
    assert set(plain.labels["group"].index) == {-1, 0, 1}


def test_booleans_refuse_what_is_no_solid() -> None:
    opened = iso.Mesh(cube().vertices, CUBE[1:])
    inward = iso.Mesh(cube().vertices, [face[::-1] for face in CUBE])
    one_turned = iso.Mesh(cube().vertices, [CUBE[0][::-1], *CUBE[1:]])
    two = together(cube(), cube(offset=(1, 1, 1)))
    pinched = iso.Mesh(two.vertices, [tuple(7 if v == 8 else int(v) for v in face) for face in two.faces])
    degenerate = iso.Mesh(cube().vertices, [*CUBE, (0, 1, 1)])
    for mesh, reason in (
        (opened, "mesh b 4 edges have one face, the first from vertex 0 to 1"),
        (inward, "mesh b its faces look inward"),
        (one_turned, "mesh b two faces run the same way"),
        (pinched, "mesh b the faces at 1 vertices form several fans, the first at vertex 7"),
        (degenerate, "mesh b face 6 names a vertex twice"),
    ):
        with pytest.raises(iso.GeometryError, match=reason):
            iso.analysis.boolean(cube(), mesh, "union")
    with pytest.raises(iso.GeometryError, match="one of union"):
        iso.analysis.boolean(cube(), cube(), "xor")
    with pytest.raises(iso.GeometryError, match="nothing is left of the intersection"):
        iso.analysis.boolean(cube(), cube(offset=(5, 0, 0)), "intersection")
    coloured = iso.Mesh(cube().vertices, CUBE, attributes={"colour": np.ones((8, 3))})
    with pytest.warns(iso.IsophoteWarning, match="leaves out the attributes colour"):
        iso.analysis.boolean(coloured, cube(), "union")
