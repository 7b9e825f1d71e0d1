"""Air that scatters light: what the tiles of path tracing ask of it.

What does the work are entries (air_rays.py), which only scenes with a medium call; there `media.air.scatter` is not 0.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import call_entry, table_address
from isophote.kernels.base.jit import device

__all__ = ["SCATTERED", "dim_shadow_rays", "scatter_in_air"]

# A hit is that of a lamp with this number where the air has scattered the ray: its columns hold the ray that goes on.
SCATTERED = np.int64(-1)

_NONE = np.int64(0)


@device
def scatter_in_air(scene, plan, wave, count, depth):
    """Scatter the rays of a wave, whose hits are known, on their ways through the air. Returns the number of shadow
    rays that were made."""
    entry = scene.media.air.scatter
    if entry == 0:
        return _NONE
    tables = table_address(scene), table_address(plan), table_address(wave)
    return call_entry(entry, (*tables, np.int64(count), np.int64(depth)))


@device
def dim_shadow_rays(scene, wave, count):
    """Take from the light of shadow rays what the air does."""
    if scene.media.air.dim != 0:
        call_entry(scene.media.air.dim, (table_address(scene), table_address(wave), np.int64(count)))
