"""A Cornell box: matte walls, one red and one green, two white blocks, and a lamp in the ceiling.

The room is 2 m wide, high and deep. Every surface is a polygon; the light between them is path traced.

    isophote render examples/cornell_box.py -o cornell.png
"""

import numpy as np

import isophote as iso

WHITE, RED, GREEN = iso.Matte((0.73, 0.73, 0.73)), iso.Matte((0.61, 0.06, 0.06)), iso.Matte((0.12, 0.44, 0.10))


def wall(*corners):
    """One polygon, seen from where its corners run counter-clockwise."""
    return iso.Mesh(corners, [range(len(corners))])


def block(width, height, depth):
    """A closed box that stands on the floor, its base centred at the origin."""
    x, z = width / 2, depth / 2
    base = np.array([(-x, 0, -z), (-x, 0, z), (x, 0, z), (x, 0, -z)])
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return iso.Mesh(np.concatenate([base, base + np.array([0, height, 0])]), faces)


room = [
    iso.Item(wall((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)), WHITE, name="floor"),
    iso.Item(wall((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)), WHITE, name="ceiling"),
    iso.Item(wall((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)), WHITE, name="back"),
    iso.Item(wall((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)), RED, name="left"),
    iso.Item(wall((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)), GREEN, name="right"),
]
blocks = [
    iso.Item(block(0.6, 0.6, 0.6), WHITE, name="low").rotate("y", -0.29).translate((0.35, 0, 0.35)),
    iso.Item(block(0.6, 1.2, 0.6), WHITE, name="high").rotate("y", 0.30).translate((-0.35, 0, -0.3)),
]
lamp = iso.RectLight(size=(0.7, 0.6), radiance=(18, 14, 8.5)).at((0, 1.99, -0.1))

scene = iso.Scene(
    items=room + blocks,
    lights=[lamp],
    camera=iso.Camera(eye=(0, 1, 5), target=(0, 1, 0), fov_degrees=28),
    name="Cornell box",
)

if __name__ == "__main__":
    iso.render(scene, iso.PathTrace(samples=64), size=(512, 512), seed=1).save("cornell.png")
