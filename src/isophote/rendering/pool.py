"""The pool that runs tile kernels: threads, deadline, cancelling."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import NamedTuple, TypeVar

import numpy as np

from isophote.errors import RenderError
from isophote.machine import processors

__all__ = ["Pool", "Tile", "checked_threads", "tiles_of"]

_Job = TypeVar("_Job")

# Seconds between looks at how far the threads are.
_GLANCE = 0.1
# Each thread has scratch memory of its own, up to some megabytes.
_MOST_THREADS = 1024


class Tile(NamedTuple):
    """Pixels x0 ≤ x < x1, y0 ≤ y < y1."""

    x0: int
    x1: int
    y0: int
    y1: int


def tiles_of(size: tuple[int, int], edge: int) -> list[Tile]:
    """The tiles of a picture of `size` (width, height), row by row."""
    width, height = size
    return [
        Tile(x, min(x + edge, width), y, min(y + edge, height))
        for y in range(0, height, edge)
        for x in range(0, width, edge)
    ]


def checked_threads(threads: object) -> int | None:
    """`threads`, if it is a number of threads that can be had, or None for all processors. Raises `RenderError`."""
    if threads is None:
        return None
    if isinstance(threads, bool) or not isinstance(threads, int | np.integer) or not 1 <= threads <= _MOST_THREADS:
        raise RenderError(
            f"threads must be a whole number from 1 to {_MOST_THREADS:,}, or None for all processors, not {threads!r}"
        )
    return int(threads)


class Pool:
    """Threads that run jobs until all are done, time is up, or the user interrupts.

    A pool that was stopped, or in which a job failed, takes no more jobs. Kernels let go of the interpreter, so threads
    run side by side; a job that has begun is always finished, so that what it wrote is whole.
    """

    def __init__(self, threads: int | None = None, deadline: float | None = None) -> None:
        self.threads = checked_threads(threads) or processors()
        self.deadline = deadline
        self._stopped = threading.Event()

    @property
    def interrupted(self) -> bool:
        """Whether the user interrupted."""
        return self._stopped.is_set()

    @property
    def stopped(self) -> bool:
        """Whether the user interrupted or time is up."""
        return self._stopped.is_set() or (self.deadline is not None and time.monotonic() >= self.deadline)

    def stop(self) -> None:
        """Start no further jobs."""
        self._stopped.set()

    def run(self, work: Callable[[_Job, int], None], jobs: Sequence[_Job], done: Callable[[int], None]) -> None:
        """Call `work(job, thread)` for each job in order, on as many threads as there are, or in the calling one where
        that is one; `done(count)` now and then, in the calling thread.

        An interrupt (Ctrl-C) stops after the jobs under way; what a job raises is raised here.
        """
        threads = max(1, min(self.threads, len(jobs)))
        with _interrupts_told(self.stop) as told:
            if threads == 1 and told:
                self._run_here(work, jobs, done)
            else:
                self._run_in_threads(threads, work, jobs, done)

    def _run_here(self, work: Callable[[_Job, int], None], jobs: Sequence[_Job], done: Callable[[int], None]) -> None:
        """In the calling thread: starting another takes as long as tracing some thousands of rays."""
        finished, glance = 0, time.monotonic() + _GLANCE
        try:
            for job in jobs:
                if self.stopped:
                    break
                work(job, 0)
                finished += 1
                if time.monotonic() >= glance:
                    done(finished)
                    glance = time.monotonic() + _GLANCE
        except KeyboardInterrupt:
            self.stop()
        except BaseException:
            self.stop()
            raise
        done(finished)

    def _run_in_threads(
        self, threads: int, work: Callable[[_Job, int], None], jobs: Sequence[_Job], done: Callable[[int], None]
    ) -> None:
        following = iter(jobs)
        lock = threading.Lock()
        finished = 0

        def worker(thread: int) -> None:
            nonlocal finished
            while not self.stopped:
                with lock:
                    job = next(following, None)
                if job is None:
                    return
                work(job, thread)
                with lock:
                    finished += 1

        with ThreadPoolExecutor(threads) as executor:
            running = {executor.submit(worker, thread) for thread in range(threads)}
            while running:
                try:
                    ended, running = wait(running, timeout=_GLANCE, return_when=FIRST_COMPLETED)
                    done(finished)
                    for future in ended:
                        future.result()
                except KeyboardInterrupt:
                    self.stop()
                except BaseException:
                    self.stop()
                    raise
        done(finished)


@contextmanager
def _interrupts_told(stop: Callable[[], None]) -> Iterator[bool]:
    """Have interrupts call `stop`, and not break into what runs meanwhile; whether that is so. They come to the main
    thread alone; a handler there that is someone else's stays."""
    if threading.current_thread() is not threading.main_thread():
        yield True
        return
    before = signal.getsignal(signal.SIGINT)
    if before not in (signal.default_int_handler, signal.SIG_DFL, signal.SIG_IGN):
        yield False
        return
    if before != signal.SIG_IGN:
        signal.signal(signal.SIGINT, lambda number, frame: stop())
    try:
        yield True
    finally:
        signal.signal(signal.SIGINT, before)
