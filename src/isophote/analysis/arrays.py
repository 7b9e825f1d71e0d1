"""Arrays that results are made of."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["distinct", "read_only"]


def read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A view that cannot be written to."""
    view = array.view()
    view.flags.writeable = False
    return view


def distinct(numbers: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The numbers of a list, each once, in increasing order.

    By sorting: NumPy's own way by hashing takes ten times as long on millions of whole numbers.
    """
    ordered = np.sort(numbers)
    new = np.ones(len(ordered), np.bool_)
    np.not_equal(ordered[1:], ordered[:-1], out=new[1:])
    return ordered[new]
