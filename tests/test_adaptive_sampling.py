"""Samples where the error is: how they are shared out, what pictures say of it, that they stay true and repeatable."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.rendering import passes
from isophote.rendering.film import LUMINANCE, Film
from isophote.rendering.passes import Limits, trace_passes
from isophote.rendering.pixel_filter import filter_table
from scenes import box, icosphere, mean, plane, render

ITEMS = [
    iso.Item(plane(8), iso.Matte((0.7, 0.5, 0.3))),
    iso.Item(icosphere(2, 0.6, smooth=True), iso.Glass(1.5)).translate((0.7, 0.7, 0.3)),
    iso.Item(box(0.9), iso.Matte((0.9, 0.2, 0.2))).rotate("y", 0.4).translate((-0.8, 0.46, 0)),
]
LIGHTS = [iso.RectLight(size=(0.6, 0.6), power=30).at((0.5, 2.5, -0.5)), iso.Sky(strength=0.5)]
CAMERA = iso.Camera((0, 2, 5), (0, 0.5, 0))


def picture(noise: float, **settings: object) -> iso.Image:
    return render(ITEMS, LIGHTS, CAMERA, **{"size": (60, 40), "noise": noise, **settings})


def told_noise(image: iso.Image) -> float:
    """Root mean square standard error of the pixels, in parts of the mean."""
    error = np.sqrt((image.channels["variance"].astype(np.float64) @ LUMINANCE).mean())
    return float(error / (image.channels["colour"].astype(np.float64) @ LUMINANCE).mean())


# --- how samples are shared out, by pixels of known variance --------------------------------------


def shared_out(deviation: np.ndarray, limits: Limits, threads: int = 2) -> Film:
    """The film after passes over pixels whose samples are 1 ± `deviation`, up and down in turn."""
    from isophote.progress import Reporter
    from isophote.rendering.method import Job
    from isophote.rendering.pool import Pool

    height, width = deviation.shape
    film = Film((width, height), filter_table(iso.PixelFilter("box")))

    def work(tile, thread):
        for y in range(tile.y0, tile.y1):
            for x in range(tile.x0, tile.x1):
                for k in range(film.count[y, x], film.target[y, x]):
                    value = 1 + deviation[y, x] * (1 if k % 2 else -1)
                    film._total[0, y, x] += value
                    film._squares[0, y, x] += value**2
                film.count[y, x] = film.target[y, x]

    job = Job(iso.Scene([]), (width, height), 0, threads, Reporter(lambda stage, fraction: None))
    trace_passes(work, film, limits, job, Pool(threads), "sampling", 0.0)
    return film


def test_samples_are_in_proportion_to_the_deviation():
    """The least for a given root mean square error, n = σ mean(σ) / e²: two halves, eight times as uneven one."""
    deviation = np.full((24, 48), 0.1)
    deviation[:, 24:] = 0.8
    film = shared_out(deviation, Limits(None, noise=0.05))
    wanted = np.array([0.1, 0.8]) * 0.45 / 0.05**2
    found = np.array([film.count[:, :20].mean(), film.count[:, 28:].mean()])
    assert np.allclose(found, wanted, rtol=0.12)
    assert film.noise() <= 0.05
    even = (deviation**2).mean() / 0.05**2
    assert film.count.mean() < 0.75 * even


def test_pixels_beside_noisy_ones_get_more_than_they_ask_for():
    """One pixel of noise: those around it, whose samples so far may have missed something, are looked at as well."""
    deviation = np.zeros((21, 21))
    deviation[10, 10] = 0.5
    count = shared_out(deviation, Limits(None, noise=0.002)).count
    assert count[10, 10] == count.max() > 100
    assert count[9:12, 9:12].min() > 20
    assert (count[:7] == 16).all()


def test_without_noise_all_pixels_get_the_same():
    count = shared_out(np.random.default_rng(1).random((10, 12)), Limits(100)).count
    assert (count == 100).all()


@pytest.mark.parametrize("most", [1, 5, 16, 17, 40])
def test_no_pixel_gets_more_than_the_most(most):
    count = shared_out(np.full((8, 8), 1.0), Limits(most, noise=1e-6)).count
    assert (count == most).all()


def test_limits_plan():
    assert Limits(None).planned == 64
    assert Limits(7).planned == 7
    assert Limits(None, noise=0.1).planned == passes.MOST_SAMPLES
    assert Limits(9, noise=0.1).planned == 9


# --- pictures -------------------------------------------------------------------------------------


def test_pictures_reach_the_noise_with_fewer_samples_than_even_ones():
    image = picture(0.04)
    samples = image.channels["samples"]
    assert samples.dtype == np.int32
    assert told_noise(image) <= 0.04
    assert samples.min() >= 16
    assert samples.max() > 8 * samples.min()
    assert image.metadata["samples"] == f"{samples.min()} to {samples.max()}"
    even = picture(None, samples=int(samples.mean()) + 1)
    assert told_noise(even) > 1.5 * told_noise(image)
    # The ball of glass and what it throws on the floor are where the error is.
    glass = image.channels["item"] == 1
    assert samples[glass].mean() > 2 * samples[~glass].mean()


@pytest.mark.parametrize("pattern", ["blue-noise", "independent"])
def test_neither_threads_nor_tiles_nor_waves_change_the_picture(pattern, monkeypatch):
    from isophote.rendering import path_trace

    first = picture(0.06, threads=1, pattern=pattern)
    assert first.channels["samples"].max() > 64
    for settings in ({"threads": 3}, {"_TILE": 13}, {"_WAVE": 77}):
        for name, value in settings.items():
            if name != "threads":
                monkeypatch.setattr(passes if name == "_TILE" else path_trace, name, value)
        again = picture(0.06, threads=settings.get("threads", 2), pattern=pattern)
        for name in first.channels:
            assert first.channels[name].tobytes() == again.channels[name].tobytes()


def test_the_mean_is_kept_and_the_error_is_as_told():
    """Pixels that see little by chance stop early: the bias of that is small beside the noise that was asked for."""
    truth = picture(None, samples=4096, seed=77, pattern="sobol").channels["colour"].astype(np.float64)
    images = [picture(0.06, seed=seed, pattern="independent") for seed in range(8)]
    errors = np.array([image.channels["colour"] - truth for image in images])
    bias = errors.mean() / truth.mean()
    assert abs(bias) < 0.1 * 0.06
    told = np.mean([image.channels["variance"] for image in images])
    # Pixels that stop too early also tell too little of their variance; the long picture has an error of its own.
    assert 0.8 < (errors**2).mean() / told < 1.6


def test_black_pictures_end_and_even_ones_take_the_first_samples_only():
    dark = render([iso.Item(plane(2))], [iso.PointLight((0, -1, 0), 1)], CAMERA, noise=0.01)
    assert not mean(dark).any()
    assert (dark.channels["samples"] == 16).all()
    wall = iso.Item(plane(50), iso.Emitter((1, 0.5, 0.2)))
    flat = render([wall], (), iso.Camera((0, 2, 1), (0, 0, 0)), noise=0.001)
    assert (flat.channels["samples"] == 16).all()


@pytest.mark.parametrize("name", ["mitchell", "lanczos"])
def test_signed_filters_reach_the_noise_too(name):
    image = picture(0.06, filter=name)
    assert told_noise(image) <= 0.06 * 1.0001
    assert image.channels["samples"].max() > image.channels["samples"].min()


def test_samples_are_kept_in_files(tmp_path):
    image = picture(0.1)
    image.save(tmp_path / "picture.exr")
    assert np.array_equal(iso.load_image(tmp_path / "picture.exr").channels["samples"], image.channels["samples"])


def test_ray_traced_pictures_sample_edges():
    """Flat surfaces under a point light need few samples; their edges more."""
    scene = iso.Scene(ITEMS[::2], [iso.PointLight((1, 3, 2), 200)], CAMERA)
    image = iso.render(scene, iso.RayTrace(noise=0.01), size=(60, 40), progress=False)
    samples = image.channels["samples"]
    assert samples.max() > 4 * samples.min()
    item = image.channels["item"]
    edge = np.zeros(item.shape, bool)
    edge[:, 1:] |= item[:, 1:] != item[:, :-1]
    assert samples[edge].mean() > 2 * samples[~edge].mean()
