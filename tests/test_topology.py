"""Topology of meshes: constructed surfaces, real files, and brute force over small random meshes."""

from __future__ import annotations

import itertools
import math
from collections import Counter, defaultdict

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.analysis import topology
from isophote.analysis.connectivity import stars
from surfaces import (
    CUBE,
    Face,
    annulus,
    cube,
    klein_bottle,
    mesh_of,
    moebius,
    plate_with_holes,
    strip,
    together,
    torus,
    triangles_of,
    turned,
    with_handles,
)


def edges_of(face: Face) -> list[tuple[int, int]]:
    return list(zip(face, (*face[1:], face[0]), strict=True))


def pairs(edges: np.ndarray) -> list[tuple[int, int]]:
    return [(int(a), int(b)) for a, b in edges]


def test_a_cube() -> None:
    found = topology(cube())
    assert (found.vertices, found.edges, found.faces, found.euler, found.genus) == (8, 12, 6, 2, 0)
    assert found.closed
    assert found.manifold
    assert found.oriented
    assert found.orientable
    assert len(found.components) == 1
    assert found.angle_deficit == pytest.approx(4 * math.pi, abs=1e-13)
    assert found.boundary_turning == 0
    assert found.boundary_loops == ()
    with pytest.raises(ValueError, match="read-only"):
        found.boundary_edges[:] = 0


@pytest.mark.parametrize("genus", range(11))
@pytest.mark.parametrize("cut", [list, triangles_of])
def test_genus_of_glued_handles(genus: int, cut: object) -> None:
    found = topology(mesh_of(cut(with_handles(genus))))  # type: ignore[operator]
    assert found.genus == genus
    assert found.components.genus.tolist() == [genus]
    assert found.euler == 2 - 2 * genus
    assert found.closed
    assert found.manifold
    assert found.oriented
    assert abs(found.gauss_bonnet_error) < 1e-12 * found.vertices


@pytest.mark.parametrize("holes", range(11))
def test_genus_of_plates(holes: int) -> None:
    found = topology(plate_with_holes(holes))
    assert found.genus == holes
    # Right angles only: three squares at a corner, four or five around the others.
    assert found.angle_deficit == pytest.approx(2 * math.pi * (2 - 2 * holes), abs=1e-12)


def test_one_sided_surfaces() -> None:
    for faces in (moebius(), triangles_of(moebius())):
        found = topology(mesh_of(faces))
        assert found.manifold
        assert not found.closed
        assert not found.orientable
        assert not found.oriented
        assert found.genus is None
        assert (found.euler, found.loop_count, found.components.crosscaps.tolist()) == (0, 1, [1])
        assert len(found.boundary_loops[0]) == 14
    for faces in (klein_bottle(), triangles_of(klein_bottle())):
        found = topology(mesh_of(faces))
        assert found.manifold
        assert found.closed
        assert not found.orientable
        assert (found.euler, found.genus, found.components.crosscaps.tolist()) == (0, None, [2])
        assert found.components.genus.tolist() == [-1]


def test_surfaces_with_boundary() -> None:
    for faces, loops, euler in ((strip(3, 4), [14], 1), (annulus(), [7, 7], 0), (torus()[1:], [4], -1)):
        found = topology(mesh_of(faces))
        assert found.manifold
        assert not found.closed
        assert found.oriented
        assert sorted(len(loop) for loop in found.boundary_loops) == loops
        assert found.components.boundary_loops.tolist() == [len(loops)]
        assert found.euler == euler == 2 - 2 * found.genus - len(loops)
        forward = {edge for face in faces for edge in edges_of(face)}
        assert all(edge in forward for loop in found.boundary_loops for edge in edges_of(tuple(loop)))
        assert abs(found.gauss_bonnet_error) < 1e-12 * found.vertices


def test_a_flat_disc_turns_once() -> None:
    # All of the turning of a flat disc is in its rim.
    count = 40
    rim = [(math.cos(a), math.sin(a), 0) for a in 2 * np.pi * np.arange(count) / count]
    found = topology(iso.Mesh([*rim, (0.1, 0.2, 0)], [(i, (i + 1) % count, count) for i in range(count)]))
    assert found.angle_deficit == pytest.approx(0, abs=1e-13)
    assert found.boundary_turning == pytest.approx(2 * math.pi, abs=1e-13)


def test_three_faces_on_an_edge() -> None:
    found = topology(mesh_of([(0, 1, 2), (1, 0, 3), (0, 1, 4)]))
    assert pairs(found.non_manifold_edges) == [(0, 1)]
    assert found.non_manifold_faces.tolist() == [0, 1, 2]
    assert found.non_manifold_vertices.tolist() == [0, 1]
    assert not found.manifold
    assert not found.closed
    assert found.genus is None
    assert found.boundary_loops == ()
    assert sorted(tuple(map(int, chain)) for chain in found.boundary_chains) == [(0, 3, 1), (1, 2, 0), (1, 4, 0)]


def test_a_pinched_vertex_and_a_bow_tie() -> None:
    two = together(cube(), cube(offset=(1, 1, 1)))
    shared = [tuple(7 if v == 8 else int(v) for v in face) for face in two.faces]
    found = topology(iso.Mesh(two.vertices, shared))
    assert found.non_manifold_vertices.tolist() == [7]
    assert found.unused_vertices.tolist() == [8]
    assert found.closed
    assert not found.manifold
    assert found.genus is None
    assert (len(found.components), found.euler, len(found.non_manifold_edges)) == (1, 3, 0)
    bow_tie = topology(mesh_of([(0, 1, 2), (0, 3, 4)]))
    assert bow_tie.non_manifold_vertices.tolist() == [0]
    assert sorted(map(len, bow_tie.boundary_loops)) == [3, 3]
    assert bow_tie.boundary_chains == ()


def test_a_double_cover_is_a_sphere() -> None:
    found = topology(mesh_of([(0, 1, 2), (2, 1, 0)]))
    assert found.closed
    assert found.manifold
    assert found.oriented
    assert found.genus == 0
    assert not topology(mesh_of([(0, 1, 2), (0, 1, 2)])).oriented


def test_a_turned_face_is_to_blame() -> None:
    found = topology(turned(cube(), 2))
    assert not found.oriented
    assert found.orientable
    assert found.manifold
    assert pairs(found.turned_edges) == sorted((min(e), max(e)) for e in edges_of(CUBE[2]))


def test_components_are_told_apart() -> None:
    found = topology(together(cube(), mesh_of(torus()), mesh_of(moebius()), mesh_of(torus()[3:])))
    parts = found.components
    assert parts.genus.tolist() == [0, 1, -1, 1]
    assert parts.boundary_loops.tolist() == [0, 0, 1, 1]
    assert parts.closed.tolist() == [True, True, False, False]
    assert parts.orientable.tolist() == [True, True, False, True]
    assert parts.crosscaps.tolist() == [0, 0, 1, 0]
    assert np.bincount(parts.of_vertex).tolist() == parts.vertices.tolist()
    assert (int(parts.edges.sum()), int(parts.faces.sum())) == (found.edges, found.faces)
    assert found.genus is None


def test_degenerate_faces_are_set_aside() -> None:
    faces = [*triangles_of(list(CUBE)), (0, 1, 1), (2, 2, 2), (5, 6, 5)]
    found = topology(mesh_of(faces))
    assert found.degenerate_faces.tolist() == [12, 13, 14]
    assert (found.closed, found.manifold, found.faces, found.euler) == (True, True, 12, 2)
    quads = topology(mesh_of([(0, 1, 0, 2), *CUBE, (4, 5, 6, 6, 7)]))
    assert quads.degenerate_faces.tolist() == [0, 7]
    assert quads.closed
    assert quads.manifold
    nothing = topology(mesh_of([(0, 1, 0)]))
    assert (nothing.vertices, nothing.faces, nothing.closed, nothing.euler) == (0, 0, False, 0)


def test_what_is_no_mesh_is_refused() -> None:
    with pytest.raises(iso.GeometryError, match="a Mesh is wanted"):
        topology([(0, 1, 2)])  # type: ignore[arg-type]


@pytest.mark.parametrize("count", [17, 49, 100_000])
def test_hubs(count: int) -> None:
    # A double cone: two vertices with all faces; then one face less, and one fan more.
    ring = np.arange(count)
    following = np.roll(ring, -1)
    top, bottom = np.full(count, count), np.full(count, count + 1)
    faces = np.concatenate([np.stack([ring, following, top], 1), np.stack([following, ring, bottom], 1)])
    points = np.random.default_rng(1).normal(size=(count + 2, 3))
    found = topology(iso.Mesh(points, faces))
    assert found.closed
    assert found.manifold
    assert found.oriented
    assert found.euler == 2
    assert [len(loop) for loop in topology(iso.Mesh(points, faces[1:])).boundary_loops] == [3]
    # Holes that touch are one: a walk goes on along the fan by which it came.
    pinched = topology(iso.Mesh(points, np.delete(faces, [1, 5], axis=0)))
    assert pinched.non_manifold_vertices.tolist() == [count]
    assert [len(loop) for loop in pinched.boundary_loops] == [6]


def test_the_number_of_processors_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    faces = np.delete(np.array(strip(300, 400, "even", "even")), [5, 7, 70_000], axis=0)
    points = np.random.default_rng(2).normal(size=(120_000, 3))
    results = []
    for processors in (1, 3, 8):
        monkeypatch.setattr(stars, "processors", lambda count=processors: count)
        monkeypatch.setattr("isophote.analysis.crew.processors", lambda count=processors: count)
        found = topology(iso.Mesh(points, faces))
        results.append((found.angle_deficit, found.boundary_turning, found.euler, *map(bytes, found.boundary_loops)))
        halves = iso.analysis.half_edges(iso.Mesh(points, faces))
        results[-1] += (bytes(halves.twin),)
    assert results[0] == results[1] == results[2]
    assert results[0][2] == -3


def test_angles_at_any_scale() -> None:
    for scale in (1e-300, 1e-150, 1e150, 1.7e308):
        found = topology(iso.Mesh(cube().vertices * scale, CUBE))
        assert found.angle_deficit == pytest.approx(4 * math.pi, abs=1e-13)
    # Two corners at one place, and all three.
    flat = topology(
        iso.Mesh([(0, 0, 0), (0, 0, 0), (1, 0, 0), (1, 0, 0), (1, 0, 0)], [(0, 1, 2), (1, 2, 0), (2, 3, 4)])
    )
    assert abs(flat.gauss_bonnet_error) < 1e-14


small_faces = st.lists(
    st.lists(st.integers(0, 6), min_size=3, max_size=5, unique=True).map(tuple), min_size=1, max_size=7
)


@settings(max_examples=300, deadline=None)
@given(small_faces)
def test_against_brute_force(faces: list[Face]) -> None:
    mesh = mesh_of(faces)
    found = topology(mesh)
    ways: dict[tuple[int, int], list[tuple[int, bool]]] = defaultdict(list)
    for f, face in enumerate(faces):
        for a, b in edges_of(face):
            ways[min(a, b), max(a, b)].append((f, a < b))
    used = {v for face in faces for v in face}
    assert (found.vertices, found.edges, found.faces) == (len(used), len(ways), len(faces))
    assert pairs(found.boundary_edges) == sorted(e for e, at in ways.items() if len(at) == 1)
    crowded = {e: at for e, at in ways.items() if len(at) > 2}
    assert pairs(found.non_manifold_edges) == sorted(crowded)
    assert found.non_manifold_faces.tolist() == sorted({f for at in crowded.values() for f, _ in at})
    regular = {e: at for e, at in ways.items() if len(at) == 2}
    assert pairs(found.turned_edges) == sorted(e for e, (p, q) in regular.items() if p[1] == q[1])
    assert found.unused_vertices.tolist() == sorted(set(range(len(mesh.vertices))) - used)
    assert found.non_manifold_vertices.tolist() == [v for v in sorted(used) if not has_one_fan(v, faces, ways)]
    assert len(found.components) == count_parts(used, [(face[0], v) for face in faces for v in face])
    assert found.orientable == any(
        all((p[1] ^ turn[p[0]]) != (q[1] ^ turn[q[0]]) for p, q in regular.values())
        for turn in itertools.product((False, True), repeat=len(faces))
    )
    assert abs(found.gauss_bonnet_error) < 1e-13 * (len(used) + len(faces))
    check_walks(found)


def has_one_fan(v: int, faces: list[Face], ways: dict[tuple[int, int], list[tuple[int, bool]]]) -> bool:
    """Whether the faces at a vertex hang together across edges of two faces, none of which has more."""
    here = [f for f, face in enumerate(faces) if v in face]
    spokes = [at for edge, at in ways.items() if v in edge]
    joined = [(at[0][0], at[1][0]) for at in spokes if len(at) == 2]
    return all(len(at) <= 2 for at in spokes) and count_parts(set(here), joined) == 1


def count_parts(members: set[int], links: list[tuple[int, int]]) -> int:
    part = {m: m for m in members}
    for a, b in links:
        old, new = part[a], part[b]
        part = {m: new if p == old else p for m, p in part.items()}
    return len(set(part.values()))


def check_walks(found: iso.analysis.Topology) -> None:
    """Walks pass all boundary edges, each once, and nothing else."""
    rim = set(pairs(found.boundary_edges))
    closed = [edge for loop in found.boundary_loops for edge in edges_of(tuple(map(int, loop)))]
    open_ones = [edge for chain in found.boundary_chains for edge in itertools.pairwise(map(int, chain))]
    passed = Counter((min(e), max(e)) for e in closed + open_ones)
    assert set(passed) == rim
    assert all(times == 1 for times in passed.values())
