"""Every ray against every triangle, or every thing: the smallest accelerator, by which the others are tested."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.contract import (
    add_counts,
    answer,
    any_in_blocks,
    closest_in_blocks,
    nearest_of,
    ray_at,
    ray_direction,
    ray_origin,
)
from isophote.kernels.accel.layout import BLOCK
from isophote.kernels.accel.things import enough, test_thing, things_of
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.table import INT, Table
from isophote.kernels.forms.triangle import shear

__all__ = ["BRUTE", "any_of_all", "closest_of_all", "things_of_all"]

# `triangles`: how many there are, or how many things.
BRUTE = Table("Brute", triangles=INT)
open_brute = opener_at(BRUTE)

_FIRST = np.int64(0)
# Things are tested one by one, whatever their boxes.
_NO_BOXES = np.float32(0)


@entry
def closest_of_all(tables, blocks, ray):
    count, words = open_brute(tables).triangles, ray_at(ray)
    triangles = floats_at(blocks, count * BLOCK)
    sheared = shear(ray_origin(words), ray_direction(words))
    nearest = closest_in_blocks(triangles, _FIRST, count, sheared, nearest_of(words), words)
    add_counts(words, 0, count, 0)
    return answer(words, nearest)


@entry
def any_of_all(tables, blocks, ray):
    count, words = open_brute(tables).triangles, ray_at(ray)
    triangles = floats_at(blocks, count * BLOCK)
    sheared = shear(ray_origin(words), ray_direction(words))
    add_counts(words, 0, count, 0)
    return np.int64(any_in_blocks(triangles, _FIRST, count, sheared, nearest_of(words).t))


@entry
def things_of_all(tables, blocks, ray, test, subject, any_will_do):
    words = ray_at(ray)
    things, nearest = things_of(ray, words, _NO_BOXES, test, subject, any_will_do), nearest_of(words)
    for thing in range(open_brute(tables).triangles):
        nearest = test_thing(thing, things, nearest, words)
        if enough(things, nearest):
            break
    return answer(words, nearest)
