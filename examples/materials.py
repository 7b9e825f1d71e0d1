"""Fifteen balls, a material each, in three rows of five: from matte at the front to metals at the back.

Colours and numbers of a material may be textures, as the floor's are. Brushed metal is rougher one way than the other.

    isophote render examples/materials.py -o materials.png --size 800x450 --samples 256
"""

import numpy as np

import isophote as iso

MATERIALS = [
    # The front row: matte, rough matte, and the classic highlights.
    iso.Matte("tomato"),
    iso.OrenNayar("tomato", roughness=1),
    iso.Phong("tomato", specular=0.2, exponent=40),
    iso.Blinn("tomato", specular=0.2, exponent=160),
    iso.Ward("tomato", specular=0.3, roughness=(0.55, 0.25)),
    # The middle: clear coats and clear bodies.
    iso.Plastic("royalblue", roughness=0),
    iso.Plastic("royalblue", roughness=0.4),
    iso.Glass(1.5),
    iso.Glass(1.5, roughness=0.35),
    iso.Mix(iso.Metal("silver", roughness=0.1), iso.Matte("darkslateblue"), amount=0.5),
    # The back: metals, brushed around their axes and lacquered.
    iso.Metal("gold", roughness=0.1),
    iso.Metal("gold", roughness=0.5),
    iso.Metal("copper", roughness=(0.6, 0.2)),
    iso.Coated(iso.Metal("copper", roughness=0.6)),
    iso.Principled("seagreen", metallic=0.6, roughness=0.35),
]


def floor(reach, squares=28):
    """A square floor with a chequered texture."""
    corners = [(-reach, 0, reach), (reach, 0, reach), (reach, 0, -reach), (-reach, 0, -reach)]
    tiles = np.array([[(168, 164, 156), (104, 104, 108)], [(104, 104, 108), (168, 164, 156)]], np.uint8)
    square = np.array([(0, 0), (squares, 0), (squares, squares), (0, squares)]) / 2
    material = iso.Plastic(iso.ImageTexture(tiles, filter="nearest"), roughness=0.45)
    return iso.Item(iso.Mesh(corners, [(0, 1, 2, 3)], attributes={"uv": square}), material)


ball = iso.sphere(0.5)
scene = iso.Scene(
    items=[
        floor(9),
        *(iso.Item(ball, m).translate((1.2 * (k % 5 - 2), 0.5, -1.5 * (k // 5))) for k, m in enumerate(MATERIALS)),
    ],
    lights=[
        iso.RectLight(size=(2.5, 2.5), power=200).at((-3.5, 4.5, 2.5), target=(0, 0.4, -1)),
        iso.RectLight(size=(0.8, 3), power=90, colour="#ffd9b0").at((4, 2.5, 0), target=(0, 0.4, -1)),
        iso.Sky("white", 0.55),
    ],
    camera=iso.Camera(eye=(0, 4.6, 6.2), target=(0, 0.3, -1.35), fov_degrees=30),
)
