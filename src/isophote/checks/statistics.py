"""How far random samples are from what they should be."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["chi_square_deviation"]

# Cells of fewer expected samples are put together, for which chi-square is not yet a good model.
_LEAST = 8


def chi_square_deviation(found: npt.ArrayLike, expected: npt.ArrayLike) -> float:
    """How many standard deviations Pearson's chi-square of counts lies above its mean; inf where what cannot be was
    found.

    z = ((χ²/k)^⅓ − (1 − 2/9k)) / √(2/9k) for k degrees of freedom: a chance of 10⁻⁴ is 3.72, of 10⁻⁶ 4.75. Source:
    Wilson, Hilferty, "The distribution of chi-square", PNAS 17, 1931.
    """
    f, e = (np.asarray(values, np.float64).reshape(-1) for values in (found, expected))
    rare = e < _LEAST
    f, e = np.append(f[~rare], f[rare].sum()), np.append(e[~rare], e[rare].sum())
    if e[-1] == 0:
        if f[-1] > 0:
            return float("inf")
        f, e = f[:-1], e[:-1]
    degrees = len(e) - 1
    chi2 = float(((f - e) ** 2 / e).sum())
    return float(((chi2 / degrees) ** (1 / 3) - (1 - 2 / (9 * degrees))) / (2 / (9 * degrees)) ** 0.5)
