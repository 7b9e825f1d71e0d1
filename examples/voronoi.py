"""A Voronoi diagram, relaxed by Lloyd, as columns: cells shrunk a little, the higher the nearer to the middle.

isophote render examples/voronoi.py -o voronoi.png
"""

import numpy as np

import isophote as iso

COLOURS = ("#d1495b", "#edae49", "#66a182", "#2e86ab", "#8d6a9f")

hexagon = [(2 * np.cos(a), 2 * np.sin(a)) for a in np.arange(6) * np.pi / 3]
sites = np.random.default_rng(4).uniform(-1, 1, (90, 2))
diagram = iso.analysis.lloyd(sites, hexagon, iterations=8)


def column(cell: iso.analysis.Cell) -> iso.Mesh:
    """A cell as a closed prism; the diagram's y points away from the eye."""
    height = 0.15 + 0.9 * np.exp(-(cell.site @ cell.site))
    corners = cell.site + 0.92 * (cell.polygon - cell.site)
    n = len(corners)
    points = [(x, h, -y) for h in (0, height) for x, y in corners]
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return iso.Mesh(points, [tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides])


columns = [
    iso.Item(column(cell), iso.Matte(COLOURS[i % len(COLOURS)]), name=f"cell {i}")
    for i, cell in enumerate(diagram.cells)
]
scene = iso.Scene(
    [
        *columns,
        iso.Item(iso.Mesh([(-9, 0, -9), (-9, 0, 9), (9, 0, 9), (9, 0, -9)], [(0, 1, 2, 3)]), iso.Matte("#dddddd")),
    ],
    lights=[iso.RectLight(size=(3, 3), power=300).at((-2, 5, 2)), iso.Sky("white", 0.5)],
    camera=iso.Camera(eye=(0, 3.6, 4.2), target=(0, 0.1, 0.1), fov_degrees=44),
)
