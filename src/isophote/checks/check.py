"""What a check is: a quantity to measure, the value that it should have, and how far off it may be."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

import attrs
import numpy as np
import numpy.typing as npt

__all__ = ["Check", "Effort", "Measured", "farthest", "mean_of"]


class Measured(NamedTuple):
    """A quantity as it was found, as it should be, and the allowed difference; `at_most` allows any smaller one."""

    measured: float
    exact: float
    allowed: float
    at_most: bool = False

    @property
    def passed(self) -> bool:
        """Whether the difference is allowed; never where what was measured is not a number."""
        excess = self.measured - self.exact
        return bool(excess <= self.allowed if self.at_most else abs(excess) <= self.allowed)


@attrs.frozen
class Effort:
    """How hard to try: `samples` are multiplied by `factor`, and random numbers begin with `seed`."""

    factor: int = 1
    seed: int = 0
    threads: int | None = None

    def samples(self, quick: int) -> int:
        """How many samples to take where a quick run takes so many."""
        return quick * self.factor

    def generator(self) -> np.random.Generator:
        """Random numbers of this run."""
        return np.random.default_rng(self.seed)


@attrs.frozen
class Check:
    """One thing that can be measured: `topic` groups, `name` tells what it is."""

    topic: str
    name: str
    measure: Callable[[Effort], Measured]


def farthest(found: Iterable[Measured]) -> Measured:
    """Of several the one that is farthest off, in parts of what it may be."""
    return max(found, key=lambda one: abs(one.measured - one.exact) / one.allowed)


def mean_of(values: npt.ArrayLike, exact: float, rounding: float) -> Measured:
    """The mean of independent random values; it may be off by 4.5 of its standard errors, which the mean of 64 is once
    in 30,000 times, and by `rounding`, in the unit of the values."""
    numbers = np.asarray(values, np.float64).reshape(-1)
    error = float(numbers.std(ddof=1)) / math.sqrt(len(numbers))
    return Measured(float(numbers.mean()), exact, 4.5 * error + rounding)
