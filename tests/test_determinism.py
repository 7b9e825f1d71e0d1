"""The same seed gives the same bits, whatever the threads, tiles and waves; interrupts give the picture so far."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.errors import RenderError
from isophote.rendering import passes, path_trace
from isophote.rendering.passes import PATTERNS
from scenes import box, icosphere, plane, render

ITEMS = [
    iso.Item(plane(8), iso.Matte((0.7, 0.5, 0.3))),
    iso.Item(icosphere(2, 0.6, smooth=True), iso.Glass(1.5)).translate((0.7, 0.7, 0.3)),
    iso.Item(box(0.9), iso.Matte((0.9, 0.2, 0.2))).rotate("y", 0.4).translate((-0.8, 0.46, 0)),
]
LIGHTS = [
    iso.RectLight(size=(1, 1), power=60).at((0, 2.5, 0)),
    iso.SphereLight(radius=0.2, power=5).at((1, 2, 1)),
    iso.Sky(strength=0.2),
]
CAMERA = iso.Camera((0, 2, 5), (0, 0.5, 0), lens_radius=0.05)


def picture(**settings: object) -> iso.Image:
    return render(ITEMS, LIGHTS, CAMERA, **{"size": (70, 45), "samples": 11, **settings})


def same_bits(a: iso.Image, b: iso.Image) -> bool:
    return all(a.channels[name].tobytes() == b.channels[name].tobytes() for name in a.channels)


@pytest.fixture(scope="module")
def reference() -> iso.Image:
    return picture()


@pytest.mark.parametrize("pattern", PATTERNS)
def test_any_number_of_threads(pattern):
    one, two, three = (picture(threads=threads, pattern=pattern) for threads in (1, 2, 3))
    assert same_bits(one, two)
    assert same_bits(one, three)


@pytest.mark.parametrize(
    ("module", "name", "value"),
    [
        (passes, "_TILE", 8),
        (passes, "_TILE", 13),
        (passes, "_TILE", 256),
        (path_trace, "_WAVE", 1),
        (path_trace, "_WAVE", 100),
        (path_trace, "_WAVE", 5000),
    ],
)
def test_any_size_of_tiles_and_waves(module, name, value, reference, monkeypatch):
    monkeypatch.setattr(module, name, value)
    assert same_bits(picture(), reference)


@pytest.mark.parametrize(("first", "largest"), [(1, 1), (3, 5), (64, 64)])
def test_any_split_into_passes(first, largest, reference, monkeypatch):
    monkeypatch.setattr(passes, "_FIRST_PASS", first)
    monkeypatch.setattr(passes, "_LARGEST_PASS", largest)
    assert same_bits(picture(), reference)


def test_a_picture_again_is_the_same_and_other_seeds_differ(reference):
    assert same_bits(picture(), reference)
    others = [picture(seed=seed) for seed in (2, -1, 2**40 + 1)]
    colours = [image.channels["colour"].tobytes() for image in (reference, *others)]
    assert len(set(colours)) == 4
    for image in others:
        assert np.array_equal(image.channels["item"], reference.channels["item"])


def test_more_samples_begin_with_the_fewer():
    """So that a picture can go on where it stopped: the sums of 4 samples are part of those of 8."""
    few, many = (
        picture(samples=n, pattern="independent", size=(8, 8)).channels["colour"].astype(np.float64) for n in (4, 8)
    )
    rest = many * 8 - few * 4
    assert rest.min() > -1e-4
    assert not np.allclose(rest, few * 4)


def test_an_interrupt_returns_the_picture_so_far(reference):
    pressed = []

    def interrupt(stage: str, fraction: float) -> None:
        if stage == "path tracing" and fraction > 0 and not pressed:
            pressed.append(True)
            raise KeyboardInterrupt

    scene = iso.Scene(ITEMS, LIGHTS, CAMERA)
    image = iso.render(scene, iso.PathTrace(samples=2**20), size=(70, 45), seed=1, progress=interrupt)
    assert "interrupted" in image.metadata["stopped"]
    assert np.array_equal(image.channels["item"], reference.channels["item"])
    assert np.isfinite(image.channels["colour"]).all()
    assert int(image.metadata["samples"].split()[-1]) < 2**20


def test_what_a_report_raises_comes_out():
    def fail(stage: str, fraction: float) -> None:
        raise ValueError("mine")

    with pytest.raises(ValueError, match="mine"):
        iso.render(iso.Scene(ITEMS, LIGHTS, CAMERA), iso.PathTrace(samples=4), size=(8, 8), progress=fail)


def test_time_and_noise_limits_stop():
    image = picture(samples=None, seconds=0.3, size=(32, 32))
    assert 0.2 < float(image.metadata["seconds"]) < 3
    assert int(image.metadata["samples"].split()[0]) >= 1
    level = 0.05
    image = picture(samples=None, noise=level, size=(32, 32), pattern="independent")
    weights = np.array([0.2126, 0.7152, 0.0722])
    error = np.sqrt((image.channels["variance"].astype(np.float64) @ weights).mean())
    assert error <= level * (image.channels["colour"].astype(np.float64) @ weights).mean() * 1.0001
    assert image.channels["samples"].max() < 2**12
    assert int(picture(samples=8, noise=1e-9, size=(8, 8)).metadata["samples"]) == 8


def test_a_time_limit_of_next_to_nothing_still_gives_every_pixel_a_sample():
    image = picture(samples=None, seconds=1e-9)
    assert int(image.metadata["samples"].split()[0]) >= 1
    assert (image.channels["colour"].sum(axis=2) > 0).mean() > 0.5


@pytest.mark.parametrize(
    "settings",
    [
        {"samples": 0},
        {"samples": 2.5},
        {"samples": True},
        {"max_depth": 0},
        {"filter": "sinc"},
        {"pattern": "halton"},
        {"seconds": 0},
        {"seconds": float("nan")},
        {"noise": -1},
        {"noise": "low"},
    ],
)
def test_settings_that_make_no_sense_are_refused(settings):
    with pytest.raises(RenderError, match=next(iter(settings))):
        iso.PathTrace(**settings)
