"""Black-and-white pictures as forms in the plane."""

from __future__ import annotations

import os
from functools import cached_property
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, GeometryError
from isophote.shapes.field.data import GridData
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.flat import FlatForm
from isophote.shapes.field.form import Box, Exactness, grown, number_spelled
from isophote.shapes.field.numbers import positive_number

__all__ = ["Picture", "picture_of", "read_mask"]

Mask: TypeAlias = npt.NDArray[np.bool_]

_MOST_PIXELS = 1 << 24
_MOST_SPELLED = 64


def read_mask(image: str | os.PathLike[str] | npt.ArrayLike, threshold: float) -> Mask:
    """(h, w): which pixels of a picture, a file or an array (h, w), are darker than `threshold`.

    Files and arrays of whole numbers are 8-bit, 0 black to 255 white, and count in parts of 255; colours by their
    luma; what is transparent is white. Arrays of truth values are True where inside.
    """
    if isinstance(image, str | os.PathLike):
        grey: npt.NDArray[Any] = _read(image)
    else:
        grey = _checked_array(image)
        if grey.dtype == bool:
            return grey
        if grey.dtype.kind in "iu":
            grey = grey / 255
    if not 0 < threshold <= 1:
        raise GeometryError(f"image: threshold must be above 0 and not above 1, but is {threshold!r}")
    mask: Mask = np.asarray(grey, np.float64) < threshold
    return mask


def _read(path: str | os.PathLike[str]) -> npt.NDArray[np.float64]:
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as picture:
            if picture.width * picture.height > _MOST_PIXELS:
                raise FileError(path, f"the picture has more than {_MOST_PIXELS:,} pixels; make it smaller", "image")
            rgba = picture.convert("RGBA")
            paper = Image.new("RGBA", rgba.size, "white")
            return np.asarray(Image.alpha_composite(paper, rgba).convert("L")) / 255
    except (UnidentifiedImageError, Image.DecompressionBombError, ValueError, SyntaxError, EOFError) as error:
        raise FileError(path, f"it is no picture that can be read: {error}", "image") from error
    except OSError as error:
        raise FileError(path, error.strerror or str(error), "image") from error


def _checked_array(image: npt.ArrayLike) -> npt.NDArray[Any]:
    try:
        array = np.asarray(image)
    except ValueError as error:
        raise GeometryError(f"image: an array must be (h, w): {error}") from error
    if array.ndim != 2 or array.dtype.kind not in "biuf":
        raise GeometryError(f"image: an array must be (h, w) numbers or truth values, not {array.dtype} {array.shape}")
    if not 0 < array.size <= _MOST_PIXELS:
        raise GeometryError(f"image: an array must have from 1 to {_MOST_PIXELS:,} pixels, but has shape {array.shape}")
    if not np.isfinite(array).all():
        row, column = np.argwhere(~np.isfinite(array))[0]
        raise GeometryError(f"image: pixel ({row}, {column}) is {array[row, column]}")
    return array


def _distances(mask: Mask) -> GridData:
    """Distances to the outline of the pixels that are True, at their corners, middles and the middles of their sides.

    On this lattice of half pixels they are exact: whatever point of the outline is nearest to a point of the lattice
    lies on the lattice too, for the outline consists of whole sides of pixels.
    """
    from scipy.ndimage import distance_transform_edt

    # One row of white round the picture, so that it has an outline where it is black up to its edge.
    wide = np.pad(mask, 1)
    height, width = wide.shape
    lattice = np.zeros((2 * height + 1, 2 * width + 1), bool)
    inside = lattice.copy()
    inside[1::2, 1::2] = wide
    upright = wide[:, 1:] != wide[:, :-1]
    level = wide[1:, :] != wide[:-1, :]
    lattice[1::2, 2:-1:2] |= upright
    lattice[2:-1:2, 1::2] |= level
    for ends in (lattice[0:-2:2, 2:-1:2], lattice[2::2, 2:-1:2]):
        ends |= upright
    for ends in (lattice[2:-1:2, 0:-2:2], lattice[2:-1:2, 2::2]):
        ends |= level
    # Points on the lattice's other rows are inside where the pixels on both of their sides are.
    inside[1::2, 2:-1:2] = wide[:, 1:] & wide[:, :-1]
    inside[2:-1:2, 1::2] = wide[1:, :] & wide[:-1, :]
    inside[2:-1:2, 2:-1:2] = wide[1:, 1:] & wide[1:, :-1] & wide[:-1, 1:] & wide[:-1, :-1]
    distance = distance_transform_edt(~lattice) / 2
    values = np.where(inside, -distance, distance)[::-1]
    return GridData(values, (-width / 2, -height / 2), 0.5)


@attrs.frozen(repr=False)
class Picture(FlatForm):
    """What is black in a picture whose pixels are squares with sides `pixel`; its middle is the origin, its top up.

    Values are exact distances to the outline of the squares at each half pixel, bilinear between. So the outline is
    exact, and other values within the picture are off by (√2 / 4) `pixel` at most, for that is the mean distance to
    the four samples round a point in the middle of them.
    """

    mask: tuple[bytes, int, int]
    pixel: float = positive_number(default=1.0)
    # How the picture was asked for, where it came from a file.
    source: str = attrs.field(default="", eq=False)
    exactness = Exactness.BOUND

    def __attrs_post_init__(self) -> None:
        if not self._inside.any():
            raise GeometryError("image: no pixel is darker than the threshold, so there is no inside; raise threshold=")

    @cached_property
    def data(self) -> GridData:
        """Signed distances on the lattice of half pixels, of pixels with sides 1."""
        return _distances(self._inside)

    @property
    def _inside(self) -> Mask:
        packed, height, width = self.mask
        bits = np.unpackbits(np.frombuffer(packed, np.uint8), count=height * width)
        return bits.reshape(height, width).astype(bool)

    def expression(self, p: Point) -> Value:
        pixel = p.number(self.pixel)
        value = p.graph.apply("GRID2", p.x / pixel, p.y / pixel, constant=self.data) * pixel
        return p.bounded(value, self.data.slope)

    @property
    def bounds(self) -> Box:
        inside = self._inside
        rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
        height, width = inside.shape
        low = (columns[0] - width / 2, height / 2 - rows[-1] - 1)
        high = (columns[-1] + 1 - width / 2, height / 2 - rows[0])
        return np.array([low, high]) * float(self.pixel)

    def bounds_at(self, level: float) -> Box:
        # Beyond the picture a value is the length of that on its border and the distance to it, whose sum is no more
        # than √2 of that; values within it are off by so much of a pixel.
        return self.bounds if level <= 0 else grown(self.bounds, np.sqrt(2) * level + np.sqrt(2) / 4 * self.pixel)

    def spelled(self) -> str:
        pixel = f", pixel={number_spelled(self.pixel)}" if self.pixel != 1 else ""
        inside = self._inside
        if self.source:
            return f"image({self.source}{pixel})"
        if inside.size <= _MOST_SPELLED:
            return f"image({inside.tolist()}{pixel})"
        return f"<image of {inside.shape[1]} by {inside.shape[0]} pixels{pixel}>"


def picture_of(image: str | os.PathLike[str] | npt.ArrayLike, threshold: float, pixel: float) -> Picture:
    """The form of a picture: a file, or an array (h, w) whose row 0 is the top."""
    mask = read_mask(image, threshold)
    source = ""
    if isinstance(image, str | os.PathLike):
        given = "" if threshold == 0.5 else f", threshold={number_spelled(float(threshold))}"
        source = repr(os.fspath(image)) + given
    return Picture((np.packbits(mask).tobytes(), *mask.shape), pixel, source)
