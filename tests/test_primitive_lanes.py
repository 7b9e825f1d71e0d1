"""Sixteen rays at once against primitives: the same first crossings as each ray by itself has."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import isophote as iso
from isophote.kernels.base.entry import call_entry, element_address
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, HIGH, LANES, PART, T
from isophote.kernels.primitive.layout import WORDS
from isophote.kernels.primitive.lines import cross_lines
from isophote.lower.primitive_table import primitive_of
from isophote.lower.primitives import KINDS, own_numbers

SHAPES = {
    "sphere": iso.sphere(1),
    "plane": iso.plane(),
    "disk": iso.Disk(),
    "box": iso.box(2),
    "slab": iso.slab(2),
    "pipe": iso.cylinder(1),
    "cylinder": iso.cylinder(1, 2),
    "cone": iso.cone(1, 2),
    "wide cone": iso.cone(0.2, 2, 1),
    "torus": iso.torus(1, 0.3),
    "thin torus": iso.torus(1, 0.05),
    "fat torus": iso.torus(1, 0.999),
    "spindle": iso.torus(1, 1.4),
}
RNG = np.random.default_rng(12)


@njit
def meet_together(meet_lanes: int, own: np.ndarray, blocks: np.ndarray) -> None:
    """Sixteen rays at a time: each row is a block as lanes.py has it, with WORDS doubles behind it."""
    for i in range(len(blocks)):
        block = element_address(blocks, i * blocks.shape[1])
        call_entry(meet_lanes, (element_address(own, 0), block, np.int64(LANES)))


def lines(count: int) -> np.ndarray:
    """From far and near and within, in all directions, along the axes, level, and through the middle."""
    o = RNG.normal(size=(count, 3)) * np.repeat([0.3, 1, 3, 100], count // 4)[:, None]
    d = RNG.normal(size=(count, 3)) - o * RNG.integers(0, 2, (count, 1))
    d[::7] = np.eye(3)[RNG.integers(0, 3, len(d[::7]))] * RNG.choice([-1.0, 1.0], (len(d[::7]), 1))
    d[1::7] = RNG.integers(-1, 2, d[1::7].shape) + np.array([0, 0, 0.5])
    d[2::7, 1] = 0
    d[3::7] = -o[3::7]
    return np.hstack([o, d])


@pytest.mark.parametrize("limit", [np.inf, 1.5])
@pytest.mark.parametrize("name", SHAPES)
def test_sixteen_rays_meet_what_each_meets(name: str, limit: float) -> None:
    primitive = primitive_of(SHAPES[name])
    assert primitive is not None
    kind, own = KINDS[primitive.kind], own_numbers(primitive)
    assert kind.meet_lanes is not None
    count = 256 * LANES
    rays = lines(count)
    alone, part = np.full((count, 1), np.nan), np.zeros((count, 1))
    cross_lines(kind.meet.address, own, rays, 0.0, limit, alone, part)
    blocks = np.zeros((count // LANES, BLOCK_DOUBLES + WORDS))
    blocks[:, : 6 * LANES] = rays.reshape(-1, LANES, 6).transpose(0, 2, 1).reshape(-1, 6 * LANES)
    blocks[:, HIGH : HIGH + LANES] = limit
    meet_together(kind.meet_lanes.address, own, blocks)
    together, parts = blocks[:, T : T + LANES].reshape(-1), blocks[:, PART : PART + LANES].reshape(-1)
    met = ~np.isnan(alone[:, 0])
    assert 100 < met.sum() < count
    # What runs exactly along a face or touches an edge may be told either way.
    differ = met != np.isfinite(together)
    assert differ.sum() <= 3
    both = met & np.isfinite(together)
    assert np.allclose(together[both], alone[both, 0], rtol=1e-7, atol=1e-9)
    assert (parts[both] == part[both, 0]).mean() > 0.999
