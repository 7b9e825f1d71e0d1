"""Pictures that vary a colour over a surface or over the sky."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.fields import ArrayKey, frozen_array, instance_of, one_of, optional
from isophote.scene.texture import Texture

__all__ = ["ImageTexture"]

Pixels: TypeAlias = npt.NDArray[Any]

_LARGEST_REPR = 16
_CHANNELS = (1, 3, 4)


def _pixels(value: npt.ArrayLike) -> Pixels:
    try:
        given = np.asarray(value)
    except ValueError as error:
        raise SceneError(f"a texture's pixels must be a regular array: {error}") from None
    if given.ndim not in (2, 3) or (given.ndim == 3 and given.shape[2] not in _CHANNELS):
        raise SceneError(f"a texture's pixels must be (h, w), (h, w, 1), (h, w, 3) or (h, w, 4), not {given.shape}")
    if given.size == 0:
        raise SceneError(f"a texture needs one pixel or more, but these are {given.shape}")
    typed = _typed(given, listed=not isinstance(value, np.ndarray))
    return frozen_array(np.ascontiguousarray(typed if typed is not value else typed.copy()))


def _typed(given: Pixels, listed: bool) -> Pixels:
    if given.dtype == np.uint8:
        return given
    if listed and given.dtype.kind == "i" and given.min() >= 0 and given.max() <= 255:
        return given.astype(np.uint8)
    if given.dtype.kind != "f":
        raise SceneError(
            f"a texture's pixels must be uint8 (0 to 255) or float32, not {given.dtype}; "
            "divide whole numbers of another range by their maximum"
        )
    with np.errstate(over="ignore"):
        pixels = given.astype(np.float32)
    if not np.isfinite(pixels).all():
        bad = np.argwhere(~np.isfinite(pixels))[0]
        raise SceneError(
            f"a texture's pixels must be finite, but row {bad[0]}, column {bad[1]} is not; "
            "np.nan_to_num replaces such values"
        )
    return pixels


def _wrap(value: Any) -> Any:
    """One way for both axes as one word."""
    if isinstance(value, list | tuple) and len(value) == 2:
        return value[0] if value[0] == value[1] else tuple(value)
    return value


def _each_wrap(instance: Any, attribute: Any, value: Any) -> None:
    if isinstance(value, list | tuple) and len(value) != 2:
        raise SceneError(f"ImageTexture: wrap must be one way, or two for u and v, but is {value!r}")
    for way in value if isinstance(value, tuple) else (value,):
        one_of("repeat", "clamp", "mirror")(instance, attribute, way)


@attrs.frozen(repr=False)
class ImageTexture(Texture):
    """A picture over the unit square of texture coordinates.

    `pixels` is (h, w), (h, w, 1), (h, w, 3) or (h, w, 4), uint8 (0 to 255, standing for 0 to 1) or float32;
    row 0 is the top row of the picture, as in image files. Texture coordinates (u, v) have their origin at
    the lower left corner of the picture, u to the right and v up: pixel (row, column) has its centre at
    u = (column + 1/2) / w, v = 1 − (row + 1/2) / h.

    `colour_space` says how red, green and blue (not the fourth channel) are encoded: "srgb", the default for
    uint8, or "linear", the default for float32. `wrap` says what lies outside the unit square: "repeat", "clamp"
    or "mirror", or a pair of these for u and v. `name` is for people and for writing files.

    `filter` says how the picture is averaged over what a sample covers of it, in linear light: "ewa" under an
    ellipse, up to 16 times as long as wide (Heckbert, 1989); "trilinear" over a square as wide as the ellipse is
    long; "bilinear" and "nearest" not at all. Between the centres of pixels all but "nearest" are bilinear.

    Raises `SceneError` for other shapes and types, no pixels, and non-finite values.
    """

    pixels: Pixels = attrs.field(converter=_pixels, eq=ArrayKey)
    colour_space: str = attrs.field(validator=one_of("srgb", "linear"))
    wrap: str | tuple[str, str] = attrs.field(default="repeat", converter=_wrap, validator=_each_wrap)
    filter: str = attrs.field(default="ewa", validator=one_of("ewa", "trilinear", "bilinear", "nearest"))
    name: str | None = attrs.field(default=None, kw_only=True, validator=optional(instance_of("a string or None", str)))

    @colour_space.default
    def _by_type(self) -> str:
        return "srgb" if self.pixels.dtype == np.uint8 else "linear"

    @classmethod
    def missing(cls, name: str) -> ImageTexture:
        """The placeholder for a picture that is not there: magenta, under the picture's name."""
        return cls(np.array([[[255, 0, 255]]], np.uint8), filter="nearest", name=name)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.pixels.shape[1], self.pixels.shape[0]

    @property
    def channels(self) -> int:
        """Number of channels: 1, 3 or 4."""
        return 1 if self.pixels.ndim == 2 else int(self.pixels.shape[2])

    @property
    def wraps(self) -> tuple[str, str]:
        """Ways beyond the unit square along u and v."""
        return (self.wrap, self.wrap) if isinstance(self.wrap, str) else self.wrap

    def __repr__(self) -> str:
        settings = f"{self.colour_space!r}, {self.wrap!r}, {self.filter!r}"
        name = "" if self.name is None else f", name={self.name!r}"
        if self.pixels.size <= _LARGEST_REPR:
            return f"ImageTexture({self.pixels.tolist()}, {settings}{name})"
        width, height = self.size
        return f"<ImageTexture: {width} by {height}, {self.channels} channels of {self.pixels.dtype}, {settings}{name}>"
