"""Texture filters: error at one sample a pixel beside many, time of a look-up, and what textured scenes cost.

python bench/textures.py                 tables
python bench/textures.py --quick         small pictures, once
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import attrs
import numpy as np
import numpy.typing as npt

import isophote as iso

FILTERS = ("nearest", "bilinear", "trilinear", "ewa")
SKY = iso.Sky((1.0, 1.0, 1.0))


def checker(size: int, squares: int) -> npt.NDArray[np.uint8]:
    """(size, size, 3): red and white squares."""
    row = np.arange(size) * squares // size % 2
    grey = (row[:, None] ^ row) * 255
    return np.stack([np.full_like(grey, 230), grey, grey], axis=-1).astype(np.uint8)


def horizon(picture: iso.ImageTexture) -> iso.Scene:
    """A plane to the horizon, 4 squares of the picture to the metre."""
    far, tiles = 400.0, 200.0
    corners = [(-far, 0, far), (far, 0, far), (far, 0, -far), (-far, 0, -far)]
    uv = [(-tiles, -tiles), (tiles, -tiles), (tiles, tiles), (-tiles, tiles)]
    ground = iso.Mesh(corners, [(0, 1, 2, 3)], attributes={"uv": uv})
    return iso.Scene(
        [iso.Item(ground, iso.Matte(picture))], [SKY], iso.Camera((0, 1, 0), (0.4, 0.8, -1), fov_degrees=50)
    )


def drawn(scene: iso.Scene, size: tuple[int, int], samples: int, seed: int = 1) -> npt.NDArray[np.float64]:
    """Colours under ambient light alone: of a matte surface, its texture. One sample is taken in the middle."""
    method = iso.RayTrace(samples=samples, pattern="regular" if samples == 1 else "blue-noise")
    image = iso.render(scene, method, size=size, seed=seed, progress=False)
    return image.channels["colour"].astype(np.float64)


def error_table(quick: bool) -> None:
    size, many = ((64, 48), 256) if quick else ((160, 120), 4096)
    texture = iso.ImageTexture(checker(256, 8))
    truth = drawn(horizon(attrs.evolve(texture, filter="bilinear")), size, many)
    # Rows of the ground, without the one that has the horizon in it.
    ground = slice(int(np.argmax((truth[..., 1] < 0.999).all(axis=1))) + 1, None)
    print(f"horizon of checks, {size[0]} by {size[1]}: RMSE of the ground beside {many} samples a pixel")
    print(f"{'filter':10}{'1 sample':>10}{'4 samples':>11}{'16 samples':>12}{'64 samples':>12}")
    for kind in FILTERS:
        scene = horizon(attrs.evolve(texture, filter=kind))
        found = [drawn(scene, size, samples, 2) for samples in (1, 4, 16, 64)]
        errors = [float(np.sqrt(((one - truth)[ground] ** 2).mean())) for one in found]
        print(
            f"{kind:10}" + "".join(f"{error:{width}.4f}" for error, width in zip(errors, (10, 11, 12, 12), strict=True))
        )
    print()


def least_time(work: Callable[[], object], runs: int) -> float:
    """Shortest processor time of some runs, seconds."""
    times = []
    for _ in range(runs):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def look_up_table(quick: bool) -> None:
    count, runs = (20_000, 2) if quick else (400_000, 7)
    rng = np.random.default_rng(3)
    pixels = rng.integers(0, 256, (1024, 1024, 3)).astype(np.uint8)
    scattered = rng.random((count, 2)).astype(np.float32)
    row = np.stack([np.linspace(0, 8, count) % 1, np.linspace(0, 0.2, count)], axis=1).astype(np.float32)
    print("nanoseconds a look-up, 1024 by 1024 pixels of 8 bits, processor time")
    print(f"{'filter':10}{'footprint':>24}{'scattered':>11}{'in order':>10}")
    widths = {
        "1 by 1 texels": (0.5, 0.5),
        "4 by 4 texels": (2, 2),
        "16 by 2 texels": (8, 1),
        "16 by 1 texels": (8, 0.5),
    }
    for kind in FILTERS:
        texture = iso.ImageTexture(pixels, filter=kind)
        for name, (a, b) in widths.items() if kind in ("trilinear", "ewa") else [("none", (0.0, 0.0))]:
            turn = np.array([[np.cos(0.5), np.sin(0.5)], [-np.sin(0.5), np.cos(0.5)]])
            axes = turn * np.array([[a], [b]]) / 1024
            nothing = iso.ImageTexture(np.zeros((1, 1, 3), np.uint8), filter="nearest")

            def cost(uv: npt.NDArray[np.float32], axes=axes, texture=texture, nothing=nothing) -> float:
                base = least_time(lambda: iso.texture_values(nothing, uv[:10], uv_axes=axes), runs)
                lower = least_time(lambda: iso.texture_values(texture, uv[:10], uv_axes=axes), runs)
                whole = least_time(lambda: iso.texture_values(texture, uv, uv_axes=axes), runs)
                filled = least_time(lambda: iso.texture_values(nothing, uv, uv_axes=axes), runs)
                return ((whole - lower) - (filled - base)) / len(uv) * 1e9

            print(f"{kind:10}{name:>24}{cost(scattered):11.1f}{cost(row):10.1f}")
    print()


def scene_table(quick: bool) -> None:
    size, samples, runs = ((64, 48), 1, 1) if quick else ((320, 240), 4, 5)
    print(f"path tracing {size[0]} by {size[1]}, {samples} samples a pixel: processor seconds")
    print(f"{'ground':24}{'seconds':>9}{'ratio':>8}")
    plain = horizon(iso.ImageTexture(checker(256, 8)))
    scenes = {"one colour": iso.Scene([iso.Item(plain.items[0].shape, iso.Matte(0.5))], plain.lights, plain.camera)}
    scenes |= {kind: horizon(iso.ImageTexture(checker(256, 8), filter=kind)) for kind in FILTERS}
    first = 0.0
    for name, scene in scenes.items():
        seconds = least_time(
            lambda scene=scene: iso.render(scene, iso.PathTrace(samples=samples), size=size, progress=False, threads=1),
            runs,
        )
        first = first or seconds
        print(f"{name:24}{seconds:9.3f}{seconds / first:8.2f}")
    print()


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", choices=("error", "look-up", "scene"))
    given = parser.parse_args()
    for name, table in (("error", error_table), ("look-up", look_up_table), ("scene", scene_table)):
        if given.only in (None, name):
            table(given.quick)


if __name__ == "__main__":
    main()
