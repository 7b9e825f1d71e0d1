"""Random fields: whatever they are made of, their meshes are closed manifolds."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from closed_meshes import check_closed, euler, volume
from isophote.kernels.measure.contour_cases import (
    AMBIGUOUS,
    CASES,
    COUNT_SHIFT,
    CROSSED,
    FACE_EDGES,
    case_word,
    twice_crossed_faces,
)

sizes = st.floats(0.05, 0.7)
places = st.tuples(*(st.floats(-0.6, 0.6),) * 3)
turns = st.tuples(st.tuples(st.floats(0.1, 1), st.floats(-1, 1), st.floats(-1, 1)), st.floats(0, 3))
primitives = st.one_of(
    sizes.map(iso.sphere),
    st.tuples(sizes, sizes, sizes).map(iso.box),
    st.tuples(sizes, sizes).map(lambda s: iso.cylinder(*s)),
)
placed = st.tuples(primitives, turns, places).map(lambda s: s[0].rotate(*s[1]).translate(s[2]))
operations = st.sampled_from(["union", "intersection", "difference"])
blends = st.sampled_from([0.0, 0.0, 0.1])


def joined(parts: tuple[Any, Any, str, float]) -> Any:
    first, second, operation, blend = parts
    return getattr(first, operation)(second, blend=blend)


trees = st.recursive(placed, lambda inner: st.tuples(inner, inner, operations, blends).map(joined), max_leaves=10)
ways = st.sampled_from([{"tolerance": 0.0}, {}, {"tolerance": 0.02}, {"method": "surface-nets"}])


@settings(deadline=None, max_examples=60)
@given(field=trees, cell=st.sampled_from([0.2, 0.09, 0.05]), way=ways)
def test_any_field_gives_a_closed_manifold(field: Any, cell: float, way: dict[str, Any]) -> None:
    try:
        mesh = iso.to_mesh(field, cell=cell, **way)
    except iso.GeometryError as error:
        if "no surface found" not in str(error):
            raise
        return
    check_closed(mesh)
    assert euler(mesh) % 2 == 0
    # What is thinner than a cell may come out turned inside out.
    assert volume(mesh) > -(cell**3)


def test_fields_as_fine_as_the_grid_give_closed_manifolds() -> None:
    """Hundreds of balls put and taken away, of the size of a cell: every ambiguous case, on both sides of faces."""
    for seed in range(4):
        random = np.random.default_rng(seed)
        balls = [
            iso.sphere(random.uniform(0.06, 0.16)).translate(tuple(random.uniform(-1, 1, 3).tolist()))
            for _ in range(300)
        ]
        field = iso.union(*balls[:150]) - iso.union(*balls[150:])
        for way in ({"tolerance": 0.0}, {"tolerance": 0.02}, {"method": "surface-nets"}):
            mesh = iso.to_mesh(field, cell=0.11, **way)  # type: ignore[arg-type]
            check_closed(mesh)
            assert mesh.face_count > 1000


def test_each_component_of_a_cell_is_a_ring_of_at_least_three_crossings() -> None:
    for signs in range(1, 255):
        for joined in range(64):
            word = case_word(signs, joined)
            crossed = [edge for edge in range(12) if CROSSED[signs] >> edge & 1]
            of = {edge: word >> 2 * edge & 3 for edge in crossed}
            members = [[edge for edge in crossed if of[edge] == k] for k in range(word >> COUNT_SHIFT & 7)]
            assert all(len(ring) >= 3 for ring in members)
            # Curves on faces join two crossings each, so every component has an even number on each face.
            for ring in members:
                assert all(sum(FACE_EDGES[face] >> edge & 1 for edge in ring) % 2 == 0 for face in range(6))


def test_the_other_way_across_a_face_parts_what_crosses_it_twice_and_joins_nothing() -> None:
    ambiguous = [signs for signs in range(256) if CASES[signs] & AMBIGUOUS]
    assert len(ambiguous) == 120
    found = 0
    for signs in ambiguous:
        for joined in range(64):
            twice = twice_crossed_faces(signs, joined)
            for face in range(6):
                if twice >> face & 1:
                    found += 1
                    parted = twice_crossed_faces(signs, joined ^ 1 << face)
                    assert not parted >> face & 1
                    assert parted & ~twice == 0
    assert found > 100
