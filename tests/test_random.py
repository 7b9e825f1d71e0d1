"""Counted random numbers: bijections, avalanche, Sobol's matrices, scrambles, permutations."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from isophote.kernels.base.random import combine, mix, owen, permute, reverse_bits, sobol_1, unit_float

U = np.uint32
KEYS = [0, 1, 0xDEADBEEF, 0xFFFFFFFF]


@njit
def apply_mix(x, out):
    for i in range(len(x)):
        out[i] = mix(x[i])


@njit
def apply_combine(a, b, out):
    for i in range(len(a)):
        out[i] = combine(a[i], b[i])


@njit
def apply_owen(x, key, out):
    for i in range(len(x)):
        out[i] = owen(x[i], key)


@njit
def apply_reverse(x, out):
    for i in range(len(x)):
        out[i] = reverse_bits(x[i])


@njit
def apply_sobol(x, out):
    for i in range(len(x)):
        out[i] = sobol_1(x[i])


@njit
def apply_permute(count, key, out):
    for i in range(count):
        out[i] = permute(np.uint32(i), np.uint32(count), key)


@njit
def apply_unit(x, out):
    for i in range(len(x)):
        out[i] = unit_float(x[i])


def run(kernel, *arguments, count: int) -> np.ndarray:
    out = np.zeros(count, np.uint32)
    kernel(*arguments, out)
    return out


def unmix(x: np.ndarray) -> np.ndarray:
    """The inverse of `mix`, step by step backward."""

    def unshift(y: np.ndarray, by: int) -> np.ndarray:
        x = y.copy()
        for _ in range(32 // by + 1):
            x = y ^ (x >> U(by))
        return x

    x = unshift(x, 16) * U(pow(0x846CA68B, -1, 2**32))
    x = unshift(x, 15) * U(pow(0x7FEB352D, -1, 2**32))
    return unshift(x, 16)


@pytest.mark.parametrize("first", [0, 2**31 - 2**19, 2**32 - 2**20])
def test_mix_is_a_bijection(first):
    x = (np.arange(2**20) + first).astype(np.uint32)
    mixed = run(apply_mix, x, count=len(x))
    assert len(np.unique(mixed)) == len(x)
    assert np.array_equal(unmix(mixed), x)


@pytest.mark.parametrize("name", ["mix", "combine"])
def test_every_bit_stirs_all_others(name):
    """Strict avalanche: turning one bit of the input turns each bit of the output with a chance of one half."""
    rng = np.random.default_rng(1)
    count = 20_000
    x, other = rng.integers(0, 2**32, (2, count), np.uint32)

    def stirred(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return run(apply_mix, a, count=count) if name == "mix" else run(apply_combine, a, b, count=count)

    before = stirred(x, other)
    flips = []
    for k in range(32):
        flips.append(before ^ stirred(x ^ U(1 << k), other))
        if name == "combine":
            flips.append(before ^ stirred(x, other ^ U(1 << k)))
    shares = np.array([[((f >> U(k)) & U(1)).mean() for k in range(32)] for f in flips])
    # lowbias32 has a bias of 0.17 · 10⁻³; sampling adds 3.5 · 10⁻³ (1σ).
    assert np.abs(shares - 0.5).max() < 0.02
    assert np.abs(shares.mean(axis=1) - 0.5).max() < 0.005


def test_neighbouring_keys_do_not_collide():
    a, b = (x.reshape(-1).astype(np.uint32) for x in np.meshgrid(np.arange(512), np.arange(512)))
    keys = run(apply_combine, a, b, count=len(a))
    # 2^18 draws out of 2^32 collide 8 times on average.
    assert len(a) - len(np.unique(keys)) < 30


def test_reversed_bits():
    x = np.random.default_rng(1).integers(0, 2**32, 1000, np.uint32)
    wanted = [int(f"{v:032b}"[::-1], 2) for v in x.tolist()]
    assert run(apply_reverse, x, count=1000).tolist() == wanted


def test_unit_floats_are_below_one():
    x = np.array([0, 255, 256, 2**31, 2**32 - 1], np.uint32)
    out = np.zeros(5, np.float32)
    apply_unit(x, out)
    assert out.tolist() == [0, 0, 2.0**-24, 0.5, 1 - 2.0**-24]


def directions() -> list[int]:
    """Direction numbers of Sobol's second dimension: primitive polynomial x + 1, so m_k = 2 m_{k-1} xor m_{k-1}."""
    m = [1]
    while len(m) < 32:
        m.append((m[-1] << 1) ^ m[-1])
    return [value << (31 - k) for k, value in enumerate(m)]


def test_sobol_agrees_with_direction_numbers():
    index = np.concatenate([np.arange(4096), 2 ** np.arange(32), [2**32 - 1, 0xDEADBEEF]]).astype(np.uint32)
    wanted = np.zeros(len(index), np.uint32)
    for k, direction in enumerate(directions()):
        wanted ^= np.where((index >> U(k)) & U(1), U(direction), U(0))
    reverse = run(apply_sobol, index, count=len(index))
    assert np.array_equal(run(apply_reverse, reverse, count=len(index)), wanted)


@pytest.mark.parametrize("key", KEYS)
def test_owen_scrambles_each_bit_by_those_below(key):
    """A nested scramble is a bijection of the low k bits for every k: numbers equal there stay so, others do not."""
    for bits in (1, 2, 5, 12):
        low = np.arange(2**bits, dtype=np.uint32)
        high = np.random.default_rng(2).integers(0, 2**32, len(low), np.uint32) << U(bits)
        mask = U(2**bits - 1)
        plain = run(apply_owen, low, U(key), count=len(low)) & mask
        assert len(np.unique(plain)) == len(low)
        assert np.array_equal(run(apply_owen, low | high, U(key), count=len(low)) & mask, plain)


def test_owen_flips_every_bit_by_the_key_and_by_lower_bits():
    rng = np.random.default_rng(3)
    x = rng.integers(0, 2**32, 4000, np.uint32)
    changed = np.zeros((4000, 32), bool)
    for i, key in enumerate(rng.integers(0, 2**32, 4000, np.uint32)):
        one = run(apply_owen, x[i : i + 1], key, count=1)
        changed[i] = ((one ^ x[i]) >> np.arange(32, dtype=np.uint32)) & U(1)
    assert np.abs(changed.mean(axis=0) - 0.5).max() < 0.05


@pytest.mark.parametrize("key", KEYS)
def test_permutations_of_every_count(key):
    for count in range(1, 201):
        assert np.array_equal(np.sort(run(apply_permute, count, U(key), count=count)), np.arange(count))


def test_permutations_send_every_place_everywhere():
    count, keys = 12, np.random.default_rng(4).integers(0, 2**32, 12_000, np.uint32)
    table = np.zeros((count, count))
    for key in keys:
        table[np.arange(count), run(apply_permute, count, key, count=count)] += 1
    expected = len(keys) / count
    # 121 degrees of freedom: chi-square is above 194 with a chance of 10⁻⁵.
    assert ((table - expected) ** 2 / expected).sum() < 194
