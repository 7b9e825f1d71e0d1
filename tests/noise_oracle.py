"""Noises in NumPy, from their definitions: oracles for the kernels, in the same precision and order of operations.

All take places (n, 3) float32 in cells and a seed.
"""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]
Keys = npt.NDArray[np.uint32]

F = np.float32
PRIMES = (0x8DA6B343, 0xD8163841, 0xCB1AB31F)
STEP = 0x9E3779B9


def mix(x: Keys) -> Keys:
    """Wellons' lowbias32."""
    x = x ^ (x >> np.uint32(16))
    x = x * np.uint32(0x7FEB352D)
    x = x ^ (x >> np.uint32(15))
    x = x * np.uint32(0x846CA68B)
    return x ^ (x >> np.uint32(16))


def keys(cells: npt.NDArray[np.int64], seed: int) -> Keys:
    """Keys of lattice points (..., 3): z, y and x go in one after another."""
    key = np.full(cells.shape[:-1], seed, np.uint32)
    for axis in (2, 1, 0):
        key = mix((cells[..., axis].astype(np.uint32) * np.uint32(PRIMES[axis])) ^ key)
    return key


def unit(key: Keys) -> Floats:
    return (key >> np.uint32(8)).astype(np.float32) * F(2.0**-24)


def edge_vectors(key: Keys) -> Floats:
    """The gradients of Perlin's `grad`, by the four highest bits."""
    h = key >> np.uint32(28)
    x, y, z = np.eye(3, dtype=np.float32)
    first = np.where((h < 8)[:, None], x, y)
    second = np.where((h < 4)[:, None], y, np.where(((h == 12) | (h == 14))[:, None], x, z))
    signs = 1 - 2 * ((h[:, None] >> np.array([0, 1], np.uint32)) & np.uint32(1)).astype(np.float32)
    return first * signs[:, :1] + second * signs[:, 1:]


def cells_of(places: Floats) -> tuple[npt.NDArray[np.int64], Floats]:
    below = np.floor(places)
    return below.astype(np.int64), places - below


def weights(t: Floats) -> Floats:
    return ((t * t) * t) * (t * (t * F(6) - F(15)) + F(10))


def trilinear(corners: dict[tuple[int, int, int], Floats], u: Floats) -> Floats:
    """Corner values (n,) mixed along x, then y, then z."""
    values = corners
    for axis in range(3):
        low = {key: value for key, value in values.items() if key[axis] == 0}
        values = {key: a + (values[_up(key, axis)] - a) * u[:, axis] for key, a in low.items()}
    return values[0, 0, 0]


def _up(key: tuple[int, int, int], axis: int) -> tuple[int, int, int]:
    x, y, z = (1 if k == axis else c for k, c in enumerate(key))
    return x, y, z


def value_noise(places: Floats, seed: int) -> Floats:
    cells, t = cells_of(places)
    corners = {c: unit(keys(cells + np.array(c), seed)) for c in itertools.product((0, 1), repeat=3)}
    return trilinear(corners, weights(t))


def perlin(places: Floats, seed: int) -> Floats:
    cells, t = cells_of(places)
    corners = {}
    for corner in itertools.product((0, 1), repeat=3):
        g = edge_vectors(keys(cells + np.array(corner), seed))
        d = t - np.array(corner, np.float32)
        corners[corner] = (g[:, 0] * d[:, 0] + g[:, 1] * d[:, 1]) + g[:, 2] * d[:, 2]
    return trilinear(corners, weights(t))


def simplex(places: Floats, seed: int) -> npt.NDArray[np.float64]:
    """In double precision, and over all points of the lattice that might matter, without tetrahedra."""
    p = places.astype(np.float64)
    skewed = np.floor(p + p.sum(axis=1, keepdims=True) / 3).astype(np.int64)
    total = np.zeros(len(p))
    for offset in itertools.product((-1, 0, 1, 2), repeat=3):
        cells = skewed + np.array(offset)
        d = p - (cells - cells.sum(axis=1, keepdims=True) / 6)
        t = np.maximum(0.5 - (d * d).sum(axis=1), 0.0)
        total += t**4 * (edge_vectors(keys(cells, seed)) * d).sum(axis=1)
    return total * 76.8


def features(low: int, high: int, seed: int, jitter: float) -> tuple[Floats, Keys]:
    """All feature points of the cells from `low` to `high` along each axis, (n, 3) float32, and their numbers."""
    grid = np.stack(np.meshgrid(*[np.arange(low, high)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    x = keys(grid, seed)
    y = mix(x + np.uint32(STEP))
    z = mix(y + np.uint32(STEP))
    offsets = np.stack([unit(x), unit(y), unit(z)], axis=1) * F(jitter) + F(0.5 - 0.5 * jitter)
    return grid.astype(np.float32) + offsets, mix(z + np.uint32(STEP))


METRICS = {
    "euclidean": lambda d: np.sqrt((d * d).sum(axis=-1)),
    "manhattan": lambda d: np.abs(d).sum(axis=-1),
    "chebyshev": lambda d: np.abs(d).max(axis=-1),
}
