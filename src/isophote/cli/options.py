"""What options are made of: choices and sizes, refused with exit status 2 where they are written wrongly."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable

import typer

__all__ = ["FILTERS", "FORM_FACTORS", "PATTERNS", "SOLVERS", "WAYS", "one_of", "picture_size", "shutter_of"]

# Names of reconstruction filters and of sample patterns; what knows these and the following for good loads slowly.
FILTERS = ("box", "tent", "gaussian", "mitchell", "blackman-harris", "lanczos")
PATTERNS = ("blue-noise", "antithetic", "sobol", "jittered", "regular", "independent")
# Of radiosity, how light is exchanged and what patches see of each other; of ambient occlusion, how it is found.
SOLVERS = ("hierarchical", "gathering", "shooting")
FORM_FACTORS = ("rays", "hemicube", "hemisphere")
WAYS = ("rays", "horizon", "classic")

_SIZE = re.compile(r"(\d{1,9})[x×X](\d{1,9})")


def one_of(names: Iterable[str]) -> Callable[[str | None], str | None]:
    """A callback for an option that takes one of the names, or is not given."""
    known = tuple(names)

    def check(value: str | None) -> str | None:
        if value is not None and value not in known:
            raise typer.BadParameter(f"{value!r} is not one of {', '.join(known)}")
        return value

    return check


def picture_size(text: str) -> tuple[int, int]:
    """(width, height) of "640x480"."""
    found = _SIZE.fullmatch(text.strip())
    if found is None:
        raise typer.BadParameter(f"{text!r} is no size; write width and height in pixels, such as 640x480")
    return int(found[1]), int(found[2])


def shutter_of(text: str) -> tuple[float, float]:
    """(opening, closing) of "0,0.5", in seconds."""
    try:
        opened, closed = (float(part) for part in text.split(","))
    except ValueError:
        opened, closed = 1.0, 0.0
    if not -math.inf < opened <= closed < math.inf:
        raise typer.BadParameter(f"{text!r} is no shutter; write when it opens and closes in seconds, such as 0,0.5")
    return opened, closed
