"""Whitted's picture of 1979 again: a glass ball and a mirror over a checkered floor, by trees of rays.

Run as a program, it also draws penumbras by one, four and sixty-four shadow rays, three kinds of spots, and a drink
with ice, whose glass, liquid and ice lie within each other, with shadows that are opaque and tinted.

    isophote render examples/ray_tracing.py -o whitted.png --method ray --size 640x360
    isophote render examples/ray_tracing.py -o whitted.png --method path --samples 256
"""

import numpy as np

import isophote as iso

SQUARES = np.array([[(0.9, 0.75, 0.1), (0.7, 0.06, 0.04)], [(0.7, 0.06, 0.04), (0.9, 0.75, 0.1)]], np.float32)
FLOOR = iso.Mesh(
    [(-12, 0, 4), (12, 0, 4), (12, 0, -20), (-12, 0, -20)],
    [(0, 1, 2, 3)],
    attributes={"uv": [(0, 0), (12, 0), (12, 12), (0, 12)]},
)

scene = iso.Scene(
    items=[
        iso.Item(FLOOR, iso.Matte(iso.ImageTexture(SQUARES, filter="nearest")), name="floor"),
        iso.Item(iso.sphere(0.75), iso.Glass(1.5)).translate((-0.35, 1.25, 0.6)),
        iso.Item(iso.sphere(0.8), iso.Mirror((0.8, 0.8, 0.85))).translate((1.15, 0.95, -0.9)),
    ],
    lights=[
        iso.Sky((0.22, 0.33, 0.5), 0.8),
        iso.SphereLight(radius=0.5, power=2600, colour="#fff0d8").at((-5, 9, 6)),
    ],
    camera=iso.Camera(eye=(0, 1.5, 6.5), target=(0.25, 0.95, 0), fov_degrees=30),
    name="After Whitted",
)


def panels(*scenes_and_methods, size, seed=1):
    """Pictures side by side."""
    images = [iso.render(view, method, size=size, seed=seed) for view, method in scenes_and_methods]
    return iso.Image({"colour": np.concatenate([image.channels["colour"] for image in images], axis=1)})


def penumbras():
    """A ball under a square light, by more and more shadow rays."""
    view = iso.Scene(
        [iso.Item(iso.plane(), iso.Matte(0.7)), iso.Item(iso.sphere(0.5), iso.Matte("tomato")).translate((0, 0.7, 0))],
        [iso.RectLight(size=(1.2, 1.2), power=80).at((-1.2, 3, 0.6), target=(0, 0.5, 0)), iso.Sky("white", 0.12)],
        iso.Camera((0, 2.2, 4), (0.1, 0.35, 0), fov_degrees=32),
    )
    counts = (1, 4, 64)
    return panels(*((view, iso.RayTrace(samples=4, light_samples=n)) for n in counts), size=(260, 200))


def spots():
    """Hard by a cone, smooth between two, soft by the power of the cosine."""
    kinds = ({"cone_degrees": 34}, {"cone_degrees": 48, "inner_degrees": 14}, {"cone_degrees": 180, "exponent": 40})
    lights = [
        iso.SpotLight.of_intensity((x, 2.4, 0.9), 16, target=(x, 0.4, 0), **kind)
        for x, kind in zip((-1.4, 0, 1.4), kinds, strict=True)
    ]
    wall = iso.Item(iso.plane((0, 0, 1)), iso.Matte("linen")).translate((0, 0, -0.3))
    return iso.Scene(
        [iso.Item(iso.plane(), iso.Matte(0.5)), wall],
        [*lights, iso.Sky("white", 0.04)],
        iso.Camera((0, 1.3, 5.2), (0, 0.75, 0), fov_degrees=26),
    )


def drink():
    """Liquid that reaches a hair into its glass, and ice that sticks out of it: the higher priority is there."""
    glass = iso.cylinder(0.42, 1.0) - iso.cylinder(0.37, 1.0).translate((0, 0.06, 0))
    liquid = iso.cylinder(0.372, 0.66).translate((0, -0.111, 0))
    ice = iso.box(0.3).round(0.03)
    tea = iso.Glass.tinted((0.85, 0.42, 0.1), at=0.3, ior=1.33)
    return iso.Scene(
        [
            iso.Item(iso.plane(), iso.Matte(0.75)),
            iso.Item(glass, iso.Glass(1.5, priority=2)).translate((0, 0.501, 0)),
            iso.Item(liquid, tea).translate((0, 0.501, 0)),
            iso.Item(ice, iso.Glass(1.31, priority=1)).rotate("x", 0.5).rotate("y", 0.4).translate((0.08, 0.72, 0.05)),
        ],
        [iso.SphereLight(radius=0.15, power=120).at((-2.2, 3.2, -1.2)), iso.Sky("white", 0.45)],
        iso.Camera((0, 1.35, 3.2), (0.1, 0.42, 0), fov_degrees=30),
    )


if __name__ == "__main__":
    iso.render(scene, iso.RayTrace(light_samples=8), size=(560, 315), seed=1).save("whitted.png")
    penumbras().save("penumbras.png")
    iso.render(spots(), iso.RayTrace(), size=(640, 240), seed=1).save("spots.png")
    methods = [iso.RayTrace(depth=24, shadows=shadows) for shadows in ("opaque", "tinted")]
    panels(*((drink(), method) for method in methods), size=(300, 260)).save("drink.png")
