"""The two decorators of every compiled function.

`kernel` marks what Python calls: it frees the interpreter while it runs and is cached on disk.
`device` marks what kernels call: it is compiled into them.

Both follow IEEE arithmetic but for contraction (`a * b + c` in one rounding) and reordering-free flags
named where they are used; division by zero gives infinity, as in NumPy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit

from isophote.kernels.base import cache

__all__ = ["device", "kernel"]

cache.install()

_CONTRACT = {"contract", "nsz"}


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls; see the module's text."""
    return njit(function, nogil=True, cache=True, error_model="numpy", fastmath=_CONTRACT)


def device(function: Callable[..., Any]) -> Any:
    """Compile a function that kernels call; see the module's text."""
    return njit(function, nogil=True, error_model="numpy", fastmath=_CONTRACT)
