"""One field, three meshes: surface nets, dual contouring, and dual contouring with flat cells merged.

Every triangle is drawn a little smaller than it is, so that the dark solid within shows between them. Surface nets
round the edges off; dual contouring keeps them; merged, the flat faces are left with a few large triangles.

    isophote render examples/meshed.py -o meshed.png --size 960x360 --samples 64
"""

import numpy as np

import isophote as iso

CELL = 1.5 / 22
PART = (iso.sphere(1) & iso.box(1.5)) - iso.cylinder(0.5) - iso.cylinder(0.5).along("x") - iso.cylinder(0.5).along("z")
WAYS = (
    ({"method": "surface-nets"}, "#b0643c"),
    ({"tolerance": 0}, "#5b8c6e"),
    ({"tolerance": 0.004}, "#4a76a8"),
)


def shown(mesh, gap=0.006):
    """The triangles of a mesh, each moved in by `gap` on its three sides."""
    corners = mesh.vertices[mesh.faces]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - np.roll(corners, -2, axis=1), axis=2, keepdims=True)
    around = sides.sum(axis=1)
    middle = (sides * corners).sum(axis=1) / around
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    # The circle within a triangle has the radius 2 area / sides.
    left = np.clip(1 - gap * around[:, 0] / np.maximum(area, 1e-12), 0, 1)
    smaller = middle[:, None] + (corners - middle[:, None]) * left[:, None, None]
    return iso.Mesh(smaller.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


def at(mesh, x):
    """The mesh, standing on the floor beside the others."""
    return mesh.with_(vertices=mesh.vertices + np.array([x, 0.76, 0]))


items = [iso.Item(iso.Mesh([(-9, 0, 9), (9, 0, 9), (9, 0, -9), (-9, 0, -9)], [(0, 1, 2, 3)]), iso.Matte("#d9d4cc"))]
for number, (way, colour) in enumerate(WAYS):
    x = 1.9 * (number - 1)
    items.append(iso.Item(at(shown(iso.to_mesh(PART, cell=CELL, **way)), x), iso.Matte(colour)))
    core = iso.to_mesh(PART.offset(-0.008), cell=CELL, **way)
    items.append(iso.Item(at(core, x), iso.Matte("#1c1c1e")))

scene = iso.Scene(
    items,
    lights=[iso.RectLight(size=(3, 3), power=160).at((3, 5, 3), target=(0, 0.5, 0)), iso.Sky("white", 0.5)],
    camera=iso.Camera(eye=(0, 3.2, 6), target=(0, 0.72, 0), fov_degrees=23),
)
