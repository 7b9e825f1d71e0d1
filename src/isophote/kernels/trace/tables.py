"""All tables of a scene together, and the plan of a picture: what every rendering kernel is given."""

from __future__ import annotations

from isophote.kernels.accel.field_layout import FIELDS
from isophote.kernels.accel.geometry import GEOMETRY
from isophote.kernels.accel.surface import SURFACES
from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT_ROWS, FLOATS, INT, LONGS, Table
from isophote.kernels.light.bsdf import MATERIALS
from isophote.kernels.light.emitter import LIGHTS
from isophote.kernels.light.medium import MEDIA
from isophote.kernels.primitive.layout import PRIMITIVES
from isophote.kernels.texture.contract import TEXTURES

__all__ = ["FILM", "PLAN", "SCENE"]

# A lowered scene; `camera` (10, 3), see camera.py.
SCENE = Table(
    "Scene",
    geometry=GEOMETRY,
    surfaces=SURFACES,
    fields=FIELDS,
    primitives=PRIMITIVES,
    materials=MATERIALS,
    media=MEDIA,
    textures=TEXTURES,
    lights=LIGHTS,
    camera=FLOAT_ROWS,
)

# How a picture is sampled: its size, the samples planned for a pixel, seed, pattern (sampler.py), reconstruction filter
# (film.py), media that the camera stands in (medium.py), longest path in rays, and the number of rays after which paths
# may end by chance.
PLAN = Table(
    "Plan",
    width=INT,
    height=INT,
    samples=INT,
    seed=INT,
    pattern=INT,
    offsets=FLOATS,
    crossings=FLOATS,
    inside=INT,
    max_depth=INT,
    roulette_depth=INT,
)

# Sums over the samples of each pixel, row by row: `total`, `squares` (pixels, 3), `count` (pixels,), and as much again
# for the samples where the filter is negative, if it ever is. `target` (pixels,): how many samples a pixel shall have.
FILM = Table("Film", total=DOUBLE_BOXES, squares=DOUBLE_BOXES, count=LONGS, target=LONGS)
