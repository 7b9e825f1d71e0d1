"""Pictures of the inside of a field in the plane: regions proven to be inside or outside are filled whole.

A region is a square of LEAF · 4ᵏ pixels, split into 4 × 4; each child that is not decided has a shortened tape of its
own, down to leaves of LEAF × LEAF pixels, where the tape is run at each pixel.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import load16, lowest_bit, splat16, store16
from isophote.kernels.base.simd import mask16 as mask16_type
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import open_field_data
from isophote.kernels.forms.interpreters import open_interpreters, values_on
from isophote.kernels.forms.regions import REGIONS, bound_regions, load_region
from isophote.kernels.forms.tape import LANES, WIDTH
from isophote.kernels.forms.tape_prune import shorten

__all__ = ["LEAF", "fill_square", "split_picture"]

# Pixels along a side of a leaf, which are as many as a vector's lanes.
LEAF = 16

_FIRST, _ROW = np.int64(0), np.int64(op.ROW)
_ZERO, _ALL = np.float32(0), np.int32(0xFFFF)


@intrinsic
def _store_mask(typingctx, picture, index, mask):
    """Sixteen truth values as bytes, to a contiguous uint8 array from element `index` on."""
    if not (isinstance(picture, types.Array) and picture.dtype == types.uint8 and mask == mask16_type):
        return None

    def codegen(context, builder, signature, args):
        data = cgutils.create_struct_proxy(signature.args[0])(context, builder, args[0]).data
        bytes16 = ir.VectorType(ir.IntType(8), REGIONS)
        pointer = builder.bitcast(builder.gep(data, [args[1]]), bytes16.as_pointer())
        builder.store(builder.zext(args[2], bytes16), pointer).align = 1
        return context.get_dummy_value()

    return types.void(picture, types.intp, mask), codegen


@device
def _load_children(xs, ys, picture, px, py, size, slots):
    """Boxes around the pixels of the sixteen children of `size`² at pixel (px, py); bits of those in the picture."""
    height, width = picture.shape
    there = np.int32(0)
    for child in range(REGIONS):
        x, y = px + (child & 3) * size, py + (child >> 2) * size
        if x < width and y < height:
            there |= np.int32(1) << np.int32(child)
        x, y = min(x, width - 1), min(y, height - 1)
        load_region(slots, child, 0, xs[x], xs[min(x + size, width) - 1])
        # Rows count from the top.
        load_region(slots, child, 1, ys[min(y + size, height) - 1], ys[y])
        load_region(slots, child, 2, _ZERO, _ZERO)
    return there


@device
def _fill(picture, px, py, size):
    """Make a region inside."""
    height, width = picture.shape
    for y in range(py, min(py + size, height)):
        picture[y, px : min(px + size, width)] = 1


@device
def _decide(runners, rows, first, count, data, xs, ys, picture, px, py, size, slots, choices):
    """Fill those of the sixteen children of `size`² that are inside; bits of those that are not decided."""
    there = _load_children(xs, ys, picture, px, py, size, slots)
    outside, inside = bound_regions(runners, rows, first, count, data, slots, choices)
    inside &= there
    left = there & ~(outside | inside)
    while inside != 0:
        child = np.int64(lowest_bit(inside))
        inside &= inside - np.int32(1)
        _fill(picture, px + (child & 3) * size, py + (child >> 2) * size, size)
    return left


@device
def _run_leaf(runners, rows, first, count, data, xs, ys, picture, px, py, slots):
    """Run a tape at each pixel of a leaf."""
    height, width = picture.shape
    result = (np.int64(op.INPUTS) - 1 + count) * LANES
    zero = splat16(_ZERO)
    for part in range(0, min(np.int64(LEAF), height - py), WIDTH):
        for k in range(WIDTH):
            store16(slots, k * LEAF, load16(xs, px))
            store16(slots, LANES + k * LEAF, splat16(ys[min(py + part + k, height - 1)]))
            store16(slots, 2 * LANES + k * LEAF, zero)
        values_on(runners, rows, first, count, data, slots, np.int64(WIDTH))
        for k in range(min(np.int64(WIDTH), height - py - part)):
            y, values = py + part + k, result + k * LEAF
            if px + LEAF <= width:
                _store_mask(picture, y * width + px, load16(slots, values) < zero)
            else:
                for x in range(width - px):
                    picture[y, px + x] = slots[values + x] < _ZERO


@kernel
def split_picture(rows, data, interpreters, xs, ys, picture, size, children, out, slots, choices, marks):
    """Decide the sixteen squares of `size`² pixels that a picture is made of.

    `rows`: the tape; `data`, `interpreters`: the words of a FIELD_DATA and of INTERPRETERS. `xs` (w + LEAF,) and `ys`
    (h,) float32: where pixels are, rows from the top down; `picture` (h, w) uint8, zero before. `children` (16, 4) gets
    x, y, and first row and number of rows in `out`, of each square that is not decided; their number is returned. `out`
    holds sixteen tapes; the rest is scratch of the interpreter of intervals and of `shorten`.
    """
    tables, runners = open_field_data(data), open_interpreters(interpreters)
    count = np.int64(rows.size) // _ROW
    left = _decide(runners, rows, _FIRST, count, tables, xs, ys, picture, _FIRST, _FIRST, size, slots, choices)
    written, number = np.int64(0), np.int64(0)
    while left != 0:
        child = np.int64(lowest_bit(left))
        left &= left - np.int32(1)
        kept = shorten(rows, _FIRST, count, choices, child, out, written, marks)
        children[number, 0], children[number, 1] = (child & 3) * size, (child >> 2) * size
        children[number, 2], children[number, 3] = written, kept
        written += kept
        number += 1
    return number


@kernel
def fill_square(rows, data, interpreters, xs, ys, picture, square, size, tapes, slots, choices, marks, path):
    """Decide every pixel of a `square` of `size`² pixels, a row of `children`, whose tape is in `rows`.

    `tapes` and `choices` hold as many rows as the tape has, for each level of splitting; `path` (levels + 1, 5) int64,
    `slots` and `marks` are scratch.
    """
    tables, runners = open_field_data(data), open_interpreters(interpreters)
    most, level = np.int64(square[3]), np.int64(0)
    path[0, 0], path[0, 1], path[0, 2], path[0, 3] = square[0], square[1], square[2], square[3]
    own, entering = rows, True
    while level >= 0:
        px, py, first, count = path[level, 0], path[level, 1], path[level, 2], path[level, 3]
        side = size >> (2 * level)
        own = rows if level == 0 else tapes
        if side == LEAF:
            _run_leaf(runners, own, first, count, tables, xs, ys, picture, px, py, slots)
            level, entering = level - 1, False
            continue
        chosen = choices[level * most : (level + 1) * most]
        if entering:
            path[level, 4] = _decide(
                runners, own, first, count, tables, xs, ys, picture, px, py, side >> 2, slots, chosen
            )
        left = path[level, 4]
        if left == 0:
            level, entering = level - 1, False
            continue
        child = np.int64(lowest_bit(np.int32(left)))
        path[level, 4] = left & (left - 1)
        kept = shorten(own, first, count, chosen, child, tapes, level * most, marks)
        level, entering = level + 1, True
        path[level, 0], path[level, 1] = px + (child & 3) * (side >> 2), py + (child >> 2) * (side >> 2)
        path[level, 2], path[level, 3] = (level - 1) * most, kept
