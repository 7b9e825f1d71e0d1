"""Accelerators: every one finds what brute force finds, bit for bit, and says what its rays visit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from accelerator_rays import check_against_brute_force, distant_rays, rays_at
from isophote.accel.accelerator import ACCELERATORS, build_accelerator
from isophote.errors import GeometryError, RenderError
from scenes import icosphere
from trees import GEOMETRIES, random_soup, soup, sphere

MODELS = Path(__file__).parents[1] / "../shared/models"
PATHS = sorted(
    path.relative_to(MODELS).as_posix()
    for folder in ("boundary", "broken", "closed", "genus", "large", "scene", "subdiv/opensubdiv", "textured")
    for path in (MODELS / folder).rglob("*")
    if path.suffix in (".obj", ".off", ".ply", ".stl", ".gz")
)
# Tests of triangles by brute force for one mesh.
BUDGET = 4_000_000


@pytest.mark.parametrize("path", PATHS)
def test_every_model_as_by_brute_force(path):
    mesh = iso.load_mesh(MODELS / path)
    count = int(np.clip(BUDGET // max(len(iso.triangulate(mesh).triangles), 1), 60, 1_000))
    check_against_brute_force(mesh, rays_at(mesh, count), ACCELERATORS)
    check_against_brute_force(mesh, distant_rays(mesh, count // 3), ACCELERATORS)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_awkward_geometry_as_by_brute_force(name):
    points, triangles = GEOMETRIES[name]
    check_against_brute_force(iso.Mesh(points, triangles), rays_at(iso.Mesh(points, triangles), 500), ACCELERATORS)


@settings(max_examples=40, deadline=None)
@given(
    corners=st.lists(st.lists(st.integers(-2, 2), min_size=9, max_size=9), min_size=1, max_size=60),
    seed=st.integers(0, 1000),
)
def test_small_numbers_as_by_brute_force(corners, seed):
    """Corners on a lattice, and rays along its lines and diagonals: all lies on planes, edges and vertices at once."""
    mesh = iso.Mesh(*soup(np.array(corners, np.float64).reshape(-1, 3, 3)))
    rng = np.random.default_rng(seed)
    directions = rng.integers(-2, 3, (200, 3))
    directions[(directions == 0).all(axis=1)] = (0, 1, 0)
    check_against_brute_force(mesh, (rng.integers(-3, 4, (200, 3)), directions), ACCELERATORS)


def test_rays_that_touch_a_side_at_zero_are_met():
    """A ray within the plane y = 0, in which the box's side lies, meets the vertex there."""
    points = np.array([[-0.5, 0.0, 1.5], [-0.25, -0.5, 1.5], [-0.25, 0.0, 1.75]])
    for name in ACCELERATORS:
        hits = iso.Tracer(iso.Mesh(points, [[0, 1, 2]]), accelerator=name).closest([[0, 0, 1.75]], [[-1, 0, 0]])
        assert hits.distance[0] == 0.25, name


@pytest.mark.parametrize("name", ACCELERATORS)
def test_triangles_seen_edge_on_from_the_side_are_not_met(name):
    """A ray beside triangles whose planes contain it: edge functions so small that rounding could make them zero."""
    rng = np.random.default_rng(0)
    a, b = rng.uniform(0.3, 1, (2, 2000)).astype(np.float32)
    # The corners (x, -x, z) all lie in a plane with the z axis, to within the rounding of x.
    x = np.stack([a, np.nextafter(a, np.float32(2)), b], axis=1)
    z = np.tile(np.float32([0, 0.5, 1]), (2000, 1))
    corners = np.stack([x, -x[:, [1, 0, 2]], z], axis=2)
    mesh = iso.Mesh(*soup(corners))
    assert not iso.Tracer(mesh, accelerator=name).occluded([[0, 0, 5]], [[0, 0, -1]])[0]


@pytest.mark.parametrize("name", ACCELERATORS)
@pytest.mark.parametrize("geometry", [sphere(100, 0.05), random_soup(20_000)])
def test_same_bits_for_any_number_of_threads(name, geometry):
    alone = build_accelerator(name, *geometry, threads=1)
    for threads in (2, 3, None):
        together = build_accelerator(name, *geometry, threads=threads)
        assert alone.blocks.tobytes() == together.blocks.tobytes()
        for field, values in alone.tables.arrays.items():
            assert np.asarray(values).tobytes() == np.asarray(together.tables.arrays[field]).tobytes(), field


def test_unknown_accelerators_are_refused():
    with pytest.raises(RenderError, match="bvh, grid"):
        iso.Tracer(iso.sphere(1), accelerator="octree")
    with pytest.raises(RenderError, match="bvh, grid"):
        iso.PathTrace(accelerator="octree")


@pytest.mark.parametrize("name", ACCELERATORS)
def test_bad_triangles_are_refused(name):
    with pytest.raises(GeometryError, match="finite"):
        build_accelerator(name, [[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(GeometryError, match="outside"):
        build_accelerator(name, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]])


@pytest.mark.parametrize("name", [*ACCELERATORS, "brute"])
def test_no_triangles_can_be_built_over(name):
    built = build_accelerator(name, np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    assert len(built.blocks) == 0
    assert built.bounds[0, 0] > built.bounds[1, 0]


@pytest.mark.parametrize("name", [*ACCELERATORS, "brute"])
def test_counts_of_a_mesh(name):
    mesh = icosphere(4)
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


@pytest.mark.parametrize("name", ACCELERATORS)
def test_instances_have_accelerators_of_their_own(name):
    """Two hundred placed copies of a mesh, too many triangles to be one object."""
    mesh = icosphere(4)
    rng = np.random.default_rng(5)
    places = rng.uniform(-20, 20, (200, 3))
    items = [
        iso.Item(mesh).rotate("y", float(a)).translate(p) for a, p in zip(rng.uniform(0, 6, 200), places, strict=True)
    ]
    origins, directions = rng.uniform(-30, 30, (2000, 3)), rng.normal(size=(2000, 3))
    truth = iso.Tracer(iso.Scene(items), accelerator="bvh").closest(origins, directions)
    found = iso.Tracer(iso.Scene(items), accelerator=name).closest(origins, directions)
    assert truth.hit.any()
    for field in ("distance", "item", "primitive", "uv", "normal"):
        assert np.array_equal(getattr(found, field), getattr(truth, field)), field


@pytest.mark.parametrize("name", [name for name in ACCELERATORS if name != "bvh"])
def test_a_picture_is_the_same_by_every_accelerator(name):
    mesh = icosphere(3)
    scene = iso.studio(
        iso.Scene([iso.Item(mesh, iso.Matte("tomato")), iso.Item(mesh, iso.Mirror()).translate((1.5, 0.5, 1))])
    )
    pictures = [iso.render(scene, iso.PathTrace(4, accelerator=kind), size=(40, 30)) for kind in ("bvh", name)]
    for channel in ("colour", "depth", "normal", "item"):
        assert np.array_equal(pictures[0].channels[channel], pictures[1].channels[channel]), channel
