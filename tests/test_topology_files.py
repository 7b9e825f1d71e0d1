"""Topology of real files, against counts that an independent script made of them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from isophote.analysis import repair, topology
from surfaces import triangles_of

MODELS = Path(__file__).parents[1] / "../shared/models"
TABLE = MODELS / "SOURCES.md"
# Its counts take in a face that names a vertex twice; here such a face is set aside.
DEGENERATE = {"broken/deg_faces.obj"}
FOLDERS = ("closed/", "genus/", "boundary/", "broken/", "subdiv/", "large/")

pytestmark = pytest.mark.skipif(not TABLE.exists(), reason="the models are not there")


def rows() -> list[tuple[str, int, int, int, str]]:
    """(file, vertices, faces, χ, facts) of each model."""
    if not TABLE.exists():
        return []
    found = []
    for line in TABLE.read_text().splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        size = re.match(r"(\d+) / (\d+) ", cells[5]) if len(cells) > 8 else None
        if size and cells[6] and cells[1].strip("`").startswith(FOLDERS) and "degenerate" not in cells[7]:
            found.append((cells[1].strip("`"), int(size[1]), int(size[2]), int(cells[6]), cells[7]))
    return found


def load(name: str) -> iso.Mesh:
    """A model; the triangles of an STL joined where their corners coincide, and nothing else."""
    mesh = iso.load_mesh(MODELS / name)
    if not name.lower().endswith("stl"):
        return mesh
    return repair(mesh, degenerate=False, duplicates=False, split=False, holes=False, unused=False)[0]


def number(pattern: str, facts: str) -> int:
    found = re.search(pattern, facts)
    return int(found[1]) if found else 0


@pytest.mark.parametrize(("name", "vertices", "faces", "euler", "facts"), rows(), ids=lambda value: str(value)[:24])
def test_counts(name: str, vertices: int, faces: int, euler: int, facts: str) -> None:
    mesh = load(name)
    found = topology(mesh)
    assert (found.vertices + len(found.unused_vertices), found.faces, found.euler) == (vertices, faces, euler)
    assert len(found.unused_vertices) == number(r"(\d+) unused", facts)
    assert len(found.boundary_edges) == number(r"(\d+) boundary edges", facts)
    assert len(found.non_manifold_edges) == number(r"(\d+) non-manifold edges", facts)
    assert len(found.turned_edges) == number(r"(\d+) mis-oriented edges", facts)
    assert len(found.components) == (number(r"(\d+) components", facts) or 1)
    assert (found.closed and found.manifold) == ("closed 2-manifold" in facts or "12 mis-oriented" in facts)
    if "genus" in facts:
        assert found.genus == number(r"genus (\d+)", facts)
    if "touching" not in facts:
        assert found.loop_count == number(r"in (\d+) loop", facts)
    else:
        assert touching_parts(found) == number(r"in (\d+) loop", facts)
    assert abs(found.gauss_bonnet_error) < 1e-12 * found.vertices


def touching_parts(found: iso.analysis.Topology) -> int:
    """How many parts the boundary edges form that hang together at vertices."""
    part = {int(v): int(v) for edge in found.boundary_edges for v in edge}

    def root(v: int) -> int:
        while part[v] != v:
            v = part[v]
        return v

    for a, b in found.boundary_edges.tolist():
        part[root(a)] = root(b)
    return sum(v == p for v, p in part.items())


@pytest.mark.parametrize(("name", "vertices", "faces", "euler", "facts"), rows(), ids=lambda value: str(value)[:24])
def test_fans_and_volumes(name: str, vertices: int, faces: int, euler: int, facts: str) -> None:
    mesh = load(name)
    if "non-manifold edges" not in facts:
        split, report = repair(mesh, weld=None, holes=False, unused=False, duplicates=False)
        assert len(split.vertices) - len(mesh.vertices) == number(r"(\d+) extra vertex fans", facts)
        assert len(report.split_vertices) == len(topology(mesh).non_manifold_vertices)
        assert topology(split).manifold
    volume = re.search(r"vol (-?[\d.]+)", facts)
    if volume and "multibody" not in name:
        # The script cut polygons from their first corner.
        cut = iso.Mesh(mesh.vertices, triangles_of([tuple(face) for face in mesh.faces]))
        assert iso.analysis.mass_properties(cut).volume == pytest.approx(float(volume[1]), rel=1e-5)


def test_a_degenerate_face_and_an_unused_vertex() -> None:
    # Faces 123, 326, 462 and 113, counted from 1: the last names a vertex twice, and no face names vertex 5.
    found = topology(iso.load_mesh(MODELS / "broken/deg_faces.obj"))
    assert found.degenerate_faces.tolist() == [3]
    assert found.unused_vertices.tolist() == [4]
    assert (found.vertices, found.edges, found.faces, found.euler) == (5, 7, 3, 1)
    assert len(found.boundary_edges) == 5
    assert found.manifold


def test_moebius_has_no_sides() -> None:
    mesh = iso.load_mesh(MODELS / "boundary/moebius.obj")
    found = topology(mesh)
    assert not found.orientable
    assert found.components.crosscaps.tolist() == [1]
    with pytest.raises(iso.GeometryError, match="cannot be oriented"):
        iso.analysis.orient(mesh)


def test_everything_can_be_repaired() -> None:
    for name in ("broken/angle_block.STL", "broken/triple_vierbein.obj", "boundary/bun_zipper.ply"):
        mesh, report = repair(iso.load_mesh(MODELS / name))
        found = topology(mesh)
        assert found.closed
        assert found.manifold
        assert report.open == ()
        oriented = topology(iso.analysis.orient(mesh))
        assert oriented.oriented
        assert np.all(oriented.components.genus >= 0)
