"""The pool that runs jobs: in the calling thread, or in several."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable

import pytest

from isophote.rendering.pool import Pool


def ran(threads: int, count: int, work: Callable[[int], None] = lambda job: None) -> tuple[Pool, list[int], list[int]]:
    """The pool, jobs that were finished, and what was told of them."""
    pool, finished, told = Pool(threads), [], []

    def whole(job: int, thread: int) -> None:
        assert 0 <= thread < threads
        work(job)
        finished.append(job)

    pool.run(whole, range(count), told.append)
    return pool, finished, told


@pytest.mark.parametrize("threads", [1, 3])
def test_all_jobs_are_done(threads):
    pool, finished, told = ran(threads, 20)
    assert sorted(finished) == list(range(20))
    assert told[-1] == 20
    assert not pool.stopped


@pytest.mark.parametrize(("threads", "count", "here"), [(1, 5, True), (4, 1, True), (2, 5, False)])
def test_one_thread_is_the_calling_one(threads, count, here):
    seen = set()
    ran(threads, count, lambda job: seen.add(threading.current_thread()))
    assert (threading.current_thread() in seen) == here


@pytest.mark.parametrize("threads", [1, 2])
def test_an_interrupt_lets_jobs_under_way_end(threads):
    before = signal.getsignal(signal.SIGINT)

    def press(job: int) -> None:
        if job == 3:
            os.kill(os.getpid(), signal.SIGINT)
            # What an interrupt could break into.
            sum(range(200_000))

    pool, finished, told = ran(threads, 100_000, press)
    assert pool.interrupted
    assert 3 in finished
    assert told[-1] == len(finished) < 100_000
    assert signal.getsignal(signal.SIGINT) is before


def test_a_handler_of_someone_elses_stays():
    pressed = []
    before = signal.signal(signal.SIGINT, lambda number, frame: pressed.append(number))
    try:
        pool, finished, _ = ran(1, 10, lambda job: os.kill(os.getpid(), signal.SIGINT) if job == 2 else None)
    finally:
        signal.signal(signal.SIGINT, before)
    assert pressed
    assert len(finished) == 10
    assert not pool.interrupted


@pytest.mark.parametrize("threads", [1, 3])
def test_what_a_job_raises_comes_out(threads):
    def fail(job: int) -> None:
        if job == 2:
            raise ValueError("mine")

    with pytest.raises(ValueError, match="mine"):
        ran(threads, 5, fail)


@pytest.mark.parametrize("threads", [1, 3])
def test_after_the_deadline_nothing_begins(threads):
    pool, done = Pool(threads, deadline=0.0), []
    pool.run(lambda job, thread: done.append(job), range(5), lambda count: None)
    assert done == []


def test_other_threads_run_jobs_themselves():
    found = []
    thread = threading.Thread(target=lambda: found.append(ran(1, 4)[1]))
    thread.start()
    thread.join()
    assert found == [[0, 1, 2, 3]]
