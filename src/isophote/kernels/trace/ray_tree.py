"""Trees of rays: those that wait to be traced, and what each level of a tree has gathered.

Where a ray is reflected and refracted, its tree branches. Rays wait in one list for each level of the trees. A wave is
traced from the deepest list that has any, so that no list ever holds more than twice a wave; a level's rays of one
tree are met in the same order whatever other trees share the waves, and each level is summed by itself. So neither
waves nor tiles can change a bit of a picture.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.jit import device
from isophote.kernels.base.random import combine
from isophote.kernels.base.table import (
    FLOAT,
    FLOAT_ROWS,
    FLOATS,
    INT,
    INT_ROWS,
    LONG_ROWS,
    LONGS,
    WORD_ROWS,
    Packed,
    Table,
)
from isophote.kernels.base.vec import maximum_component, vec3
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.ray_log import ENDED_BY_DEPTH, ENDED_BY_WEIGHT, log_branch
from isophote.kernels.trace.shadow_tint import RAY_WORDS
from isophote.kernels.trace.wave import LANES, row_vec3, set_row_vec3
from isophote.kernels.trace.wave_entries import ENTRIES, pack_entries

__all__ = [
    "TREE",
    "branch",
    "gather",
    "new_tree",
    "next_level",
    "start_trees",
    "sum_levels",
    "take",
]

# Rows of a level's list. Floats: origin, direction, weight in the pixel's sample, and the ray's cone (cone.py).
ORIGIN, DIRECTION, CARRIED, CONE, FLOATS_A_LEVEL = np.int64(0), np.int64(3), np.int64(6), np.int64(9), np.int64(11)
# Words: key of its sample numbers, number of the pixel's sample, wave column of the tree.
KEY, SAMPLE, OWNER, WORDS_A_LEVEL = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
# Longs: media that it is in (medium.py), and its row in the log.
INSIDE, LOGGED, LONGS_A_LEVEL = np.int64(0), np.int64(1), np.int64(2)
# Rows of `rays`: how many rays each tree has so far, the rows in the log of the wave's rays and shadow rays, and the
# media that shadow rays begin in.
COUNT, RAY_LOGGED, SHADOW_LOGGED, SHADOW_INSIDE, RAY_ROWS = np.int64(0), np.int64(1), np.int64(2), np.int64(3), 4
# Columns of `waiting`: those taken, and all.
TAKEN, END = np.int64(0), np.int64(1)

# Rows of `surfaces`, surfaces that lights shine on: what surface_of said, what the ray carries there, and its wave
# column as a word; plain ones (ray_lights.py) have 1 in PLAIN, their normals on the ray's side, and what they scatter
# of light from above in SHARE; FROM and BLENDED, the ray's direction and the normal between corners, only until normals
# are worked out (ray_matte.py), and SENT, the number of its shadow rays, until they are counted …
PLACE, NORMAL, SHADING, SHARE, ERROR, U, V, PLAIN, COLUMN, FROM, BLENDED, SENT, SURFACE_FLOATS = (
    np.int64(row) for row in (0, 3, 6, 9, 12, 13, 14, 15, 16, 17, 20, 23, 24)
)
# … and of `surface_numbers`, which plain ones have none of: the media before and behind the surface, and all those that
# a ray is in which went through.
ITEM, TRIANGLE, BEFORE, BEHIND, THROUGH, SURFACE_NUMBERS = (np.int64(row) for row in (0, 1, 2, 3, 4, 5))
# Rows of `keys`: what the sample numbers of a few of them are drawn for.
DRAW_KEY, DRAW_SAMPLE, KEY_ROWS = np.int64(0), np.int64(1), 2

_ZERO, _ONE, _FAR = np.float32(0), np.float32(1), np.float32(np.inf)
_U = np.uint32

# `floats`, `words`, `longs`, `waiting`: the lists above, level by level; `rays` (4, wave); `sums` (3 · levels, wave);
# `surfaces`, `surface_numbers`; `jobs` (n, 3): each sample of each light as its group, its number and how many samples
# that light gets; `draws` (2 m, h): the sample numbers of m of them for h surfaces; `keys` (2, h). `least`: what rays
# must carry. `entries`: of wave_entries.py; `draw_jobs`, `sample_lights`: of light_samples.py. `tint`: address of
# shadow_tint, or 0 where all that is in the way blocks, and `shadow`, one of its rays. `traced` (pixels,): rays of each
# pixel.
TREE = Table(
    "RayTree",
    floats=FLOAT_ROWS,
    words=WORD_ROWS,
    longs=LONG_ROWS,
    waiting=LONG_ROWS,
    rays=LONG_ROWS,
    sums=FLOAT_ROWS,
    surfaces=FLOAT_ROWS,
    surface_numbers=LONG_ROWS,
    jobs=INT_ROWS,
    draws=FLOAT_ROWS,
    keys=WORD_ROWS,
    least=FLOAT,
    tint=INT,
    entries=ENTRIES,
    draw_jobs=INT,
    sample_lights=INT,
    shadow=FLOATS,
    traced=LONGS,
)


def new_tree(
    size: int,
    levels: int,
    jobs: npt.NDArray[np.int32],
    least: float,
    traced: npt.NDArray[np.int64],
    *,
    tint: int,
    draw_jobs: int,
    sample_lights: int,
) -> Packed:
    """Scratch for trees of so many levels in waves of `size` rays, as `new_wave` makes them; one for each thread,
    `traced` for all. `tint`, `draw_jobs`, `sample_lights`: addresses of entries."""
    size = -(-size // int(LANES)) * int(LANES)
    part = max(1, min(len(jobs), size // int(LANES)))
    several = max(1, size // (part * int(LANES))) * int(LANES)
    return TREE.pack(
        floats=np.zeros((levels * int(FLOATS_A_LEVEL), 2 * size), np.float32),
        words=np.zeros((levels * int(WORDS_A_LEVEL), 2 * size), np.uint32),
        longs=np.zeros((levels * int(LONGS_A_LEVEL), 2 * size), np.int64),
        waiting=np.zeros((levels, 2), np.int64),
        rays=np.zeros((RAY_ROWS, size), np.int64),
        sums=np.zeros((3 * levels, size), np.float32),
        surfaces=np.zeros((SURFACE_FLOATS, size), np.float32),
        surface_numbers=np.zeros((SURFACE_NUMBERS, size), np.int64),
        jobs=jobs,
        draws=np.zeros((2 * part, several), np.float32),
        keys=np.zeros((KEY_ROWS, several), np.uint32),
        least=least,
        tint=tint,
        entries=pack_entries(),
        draw_jobs=draw_jobs,
        sample_lights=sample_lights,
        shadow=np.zeros(RAY_WORDS, np.float32),
        traced=traced,
    )


@device
def start_trees(tree, levels, count):
    """Begin the trees of the camera rays in wave columns 0 … count − 1."""
    rays = tree.rays[COUNT]
    for i in range(count):
        rays[i] = 0
    for row in range(3 * levels):
        sums = tree.sums[row]
        for i in range(count):
            sums[i] = _ZERO


@device
def branch(tree, log, wave, levels, level, i, kind, inside, start, into, carried, weight, cone):
    """Let a ray wait that leaves what the ray in wave column `i` met, with so much weight in it, unless it is too deep
    or carries too little."""
    shown = carried * weight
    deep = level + 1 >= levels
    ended = ENDED_BY_DEPTH if deep else (ENDED_BY_WEIGHT if maximum_component(shown) < tree.least else 0)
    logged = log_branch(log, tree.rays[RAY_LOGGED, i], kind, level + 1, ended, start, into, weight)
    if ended != 0 or maximum_component(shown) <= _ZERO:
        return
    below = level + 1
    at = tree.waiting[below, END]
    tree.waiting[below, END] = at + 1
    first = below * FLOATS_A_LEVEL
    set_row_vec3(tree.floats, first + ORIGIN, at, start)
    set_row_vec3(tree.floats, first + DIRECTION, at, into)
    set_row_vec3(tree.floats, first + CARRIED, at, shown)
    tree.floats[first + CONE, at], tree.floats[first + CONE + 1, at] = cone
    first = below * WORDS_A_LEVEL
    tree.words[first + KEY, at] = combine(_U(wave.ints[rows.PIXEL, i]), _U(kind))
    tree.words[first + SAMPLE, at] = wave.ints[rows.SAMPLE, i]
    tree.words[first + OWNER, at] = wave.ints[rows.OWNER, i]
    first = below * LONGS_A_LEVEL
    tree.longs[first + INSIDE, at] = inside
    tree.longs[first + LOGGED, at] = logged


@device
def next_level(tree, levels, level):
    """The deepest level where rays wait after a wave of `level`, or 0 where none wait."""
    deepest = min(level + 1, levels - 1)
    while deepest > 0:
        if tree.waiting[deepest, TAKEN] < tree.waiting[deepest, END]:
            return deepest
        tree.waiting[deepest, TAKEN] = tree.waiting[deepest, END] = 0
        deepest -= 1
    return deepest


@device
def take(tree, wave, level):
    """Move as many of a level's rays into the wave as it holds, the first first. Returns how many."""
    floats, ints = wave.floats, wave.ints
    first = tree.waiting[level, TAKEN]
    count = min(floats.columns, tree.waiting[level, END] - first)
    tree.waiting[level, TAKEN] = first + count
    above, words, longs = level * FLOATS_A_LEVEL, level * WORDS_A_LEVEL, level * LONGS_A_LEVEL
    for i in range(count):
        at = first + i
        set_row_vec3(floats, rows.ORIGIN, i, row_vec3(tree.floats, above + ORIGIN, at))
        set_row_vec3(floats, rows.DIRECTION, i, row_vec3(tree.floats, above + DIRECTION, at))
        set_row_vec3(floats, rows.CARRIED, i, row_vec3(tree.floats, above + CARRIED, at))
        set_row_vec3(floats, rows.RADIANCE, i, vec3(_ZERO, _ZERO, _ZERO))
        floats[rows.WIDTH, i], floats[rows.SPREAD, i] = tree.floats[above + CONE, at], tree.floats[above + CONE + 1, at]
        floats[rows.HIT_T, i] = _FAR
        ints[rows.PIXEL, i] = tree.words[words + KEY, at]
        ints[rows.SAMPLE, i] = tree.words[words + SAMPLE, at]
        ints[rows.OWNER, i] = tree.words[words + OWNER, at]
        wave.longs[rows.INSIDE, i] = tree.longs[longs + INSIDE, at]
        tree.rays[RAY_LOGGED, i] = tree.longs[longs + LOGGED, at]
    return count


@device
def gather(tree, wave, level, count):
    """Add what each ray of the wave has gathered to its tree's level."""
    rays = tree.rays[COUNT]
    for k in range(3):
        sums, radiance = tree.sums[3 * level + k], wave.floats[rows.RADIANCE + k]
        if level == 0:
            # Each in its tree's column.
            for i in range(count):
                sums[i] += radiance[i]
        else:
            owners = wave.ints[rows.OWNER]
            for i in range(count):
                sums[np.int64(owners[i])] += radiance[i]
    owners = wave.ints[rows.OWNER]
    for i in range(count):
        rays[np.int64(owners[i])] += 1


@device
def sum_levels(tree, wave, levels, count):
    """What each tree has gathered, into the wave's columns."""
    for k in range(3):
        radiance, first = wave.floats[rows.RADIANCE + k], tree.sums[k]
        for i in range(count):
            radiance[i] = first[i]
        for level in range(1, levels):
            sums = tree.sums[3 * level + k]
            for i in range(count):
                radiance[i] += sums[i]
