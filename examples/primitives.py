"""Solids by their formulas: every kind of exact primitive on a chequered plane, with nothing meshed.

A bare `iso.sphere`, `iso.torus` or `iso.cone` in a scene is met by its formula, however it is moved and scaled.
Polygons, disks and quadrics are shapes of their own.

    isophote render examples/primitives.py -o primitives.png --size 640x360 --samples 256
"""

import numpy as np

import isophote as iso

TILES = iso.ImageTexture(np.array([[(176, 168, 154), (120, 130, 134)], [(120, 130, 134), (176, 168, 154)]], np.uint8),
                    filter="nearest")  # fmt: skip
STRIPES = iso.ImageTexture(np.array([[(214, 92, 60), (240, 226, 200)] * 8], np.uint8), filter="nearest")


def star(radius, inner, count=5):
    """The corners of a star in the plane z = 0."""
    angle = np.pi * (np.arange(2 * count) / count + 0.5)
    reach = np.where(np.arange(2 * count) % 2 == 0, radius, inner)
    return np.stack([reach * np.cos(angle), reach * np.sin(angle), 0 * angle], axis=1)


# x² + z² − y²/3 = 0.04 between two lids, and the saddle y = x² − z² as a sheet.
hyperboloid = iso.Quadric((1, -1 / 3, 1, 0, 0, 0, 0, 0, 0, -0.04), [(-1, -0.5, -1), (1, 0.5, 1)])
saddle = iso.Quadric((1, 0, -1, 0, 0, 0, 0, -1, 0, 0), [(-0.5, -0.4, -0.5), (0.5, 0.4, 0.5)], closed=False)

scene = iso.Scene(
    items=[
        iso.Item(iso.plane().scale(0.8), iso.Matte(TILES)),
        iso.Item(iso.sphere(0.4), iso.Glass(1.5)).translate((-0.35, 0.4, 0.8)),
        iso.Item(iso.torus(0.42, 0.16), iso.Mirror((0.95, 0.8, 0.5))).rotate("x", 0.5).translate((0.75, 0.36, 0.7)),
        iso.Item(iso.cylinder(0.3, 0.8), iso.Matte(STRIPES)).translate((-1.35, 0.4, 0.3)),
        iso.Item(iso.cone(0.4, 0.9), iso.Matte("seagreen")).translate((0.25, 0.45, -0.5)),
        iso.Item(iso.ellipsoid((0.5, 0.28, 0.3)).rotate("z", 0.3), iso.Matte("slateblue")).translate((1.75, 0.36, 0.1)),
        iso.Item(hyperboloid, iso.Matte("goldenrod")).translate((-0.75, 0.5, -0.7)),
        iso.Item(saddle, iso.Matte((0.75, 0.3, 0.45))).translate((1.25, 0.6, -0.9)),
        iso.Item(iso.Polygon(star(0.5, 0.22), [star(0.2, 0.09)]), iso.Matte("tomato")).translate((-1.9, 0.6, -0.7)),
        iso.Item(iso.sphere(0.12), iso.Emitter((14, 12, 9))).translate((0.35, 1.3, 0.6)),
    ],
    lights=[
        iso.RectLight(size=(2, 2), power=130).at((-3, 4, 3), target=(0, 0.4, 0)),
        iso.Sky("lightsteelblue", 0.5),
    ],
    camera=iso.Camera(eye=(0.1, 1.9, 5.2), target=(0, 0.42, 0), fov_degrees=34),
    name="Primitives",
)

if __name__ == "__main__":
    iso.render(scene, iso.PathTrace(samples=256), size=(640, 360), seed=1).save("primitives.png")
