"""Progress of long work: bars on a terminal, or a function of the caller's."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn

__all__ = ["ProgressLike", "Reporter", "reporter"]

ProgressLike: TypeAlias = bool | Callable[[str, float], None] | None


class Reporter:
    """Tells how far a stage is: `report(stage, fraction)`, fraction from 0 to 1."""

    def __init__(self, report: Callable[[str, float], None]) -> None:
        self._report = report

    def __call__(self, stage: str, fraction: float) -> None:
        self._report(stage, min(max(fraction, 0.0), 1.0))


class _Bars:
    """One bar for each stage, on stderr."""

    def __init__(self) -> None:
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
        )
        self._tasks: dict[str, TaskID] = {}

    def __enter__(self) -> _Bars:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def report(self, stage: str, fraction: float) -> None:
        if stage not in self._tasks:
            self._tasks[stage] = self._progress.add_task(stage, total=1.0)
        self._progress.update(self._tasks[stage], completed=fraction)


@contextmanager
def reporter(progress: ProgressLike) -> Iterator[Reporter]:
    """What `progress=` asks for: True for bars, False for silence, None for bars if stderr is a terminal, or a function
    of (stage, fraction) to be called."""
    if callable(progress):
        yield Reporter(progress)
    elif progress or (progress is None and sys.stderr.isatty()):
        with _Bars() as bars:
            yield Reporter(bars.report)
    else:
        yield Reporter(lambda stage, fraction: None)
