"""A thousand instances of one mesh: a field of twisted stones that share their geometry.

Items that hold the same mesh object are instances: each has its own place, turn and size, all have one set of
triangles. `isophote info --tree examples/instances.py` tells what that takes.

    isophote render examples/instances.py -o instances.png --size 640x360
"""

import numpy as np

import isophote as iso

COUNT = 1000
COLOURS = [iso.Matte(name) for name in ("#b5651d", "#d8b26e", "#7a8b99", "#e3dac9", "#5b7553")]


def stone(rows=24, columns=48):
    """A twisted block with round edges, 1 m high, that stands on the floor."""
    height = np.linspace(0, 1, rows + 1)[:, None]
    angle = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
    # A superellipse whose size falls toward both ends.
    reach = (np.cos(angle) ** 4 + np.sin(angle) ** 4) ** -0.25 * 0.3 * (1 - (2 * height - 1) ** 6) ** 0.5
    turned = angle + 0.9 * height
    x, z = reach * np.sin(turned), reach * np.cos(turned)
    points = np.stack([x, np.broadcast_to(height, x.shape), z], axis=-1).reshape(-1, 3)
    here = np.arange(rows * columns).reshape(rows, columns)
    there = np.roll(here, -1, axis=1)
    return iso.Mesh(points, np.stack([here, there, there + columns, here + columns], axis=-1).reshape(-1, 4))


def field(mesh, count, rng):
    """`count` items of one mesh on a jittered grid."""
    side = int(np.ceil(np.sqrt(count)))
    places = (np.stack(np.divmod(np.arange(count), side), axis=1) - side / 2 + rng.uniform(0.2, 0.8, (count, 2))) * 0.9
    for place, turn, size in zip(places, rng.uniform(0, 2 * np.pi, count), rng.uniform(0.4, 1.2, count), strict=True):
        item = iso.Item(mesh, COLOURS[rng.integers(len(COLOURS))])
        yield item.scale((0.9, size, 0.9)).rotate("y", turn).translate((place[0], 0, place[1]))


ground = iso.Mesh([(-60, 0, 60), (60, 0, 60), (60, 0, -60), (-60, 0, -60)], [(0, 1, 2, 3)])
scene = iso.Scene(
    items=[iso.Item(ground, iso.Matte("#9c9484")), *field(stone(), COUNT, np.random.default_rng(4))],
    lights=[iso.Sun((-1, 1.1, 0.5), irradiance=2.5, colour=(1, 0.92, 0.8)), iso.Sky("#a9c4e6", 0.7)],
    camera=iso.Camera(eye=(0, 5.5, 17), target=(0, 0.2, 3), fov_degrees=36),
    name="A thousand stones",
)

if __name__ == "__main__":
    iso.render(scene, iso.PathTrace(samples=64), size=(640, 360), seed=1).save("instances.png")
