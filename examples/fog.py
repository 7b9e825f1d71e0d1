"""Light in fog: two lamps shine from above into haze, one of them through a row of bars.

`Scene(medium=iso.Medium(scattering, absorption, anisotropy))` fills the air; what the lamps send through it is seen
from the side, and shadows stand in it as shafts. Path tracing alone shows it.

    isophote render examples/fog.py -o fog.png --size 640x360 --samples 512
"""

import isophote as iso


def wall(*corners):
    """A flat wall through corners."""
    return iso.Mesh(corners, [tuple(range(len(corners)))])


floor = wall((-4, 0, 3), (4, 0, 3), (4, 0, -3), (-4, 0, -3))
back = wall((-4, 0, -3), (4, 0, -3), (4, 4, -3), (-4, 4, -3))
# A screen with gaps between its bars, in the light of the first lamp.
bars = [iso.Item(iso.box((0.18, 3, 0.05)).translate((-1.6 + 0.45 * k, 1.9, -1.2)), iso.Matte(0.2)) for k in range(5)]

scene = iso.Scene(
    items=[
        iso.Item(floor, iso.Matte(0.35)),
        iso.Item(back, iso.Matte(0.3)),
        iso.Item(iso.sphere(0.55).translate((1.5, 0.55, 0.2)), iso.Matte("tomato")),
        *bars,
    ],
    lights=[
        iso.SpotLight((-2.2, 3.6, -2.6), 150, target=(-0.6, 0.4, 1.6), cone_degrees=50, colour=(1, 0.85, 0.6)),
        iso.SpotLight((3.2, 3.6, 0.2), 70, target=(1.4, 0.4, 0.2), cone_degrees=26, colour=(0.5, 0.75, 1)),
    ],
    camera=iso.Camera(eye=(0, 1.5, 7.5), target=(0, 1.45, 0), fov_degrees=32),
    name="Fog",
    medium=iso.Medium(scattering=0.09, absorption=0.01, anisotropy=0.4, bounds=[(-4, 0, -3), (4, 3.2, 4)]),
)

if __name__ == "__main__":
    iso.render(scene, iso.PathTrace(samples=512), size=(640, 360), seed=1).save("fog.png")
