"""A gear wheel in triangles: few where it is wide, small ones where its outline needs them, none below 28 degrees.

isophote render examples/triangulated.py -o triangulated.png
"""

import numpy as np

import isophote as iso

COLOURS = ("#1d3557", "#457b9d", "#a8dadc", "#f1faee", "#e9c46a", "#e76f51")
TEETH, LIFT = 18, 0.08


def ring(radii: np.ndarray) -> np.ndarray:
    angle = np.arange(len(radii)) * 2 * np.pi / len(radii)
    return radii[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def loop(first: int, count: int) -> np.ndarray:
    number = first + np.arange(count)
    return np.stack([number, np.roll(number, -1)], axis=1)


teeth = ring(np.tile([1.0, 1.16, 1.16, 1.0], TEETH))
holes = [0.6 * np.array([np.cos(a), np.sin(a)]) + ring(np.full(24, 0.17)) for a in np.arange(5) * 2 * np.pi / 5]
axle = ring(np.full(32, 0.22))
outlines = [teeth, *holes, axle]
starts = np.cumsum([0, *map(len, outlines)])
edges = [loop(start, len(outline)) for start, outline in zip(starts[:-1], outlines, strict=True)]
# Holes go clockwise.
edges[1:] = [hole[:, ::-1] for hole in edges[1:]]

coarse = iso.analysis.delaunay(np.concatenate(outlines), np.concatenate(edges))
wheel = iso.analysis.refine_triangulation(coarse, min_angle_degrees=28)
corners = wheel.points[wheel.triangles[wheel.inside()]]
sides = np.roll(corners, -1, axis=1) - corners
areas = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]) / 2
shade = np.searchsorted(np.quantile(areas, np.arange(1, len(COLOURS)) / len(COLOURS)), areas)


def tiles(chosen: np.ndarray) -> iso.Mesh:
    """Triangles, each a little smaller than it is, as low prisms; the wheel's y points away from the eye."""
    middle = chosen.mean(axis=1, keepdims=True)
    flat = (middle + 0.88 * (chosen - middle)).reshape(-1, 2)
    n = len(flat)
    points = np.concatenate([np.column_stack([flat[:, 0], np.full(n, h), -flat[:, 1]]) for h in (0, LIFT)])
    first = np.arange(0, n, 3)
    tops = [(i + n, i + 1 + n, i + 2 + n) for i in first]
    walls = [(i + k, i + (k + 1) % 3, n + i + (k + 1) % 3, n + i + k) for i in first for k in range(3)]
    return iso.Mesh(points, [*tops, *walls])


scene = iso.Scene(
    [
        *(iso.Item(tiles(corners[shade == k]), iso.Matte(colour), name=colour) for k, colour in enumerate(COLOURS)),
        iso.Item(iso.Mesh([(-9, 0, -9), (-9, 0, 9), (9, 0, 9), (9, 0, -9)], [(0, 1, 2, 3)]), iso.Matte("#b8b8b8")),
    ],
    lights=[iso.RectLight(size=(2, 2), power=160).at((-2, 4, 1.5)), iso.Sky("white", 0.4)],
    camera=iso.Camera(eye=(0, 2.7, 1.9), target=(0, 0, 0.06), fov_degrees=37),
)
