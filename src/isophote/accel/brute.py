"""Every ray against every triangle, as an accelerator: what the others are compared with."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Accelerator, Built, blocks_of
from isophote.kernels.accel.brute_entry import BRUTE, any_of_all, closest_of_all, things_of_all
from isophote.kernels.accel.layout import LANES

__all__ = ["BRUTE_FORCE"]


def _build(positions: npt.NDArray[np.float32], triangles: npt.NDArray[np.int32], threads: int | None) -> Built:
    count = len(triangles)
    slots = np.full(-(-count // LANES) * LANES, -1, np.int32)
    slots[:count] = np.arange(count)
    corners = positions[triangles.reshape(-1)]
    bounds = np.stack([corners.min(axis=0, initial=np.inf), corners.max(axis=0, initial=-np.inf)]).astype(np.float32)
    return Built(BRUTE.pack(triangles=count), blocks_of(positions, triangles, slots, threads), bounds)


BRUTE_FORCE = Accelerator("brute", _build, closest_of_all, any_of_all, things_of_all)
