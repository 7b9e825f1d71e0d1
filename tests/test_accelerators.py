"""Accelerators: every one finds what brute force finds, bit for bit, and says what its rays visit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from isophote.accel.accelerator import ACCELERATORS, build_accelerator
from isophote.errors import GeometryError, RenderError

MODELS = Path(__file__).parents[1] / "../shared/models"
OTHERS = [name for name in ACCELERATORS if name != "bvh"]


def rays_at(mesh: iso.Mesh, count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Rays from around the mesh and from within it, some along axes, some from its vertices."""
    rng = np.random.default_rng(seed)
    low, high = mesh.bounds
    size = np.maximum(high - low, 1e-3 * (high - low).max())
    origins = low + size * rng.uniform(-0.5, 1.5, (count, 3))
    directions = low + size * rng.uniform(0, 1, (count, 3)) - origins
    along = rng.random(count) < 0.2
    directions[along] *= rng.random((along.sum(), 3)) < 0.4
    directions[(directions == 0).all(axis=1)] = (0, 0, -1)
    at_vertices = rng.random(count) < 0.1
    origins[at_vertices] = mesh.vertices[rng.integers(0, len(mesh.vertices), at_vertices.sum())]
    return origins, directions * 10 ** rng.uniform(-3, 3, (count, 1))


@pytest.mark.parametrize("name", ACCELERATORS)
def test_same_hits_as_brute_force(name):
    mesh = iso.load_mesh(MODELS / "closed/bunny.obj") if MODELS.exists() else pytest.skip("no models")
    rays = rays_at(mesh, 5_000)
    ours, truth = (iso.Tracer(mesh, accelerator=kind).closest(*rays) for kind in (name, "brute"))
    assert truth.hit.mean() > 0.3
    assert ours.distance.tobytes() == truth.distance.tobytes()
    assert (ours.primitive != truth.primitive).mean() < 1e-3
    assert np.array_equal(iso.Tracer(mesh, accelerator=name).occluded(*rays), truth.hit)


def test_unknown_accelerators_are_refused():
    with pytest.raises(RenderError, match="bvh"):
        iso.Tracer(iso.sphere(1), accelerator="octree")
    with pytest.raises(RenderError, match="bvh"):
        iso.PathTrace(accelerator="octree")


@pytest.mark.parametrize("name", ACCELERATORS)
def test_bad_triangles_are_refused(name):
    with pytest.raises(GeometryError, match="finite"):
        build_accelerator(name, [[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(GeometryError, match="outside"):
        build_accelerator(name, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]])


@pytest.mark.parametrize("name", [*ACCELERATORS, "brute"])
def test_counts_of_a_mesh(name):
    mesh = iso.load_mesh(MODELS / "closed/bunny.obj") if MODELS.exists() else pytest.skip("no models")
    tracer = iso.Tracer(mesh, accelerator=name)
    rays = rays_at(mesh, 500)
    counts = tracer.count(*rays)
    hit = tracer.closest(*rays).hit
    assert (counts.primitives[hit] >= 1).all()
    if name == "brute":
        assert (counts.primitives == len(mesh.faces)).all()
    else:
        assert counts.primitives.mean() < 0.05 * len(mesh.faces)
        assert (counts.nodes[hit] > counts.depth[hit]).all()
    nothing = tracer.count([[1e3, 1e3, 1e3]], [[1, 0, 0]])
    assert name == "brute" or nothing.primitives[0] == 0
