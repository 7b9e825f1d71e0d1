"""Sample patterns and adaptive sampling: errors against long pictures.

    python bench/sampling.py [--size 64] [--rounds 5] [--reference 4096] [--parts patterns spectrum adaptive]

`patterns`: root mean square error (RMSE) over all pixels and channels at 1, 4, 16 and 64 samples, mean over rounds of
different seeds, and the slope of log RMSE over log samples (independent: −1/2). References are "sobol" pictures of
4,096 samples. `spectrum`: how much of the error's power lies in the lowest frequencies (below 1/8 cycle a pixel), in
parts of what white noise has there; blue noise has less. `adaptive`: samples and processor seconds for the same error,
with `noise=` and evenly, with the same samples for all pixels, interpolated between powers of two.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Sequence

import numpy as np

import isophote as iso
from common import Array, print_machine, print_table, verdict
from isophote.rendering.passes import PATTERNS
from scenes import cornell_box, isophote_scene

COUNTS = (1, 4, 16, 64)


# --- scenes ---------------------------------------------------------------------------------------


def _quad(*corners: tuple[float, float, float]) -> iso.Mesh:
    return iso.Mesh(corners, [(0, 1, 2, 3)])


def _floor(size: float = 8) -> iso.Item:
    s = size / 2
    return iso.Item(_quad((-s, 0, -s), (-s, 0, s), (s, 0, s), (s, 0, -s)), iso.Matte(0.7))


def _smooth_light() -> iso.Scene:
    lamp = iso.RectLight(size=(1, 1), power=30).at((0, 1.5, 0))
    return iso.Scene([_floor()], [lamp], iso.Camera((0, 4, 5), (0, 0, 0), fov_degrees=30))


def _smooth_lens() -> iso.Scene:
    """A gradient behind a wide lens: the film, the lens and a light, six dimensions in all."""
    x = np.linspace(0, 2 * np.pi, 256)
    pattern = 0.5 + 0.2 * (np.sin(x)[:, None] + np.cos(2 * x)[None, :])
    texture = iso.ImageTexture(np.repeat(pattern[..., None], 3, axis=2).astype(np.float32))
    corners, uv = [(-4, 0, -4), (-4, 0, 4), (4, 0, 4), (4, 0, -4)], [(0, 1), (0, 0), (1, 0), (1, 1)]
    floor = iso.Mesh(corners, [(0, 1, 2, 3)], attributes={"uv": uv})
    camera = iso.Camera((0, 5, 1), (0, 0, 0), fov_degrees=50, lens_radius=0.3, focus_distance=2)
    lamp = iso.SphereLight(radius=1, power=60).at((5, 4, 0))
    return iso.Scene([iso.Item(floor, iso.Matte(texture))], [lamp], camera)


def _inside() -> iso.Scene:
    """Indirect light: the inside of a box with one wall that shines."""
    a, b, c, d = (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)
    sides = [[(x, -1, z) for x, z in (d, c, b, a)], [(x, 1, z) for x, z in (a, b, c, d)]]
    sides += [[(x, y, -1) for x, y in (a, b, c, d)], [(x, y, 1) for x, y in (b, a, d, c)]]
    sides += [[(-1, y, z) for y, z in (d, a, b, c)]]
    walls = [iso.Item(_quad(*corners), iso.Matte(0.6)) for corners in sides]
    shine = iso.Item(_quad(*[(1, y, z) for y, z in (a, d, c, b)]), iso.Emitter((1, 1, 1)))
    return iso.Scene([*walls, shine], (), iso.Camera((0, 0, 0.9), (-0.4, -0.2, -1), fov_degrees=60))


def _polygons() -> iso.Scene:
    """Black and white: stars seen directly, edges of every slope."""
    items = []
    for k, (x, z) in enumerate((x, z) for x in (-1.5, -0.5, 0.5, 1.5) for z in (-1.5, -0.5, 0.5, 1.5)):
        turn = np.arange(10) * np.pi / 5 + 0.37 * k
        radius = np.where(np.arange(10) % 2, 0.2, 0.48)
        ring = np.stack([x + radius * np.cos(turn), np.zeros(10), z - radius * np.sin(turn)], 1)
        faces = [(10, j, (j + 1) % 10) for j in range(10)]
        items.append(iso.Item(iso.Mesh(np.vstack([ring, (x, 0, z)]), faces), iso.Emitter((1, 1, 1))))
    return iso.Scene(items, (), iso.OrthographicCamera((0, 3, 0), (0, 0, 0), up=(0, 0, -1), height=4))


def _shadows(light: iso.Scene | object) -> iso.Scene:
    slats = [
        iso.Item(_quad((x, 0.8, -2), (x, 0.8, 2), (x + 0.12, 0.8, 2), (x + 0.12, 0.8, -2)), iso.Matte(0)).rotate(
            "y", 0.3
        )
        for x in np.linspace(-1.2, 1.2, 7)
    ]
    return iso.Scene([_floor(), *slats], [light], iso.Camera((0, 5, 5), (0, 0, 0), fov_degrees=28))


SMOOTH: dict[str, Callable[[], iso.Scene]] = {
    "area light": _smooth_light,
    "lens and lamp": _smooth_lens,
}
EDGES: dict[str, Callable[[], iso.Scene]] = {
    "stars": _polygons,
    "hard shadows": lambda: _shadows(iso.PointLight((0.5, 3, 0.3), 150)),
    "penumbras": lambda: _shadows(iso.RectLight(size=(0.5, 0.5), power=60).at((0.5, 3, 0.3))),
}
# Light that has been reflected three times: it depends on more dimensions than any pattern fills with few points.
DEEP: dict[str, Callable[[], iso.Scene]] = {"indirect light": _inside}
SCENES = {**SMOOTH, **EDGES, **DEEP}
DEPTHS = {"indirect light": 4}


def picture(scene: iso.Scene, size: int, seed: int = 1, **settings: object) -> iso.Image:
    """The path-traced picture of a scene."""
    return iso.render(scene, iso.PathTrace(**settings), size=(size, size), seed=seed, progress=False)


def colour(image: iso.Image) -> Array:
    """(h, w, 3) in double precision."""
    return image.channels["colour"].astype(np.float64)


# --- patterns -------------------------------------------------------------------------------------


def pattern_errors(size: int, rounds: int, reference: int) -> dict[tuple[str, str], Array]:
    """RMSE for each of COUNTS, by (scene, pattern)."""
    found = {}
    for name, make in SCENES.items():
        scene, depth = make(), DEPTHS.get(name, 2)
        truth = colour(picture(scene, size, 99, samples=reference, max_depth=depth, pattern="sobol"))
        for pattern in PATTERNS:
            errors = [
                [
                    np.mean((colour(picture(scene, size, k, samples=n, max_depth=depth, pattern=pattern)) - truth) ** 2)
                    for k in range(rounds)
                ]
                for n in COUNTS
            ]
            found[name, pattern] = np.sqrt(np.mean(errors, axis=1))
    return found


def tell_patterns(found: dict[tuple[str, str], Array]) -> None:
    rows = []
    for (scene, pattern), errors in found.items():
        slope = np.polyfit(np.log(COUNTS), np.log(errors), 1)[0]
        of_independent = errors[2] / found[scene, "independent"][2]
        rows.append([f"{scene}, {pattern}", *errors, slope, of_independent])
    print_table(["scene, pattern", *(f"{n} samples" for n in COUNTS), "slope", "at 16, of independent"], rows)
    low = ("antithetic", "blue-noise", "sobol")
    rows = []
    for kind, scenes, goal in (("smooth", SMOOTH, 0.25), ("edges", EDGES, 0.3), ("many dimensions", DEEP, 1.0)):
        for pattern in low:
            ratio = np.exp(np.mean([np.log(found[s, pattern][2] / found[s, "independent"][2]) for s in scenes]))
            rows.append([f"{kind}, {pattern}", ratio, verdict(float(ratio), goal, at_most=True)])
    print_table(["scenes, pattern", "RMSE at 16 samples, of independent (geometric mean)", "goal"], rows)


# --- spectra --------------------------------------------------------------------------------------


def low_frequency_share(error: Array, scale: Array, most: float = 0.125) -> float:
    """Power of an error image (h, w) below `most` cycles a pixel, in parts of what white noise has there.

    Noise that differs in strength over the picture has a spectrum of its own; `scale` (h, w) evens it out.
    """
    window = np.outer(np.hanning(error.shape[0]), np.hanning(error.shape[1]))
    even = error / (scale + 0.1 * scale.max())
    power = np.abs(np.fft.fft2((even - even.mean()) * window)) ** 2
    radius = np.hypot(np.fft.fftfreq(error.shape[0])[:, None], np.fft.fftfreq(error.shape[1])[None, :])
    low = radius < most
    return float(power[low].sum() / power.sum() / low.mean())


def tell_spectra(size: int, rounds: int, reference: int) -> None:
    rows = []
    for name in ("area light", "lens and lamp", "penumbras", "indirect light"):
        scene, depth = SCENES[name](), DEPTHS.get(name, 2)
        truth = picture(scene, size, 99, samples=reference, max_depth=depth, pattern="sobol")
        scale = np.sqrt(truth.channels["variance"].astype(np.float64).mean(axis=2))
        for pattern in ("blue-noise", "sobol", "independent"):
            shares = []
            for n in (1, 4, 16):
                settings = {"samples": n, "max_depth": depth, "pattern": pattern}
                errors = [colour(picture(scene, size, k, **settings)) - colour(truth) for k in range(rounds)]
                shares.append(float(np.mean([low_frequency_share(error.mean(axis=2), scale) for error in errors])))
            rows.append([f"{name}, {pattern}", *shares])
    print_table(["scene, pattern", "1 sample", "4 samples", "16 samples"], rows)


# --- adaptive sampling ----------------------------------------------------------------------------


def _two_lights() -> iso.Scene:
    """Much that is even, and a small part that is not: a ball of glass, and a lamp in a corner."""
    y, x = np.mgrid[0 : np.pi : 25j, 0 : 2 * np.pi : 49j]
    points = np.stack([np.sin(y) * np.cos(x), np.cos(y), np.sin(y) * np.sin(x)], 2).reshape(-1, 3) * 0.5
    k = np.arange(24)[:, None] * 49 + np.arange(48)
    faces = np.stack([k, k + 1, k + 50, k + 49], 2).reshape(-1, 4)
    ball = iso.Item(iso.Mesh(points, faces), iso.Glass(1.5)).translate((0.8, 0.5, 0))
    lamp = iso.RectLight(size=(0.4, 0.4), power=25).at((1.2, 2, -0.5))
    return iso.Scene([_floor(), ball], [lamp, iso.Sky("white", 0.5)], iso.Camera((0, 3, 6), (0, 0.3, 0)))


def rmse(image: iso.Image, truth: Array) -> float:
    """Root mean square error over all pixels and channels."""
    return float(np.sqrt(np.mean((colour(image) - truth) ** 2)))


def tell_adaptive(size: int, rounds: int, reference: int) -> None:
    scenes = {
        "glass and lamp": (_two_lights, (0.05, 0.02)),
        "Cornell box": (lambda: isophote_scene(cornell_box()), (0.1, 0.05)),
        "stars": (_polygons, (0.05, 0.02)),
        "penumbras": (EDGES["penumbras"], (0.1, 0.05)),
    }
    rows = []
    for name, (make, levels) in scenes.items():
        scene = make()
        truth = colour(picture(scene, size, 99, samples=reference, pattern="sobol"))
        even = np.array([_timed(scene, truth, size, rounds, samples=n) for n in 2 ** np.arange(4, 11)])
        for noise in levels:
            error, samples, seconds, bias = _timed(scene, truth, size, rounds, noise=noise)
            # Samples and seconds of even pictures of the same error, between powers of two.
            n, t = (np.exp(np.interp(-math.log(error), -np.log(even[:, 0]), np.log(even[:, k]))) for k in (1, 2))
            rows.append([f"{name}, noise {noise:g}", error, samples, n / samples, t / seconds, f"{100 * bias:+.3f} %"])
    titles = (
        "error, of the mean",
        "samples a pixel",
        "even: times the samples",
        "even: times the seconds",
        "mean's error",
    )
    print_table(["scene", *titles], rows)


def _timed(scene: iso.Scene, truth: Array, size: int, rounds: int, **settings: object) -> tuple[float, ...]:
    """Error in parts of the mean, samples a pixel, processor seconds, and the mean's error: means over rounds."""
    found = []
    for seed in range(rounds):
        began = time.process_time()
        image = picture(scene, size, seed, **settings)
        seconds = time.process_time() - began
        error = np.mean((colour(image) - truth) ** 2) / truth.mean() ** 2
        found.append((error, image.channels["samples"].mean(), seconds, colour(image).mean() / truth.mean() - 1))
    error, samples, seconds, bias = np.mean(found, axis=0)
    return math.sqrt(error), samples, seconds, bias


def main(arguments: Sequence[str] | None = None) -> None:
    parts = ("patterns", "spectrum", "adaptive")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--reference", type=int, default=4096)
    parser.add_argument("--parts", nargs="+", choices=parts, default=parts)
    given = parser.parse_args(arguments)
    print_machine()
    if "patterns" in given.parts:
        tell_patterns(pattern_errors(given.size, given.rounds, given.reference))
    if "spectrum" in given.parts:
        tell_spectra(given.size, given.rounds, given.reference)
    if "adaptive" in given.parts:
        tell_adaptive(given.size, given.rounds, given.reference)


if __name__ == "__main__":
    main()
