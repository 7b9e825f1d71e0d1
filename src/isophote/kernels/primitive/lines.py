"""Lines over arrays against primitives, by the entries of their kinds."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import call_entry, element_address
from isophote.kernels.base.jit import kernel
from isophote.kernels.primitive import layout

__all__ = ["cross_lines", "describe_places"]

_NO = np.int64(0)


@kernel
def cross_lines(meet, own, lines, low, high, distances, parts):
    """Fill `distances`, `parts` (n, k) float64 with up to k crossings of `lines` (n, 6), origins and directions in the
    primitive's own space, at low < t < high; what is left over stays. `own` are the primitive's numbers."""
    words = np.empty(layout.WORDS)
    for i in range(len(lines)):
        for k in range(6):
            words[k] = lines[i, k]
        words[layout.LOW], words[layout.HIGH], words[layout.MOST] = low, high, distances.shape[1]
        count = call_entry(meet, (element_address(own, _NO), element_address(words, _NO)))
        for k in range(count):
            distances[i, k], parts[i, k] = words[layout.FOUND + 2 * k], words[layout.FOUND + 2 * k + 1]


@kernel
def describe_places(describe, own, places, parts, normals, uvs):
    """Move `places` (n, 3) onto parts `parts` (n,) of the surface; fill outward `normals` (n, 3), not of unit length,
    and texture coordinates `uvs` (n, 2). All are of the primitive's own space."""
    words = np.empty(layout.WORDS)
    for i in range(len(places)):
        words[layout.PART], words[layout.SLACK] = parts[i], 0.0
        for k in range(3):
            words[layout.PLACE + k] = places[i, k]
        call_entry(describe, (element_address(own, _NO), element_address(words, _NO)))
        for k in range(3):
            places[i, k], normals[i, k] = words[layout.PLACE + k], words[layout.NORMAL + k]
        uvs[i, 0], uvs[i, 1] = words[layout.UV], words[layout.UV + 1]
