"""Tables of a moving scene at several moments, against the scene lowered anew as it stands at each."""

import numpy as np
import pytest

import isophote as iso
from isophote.lower.moments import lower_moments
from isophote.lower.scene import lower_scene
from isophote.rendering.method import first_hit_channels
from isophote.rendering.pool import Pool

I = iso.Transform.identity()
SIZE = (48, 36)
TIMES = [0.1, 0.35, 0.8]
CHECKS = iso.Matte(iso.Checker("white", "black", 0.3))
CAMERA = iso.Camera((0, 2, 9), (0, 0, 0), fov_degrees=32, shutter=(0, 1))


def _motion(x, angle=1.0):
    return iso.Motion({0: I.translate((x, 0, 0)), 1: I.rotate("z", angle).scale((1, 1.3, 1)).translate((x, 1, 0.5))})


def _mesh():
    return iso.to_mesh(iso.box(0.9), cell=0.3)


def _meshes():
    mesh = _mesh()
    other = _mesh()
    return [
        iso.Item(mesh, CHECKS, _motion(-2)),
        iso.Item(mesh, transform=I.translate((0, -1, 0))),
        iso.Item(mesh, transform=_motion(1, -0.7).scale((-1, 1, 1))),
        iso.Item(other, iso.Matte("tomato"), I.translate((2.5, 0, 0))),
    ]


def _primitives():
    balls = [iso.Item(iso.sphere(0.3), transform=I.translate((x, -1, 0))) for x in (-2, -1, 0, 1, 2)]
    solids = [iso.box(0.8), iso.cylinder(0.3, 1), iso.torus(0.4, 0.1), iso.Disk(0.5)]
    moving = [iso.Item(solid, CHECKS, _motion(x)) for x, solid in zip((-3, -1, 1, 3), solids, strict=True)]
    return [*balls, *moving, iso.Item(iso.plane(), transform=iso.Motion({0: I.translate((0, -2, 0)), 1: I}))]


def _fields():
    knob = (iso.sphere(0.5) | iso.box(0.7)) - iso.cylinder(0.2)
    return [
        iso.Item(knob, CHECKS, _motion(-2)),
        iso.Item(knob, transform=I.translate((0, -1, 0))),
        iso.Item(iso.torus(0.5, 0.2).twist(0.4), transform=_motion(1.5, 0.5)),
        iso.Item(iso.plane() | iso.sphere(0.5), transform=iso.Motion({0: I.translate((0, -2, 0)), 1: I})),
    ]


def _scene(items):
    return iso.Scene(items, lights=[iso.Sky("white")], camera=CAMERA)


def _seen(tables):
    return first_hit_channels(tables, SIZE, Pool(2))


@pytest.mark.parametrize("accelerator", ["bvh", "kdtree"])
@pytest.mark.parametrize("items", [_meshes, _primitives, _fields, lambda: _meshes() + _primitives() + _fields()])
def test_moments_show_what_the_scene_shows_as_it_stands_then(items, accelerator):
    scene = _scene(items())
    lowered = lower_moments(scene, SIZE, TIMES, 2, accelerator)
    for tables, time in zip(lowered, TIMES, strict=True):
        found, expected = _seen(tables), _seen(lower_scene(scene.still(time), SIZE, 2, accelerator))
        same = found["item"] == expected["item"]
        assert same.mean() > 0.995
        assert (expected["item"] >= 0).mean() > 0.1
        near = np.isclose(found["depth"], expected["depth"], rtol=1e-3)
        assert near[same].mean() > 0.995
        turned = (found["normal"] * expected["normal"]).sum(axis=2)
        assert (turned[same & near & (expected["item"] >= 0)] > 0.99).mean() > 0.99
        alike = np.abs(found["albedo"] - expected["albedo"]).max(axis=2) < 0.02
        assert alike[same & near].mean() > 0.99
    depths = [_seen(tables)["depth"] for tables in lowered]
    assert (depths[0] != depths[1]).any()


def test_moments_share_what_stands_still():
    first, second, _ = lower_moments(_scene(_meshes() + _fields()), SIZE, TIMES, 2)
    for table, names in {"geometry": ("blocks", "nodes"), "surfaces": ("items",), "fields": ("rows", "nodes")}.items():
        for name in names:
            assert first.arrays[table].arrays[name] is second.arrays[table].arrays[name]
    assert first.arrays["lights"] is second.arrays["lights"]


def test_where_the_camera_alone_moves_all_else_is_shared():
    camera = CAMERA.with_(motion=iso.Motion({0: CAMERA.transform, 1: CAMERA.transform.translate((1, 0, 0))}))
    scene = _scene([iso.Item(iso.sphere(1))]).with_(camera=camera)
    lowered = lower_moments(scene, SIZE, TIMES, 2)
    for tables, time in zip(lowered, TIMES, strict=True):
        assert tables.arrays["primitives"] is lowered[0].arrays["primitives"]
        expected = _seen(lower_scene(scene.still(time), SIZE, 2))
        np.testing.assert_array_equal(_seen(tables)["depth"], expected["depth"])


def test_lamps_stand_where_their_items_do():
    lamp = iso.Item(_mesh(), iso.Emitter((1, 2, 3)), _motion(0))
    ball = iso.Item(iso.sphere(0.3), iso.Emitter((1, 1, 1)), iso.Motion({0: I, 1: I.translate((0, 2, 0))}))
    scene = _scene([lamp, ball, iso.Item(iso.sphere(1))])
    for tables, time in zip(lower_moments(scene, SIZE, TIMES, 2), TIMES, strict=True):
        expected = lower_scene(scene.still(time), SIZE, 2).arrays["lights"].arrays
        found = tables.arrays["lights"].arrays
        np.testing.assert_allclose(found["values"], expected["values"], atol=1e-6)
        np.testing.assert_array_equal(found["numbers"], expected["numbers"])


def test_a_lamp_that_is_stretched_out_of_round_is_one_all_the_same():
    lamp = iso.Item(iso.sphere(0.3), iso.Emitter((1, 1, 1)), iso.Motion({0: I, 1: I.scale((1, 2, 1))}))
    other = iso.Item(_mesh(), iso.Emitter((1, 1, 1)), I.translate((2, 0, 0)))
    scene = _scene([lamp, other])
    for tables, time in zip(lower_moments(scene, SIZE, [0.0, 0.5], 2), [0.0, 0.5], strict=True):
        expected = lower_scene(scene.still(time), SIZE, 2)
        for table in ("lights", "surfaces"):
            for name in ("numbers", "kinds") if table == "lights" else ("triangle_lights",):
                np.testing.assert_array_equal(
                    tables.arrays[table].arrays[name], expected.arrays[table].arrays[name], err_msg=name
                )
