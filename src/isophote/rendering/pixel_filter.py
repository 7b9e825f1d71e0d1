"""Reconstruction filters: how the samples around a pixel weigh in its colour."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError

__all__ = ["FILTERS", "FilterTable", "PixelFilter", "as_pixel_filter", "filter_table", "pixel_filter"]

Array: TypeAlias = npt.NDArray[np.float64]

# Steps of the tabulated distribution, each with the same mass, and of the integral that it is made from.
_STEPS = 1 << 14
_FINE = 1 << 17
_MOST_RADIUS = 64.0
_BLACKMAN_HARRIS = (0.35875, -0.48829, 0.14128, -0.01168)


def _box(t: Array, radius: float) -> Array:
    return np.ones_like(t)


def _tent(t: Array, radius: float) -> Array:
    return 1 - t


def _gaussian(t: Array, radius: float) -> Array:
    """σ = radius / 4."""
    result: Array = np.exp(-8 * t * t)
    return result


def _mitchell(t: Array, radius: float) -> Array:
    """B = C = 1/3 (Mitchell, Netravali: "Reconstruction Filters in Computer Graphics", SIGGRAPH 1988, equation 8)."""
    x = 2 * t
    near = (21 * x**3 - 36 * x**2 + 16) / 18
    far = (-7 * x**3 + 36 * x**2 - 60 * x + 32) / 18
    return np.where(x < 1, near, far)


def _lanczos(t: Array, radius: float) -> Array:
    """sinc(x) sinc(x / radius)."""
    return np.sinc(t * radius) * np.sinc(t)


def _blackman_harris(t: Array, radius: float) -> Array:
    """Four terms, -92 dB (Harris: "On the Use of Windows for Harmonic Analysis", 1978)."""
    angle = np.pi * (t + 1)
    a = _BLACKMAN_HARRIS
    result: Array = a[0] + a[1] * np.cos(angle) + a[2] * np.cos(2 * angle) + a[3] * np.cos(3 * angle)
    return result


class _Kind(NamedTuple):
    """A filter by the distance in parts of its radius, and the radius that is usual, in pixels."""

    shape: Callable[[Array, float], Array]
    radius: float
    least: float = 1e-3


FILTERS = {
    "box": _Kind(_box, 0.5),
    "tent": _Kind(_tent, 1.0),
    "gaussian": _Kind(_gaussian, 2.0),
    "mitchell": _Kind(_mitchell, 2.0),
    "blackman-harris": _Kind(_blackman_harris, 1.5),
    "lanczos": _Kind(_lanczos, 3.0, least=1.0),
}


def _name(instance: Any, attribute: attrs.Attribute[Any], value: object) -> None:
    if not isinstance(value, str) or value not in FILTERS:
        raise RenderError(f"PixelFilter: filter must be one of {', '.join(FILTERS)}, not {value!r}")


@attrs.frozen
class PixelFilter:
    """A reconstruction filter, f(x) f(y) about a pixel's middle, zero beyond `radius` pixels along an axis.

    "box" (radius 0.5 if none is given) is the pixel's mean; "tent" (1), "gaussian" (2, σ = radius / 4) and
    "blackman-harris" (1.5) are softer; "mitchell" (2, B = C = 1/3) and "lanczos" (3, as many lobes as the radius) are
    sharper, but negative in places: edges get a fine line on either side, colours may fall below 0, and there is more
    noise. Raises `RenderError` for other names, and radii that are not from 0.001 (of "lanczos" from 1) to 64.
    """

    name: str = attrs.field(default="box", validator=_name)
    radius: float | None = attrs.field(default=None)

    def __attrs_post_init__(self) -> None:
        least, given = FILTERS[self.name].least, self.radius
        if given is None:
            return
        number = isinstance(given, int | float | np.number) and not isinstance(given, bool)
        if not number or not least <= given <= _MOST_RADIUS:
            raise RenderError(
                f"PixelFilter: the radius of {self.name!r} must be a number of pixels from {least:g} to "
                f"{_MOST_RADIUS:g}, or None, not {given!r}"
            )

    @property
    def reach(self) -> float:
        """The radius in pixels, the usual one if none is given."""
        return FILTERS[self.name].radius if self.radius is None else float(self.radius)

    def __call__(self, x: npt.ArrayLike) -> Array:
        """f(x) for distances from the middle in pixels; its integral over all x is 1."""
        table = filter_table(self)
        t = np.abs(np.asarray(x, np.float64)) / self.reach
        shape = FILTERS[self.name].shape
        inside = np.where(t < 1, shape(np.minimum(t, 1.0), self.reach), 0.0)
        return inside / table.integral


def as_pixel_filter(value: str | PixelFilter) -> PixelFilter:
    """A filter by its name, or as it is. Raises `RenderError`."""
    return value if isinstance(value, PixelFilter) else PixelFilter(value)


def pixel_filter(method: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """Check a method's setting: a `PixelFilter` or the name of one."""
    if isinstance(value, PixelFilter) or (isinstance(value, str) and value in FILTERS):
        return
    known = ", ".join(FILTERS)
    raise RenderError(
        f"{type(method).__name__}: {attribute.name} must be one of {known}, or a PixelFilter, not {value!r}"
    )


class FilterTable(NamedTuple):
    """A filter as kernels take it.

    `offsets` (n + 1,) float32: the inverse of the distribution of |f| at even steps, pixels from the middle.
    `crossings` (k,) float32: positive distances at which f changes its sign. `excess`: what samples where f(x) f(y) is
    negative count, in parts of the pixel: its colour is (1 + excess) times the mean of the others less `excess` times
    the mean of these. `integral` of f before it was scaled to 1.
    """

    offsets: npt.NDArray[np.float32]
    crossings: npt.NDArray[np.float32]
    excess: float
    integral: float


@lru_cache(maxsize=32)
def filter_table(chosen: PixelFilter) -> FilterTable:
    """The filter's table; made once."""
    kind, radius = FILTERS[chosen.name], chosen.reach
    # Masses of thin slices from the middle outward.
    edges = np.linspace(0, 1, _FINE + 1)
    value = kind.shape((edges[1:] + edges[:-1]) / 2, radius)
    mass = value * radius / _FINE
    distribution = np.concatenate([[0.0], np.cumsum(np.abs(mass))])
    half = np.interp(np.linspace(0, distribution[-1], _STEPS // 2 + 1), distribution, edges * radius)
    offsets = np.concatenate([-half[:0:-1], half]).astype(np.float32)
    changes = np.flatnonzero(np.signbit(value[1:]) != np.signbit(value[:-1])) + 1
    # Both axes negative is positive again.
    share = float(np.abs(mass[mass < 0]).sum() / distribution[-1])
    negative = 2 * share * (1 - share)
    return FilterTable(
        offsets,
        (edges[changes] * radius).astype(np.float32),
        negative / (1 - 2 * negative),
        2 * float(mass.sum()),
    )
