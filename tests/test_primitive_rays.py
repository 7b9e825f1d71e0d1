"""Rays over arrays against scenes of primitives alone: as among other things, whatever the number of rays."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.errors import RenderError

RNG = np.random.default_rng(31)
FAR_AWAY = iso.Mesh([(900, 0, 0), (900, 1, 0), (900, 0, 1)], [(0, 1, 2)])
SUBJECTS = {
    "sphere": iso.Scene([iso.Item(iso.sphere(0.7))], camera=iso.Camera((0, 0, 5), (0, 0, 0))),
    "torus": iso.Scene([iso.Item(iso.torus(0.7, 0.3))], camera=iso.Camera((0, 0, 5), (0, 0, 0))),
    "many": iso.Scene(
        [
            iso.Item(shape.translate(tuple(RNG.uniform(-1, 1, 3))))
            for shape in (iso.sphere(0.3), iso.box(0.5), iso.cylinder(0.3, 0.8), iso.torus(0.4, 0.1), iso.cone(0.4, 1))
        ],
        camera=iso.Camera((0, 0, 5), (0, 0, 0)),
    ),
}


def rays(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From around to within, directions of any length, some with a limit."""
    origins = RNG.normal(size=(count, 3))
    directions = (RNG.uniform(-0.8, 0.8, (count, 3)) - origins) * RNG.uniform(0.1, 10, (count, 1))
    return origins, directions, np.where(RNG.random(count) < 0.3, RNG.uniform(0, 1, count), np.inf)


@pytest.mark.parametrize("name", SUBJECTS)
def test_primitives_alone_are_met_as_beside_a_triangle(name: str) -> None:
    scene = SUBJECTS[name]
    beside = iso.Scene([*scene.items, iso.Item(FAR_AWAY)], camera=scene.camera)
    asked = rays(5_000)
    for coherent in (False, True):
        alone = iso.Tracer(scene).closest(*asked, coherent=coherent)
        among = iso.Tracer(beside).closest(*asked, coherent=coherent)
        assert 0.2 < alone.hit.mean() < 0.9
        for what in ("distance", "item", "primitive", "uv", "normal"):
            assert np.array_equal(getattr(alone, what), getattr(among, what)), what
        assert np.array_equal(iso.Tracer(scene).occluded(*asked, coherent=coherent), alone.hit)


@pytest.mark.parametrize("count", [1, 15, 16, 17, 33, 271])
def test_the_number_of_rays_changes_nothing(count: int) -> None:
    tracer = iso.Tracer(SUBJECTS["many"])
    asked = rays(400)
    whole, part = tracer.closest(*asked), tracer.closest(*(a[:count] for a in asked))
    for what in ("distance", "item", "primitive", "uv", "normal"):
        assert np.array_equal(getattr(whole, what)[:count], getattr(part, what)), what
    assert np.array_equal(tracer.occluded(*(a[:count] for a in asked)), part.hit)


@pytest.mark.parametrize("number", [0, 5, 16, 40, 49])
@pytest.mark.parametrize(
    ("which", "value", "reason"),
    [(0, np.nan, "origins"), (1, np.inf, "directions"), (1, 0.0, "zero"), (1, 1e-9, "shorter"), (2, np.nan, "NaN")],
)
def test_the_first_wrong_ray_is_told(number: int, which: int, value: float, reason: str) -> None:
    asked = rays(50)
    asked[which][[number, 49]] = value
    for subject in (SUBJECTS["sphere"], FAR_AWAY):
        tracer = iso.Tracer(subject)
        for query in (tracer.closest, tracer.occluded, tracer.count):
            with pytest.raises(RenderError, match=f"{reason}.* {number} is"):
                query(*asked)
