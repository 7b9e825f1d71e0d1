"""A tiled floor that runs to the horizon, a ball that mirrors it and one of glass: pictures, filtered.

Run as a program, it draws the floor by each filter at one sample a pixel, texture_filters.png.

    isophote render examples/textures.py -o tiles.png --size 640x360 --samples 64 --denoise
"""

import attrs
import numpy as np

import isophote as iso


def tiles(edge=256):
    """Four tiles of two colours, with dark joints, rings and some dirt, (edge, edge, 3) sRGB bytes."""
    y, x = (np.mgrid[:edge, :edge] + 0.5) / edge * 2
    dark = (x.astype(int) + y.astype(int)) % 2
    u, v = x % 1 - 0.5, y % 1 - 0.5
    rings = np.sin(26 * np.hypot(u, v)) * (np.hypot(u, v) < 0.42)
    colour = np.where(dark[..., None], [0.16, 0.22, 0.3], [0.82, 0.76, 0.66]) * (1 + 0.18 * rings[..., None])
    colour[np.maximum(abs(u), abs(v)) > 0.47] = 0.07
    dirt = np.random.default_rng(4).normal(0, 0.02, (edge, edge, 1))
    return (np.clip(colour + dirt, 0, 1) * 255).astype(np.uint8)


picture = iso.ImageTexture(tiles(), name="tiles")
FAR, REPEATS = 60, 60
corners = [(-FAR, 0, FAR), (FAR, 0, FAR), (FAR, 0, -FAR), (-FAR, 0, -FAR)]
ends = [(-REPEATS, -REPEATS), (REPEATS, -REPEATS), (REPEATS, REPEATS), (-REPEATS, REPEATS)]
ground = iso.Mesh(corners, [(0, 1, 2, 3)], attributes={"uv": ends})

scene = iso.Scene(
    items=[
        iso.Item(ground, iso.Matte(picture)),
        iso.Item(iso.sphere(0.55), iso.Mirror(0.95)).translate((-0.75, 0.55, 0)),
        iso.Item(iso.sphere(0.45), iso.Glass(1.5)).translate((0.55, 0.45, 0.5)),
        iso.Item(iso.sphere(0.5), iso.Matte(iso.ImageTexture(tiles(), wrap=("repeat", "clamp")))).translate(
            (1.6, 0.5, -1)
        ),
    ],
    lights=[iso.Sun((0.5, 0.8, 0.6), irradiance=2.6), iso.Sky((0.55, 0.7, 0.95))],
    camera=iso.Camera(eye=(0.3, 1.1, 4), target=(0.25, 0.5, 0), fov_degrees=36),
    name="Tiles to the horizon",
)


def horizons(size=(125, 115)):
    """The floor alone by each filter, one sample in the middle of each pixel, and by 1,024 without a filter."""
    parts = []
    for kind, samples in (("nearest", 1), ("bilinear", 1), ("trilinear", 1), ("ewa", 1), ("bilinear", 1024)):
        floor = iso.Item(ground, iso.Matte(attrs.evolve(picture, filter=kind)))
        view = iso.Camera((0, 0.7, 0), (0.5, 0.2, -1), fov_degrees=50)
        seen = iso.Scene([floor], [iso.Sky()], view)
        method = iso.RayTrace(samples=samples, pattern="regular" if samples == 1 else "blue-noise")
        parts += [iso.render(seen, method, size=size).channels["colour"], np.ones((size[1], 4, 3), np.float32)]
    return iso.Image({"colour": np.concatenate(parts[:-1], axis=1)})


if __name__ == "__main__":
    horizons().save("texture_filters.png")
