"""Where samples go: a ball of glass and a block on a chequered floor, under a small lamp.

Run as a program, it draws the sample patterns, what noise looks like with them, a zone plate by each reconstruction
filter, how many samples each pixel gets when samples go where the noise is, and a picture before and after denoising.

    isophote render examples/sampling.py -o sampling.png --noise 0.02 --pattern blue-noise --filter mitchell
    isophote render examples/sampling.py -o quick.png --samples 8 --denoise
"""

import numpy as np

import isophote as iso

chequers = iso.ImageTexture(
    np.kron(np.indices((16, 16)).sum(axis=0) % 2, np.ones((8, 8)))[..., None].astype(np.float32) * 0.5 + 0.3
)
CORNERS = [(-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)]
square = iso.Mesh(CORNERS, [(0, 1, 2, 3)], attributes={"uv": [(0, 1), (0, 0), (1, 0), (1, 1)]})

scene = iso.Scene(
    items=[
        iso.Item(square, iso.Matte(chequers)).scale(4),
        iso.Item(iso.sphere(0.5), iso.Glass(1.5)).translate((0.75, 0.5, 0.2)),
        iso.Item(iso.box((0.8, 1, 0.8)), iso.Matte("tomato")).rotate("y", 0.5).translate((-0.7, 0.5, -0.2)),
    ],
    lights=[iso.RectLight(size=(0.4, 0.4), power=22).at((0.9, 2.2, -0.9)), iso.Sky("white", 0.4)],
    camera=iso.Camera(eye=(0, 1.8, 4.2), target=(0, 0.4, 0), fov_degrees=34),
    name="Where samples go",
)

PATTERNS = ("regular", "independent", "jittered", "antithetic", "sobol", "blue-noise")
FILTERS = ("box", "tent", "gaussian", "blackman-harris", "mitchell", "lanczos")


def drawn_points(pattern, edge=150):
    """Four by four pixels with 16 samples each, as dark dots."""
    points = iso.sample_pattern(pattern, 16, size=(4, 4), seed=1)
    corners = np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=2)[:, :, None]
    place = ((points + corners) / 4 * edge).reshape(-1, 2)
    y, x = np.mgrid[:edge, :edge] + 0.5
    distance = np.hypot(x[..., None] - place[:, 0], y[..., None] - place[:, 1]).min(axis=2)
    picture = 0.9 - 0.85 * np.clip(2.2 - distance, 0, 1)
    line = np.arange(1, 4) * edge // 4
    picture[line], picture[:, line] = 0.45, 0.45
    return np.repeat(picture[..., None], 3, axis=2).astype(np.float32)


def zone_plate(name, edge=130):
    """Rings as fine as one pixel at the edges, seen from above through a reconstruction filter."""
    n = 12 * edge
    y, x = (np.mgrid[:n, :n] + 0.5) / n * 2 - 1
    rings = 0.5 + 0.5 * np.cos(np.pi * edge / 2 * (x * x + y * y))
    plate = iso.Item(square, iso.Matte(iso.ImageTexture(rings[..., None].astype(np.float32))))
    above = iso.OrthographicCamera((0, 3, 0), (0, 0, 0), up=(0, 0, -1), height=2)
    seen = iso.Scene([plate], [iso.Sky()], above)
    return iso.render(seen, iso.PathTrace(128, max_depth=2, filter=name), size=(edge, edge)).channels["colour"]


def heat(counts):
    """Colours from dark over red to white, by the logarithm."""
    t = (np.log(counts / counts.min()) / np.log(counts.max() / counts.min()))[..., None]
    return np.clip(t * 3 - np.array([0.0, 1.0, 2.0]), 0, 1).astype(np.float32) ** 2.2


def beside(*pictures):
    """Pictures of one height as one, a white line between them."""
    gap = np.ones((len(pictures[0]), 4, 3), np.float32)
    parts = [part for picture in pictures for part in (picture, gap)][:-1]
    return np.concatenate(parts, axis=1)


def save(colour, path):
    iso.Image({"colour": colour}).save(path)


if __name__ == "__main__":
    save(beside(*(drawn_points(name) for name in PATTERNS)), "sample_patterns.png")

    lamp = iso.Scene([iso.Item(iso.plane(), iso.Matte(0.7)), *scene.items[2:]], scene.lights, scene.camera)
    noise = []
    for name in ("independent", "sobol", "blue-noise"):
        image = iso.render(lamp, iso.PathTrace(1, max_depth=2, pattern=name), size=(84, 66), seed=2)
        noise.append(np.kron(image.channels["colour"], np.ones((3, 3, 1), np.float32)))
    save(beside(*noise), "sample_noise.png")

    plates = [zone_plate(name) for name in FILTERS]
    gap = np.ones((4, beside(*plates[:3]).shape[1], 3), np.float32)
    save(np.concatenate([beside(*plates[:3]), gap, beside(*plates[3:])]), "filters.png")

    image = iso.render(scene, iso.PathTrace(noise=0.04), size=(320, 220), seed=1)
    save(beside(image.channels["colour"], heat(image.channels["samples"])), "adaptive_samples.png")
    print("samples:", image.metadata["samples"], "mean", round(float(image.channels["samples"].mean()), 1))

    size = (176, 132)
    noisy = iso.render(scene, iso.PathTrace(8), size=size, seed=1)
    clean = iso.render(scene, iso.PathTrace(8), size=size, seed=1, denoise="filter")
    truth = iso.render(scene, iso.PathTrace(512), size=size, seed=2)
    save(beside(*(picture.channels["colour"] for picture in (noisy, clean, truth))), "denoised.png")
