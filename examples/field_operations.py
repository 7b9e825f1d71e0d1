"""What can be done to fields: joined sharp, blended, rounded, chamfered; deformed; repeated.

isophote render examples/field_operations.py -o field_operations.png --size 960x600 --samples 64
"""

import math

import isophote as iso

BALL = iso.sphere(0.38).translate((0.22, 0.25, 0.2))
BLOCK = iso.box(0.75).translate((-0.1, -0.1, -0.1))
DRILL = iso.cylinder(0.2)

# Row by row, from the back.
FIELDS = [
    [
        BLOCK | BALL,
        BLOCK & iso.sphere(0.48),
        BLOCK - BALL,
        BLOCK.union(BALL, blend=0.25),
        BLOCK.difference(BALL, blend=0.2),
        BLOCK.union(BALL, chamfer=0.12),
    ],
    [
        (iso.box(0.85) - DRILL).round(0.1),
        iso.prism(6, 0.5, 0.8).chamfer(0.08),
        iso.sphere(0.5).shell(0.06) & iso.plane((0.6, 0.45, 0.8), 0.15),
        iso.octahedron(0.4).offset(0.12),
        iso.torus(0.3, 0.12).elongate((0.4, 0, 0)).along("z"),
        iso.sphere(0.42).displace(iso.waves(0.3), 0.05),
    ],
    [
        iso.box((0.55, 1, 0.3)).twist(math.pi / 2),
        iso.box((0.24, 1.7, 0.4)).rotate("y", 0.4).bend(1.6).translate((-0.3, 0, 0)),
        iso.prism(5, 0.5, 1).taper(0.3),
        iso.sphere(0.13).repeat((0.3, 0.3, 0.3), count=3),
        iso.capsule(0.09, 0.7).rotate("x", 0.4).translate((0.38, 0, 0)).repeat_around("y", 11),
        iso.box((0.5, 0.5, 0.16)).affine([[1, 0.5, 0, 0], [0, 1.4, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
    ],
]
COLOURS = ("#c8553d", "#e09f3e", "#588157", "#2a6f97", "#6d597a", "#b56576")

# So far apart, and so much further forward with each row.
ACROSS, FORWARD = 1.4, 1.7


def standing(field: iso.Field, column: float, row: float) -> iso.Field:
    """The field on the ground."""
    return field.translate((column * ACROSS, -field.bounds[0, 1], row * FORWARD))


items = [
    iso.Item(standing(field, column - 2.5, row - 1), iso.Matte(colour))
    for row, line in enumerate(FIELDS)
    for column, (field, colour) in enumerate(zip(line, COLOURS[2 * row :] + COLOURS[: 2 * row], strict=True))
]
scene = iso.Scene(
    items=[*items, iso.Item(iso.plane(), iso.Matte(0.45))],
    lights=[iso.RectLight(size=(4, 4), radiance=19).at((-5, 7, 4), target=(0, 0, 0)), iso.Sky("white", 0.5)],
    camera=iso.Camera(eye=(0, 6.4, 9.2), target=(0, 0.4, -0.1), fov_degrees=31),
)
