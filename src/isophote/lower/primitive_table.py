"""What scenes know of primitives before any is lowered: light to load, for scenes without them."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.table import Packed
from isophote.kernels.primitive.layout import PRIMITIVES

__all__ = ["no_primitives"]


def no_primitives() -> Packed:
    """The table of a scene without primitives: nothing is loaded or compiled for it."""
    return PRIMITIVES.pack(
        numbers=np.zeros((0, 2), np.int32),
        entries=np.zeros((0, 2), np.int64),
        reach=np.zeros((0, 6), np.float32),
        values=np.zeros(0),
        to_object=np.zeros((0, 12)),
        to_world=np.zeros((0, 12)),
        alone=np.zeros(0, np.int32),
        top_nodes=np.zeros(0, np.float32),
        top_items=np.zeros(0, np.int32),
        trace=0,
        surface=0,
    )
