"""Four balls with relief: a normal map, bumps, a displaced surface, and one that is cut out.

The first two are smooth, as their rims show; light falls as if they were not. The third is moved in truth, and the
fourth lets light through its holes.

    isophote render examples/relief.py -o relief.png --size 800x300 --samples 256 --denoise
"""

import numpy as np

import isophote as iso


def studs(size: int = 128) -> iso.ImageTexture:
    """A normal map of a round stud: tangent-space normals of a height."""
    x, y = np.meshgrid(np.linspace(-1, 1, size), np.linspace(1, -1, size))
    height = 0.35 * np.sqrt(np.maximum(0.5 - x**2 - y**2, 0.0))
    down, across = np.gradient(height, -2 / (size - 1), 2 / (size - 1))
    normals = np.stack([-across, -down, np.ones_like(height)], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return iso.ImageTexture(((normals + 1) / 2).astype(np.float32), "linear")


def repeated(texture: iso.ImageTexture, across: int, up: int) -> iso.ImageTexture:
    """A picture that holds another several times."""
    return iso.ImageTexture(np.tile(texture.pixels, (up, across, 1)), "linear")


CLAY = iso.Plastic("peru", roughness=0.35)
BALL = iso.to_mesh(iso.sphere(1), cell=0.1)

scene = iso.Scene(
    items=[
        iso.Item(iso.plane(), iso.Matte(0.6)),
        iso.Item(iso.sphere(1).translate((-3.6, 1, 0)), iso.NormalMap(CLAY, repeated(studs(), 24, 12))),
        iso.Item(iso.sphere(1).translate((-1.2, 1, 0)), iso.Bump(CLAY, iso.PerlinNoise(size=0.12), 0.06)),
        iso.Item(
            BALL,
            CLAY,
            iso.Transform.identity().translate((1.2, 1, 0)),
            displacement=iso.Displacement(iso.Fbm(iso.PerlinNoise(size=0.7)), 0.7, midlevel=0.5),
        ),
        iso.Item(
            iso.sphere(1).translate((3.6, 1, 0)),
            iso.Cutout(iso.Matte("peru"), iso.Checker(0.0, 1.0, size=0.3), mode="mask"),
        ),
    ],
    lights=[iso.RectLight(size=(2, 2), radiance=(40, 37, 34)).at((-3, 6, 4), target=(0, 0, 0)), iso.Sky("white", 0.5)],
    camera=iso.Camera(eye=(0, 2.4, 11), target=(0, 0.9, 0), fov_degrees=19),
)
