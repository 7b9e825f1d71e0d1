"""How the command line shows progress."""

from __future__ import annotations

import sys
from collections.abc import Callable

from isophote.cli.messages import log
from isophote.progress import ProgressLike
from isophote.rendering.warm import STAGE

__all__ = ["progress"]


def progress() -> ProgressLike:
    """What `render(progress=)` is given: bars on a terminal, else only a line where kernels have to be compiled."""
    return True if sys.stderr.isatty() else _said_once()


def _said_once() -> Callable[[str, float], None]:
    said = False

    def tell(stage: str, fraction: float) -> None:
        nonlocal said
        if stage == STAGE and not said:
            said = True
            log(stage)

    return tell
