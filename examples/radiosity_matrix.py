"""The older ways of radiosity: even patches, and light between all pairs of them.

Run as a program, it draws one room by gathering, with form factors by rays, by half cubes and by hemispheres; and by
shooting, as light is sent, until all of it is.

    isophote render examples/radiosity_matrix.py -o room.png --method radiosity --solver shooting --patch 0.25
"""

import numpy as np

import isophote as iso


def wall(*corners):
    """One parallelogram."""
    return iso.Mesh(corners, [(0, 1, 2, 3)])


GREY, ORANGE, GREEN = iso.Matte((0.7, 0.7, 0.7)), iso.Matte((0.7, 0.3, 0.05)), iso.Matte((0.15, 0.4, 0.2))

scene = iso.Scene(
    items=[
        iso.Item(wall((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)), GREY, name="floor"),
        iso.Item(wall((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)), GREY, name="ceiling"),
        iso.Item(wall((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)), GREY, name="back"),
        iso.Item(wall((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)), ORANGE, name="left"),
        iso.Item(wall((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)), GREEN, name="right"),
        iso.Item(wall((-0.6, 0, -0.3), (0.2, 0, -0.5), (0.2, 1, -0.5), (-0.6, 1, -0.3)), GREY, name="screen"),
    ],
    lights=[iso.RectLight(size=(0.5, 0.5), radiance=(14, 13, 11)).at((0.4, 1.98, 0.1))],
    camera=iso.Camera((0, 1, 4.3), (0, 1, 0), fov_degrees=34),
    name="A room by the matrix of form factors",
)


def gathered():
    """The room by each kind of form factors."""
    for kind in ("rays", "hemicube", "hemisphere"):
        method = iso.Radiosity(patch=0.25, method="gathering", form_factors=kind, directions=1024, residual=1e-3)
        yield iso.radiosity(scene, method, progress=False), None


def shot():
    """The room when half of the light is sent, three quarters of it, and next to all."""
    method = iso.Radiosity(patch=0.25, method="shooting", residual=1e-3)
    found = iso.radiosity(scene, method, progress=False)
    for step in (2, 4, found.bounce_count):
        yield found, step


def row(solutions):
    """Their pictures side by side."""
    images = (found.image(scene.camera, (200, 200), bounce=step) for found, step in solutions)
    return np.concatenate([image.channels["colour"] for image in images], axis=1)


if __name__ == "__main__":
    sheet = np.concatenate([row(gathered()), row(shot())])
    iso.Image({"colour": sheet}).save("radiosity_matrix.png")
