"""Pictures of what moves, against closed forms and the mean of many pictures of what stands still."""

import numpy as np
import pytest

import isophote as iso
from command_line import run, succeeds
from isophote.lower.moments import lower_moments
from isophote.rendering.exposure import shutter_times
from isophote.rendering.features import mean_features

I = iso.Transform.identity()
WIDTH, HEIGHT = 32, 8
# A picture of 8 × 2 metres, four pixels a metre.
FLAT = iso.OrthographicCamera((0, 0, 5), (0, 0, 0), height=2, shutter=(0, 1))
LAMP = iso.Emitter((1, 1, 1))
CORNERS = [(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)]
SQUARES = {
    "mesh": iso.Mesh(CORNERS, [(0, 1, 2, 3)]),
    "polygon": iso.Polygon(CORNERS),
    "box": iso.box((1, 1, 0.1)),
    "field": iso.box((1, 1, 0.1)) | iso.box((0.9, 0.9, 0.2)),
}
SLIDE = """import isophote as iso
rest = iso.Transform.identity()
motion = iso.Motion({0: rest.translate((-2, 0, 0)), 1: rest.translate((1, 0, 0))})
camera = iso.OrthographicCamera((0, 0, 5), (0, 0, 0), height=2)
scene = iso.Scene([iso.Item(iso.box((1, 1, 0.1)), iso.Emitter((1, 1, 1)), motion)], camera=camera)
"""


def _coverage(start, way):
    """(32,): how much of a pixel's width, and of the time, a unit length covers whose middle goes from `start` by
    `way`: the covering of a place is a trapezium over x, and its integral a sum of squares."""
    edges = (np.arange(WIDTH + 1) - WIDTH / 2) / 4
    signs = {start - 0.5: 1, start - 0.5 + way: -1, start + 0.5: -1, start + 0.5 + way: 1}
    return 4 * np.diff(sum(sign * np.maximum(edges - x, 0) ** 2 / 2 for x, sign in signs.items()) / way)


def _sliding(shape, start=-2.0, way=3.0):
    motion = iso.Motion({0: I.translate((start, 0, 0)), 1: I.translate((start + way, 0, 0))})
    return iso.Scene([iso.Item(shape, LAMP, motion)], camera=FLAT)


def _render(scene, method, seed=0, threads=2, size=(WIDTH, HEIGHT)):
    return iso.render(scene, method, size=size, seed=seed, threads=threads, progress=False)


def _red(image):
    return image.channels["colour"][..., 0].astype(np.float64)


@pytest.mark.parametrize("shape", SQUARES)
@pytest.mark.parametrize("method", [iso.PathTrace(samples=256), iso.RayTrace(samples=256)])
def test_a_sliding_square_covers_pixels_as_the_closed_form_says(shape, method):
    picture = _red(_render(_sliding(SQUARES[shape]), method))
    expected = _coverage(-2.0, 3.0)
    assert expected.sum() == pytest.approx(4.0)
    # The square is as high as the four middle rows.
    assert np.abs(picture[2:6] - expected).max() < 0.04
    assert np.abs(picture[2:6].mean(axis=0) - expected).max() < 0.015
    assert np.abs(picture[[0, 1, 6, 7]]).max() == 0


def test_occlusion_of_what_slides_is_that_of_its_coverage():
    # Nothing stands above a square by itself, and the sky beside it is open: only where it stands on the ground is
    # anything blocked, so a plate a hair above another darkens what it covers.
    plate = iso.Item(iso.Mesh([(-4, -1, 0), (4, -1, 0), (4, 1, 0), (-4, 1, 0)], [(0, 1, 2, 3)]))
    lid = iso.Item(iso.Mesh([(-0.5, -1, 9), (0.5, -1, 9), (0.5, 1, 9), (-0.5, 1, 9)], [(0, 1, 2, 3)]))
    scene = iso.Scene([plate], camera=FLAT)
    moving = scene.with_(
        items=[plate, lid.with_(transform=iso.Motion({0: I.translate((-2, 0, -8.99)), 1: I.translate((1, 0, -8.99))}))]
    )
    found = _render(moving, iso.AmbientOcclusion(samples=256)).channels["visibility"]
    times = np.random.default_rng(1).random(64)
    stills = [_render(moving.still(t), iso.AmbientOcclusion(samples=16)).channels["visibility"] for t in times]
    error = np.std(stills, axis=0) / np.sqrt(len(times))
    assert (np.abs(found - np.mean(stills, axis=0)) < 4 * error + 0.02).all()
    assert found.min() < 1 or np.std(stills) == 0


def test_a_moving_camera_sees_what_a_moving_square_shows():
    still = iso.Item(SQUARES["mesh"], LAMP)
    places = {time: FLAT.transform.translate((2 - 3 * time, 0, 0)) for time in (0, 1)}
    scene = iso.Scene([still], camera=FLAT.with_(motion=iso.Motion(places)))
    picture = _red(_render(scene, iso.PathTrace(samples=256)))
    assert np.abs(picture[2:6].mean(axis=0) - _coverage(-2.0, 3.0)).max() < 0.015


def test_the_shutter_sees_its_own_part_of_a_motion():
    scene = _sliding(SQUARES["mesh"])
    part = scene.with_(camera=FLAT.with_(shutter=(0.25, 0.5)))
    picture = _red(_render(part, iso.PathTrace(samples=256)))
    assert np.abs(picture[2:6].mean(axis=0) - _coverage(-1.25, 0.75)).max() < 0.015


def _blade(shine):
    blade = iso.Item(
        iso.box((1.6, 0.2, 0.2)), iso.Emitter((2, 2, 2)) if shine else iso.Matte(0.8), iso.Motion.turn("z", 2.5)
    )
    lamp = iso.Item(iso.sphere(0.2), iso.Emitter((9, 6, 3)), iso.Motion.turn("y", 1.0).translate((0.5, 1.5, 1)))
    tile = iso.Item(
        iso.Mesh(CORNERS, [(0, 1, 2, 3)]), iso.Emitter((3, 4, 5)), iso.Motion.turn("y", 1.3).translate((-1.5, 0, 1))
    )
    floor = iso.Item(iso.Mesh([(-4, -1, -4), (-4, -1, 4), (4, -1, 4), (4, -1, -4)], [(0, 1, 2, 3)]), iso.Matte(0.7))
    camera = iso.Camera((0, 1, 6), (0, 0, 0), fov_degrees=30, shutter=(0.2, 0.9))
    return iso.Scene([blade, lamp, tile, floor], lights=[iso.Sky("white", 0.2)], camera=camera)


@pytest.mark.parametrize("shine", [False, True])
@pytest.mark.parametrize(
    "method",
    [iso.PathTrace(samples=64, max_depth=4), iso.RayTrace(samples=16), iso.PathTrace(samples=64, pattern="jittered")],
)
def test_what_turns_and_shines_is_the_mean_of_stills_at_random_times(shine, method):
    scene, size = _blade(shine), (16, 12)
    moving = [_render(scene, method, seed, size=size).channels["colour"] for seed in range(8)]
    times = 0.2 + 0.7 * np.random.default_rng(3).random(150)
    few = (
        iso.RayTrace(samples=2)
        if isinstance(method, iso.RayTrace)
        else iso.PathTrace(samples=2, max_depth=method.max_depth)
    )
    stills = [_render(scene.still(t), few, 100 + k, size=size).channels["colour"] for k, t in enumerate(times)]
    found, expected = np.mean(moving, axis=0, dtype=float), np.mean(stills, axis=0, dtype=float)
    error = np.sqrt(np.var(stills, axis=0) / (len(stills) - 1) + np.var(moving, axis=0) / (len(moving) - 1))
    deviations = (np.abs(found - expected) / np.maximum(error, 1e-3)).mean(axis=2)
    assert (deviations < 3).mean() > 0.97
    assert found.mean() == pytest.approx(expected.mean(), abs=4 * error.mean() / np.sqrt(10))


def test_the_same_seed_gives_the_same_bits_whatever_the_threads():
    scene = _blade(False)
    for method in (iso.PathTrace(samples=20), iso.RayTrace(samples=4), iso.AmbientOcclusion(samples=8)):
        one, three = (_render(scene, method, 5, threads, (50, 40)) for threads in (1, 3))
        for name, values in one.channels.items():
            np.testing.assert_array_equal(values, three.channels[name], err_msg=f"{name} by {method}")


@pytest.mark.parametrize("method", [iso.PathTrace(samples=8), iso.RayTrace(samples=4), iso.AmbientOcclusion(samples=8)])
def test_a_shutter_changes_nothing_where_nothing_moves(method):
    still = _blade(False).still(0.3)
    assert still.camera is not None
    held = {0: still.camera.transform, 1: still.camera.transform}
    for camera in (still.camera.with_(shutter=(0, 1)), still.camera.with_(shutter=(0, 1), motion=iso.Motion(held))):
        opened = _render(still.with_(camera=camera), method)
        closed = _render(still.with_(camera=still.camera.with_(shutter=(0, 0))), method)
        np.testing.assert_allclose(opened.channels["colour"], closed.channels["colour"], rtol=1e-4, atol=1e-6)
    same = _render(still.with_(camera=still.camera.with_(shutter=(0, 1))), method)
    np.testing.assert_array_equal(same.channels["colour"], closed.channels["colour"])


def test_an_instant_shows_what_stands_at_that_time():
    scene = _blade(True)
    instant = scene.with_(camera=scene.camera.with_(shutter=(0.4, 0.4)))
    method = iso.PathTrace(samples=4)
    np.testing.assert_array_equal(
        _render(instant, method).channels["colour"], _render(scene.still(0.4), method).channels["colour"]
    )


def test_other_channels_show_the_middle_of_the_time():
    scene = _blade(False)
    half, moving = (_render(one, iso.PathTrace(samples=1)) for one in (scene.still(0.55), scene))
    for name in ("depth", "normal", "item", "albedo"):
        np.testing.assert_allclose(moving.channels[name], half.channels[name], atol=1e-5)


def test_times_are_spread_over_the_samples_of_a_pixel():
    def error(pattern):
        pictures = [
            _red(_render(_sliding(SQUARES["mesh"]), iso.PathTrace(samples=16, pattern=pattern), s)) for s in range(6)
        ]
        return np.sqrt(np.mean((np.array(pictures)[:, 2:6] - _coverage(-2.0, 3.0)) ** 2))

    independent = error("independent")
    for pattern in ("blue-noise", "sobol", "jittered"):
        assert error(pattern) < 0.65 * independent


def test_filters_and_adaptive_samples_see_the_same_motion():
    expected = _coverage(-2.0, 3.0)
    adaptive = _render(_sliding(SQUARES["mesh"]), iso.PathTrace(noise=0.02))
    assert np.ptp(adaptive.channels["samples"]) > 0
    assert np.abs(_red(adaptive)[2:6].mean(axis=0) - expected).max() < 0.03
    filtered = _red(_render(_sliding(SQUARES["mesh"]), iso.PathTrace(samples=256, filter="mitchell")))
    # A wider filter keeps all light of the row, but for what falls beside the rows.
    assert filtered[3:5].mean(axis=0).sum() == pytest.approx(expected.sum(), rel=0.03)


def test_times_begin_by_chance_and_are_even():
    scene = _sliding(SQUARES["mesh"]).with_(camera=FLAT.with_(shutter=(2, 4)))
    times = np.array(shutter_times(scene, 8, seed=1))
    np.testing.assert_allclose(np.diff(times), 0.25)
    assert 2 <= times[0] < 2.25
    assert times[0] != shutter_times(scene, 8, seed=2)[0]
    starts = [shutter_times(scene, 8, seed)[0] for seed in range(2000)]
    assert np.mean(starts) == pytest.approx(2.125, abs=4 * 0.25 / np.sqrt(12 * 2000))


@pytest.mark.parametrize(
    ("method", "channel"),
    [(iso.SphereTrace(), "colour"), (iso.AmbientOcclusion(by="horizon"), "visibility")],
)
def test_methods_that_look_once_at_a_pixel_show_the_mean_of_stills(method, channel):
    lit = _sliding(SQUARES["box"]).with_(lights=[iso.Sky("white")])
    plate = iso.Item(iso.box((20, 20, 0.1)).translate((0, 0, -0.4)), iso.Matte(0.2))
    scene = lit.with_(items=[lit.items[0].with_(material=iso.Matte(0.9)), plate])
    moving = _render(scene, method).channels[channel]
    stills = [_render(scene.still(t), method).channels[channel] for t in np.random.default_rng(1).random(60)]
    error = np.std(stills, axis=0) / np.sqrt(len(stills))
    assert np.std(stills, axis=0).max() > 0.1
    # A step of one still in sixteen beside the chance of the others.
    assert (np.abs(moving - np.mean(stills, axis=0)) <= 4 * error + np.ptp(stills, axis=0) / 12 + 1e-5).all()


def test_guides_of_denoising_are_blurred_as_the_colour_is():
    scene = _sliding(SQUARES["mesh"])
    times = [(k + 0.5) / 16 for k in range(16)]
    tables = lower_moments(scene, (WIDTH, HEIGHT), times, 2)
    normal = mean_features(tables, (WIDTH, HEIGHT), iso.PixelFilter("box"), 2)["normal"]
    assert np.abs(normal[2:6, :, 2] - _coverage(-2.0, 3.0)).max() < 1.5 / 16
    denoised = iso.render(
        scene, iso.PathTrace(samples=16), size=(WIDTH, HEIGHT), denoise="filter", progress=False
    ).channels["colour"]
    assert np.abs(denoised[2:6, :, 0] - _coverage(-2.0, 3.0)).max() < 0.15


def test_the_command_line_opens_the_shutter(tmp_path):
    path, out = tmp_path / "slide.py", tmp_path / "out.exr"
    path.write_text(SLIDE)
    for shutter, expected in (("0,1", _coverage(-2.0, 3.0)), ("0.25,0.5", _coverage(-1.25, 0.75))):
        succeeds("render", path, "-o", out, "--shutter", shutter, "--size", f"{WIDTH}x{HEIGHT}", "--samples", 64)
        found = iso.load_image(out).channels["colour"][2:6, :, 0]
        assert np.abs(found.mean(axis=0) - expected).max() < 0.03
    for wrong in ("1,0", "1", "a,b", "0,inf"):
        assert run("render", path, "-o", out, "--shutter", wrong).exit_code == 2


def test_explain_follows_the_rays_of_a_moving_scene():
    scene, method = _blade(True), iso.RayTrace(samples=8)
    picture = _render(scene, method, 3, size=(16, 12)).channels["colour"]
    explained = iso.explain(scene, (8, 6), method=method, size=(16, 12), seed=3)
    np.testing.assert_allclose(explained.colour, picture[6, 8], rtol=1e-6)
