"""Threads for kernels that work on pieces of arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from isophote.machine import processors

__all__ = ["pieces", "run"]


def run(function: Callable[..., Any], jobs: Iterable[tuple[Any, ...]]) -> list[Any]:
    """What a function returns for each tuple of arguments, in order; on all processors where there are several."""
    work = list(jobs)
    workers = min(processors(), len(work))
    if workers <= 1:
        return [function(*job) for job in work]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda job: function(*job), work))


def pieces(count: int, size: int) -> Iterator[tuple[int, int]]:
    """Ranges of at most `size` that cover 0 to `count`."""
    for begin in range(0, count, size):
        yield begin, min(begin + size, count)
