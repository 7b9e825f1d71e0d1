"""Every solid primitive on the ground, which is one too.

isophote render examples/solids.py -o solids.png --size 960x600 --samples 64
"""

import isophote as iso

# Row by row, from the back.
SOLIDS = [
    [
        iso.sphere(0.5),
        iso.ellipsoid((0.55, 0.5, 0.3)),
        iso.box((0.8, 1, 0.6)),
        iso.rounded_box((0.8, 1, 0.6), 0.15),
        iso.frame((0.8, 1, 0.8), 0.1),
        iso.cylinder(0.45, 1),
    ],
    [
        iso.capsule(0.35, 1),
        iso.cone(0.5, 1),
        iso.cone(0.5, 1, 0.25),
        iso.rounded_cone(0.4, 0.18, 1),
        iso.torus(0.4, 0.15).along("z"),
        iso.capped_torus(0.42, 0.12, 4.2).along("z").rotate("z", 1.57),
    ],
    [
        iso.link(0.25, 0.1, 1),
        iso.prism(3, 0.55, 0.8),
        iso.prism(6, 0.5, 0.8),
        iso.pyramid(0.9, 1),
        iso.octahedron(0.55),
        iso.slab(0.3) & iso.cylinder(0.5),
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
    for row, line in enumerate(SOLIDS)
    for column, (field, colour) in enumerate(zip(line, COLOURS[2 * row :] + COLOURS[: 2 * row], strict=True))
]
scene = iso.Scene(
    items=[*items, iso.Item(iso.plane(), iso.Matte(0.45))],
    lights=[iso.RectLight(size=(4, 4), radiance=19).at((-5, 7, 4), target=(0, 0, 0)), iso.Sky("white", 0.5)],
    camera=iso.Camera(eye=(0, 6.4, 9.2), target=(0, 0.4, -0.1), fov_degrees=31),
)
