"""Trees seen from outside: cells of a BSP tree along the walls of turned houses, and boxes of a bounding interval
hierarchy over a torus. It also defines the houses as a `scene`.

    python examples/trees.py
    isophote render examples/trees.py -o houses.png --accelerator bsp
"""

from pathlib import Path

import numpy as np

import isophote as iso

PICTURES = Path(__file__).parents[1] / "docs" / "pictures"
# Middle on x and z, size on x, z and y.
HOUSES = [(0, 0, 1, 1, 1.2), (1.3, 0.1, 0.6, 0.8, 1.8), (-1.2, 0.2, 0.7, 0.7, 0.8), (0.3, -1.3, 0.8, 0.6, 0.7)]
CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) - (0.5, 0, 0.5)
SIDES = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


def houses(angle):
    """Boxes on the ground, all turned by an angle about the vertical."""
    points = np.concatenate([CORNERS * (sx, sy, sz) + (x, 0, z) for x, z, sx, sz, sy in HOUSES])
    faces = np.concatenate([SIDES + 8 * k for k in range(len(HOUSES))])
    c, s = np.cos(angle), np.sin(angle)
    return iso.Mesh(points @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]), faces)


scene = iso.Scene(
    items=[iso.Item(houses(0.5), iso.Matte("wheat")), iso.Item(iso.plane(), iso.Matte("darkseagreen"))],
    lights=[iso.Sun((1, 2, 1.5), 3), iso.Sky("lightblue", 0.5)],
    camera=iso.Camera((2.5, 3, 5), (0, 0.4, 0), fov_degrees=40),
)

if __name__ == "__main__":
    iso.show_tree(houses(0.5), "bsp", depth=5, size=(400, 300)).save(PICTURES / "tree-bsp.png")
    torus = iso.to_mesh(iso.torus(1, 0.4), cell=0.03)
    iso.show_tree(torus, "bih", depth=2, size=(400, 300)).save(PICTURES / "tree-bih.png")
