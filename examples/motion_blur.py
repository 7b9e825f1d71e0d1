"""Motion blur: a wheel that rolls past, and a ball that falls, while the shutter is open for a thirtieth of a second.

An item's `transform` may be a `Motion`, placements by their times in seconds; the camera's `shutter` says when it opens
and closes. Where the wheel touches the ground it stands still, as every rolling wheel does, and its spokes are sharp.

    isophote render examples/motion_blur.py -o motion_blur.png --size 640x360 --samples 256
"""

import math

import numpy as np

import isophote as iso

RADIUS, SPEED, GRAVITY = 0.5, 4.5, 9.81
SHUTTER = (0.0, 1 / 30)
AT_REST = iso.Transform.identity()


def rolling(part):
    """Motion of a part of the wheel about its hub, along +X at SPEED: it turns by the way over the radius."""
    return iso.Motion(
        (t, part.rotate("z", -SPEED * t / RADIUS).translate((-0.65 + SPEED * t, RADIUS, 0)))
        for t in np.linspace(*SHUTTER, 9)
    )


def falling(top):
    """Motion of what was let go above `top` half a second before the shutter opens."""
    return iso.Motion(
        (t, AT_REST.translate((0.85, top - GRAVITY * ((t + 0.5) ** 2 - 0.25) / 2, 0.2)))
        for t in np.linspace(*SHUTTER, 9)
    )


paint, rubber = iso.Matte("steelblue"), iso.Matte(0.04)
spokes = [
    iso.Item(iso.cylinder(0.016, 2 * RADIUS - 0.08), paint, rolling(AT_REST.rotate("z", k * math.pi / 6)))
    for k in range(6)
]
wheel = [
    iso.Item(iso.torus(RADIUS - 0.035, 0.035), rubber, rolling(AT_REST.rotate("x", math.pi / 2))),
    iso.Item(iso.cylinder(0.05, 0.14), paint, rolling(AT_REST.rotate("x", math.pi / 2))),
    *spokes,
]
ball = iso.Item(iso.sphere(0.16), iso.Plastic("orangered", roughness=0.4), falling(0.75))
ground = iso.Item(iso.Mesh([(-30, 0, 30), (30, 0, 30), (30, 0, -30), (-30, 0, -30)], [(0, 1, 2, 3)]), iso.Matte(0.4))

scene = iso.Scene(
    items=[ground, ball, *wheel],
    lights=[iso.Sun((-2, 5, 3), irradiance=2.2), iso.Sky("aliceblue", 0.6)],
    camera=iso.Camera(eye=(0.0, 0.9, 4.6), target=(0.0, 0.5, 0), fov_degrees=17, shutter=SHUTTER),
    name="Motion blur",
)

if __name__ == "__main__":
    iso.render(scene, iso.PathTrace(samples=256), size=(640, 360), seed=1).save("motion_blur.png")
