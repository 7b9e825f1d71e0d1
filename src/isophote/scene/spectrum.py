"""Spectra as linear Rec. 709 triples."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.colour import Colour

__all__ = ["rgb_of_spectrum"]

_VISIBLE = np.arange(380.0, 781.0, 1.0)

# Height, middle in nm, and width in 1/nm below and above it, of the lobes whose sum is each colour matching function.
_LOBES = (
    ((1.056, 599.8, 0.0264, 0.0323), (0.362, 442.0, 0.0624, 0.0374), (-0.065, 501.1, 0.0490, 0.0382)),
    ((0.821, 568.8, 0.0213, 0.0247), (0.286, 530.9, 0.0613, 0.0322)),
    ((1.217, 437.0, 0.0845, 0.0278), (0.681, 459.0, 0.0385, 0.0725)),
)
_TO_RGB = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)


def _weights() -> npt.NDArray[np.float64]:
    """(3, wavelengths): what of each wavelength counts for red, green and blue; each adds up to 1."""
    matching = np.zeros((3, len(_VISIBLE)))
    for row, lobes in zip(matching, _LOBES, strict=True):
        for height, middle, below, above in lobes:
            away = (_VISIBLE - middle) * np.where(middle > _VISIBLE, below, above)
            row += height * np.exp(-(away**2) / 2)
    weights = _TO_RGB @ matching
    scaled: npt.NDArray[np.float64] = weights / weights.sum(axis=1, keepdims=True)
    return scaled


def rgb_of_spectrum(wavelengths: npt.ArrayLike, values: npt.ArrayLike) -> Colour:
    """(red, green, blue) of values given at wavelengths in nm, linear in between: the spectrum times the linear
    Rec. 709 colour matching functions of the CIE 1931 observer, so scaled that a constant spectrum keeps its value.

    Values may be beyond 0 to 1: an index of refraction, too. Raises `SceneError` unless the wavelengths, in rising
    order, reach from 400 to 700 nm. Source: Wyman, Sloan, Shirley: "Simple Analytic Approximations to the CIE XYZ Color
    Matching Functions", JCGT 2(2), 2013.
    """
    x: npt.NDArray[Any] = np.asarray(wavelengths, np.float64)
    y: npt.NDArray[Any] = np.asarray(values, np.float64)
    if x.ndim != 1 or x.shape != y.shape or not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise SceneError("a spectrum is two lists of finite numbers of one length: wavelengths in nm, and values")
    if len(x) < 2 or (np.diff(x) <= 0).any() or x[0] > 400 or x[-1] < 700:
        raise SceneError("the wavelengths of a spectrum must rise, and reach from 400 to 700 nm at least")
    red, green, blue = (_weights() @ np.interp(_VISIBLE, x, y)).tolist()
    return red, green, blue
