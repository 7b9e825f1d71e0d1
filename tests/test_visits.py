"""Heat maps of what rays visit: the numbers of `Tracer.count`, in colours that grow lighter."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.accel.accelerator import ACCELERATORS
from isophote.errors import RenderError
from scenes import icosphere

CAMERA = iso.Camera(eye=(0.31, 0.17, 4), target=(0.11, 0.07, 0), fov_degrees=40)
LIGHTS = [iso.Sky("white", 1)]


@pytest.mark.parametrize("name", ACCELERATORS)
def test_channels_hold_what_the_tracer_counts(name):
    mesh = icosphere(3)
    image = iso.render(iso.Scene([iso.Item(mesh)], LIGHTS, CAMERA), iso.Visits(name), size=(21, 21))
    # The ray through the middle pixel goes straight ahead.
    counts = iso.Tracer(mesh, accelerator=name).count([CAMERA.eye], [np.subtract(CAMERA.target, CAMERA.eye)])
    for channel, count in (("nodes", counts.nodes), ("primitives", counts.primitives), ("tree_depth", counts.depth)):
        assert image.channels[channel][10, 10] == count[0]
    assert image.channels["item"][10, 10] == 0


def test_colours_grow_lighter_with_the_count():
    image = iso.render(iso.Scene([iso.Item(icosphere(3))], LIGHTS, CAMERA), iso.Visits("kdtree"), size=(40, 40))
    nodes, light = image.channels["nodes"], image.channels["colour"] @ [0.2126, 0.7152, 0.0722]
    order = np.argsort(nodes, axis=None)
    assert (np.diff(light.reshape(-1)[order]) >= -1e-6).all()
    assert light.max() > 0.8


def test_a_given_most_makes_pictures_comparable():
    scene = iso.Scene([iso.Item(icosphere(3))], LIGHTS, CAMERA)
    once, twice = (iso.render(scene, iso.Visits("bvh", most=most), size=(20, 20)).channels for most in (10, 20))
    assert np.array_equal(once["nodes"], twice["nodes"])
    assert once["colour"].sum() > twice["colour"].sum()


@pytest.mark.parametrize("settings", [{"accelerator": "octree"}, {"count": "triangles"}, {"most": 0}, {"most": np.nan}])
def test_settings_without_meaning_are_refused(settings):
    with pytest.raises(RenderError):
        iso.Visits(**settings)
