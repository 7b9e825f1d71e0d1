"""What rays visit: the same picture by each accelerator, and heat maps of the nodes or cells on the way.

A room with a small detailed thing in it is hard for one uniform grid, and easy for grids within grids. Run it for three
pictures and a table; it also defines the `scene`.

    python examples/accelerators.py
    isophote render examples/accelerators.py -o knot.png --accelerator kdtree
"""

from pathlib import Path

import numpy as np

import isophote as iso

PICTURES = Path(__file__).parents[1] / "docs" / "pictures"
ACCELERATORS = ("bvh", "grid", "kdtree")


def knot(turns=2, rounds=3, along=400, around=24):
    """A tube about a torus knot."""
    t = np.linspace(0, 2 * np.pi, along, endpoint=False)
    radius = 1 + 0.4 * np.cos(rounds * t)
    path = np.stack([radius * np.cos(turns * t), radius * np.sin(turns * t), -0.4 * np.sin(rounds * t)], axis=1)
    ahead = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    side = np.cross(ahead, path)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(ahead, side)
    s = np.linspace(0, 2 * np.pi, around, endpoint=False)[:, None]
    points = path[:, None] + 0.14 * (np.cos(s) * side[:, None] + np.sin(s) * up[:, None])
    i, j = np.mgrid[0:along, 0:around]
    number = (i % along) * around + j
    ahead_of, beside = ((i + 1) % along) * around + j, i * around + (j + 1) % around
    corners = np.stack([number, ahead_of, ((i + 1) % along) * around + (j + 1) % around, beside], axis=-1)
    return iso.Mesh(points.reshape(-1, 3), corners.reshape(-1, 4))


def wall(*corners):
    return iso.Item(iso.Mesh(np.array(corners, float), [[0, 1, 2, 3]]), iso.Matte("lightgrey"))


scene = iso.Scene(
    items=[
        iso.Item(knot(), iso.Plastic("tomato")).scale(0.25).translate((0, 0.45, 0)),
        wall((-4, 0, -4), (-4, 0, 4), (4, 0, 4), (4, 0, -4)),
        wall((-4, 0, -4), (4, 0, -4), (4, 4, -4), (-4, 4, -4)),
        wall((-4, 0, -4), (-4, 4, -4), (-4, 4, 4), (-4, 0, 4)),
    ],
    lights=[iso.Sky("white", 0.8)],
    camera=iso.Camera(eye=(0.5, 0.9, 1.4), target=(0, 0.42, 0), fov_degrees=40),
)

if __name__ == "__main__":
    print("accelerator   nodes  triangles  deepest")
    for name in ACCELERATORS:
        image = iso.render(scene, iso.Visits(name, most=40), size=(320, 240), progress=False)
        image.save(PICTURES / f"visits-{name}.png")
        nodes, triangles, depth = (image.channels[count] for count in ("nodes", "primitives", "tree_depth"))
        print(f"{name:12s} {nodes.mean():6.1f} {triangles.mean():10.1f} {int(depth.max()):8d}")
