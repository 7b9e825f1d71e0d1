"""The tables that a sphere-traced picture crosses into kernels by."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.table import FLOAT, FLOAT_ROWS, FLOATS, INT, INT_ROWS, Table

__all__ = ["END", "LEFT", "MARCH", "SHADOW_DIRECTION", "SHADOW_START", "SHADOW_WORDS", "SPHERE_PICTURE"]

# How rays are followed: most steps and distance, factor on steps, parts of a pixel's width at which they have arrived,
# length of fixed steps (0: sphere tracing), kind of shadows, tangent of the half angle of lights without a size, and
# how far occlusion reaches (0: not at all). `lights` (n, 13), see sphere_lights.py. The entries of sphere_holes.py, 0
# where nothing is cut out.
MARCH = Table(
    "March",
    max_steps=INT,
    max_distance=FLOAT,
    relaxation=FLOAT,
    epsilon=FLOAT,
    step=FLOAT,
    shadows=INT,
    light_width=FLOAT,
    occlusion=FLOAT,
    lights=FLOAT_ROWS,
    pass_holes=INT,
    light_left=INT,
)
# Channels (height, channels · width), and scratch: of the trees and entries, of sixteen rays, of sixteen pixels, and of
# a shadow ray.
SPHERE_PICTURE = Table(
    "SpherePicture",
    colour=FLOAT_ROWS,
    depth=FLOAT_ROWS,
    distance=FLOAT_ROWS,
    normal=FLOAT_ROWS,
    albedo=FLOAT_ROWS,
    uv=FLOAT_ROWS,
    item=INT_ROWS,
    primitive=INT_ROWS,
    steps=INT_ROWS,
    scratch=FLOATS,
    lanes=FLOATS,
    pixels=FLOATS,
    shadow=FLOATS,
)
# Words of `shadow`: where the ray starts, its unit direction, where it ends, and what is left of its light.
SHADOW_START, SHADOW_DIRECTION, END, LEFT = np.int64(0), np.int64(3), np.int64(6), np.int64(7)
SHADOW_WORDS = 8
