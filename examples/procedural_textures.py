"""Solids of marble, wood and patina on a marble floor: textures that are formulas, carved from whole blocks.

Run as a program, it draws a sheet of all kinds of textures, texture_kinds.png.

    isophote render examples/procedural_textures.py -o marble.png --size 640x360 --samples 64 --denoise
"""

import numpy as np

import isophote as iso

DARK = [(0, "#d8d4c8"), (0.05, "#5a5a5c"), (0.2, "#26272b"), (1, "#141518")]
GREEN = [(0, "#e9efe2"), (0.06, "#9db89a"), (0.25, "#3d6b52"), (0.6, "#1f4a38"), (1, "#143528")]

marble = iso.Marble(size=0.45)
green = iso.Marble(GREEN, size=0.3, turbulence=2.5, seed=4)
floor = iso.Checker(iso.Marble(size=0.6, seed=7), iso.Marble(DARK, size=0.6, seed=9, clouds=0), size=0.6)
# A board is cut from beside the middle of the trunk, so that its rings are seen as arches.
board = iso.Transform.identity().rotate("x", np.pi / 2 - 0.12).translate((0.12, -0.2, 0))
oak = iso.Wood(size=0.055, wavering=1.2, transform=board)
walnut = iso.Wood("#8a5a3a", "#41240f", size=0.025, wavering=1)
weathered = iso.Ramp(iso.Fbm(iso.PerlinNoise(size=0.35, seed=5), octaves=8), [(0.49, 0), (0.56, 1)], "smooth")
verdigris = iso.Ramp(iso.Fbm(iso.PerlinNoise(size=0.1)), [(0.35, "#2f6f62"), (0.65, "#7fb8a2")])
cracks = iso.WorleyNoise(size=0.16, feature="f2-f1", seed=3)
clay = iso.Ramp(cracks, [(0.0, "#2b1a12"), (0.06, "#54341f"), (0.14, "#b98a5c"), (0.6, "#d6ad7b")])

bowl = (iso.sphere(0.42).shell(0.035) & iso.box((1, 0.42, 1)).translate((0, -0.21, 0))).translate((0, 0.44, 0))
column = iso.cylinder(0.2, 0.9).translate((0, 0.45, 0)) | iso.rounded_box((0.56, 0.1, 0.56), 0.02).translate(
    (0, 0.95, 0)
)

scene = iso.Scene(
    items=[
        iso.Item(iso.plane(), iso.Plastic(floor, roughness=0.15)),
        iso.Item(iso.sphere(0.45), iso.Plastic(marble, roughness=0.1)).at((-0.25, 0.45, 0.1)),
        iso.Item(bowl, iso.Plastic(walnut, roughness=0.3)).at((0.85, 0, 0.55)),
        iso.Item(iso.rounded_box((0.9, 0.5, 0.6), 0.03), iso.Plastic(oak, roughness=0.35))
        .rotate("y", 0.5)
        .at((-1.35, 0.25, 0.2)),
        iso.Item(column, iso.Plastic(green, roughness=0.12)).at((0.75, 0, -0.75)),
        iso.Item(iso.sphere(0.28), iso.Mix(iso.Metal("copper", roughness=0.25), iso.Matte(verdigris), weathered)).at(
            (0.75, 1.28, -0.75)
        ),
        iso.Item(iso.torus(0.3, 0.12), iso.Matte(clay)).at((-1.32, 0.62, 0.2)),
    ],
    lights=[
        iso.RectLight(size=(2, 2), power=170).at((-3, 4, 2.5), target=(0, 0.4, 0)),
        iso.Sky("#e6eeff", 0.4),
    ],
    camera=iso.Camera(eye=(0.4, 1.65, 4.1), target=(-0.1, 0.5, -0.1), fov_degrees=36),
    name="Solid textures",
)

SMALL = iso.Transform.identity().scale(1 / 6)
HEAT = [(0.3, "#1b1340"), (0.45, "#a1263c"), (0.55, "#f28f3b"), (0.7, "#fff3c4")]
RINGS = (iso.sphere(0.3).translate((0.35, 0.5, 0)) | iso.box(0.35).translate((0.7, 0.55, 0))).shell(0.02)
ISOLINES = [(0, "#20456e"), (0.12, "#20456e"), (0.12, "#e8eef5"), (1, "#9fc3e6")]

KINDS = [
    iso.Checker("tomato", "white", transform=SMALL),
    iso.Stripes("navy", "white", transform=SMALL, share=0.3),
    iso.Grid("black", "lightyellow", axes="xy", transform=SMALL),
    iso.Gradient(["gold", "tomato", "navy"], axis=(1, 1, 0), size=1.4),
    iso.Gradient(
        ["tomato", "gold", "teal", "tomato"],
        "angular",
        "z",
        transform=iso.Transform.identity().translate((0.5, 0.5, 0)),
    ),
    iso.Ramp(
        iso.Waves("radial", axis="z", distortion=iso.PerlinNoise(), amount=0.7, transform=SMALL), ["teal", "white"]
    ),
    iso.ValueNoise(transform=SMALL),
    iso.PerlinNoise(transform=SMALL),
    iso.SimplexNoise(transform=SMALL),
    iso.WorleyNoise(transform=SMALL),
    iso.WorleyNoise(feature="f2-f1", transform=SMALL),
    iso.WorleyNoise(feature="cell", metric="manhattan", transform=SMALL),
    iso.Fbm(transform=SMALL),
    iso.Fbm(kind="turbulence", transform=SMALL),
    iso.Fbm(kind="ridged", transform=SMALL),
    iso.Ramp(iso.Fbm(transform=SMALL), HEAT),
    iso.FieldTexture(RINGS, ISOLINES, period=0.1),
    iso.Formula(lambda p: 0.5 + 0.5 * np.sin(40 * p[:, 0] + 4 * np.sin(12 * p[:, 1])), ["indigo", "plum", "white"]),
]


def sheet(kinds, columns=6, edge=120, gap=4):
    """Pictures of textures in rows, white lines between them."""
    rows = -(-len(kinds) // columns)
    picture = np.ones((rows * (edge + gap) - gap, columns * (edge + gap) - gap, 3), np.float32)
    for k, texture in enumerate(kinds):
        y, x = (edge + gap) * np.array(divmod(k, columns))
        picture[y : y + edge, x : x + edge] = iso.bake_texture(texture, size=edge).pixels
    return iso.Image({"colour": picture})


if __name__ == "__main__":
    sheet(KINDS).save("texture_kinds.png")
