"""Threads for kernels that work on pieces of arrays."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

__all__ = ["pieces", "processors", "run"]


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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
