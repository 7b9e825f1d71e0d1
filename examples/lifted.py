"""Solids from outlines: text drawn out, a profile turned into a vase, a star swept along a spring, a NumPy function.

All are signed distance fields; none is made of triangles.

    isophote render examples/lifted.py -o lifted.png --size 640x360
"""

import math
from itertools import pairwise

import numpy as np

import isophote as iso

# The wall of a vase, right of the axis: a stroke along a curve, closed below by a disc.
PROFILE = [(0.34 + 0.14 * math.sin(3.6 * t + 2.6) * (1.25 - t), 0.06 + 1.1 * t) for t in np.linspace(0, 1, 13)]


def gyroid(p):
    """A wall along the surface sin x cos y + sin y cos z + sin z cos x = 0, whose slope is √3 at most."""
    q = p * 14
    wave = np.sum(np.sin(q) * np.cos(q[:, [1, 2, 0]]), axis=1)
    return np.abs(wave) / (14 * math.sqrt(3)) - 0.017


def spring(t):
    """Two turns and a half, 0.9 m wide at the bottom and 0.6 m at the top."""
    angle, reach = 2.5 * math.tau * t, 0.45 - 0.15 * t
    return reach * math.cos(angle), 0.1 + 0.95 * t, reach * math.sin(angle)


wall = iso.union(*(iso.segment(a, b, 0.025) for a, b in pairwise(PROFILE)))
vase = (wall | iso.segment((0, 0.03), PROFILE[0], 0.03)).revolve()
letters = iso.text("lifted", size=0.62, align="centre").extrude(0.14)
sponge = iso.field(gyroid, lipschitz=1.0) & iso.sphere(0.5)
coil = iso.star(5, 0.1, 0.05).sweep(spring, samples=48)

scene = iso.Scene(
    items=[
        iso.Item(iso.plane(), iso.Matte("#b8b0a2")),
        iso.Item(letters.translate((0, 0, 1.35)), iso.Matte("#c2502f")),
        iso.Item(vase.translate((-1.2, 0, 0.1)), iso.Matte("#3f6f8f")),
        iso.Item(sponge.translate((0, 0.52, -0.1)), iso.Matte("#e0c068")),
        iso.Item(coil.translate((1.2, 0, 0.1)), iso.Matte("#d9a032")),
    ],
    lights=[iso.RectLight(size=(2, 2), power=100).at((-2.5, 4, 3), target=(0, 0.4, 0)), iso.Sky("#c9dcf2", 0.6)],
    camera=iso.Camera(eye=(0.5, 2.3, 5.4), target=(0, 0.45, 0.35), fov_degrees=27),
    name="Lifted",
)

if __name__ == "__main__":
    iso.render(scene, iso.PathTrace(samples=64), size=(640, 360), seed=1).save("lifted.png")
