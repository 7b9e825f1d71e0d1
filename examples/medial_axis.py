"""The roof over a polygon with a hole: as high at each point of its medial axis as the ball there is wide.

isophote render examples/medial_axis.py -o roof.png
"""

import numpy as np

import isophote as iso

STEPS = 24

house = [(0, 0), (7, 0), (7, 2), (4.4, 2), (4.4, 3), (7.5, 3), (7.5, 6), (3, 6.5), (0, 5)]
court = [(1.6, 1.8), (3, 1.8), (3, 3.6), (2, 4)]
axis = iso.analysis.medial_axis([house, court])


def slope(arc: int, side: int) -> iso.Mesh:
    """The strip of the roof between an arc and the boundary on one of its sides."""
    balls = axis.at(arc, np.linspace(0, 1, STEPS + 1))
    top = np.column_stack([balls.centre[:, 0], balls.radius, -balls.centre[:, 1]])
    foot = np.column_stack([balls.feet[:, side, 0], np.zeros(STEPS + 1), -balls.feet[:, side, 1]])
    i, n = np.arange(STEPS), STEPS + 1
    return iso.Mesh(np.concatenate([top, foot]), np.stack([i, i + 1, n + i + 1, n + i], axis=1))


flat, curved = iso.Matte("#c8553d"), iso.Matte("#f28f3b")
corners = sum(map(len, axis.rings))
roof = [
    iso.Item(slope(arc, side), curved if axis.sites[arc, side] >= corners else flat, name=f"slope {arc}")
    for arc in range(len(axis.arcs))
    for side in (0, 1)
]
ground = iso.Mesh([(-30, 0, -30), (-30, 0, 30), (30, 0, 30), (30, 0, -30)], [(0, 1, 2, 3)])
scene = iso.Scene(
    [*roof, iso.Item(ground, iso.Matte("#8aa57d"), name="ground")],
    lights=[iso.RectLight(size=(4, 4), power=2500).at((-4, 12, 2)), iso.Sky("white", 0.4)],
    camera=iso.Camera(eye=(4.5, 8.5, 4.5), target=(3.7, 0, -2.9), fov_degrees=44),
)
