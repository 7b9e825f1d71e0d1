"""Threads that build accelerators, and the pieces that they work on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, TypeAlias

from isophote.machine import processors

__all__ = ["GRAIN", "Run", "crew", "ranges"]

# Nodes with more items are split by all threads together; those with fewer are one thread's work. Longer runs of
# anything else are cut into pieces of this length. Fixed: it must not depend on the number of threads.
GRAIN = 1 << 16

Run: TypeAlias = Callable[[Callable[..., Any], Iterable[tuple[Any, ...]]], list[Any]]


@contextmanager
def crew(threads: int | None, count: int) -> Iterator[Run]:
    """A function that calls another once for each tuple of arguments, on `threads` threads where it is worth it."""
    if threads is None:
        threads = processors()
    if threads == 1 or count < GRAIN // 4:
        yield lambda function, jobs: [function(*job) for job in jobs]
        return
    with ThreadPoolExecutor(threads) as pool:
        yield lambda function, jobs: list(pool.map(lambda job: function(*job), jobs))


def ranges(begin: int, end: int) -> Iterator[tuple[int, int]]:
    """Ranges of at most GRAIN that cover `begin` to `end`."""
    for at in range(begin, end, GRAIN):
        yield at, min(at + GRAIN, end)
