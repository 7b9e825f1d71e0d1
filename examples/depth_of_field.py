"""A thin lens: a row of blocks, of which the third is sharp.

`lens_radius` opens the lens, and what is as far as the camera's target is sharp; `focus_distance` names another
distance. A wide lens needs more samples.

    isophote render examples/depth_of_field.py -o lens.png --size 640x360 --samples 256
"""

import numpy as np

import isophote as iso


def block(width, height):
    """A closed box that stands on the floor, its base centred at the origin."""
    half = width / 2
    base = np.array([(-half, 0, -half), (-half, 0, half), (half, 0, half), (half, 0, -half)])
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return iso.Mesh(np.concatenate([base, base + np.array([0, height, 0])]), faces)


PLACES = np.array([(-1.0, 0, 1.6), (-0.5, 0, 0.6), (0.0, 0, -0.6), (0.7, 0, -2.2), (1.7, 0, -4.6)])
COLOURS = ("crimson", "darkorange", "gold", "seagreen", "steelblue")

column = block(0.5, 1.0)
ground = iso.Mesh([(-40, 0, 40), (40, 0, 40), (40, 0, -40), (-40, 0, -40)], [(0, 1, 2, 3)])
columns = [
    iso.Item(column, iso.Matte(colour)).rotate("y", 0.5).at(place)
    for colour, place in zip(COLOURS, PLACES, strict=True)
]

scene = iso.Scene(
    items=[iso.Item(ground, iso.Matte(0.6)), *columns],
    lights=[iso.RectLight(size=(3, 3), power=280).at((-4, 5, 3), target=(0, 0, 0)), iso.Sky("aliceblue", 0.5)],
    camera=iso.Camera(eye=(0, 1.1, 5), target=PLACES[2] + (0, 0.5, 0.3), fov_degrees=30, lens_radius=0.09),
    name="Depth of field",
)

if __name__ == "__main__":
    iso.render(scene, iso.PathTrace(samples=256), size=(640, 360), seed=1).save("lens.png")
