"""What is wrong with a call is told by an error of Isophote's own, with what mends it, before anything is computed."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.errors import Error
from scenes import plane

TILE = plane(2)
SCENE = iso.Scene([iso.Item(TILE, iso.Matte(0.5))], [iso.Sky("white")], iso.Camera((0, 2, 3), (0, 0, 0)))
RAY = ([(0, 1, 0)], [(0, -1, 0)])


@pytest.mark.parametrize("threads", [0, -1, 1.5, "all", True, 10**6])
@pytest.mark.parametrize(
    "call",
    [
        lambda threads: iso.render(SCENE, iso.PathTrace(1), size=(4, 4), threads=threads),
        lambda threads: iso.Tracer(TILE, threads=threads),
        lambda threads: iso.ambient_occlusion(TILE, samples=1, threads=threads),
        lambda threads: iso.radiosity(SCENE, threads=threads),
        lambda threads: iso.show_tree(TILE, threads=threads),
        lambda threads: iso.selfcheck(["form-factors"], threads=threads),
    ],
    ids=["render", "Tracer", "ambient_occlusion", "radiosity", "show_tree", "selfcheck"],
)
def test_a_number_of_threads_that_cannot_be_had_is_refused(call, threads):
    # A million threads with scratch of their own once took all of a machine's memory.
    with pytest.raises(Error, match=r"threads must be a whole number from 1 to 1,024"):
        call(threads)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: iso.radiosity(3), "give a Scene, not a int"),
        (lambda: iso.radiosity(TILE), "iso.studio makes one"),
        (lambda: iso.radiosity(SCENE, iso.PathTrace(1)), r"must be a Radiosity\(...\)"),
        (lambda: iso.tangents(3), "only a Mesh has tangents, not a int"),
        (lambda: iso.unwrap(iso.sphere(1)), "to_mesh makes one"),
        (lambda: iso.displace(iso.sphere(1), iso.PerlinNoise(), 1), "to_mesh makes one"),
        (lambda: iso.brdf_plot(iso.Emitter(1)), "without a body reflects no light"),
        (lambda: iso.measure_brdf(iso.Emitter(1)), "without a body reflects no light"),
    ],
)
def test_a_thing_of_the_wrong_kind_is_refused_by_name(call, told):
    with pytest.raises(Error, match=told):
        call()


def test_a_lamp_with_a_body_is_drawn_as_its_body():
    size = (240, 200)
    lamp, body = (iso.brdf_plot(m, size=size) for m in (iso.Emitter(5, body=iso.Matte(0.4)), iso.Matte(0.4)))
    # All but the title above.
    assert np.array_equal(lamp.channels["colour"][40:], body.channels["colour"][40:])


@pytest.mark.parametrize("number", [-1, 1.5, 10_000, True])
def test_a_bounce_that_there_is_not_is_refused(number):
    found = iso.radiosity(SCENE, iso.Radiosity(patch=1.0))
    with pytest.raises(Error, match="there are bounces 0 to"):
        found.bounce(number)
    with pytest.raises(Error, match="camera must be"):
        found.image("from above")
