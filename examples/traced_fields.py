"""Fields path-traced and sphere-traced: a blended body, a pierced one of glass and a twisted one, on an endless floor.

Nothing is meshed. Run as a program, it also draws the look of real-time renderers, how many steps each ray took, and a
wall that fixed steps miss.

    isophote render examples/traced_fields.py -o fields.png --size 640x360 --samples 256
    isophote render examples/traced_fields.py -o quick.png --method sphere
"""

import numpy as np

import isophote as iso

drops = iso.union(
    *(iso.sphere(0.26 - 0.03 * k).translate((0.15 * np.cos(2 * k), 0.24 * k, 0.15 * np.sin(2 * k))) for k in range(5)),
    blend=0.15,
)
pierced = (iso.sphere(0.5) & iso.box(0.76)) - iso.cylinder(0.24) - iso.cylinder(0.24).along("x")
column = iso.box((0.42, 1.1, 0.42)).round(0.04).twist(1.6)

scene = iso.Scene(
    items=[
        iso.Item(iso.plane(), iso.Matte((0.62, 0.6, 0.56))),
        iso.Item(drops, iso.Matte("tomato")).translate((-1.15, 0.25, 0)),
        iso.Item(pierced, iso.Glass(1.5)).rotate("y", 0.5).translate((0, 0.381, 0.45)),
        iso.Item(column, iso.Matte((0.25, 0.45, 0.7))).translate((1.1, 0.6, -0.1)),
    ],
    lights=[
        iso.RectLight(size=(1.6, 1.6), power=130).at((-2.5, 3.5, 2.5), target=(0, 0.4, 0)),
        iso.Sky("lightsteelblue", 0.5),
    ],
    camera=iso.Camera(eye=(0, 1.5, 4.6), target=(0, 0.42, 0), fov_degrees=30),
    name="Traced fields",
)


def heat(steps, most):
    """Colours from dark over red to white for counts up to `most`."""
    t = np.clip(steps / most, 0, 1)[..., None]
    return np.clip(t * np.array([3.0, 3.0, 3.0]) - np.array([0.0, 1.0, 2.0]), 0, 1) ** 2.2


def side_by_side(*pictures):
    """Pictures of one height as one."""
    return iso.Image({"colour": np.concatenate(pictures, axis=1)})


if __name__ == "__main__":
    size = (420, 260)
    iso.render(scene, iso.PathTrace(samples=256), size=(560, 315), seed=1).save("traced_fields.png")
    quick = iso.render(scene, iso.SphereTrace(), size=size)
    side_by_side(quick.channels["colour"], heat(quick.channels["steps"], 90)).save("sphere_traced.png")

    wall = iso.Scene(
        [iso.Item(iso.plane()), iso.Item(iso.box((1.6, 1, 0.01)), iso.Matte("tomato")).translate((0, 0.5, 0))],
        lights=[iso.Sun((1, 2, 1), 3.0), iso.Sky("white", 0.4)],
        camera=iso.Camera((0.8, 1.5, 3.2), (0, 0.45, 0), fov_degrees=32),
    )
    methods = (
        iso.SphereTrace(shadows="hard"),
        iso.SphereTrace(marcher="fixed", step=0.03, max_steps=2000, shadows="hard"),
    )
    side_by_side(*(iso.render(wall, m, size=size).channels["colour"] for m in methods)).save("thin_wall.png")
