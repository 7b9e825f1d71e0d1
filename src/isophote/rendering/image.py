"""Pictures as values: named channels over the same pixels, and how they were made."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, RenderError
from isophote.io.files import StrPath
from isophote.io.picture_file import read_picture, write_picture
from isophote.io.png import encode_png
from isophote.io.save import save

__all__ = ["Image", "load_image"]

Array: TypeAlias = npt.NDArray[Any]

# How many values a pixel has in each of the standard channels; (h, w) where it is one.
_COUNTS = {
    "colour": 3,
    "alpha": 1,
    "depth": 1,
    "distance": 1,
    "normal": 3,
    "albedo": 3,
    "uv": 2,
    "item": 1,
    "primitive": 1,
    "variance": 3,
    "samples": 1,
}
_NUMBERS = ("item", "primitive", "samples")
_INT32 = np.iinfo(np.int32)


def _channels(given: Mapping[str, npt.ArrayLike]) -> Mapping[str, Array]:
    if not isinstance(given, Mapping) or "colour" not in given:
        raise RenderError('a picture needs a mapping of channels with "colour" in it')
    channels = {str(name): _channel(str(name), values) for name, values in given.items()}
    sizes = {array.shape[:2] for array in channels.values()}
    if len(sizes) > 1 or 0 in channels["colour"].shape:
        found = ", ".join(f"{name} {array.shape}" for name, array in channels.items())
        raise RenderError(f"the channels of a picture must have one size, of one pixel or more, but are {found}")
    return MappingProxyType(channels)


def _channel(name: str, values: npt.ArrayLike) -> Array:
    array = np.asarray(values)
    count = _COUNTS.get(name, array.shape[2] if array.ndim == 3 else 1)
    if array.ndim == 3 and count == 1:
        array = array[..., 0] if array.shape[2] == 1 else array
    if array.ndim != (2 if count == 1 else 3) or (count > 1 and array.shape[2] != count):
        wanted = "(h, w)" if count == 1 else f"(h, w, {count})"
        raise RenderError(f'channel "{name}" must have shape {wanted}, but has {array.shape}')
    if count > 4 or array.dtype.kind not in "biuf":
        raise RenderError(f'channel "{name}" must hold up to 4 numbers a pixel, but is {array.dtype} {array.shape}')
    typed = _typed(name, array)
    # What nobody can write to, such as another picture's channel, is shared; everything else is copied.
    own = np.ascontiguousarray(typed)
    if own.flags.writeable and np.may_share_memory(own, array):
        own = own.copy()
    view = own.view()
    view.flags.writeable = False
    return view


def _typed(name: str, array: Array) -> Array:
    if name in _NUMBERS:
        if array.dtype.kind not in "iu":
            raise RenderError(f'channel "{name}" must hold whole numbers, but is {array.dtype}')
        if array.size and not _INT32.min <= int(array.min()) <= int(array.max()) <= _INT32.max:
            raise RenderError(f'channel "{name}" holds numbers beyond 32 bits')
        return array.astype(np.int32, copy=False)
    if array.dtype.kind == "f" or name in _COUNTS:
        with np.errstate(over="ignore"):
            return array.astype(np.float32, copy=False)
    return array


def _metadata(given: Mapping[str, str]) -> Mapping[str, str]:
    return MappingProxyType({str(key): str(value) for key, value in given.items()})


@attrs.frozen(eq=False, repr=False)
class Image:
    """A picture: `channels` by name, all of one size, and `metadata`, texts that say how it was made.

    "colour" is always there, (h, w, 3) float32, linear Rec. 709, row 0 at the top. Others are there where the
    method gives them: "depth" along the viewing axis and "distance" along the ray, (h, w), in metres, infinite
    where nothing is hit; "normal" (h, w, 3), "albedo" (h, w, 3), "uv" (h, w, 2); "item" and "primitive", (h, w)
    int32, exact, -1 where nothing is hit; "variance" of the colour's mean, (h, w, 3); "samples", (h, w) int32, how many
    there are in the pixel; and any further (h, w) or (h, w, 1 to 4). Floats are float32; arrays are read-only.

    Raises `RenderError` for a missing colour, shapes that do not fit, and pictures without pixels.
    """

    channels: Mapping[str, Array] = attrs.field(converter=_channels)
    metadata: Mapping[str, str] = attrs.field(factory=dict, converter=_metadata)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        height, width = self.channels["colour"].shape[:2]
        return width, height

    def with_(self, **changes: Any) -> Image:
        """The picture with other channels or metadata."""
        return attrs.evolve(self, **changes)

    def denoised(self, denoiser: str = "auto", *, threads: int | None = None) -> Image:
        """The picture with less noise, by its "variance" and, where they are there, "albedo", "normal" and "depth".

        `denoiser` is "oidn" for Open Image Denoise (`pip install "isophote[denoise]"`), "filter" for our own filter,
        or "auto" for the first where it is installed. The result has no variance. Raises `RenderError` where the
        denoiser is unknown or not installed, and, of the filter, where there is no variance.
        """
        # Loads the kernels, which pictures by themselves do without.
        from isophote.rendering.denoise import denoised_colour

        return self.with_denoised(*denoised_colour(self.channels, denoiser=denoiser, threads=threads))

    def with_denoised(self, colour: Array, by: str) -> Image:
        """The picture with this colour, denoised `by` something, and without the noise's variance."""
        kept = {name: array for name, array in self.channels.items() if name != "variance"}
        return Image({**kept, "colour": colour}, {**self.metadata, "denoised": f"by {by}"})

    def save(self, path: StrPath) -> None:
        """Write the picture by the ending of its name, whole or not at all.

        .exr holds all channels and the metadata; .png the colour in 8-bit sRGB and the metadata; .jpg, .webp,
        .tif and .bmp the colour in 8-bit sRGB. Raises `FileError` where that cannot be.
        """
        write_picture(path, self.channels, self.metadata)

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> Array:
        colour = self.channels["colour"]
        converted = colour.astype(dtype or colour.dtype, copy=bool(copy))
        if copy is False and converted is not colour:
            raise ValueError(f"a picture's colour is {colour.dtype}; {np.dtype(dtype)} needs a copy")
        return converted

    def _repr_png_(self) -> bytes:
        return encode_png(self.channels["colour"], self.metadata)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Image):
            return NotImplemented
        return (
            dict(self.metadata) == dict(other.metadata)
            and self.channels.keys() == other.channels.keys()
            and all(_same(array, other.channels[name]) for name, array in self.channels.items())
        )

    def __hash__(self) -> int:
        return hash((self.size, frozenset(self.channels), frozenset(self.metadata.items())))

    def __reduce__(self) -> tuple[type[Image], tuple[dict[str, Array], dict[str, str]]]:
        return Image, (dict(self.channels), dict(self.metadata))

    def __repr__(self) -> str:
        width, height = self.size
        return f"<Image: {width} by {height}; {', '.join(self.channels)}>"


def _same(a: Array, b: Array) -> bool:
    return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")


@save.register
def _(thing: Image, path: StrPath, **options: object) -> None:
    if options:
        raise FileError(path, f"pictures are written without options, but {', '.join(options)} is given")
    thing.save(path)


def load_image(path: StrPath) -> Image:
    """Read a picture file as an `Image`: an EXR with all its channels and texts, a PNG with its texts.

    8-bit colours become linear. Raises `FileError` for files that are no pictures, or hold no colour.
    """
    channels, metadata = read_picture(path)
    try:
        return Image(channels, metadata)
    except RenderError as error:
        raise FileError(path, str(error)) from error
