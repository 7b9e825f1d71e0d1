"""The tetrahedra between points of a ball, drawn apart, and a third of them taken out to see the others.

isophote render examples/tetrahedra.py -o tetrahedra.png
"""

import numpy as np

import isophote as iso

COLOURS = ("#264653", "#2a9d8f", "#e9c46a", "#f4a261", "#e76f51")

rng = np.random.default_rng(7)
inner = rng.normal(size=(60, 3))
inner *= (rng.random(60) ** (1 / 3) / np.linalg.norm(inner, axis=1))[:, None] * 0.8
outer = rng.normal(size=(90, 3))
outer /= np.linalg.norm(outer, axis=1, keepdims=True)

d = iso.analysis.delaunay(np.concatenate([inner, outer]))
corners = d.points[d.tetrahedra]
middle = corners.mean(axis=1, keepdims=True)
apart = 1.25 * middle + 0.9 * (corners - middle)
distance = np.linalg.norm(middle[:, 0], axis=1)
shade = np.searchsorted(np.quantile(distance, np.arange(1, len(COLOURS)) / len(COLOURS)), distance)
kept = (middle[:, 0] @ (0.4, 0.3, 0.9)) < 0.12


def solids(chosen: np.ndarray) -> iso.Mesh:
    first = 4 * np.arange(len(chosen))[:, None]
    # Each face as seen from outside, for corners whose orientation is positive.
    faces = np.concatenate([first + face for face in ((0, 1, 2), (1, 0, 3), (2, 1, 3), (0, 2, 3))])
    return iso.Mesh(chosen.reshape(-1, 3), faces)


scene = iso.Scene(
    [
        *(
            iso.Item(solids(apart[kept & (shade == k)]), iso.Matte(colour), name=colour).translate((0, 1.26, 0))
            for k, colour in enumerate(COLOURS)
        ),
        iso.Item(
            iso.Mesh([(-20, 0, -20), (-20, 0, 20), (20, 0, 20), (20, 0, -20)], [(0, 1, 2, 3)]), iso.Matte("#cccccc")
        ),
    ],
    lights=[iso.RectLight(size=(3, 3), power=260).at((2, 5, 3)), iso.Sky("white", 0.4)],
    camera=iso.Camera(eye=(1.7, 2.1, 4.2), target=(0, 1.2, 0), fov_degrees=36),
)
