"""Sample patterns as arrays, for looking at them."""

from __future__ import annotations

from isophote.kernels.base.jit import kernel
from isophote.kernels.base.sampler import pair, pixel_number

__all__ = ["fill_pattern"]


@kernel
def fill_pattern(pattern, seed, dimension, out):
    """Fill `out` (height, width, samples, 2) float32 with the pairs of one dimension."""
    height, width, count = out.shape[0], out.shape[1], out.shape[2]
    for y in range(height):
        for x in range(width):
            number = pixel_number(x, y)
            for k in range(count):
                u, v = pair(pattern, seed, number, k, count, dimension)
                out[y, x, k, 0] = u
                out[y, x, k, 1] = v
