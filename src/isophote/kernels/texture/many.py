"""A texture asked at many places at once: what plots, radiosity and tests are made of."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import kernel
from isophote.kernels.texture.contract import TEXTURES, WORDS, look_up

__all__ = ["look_up_many"]

_WORDS = np.int64(WORDS)

open_textures = TEXTURES.open


@kernel
def look_up_many(texture_words, node, records):
    """Ask the node at every record, one after another in `records`; answers stay in them."""
    textures = open_textures(texture_words)
    for first in range(0, len(records), _WORDS):
        look_up(textures, node, records, first)
