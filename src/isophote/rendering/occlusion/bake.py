"""Ambient occlusion baked into a texture."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt

from isophote.errors import FileError, GeometryError, RenderError
from isophote.io.files import StrPath, write_bytes
from isophote.io.texture_png import encode_texture
from isophote.kernels.base.table import Packed
from isophote.kernels.trace import occlusion as kernels
from isophote.progress import ProgressLike, Reporter, reporter
from isophote.rendering.method import checked_seed
from isophote.rendering.occlusion.atlas import Atlas, atlas_of
from isophote.rendering.occlusion.points import ROUNDING, checked_reach, lowered, reach_of, trace
from isophote.scene.image_texture import ImageTexture
from isophote.scene.scene import Item, Scene, Shape
from isophote.shapes.mesh import Mesh

__all__ = ["BakedOcclusion", "bake_occlusion"]

Floats: TypeAlias = npt.NDArray[np.float32]

_MOST_SAMPLES = 2**20
# What a texel takes, in bytes: its triangle, place, value, and the nearest covered texel.
_BYTES_A_TEXEL = 72
_MOST_BYTES = 4 << 30
_TEXELS_AT_ONCE = 2**18


@attrs.frozen(eq=False)
class BakedOcclusion:
    """How open the sky is above the texels of a mesh's atlas.

    `visibility` (h, w) float32 is V = 1/π ∫ v cosθ dω, 1 open and 0 closed, in the faces' texels and the gutters around
    them, and 1 elsewhere; row 0 is the top, v = 1. `coverage` (h, w) bool tells the texels that faces touch.
    """

    visibility: Floats
    coverage: npt.NDArray[np.bool_]

    @property
    def texture(self) -> ImageTexture:
        """`visibility` at 8 bits, one channel, linear: for `Principled(occlusion_texture=...)`."""
        levels = np.floor(self.visibility * np.float32(255) + np.float32(0.5)).astype(np.uint8)
        return ImageTexture(levels, "linear", wrap="clamp", name="occlusion")

    def _repr_png_(self) -> bytes:
        return encode_texture(self.texture, "linear")

    def save(self, path: StrPath) -> None:
        """Write the texture as an 8-bit PNG of greys, whole or not at all. Raises `FileError`."""
        if not str(path).lower().endswith(".png"):
            raise FileError(path, "occlusion is saved as .png")
        write_bytes(path, encode_texture(self.texture, "linear"))


def bake_occlusion(
    subject: Mesh | Item,
    *,
    size: int = 1024,
    samples: int = 64,
    max_distance: float | None = None,
    gutter: int = 4,
    among: Shape | Item | Scene | None = None,
    bias: float | None = None,
    seed: int = 0,
    progress: ProgressLike = None,
    threads: int | None = None,
) -> BakedOcclusion:
    """How open the sky is above each texel of a mesh's atlas, by rays: see `ambient_occlusion`.

    The atlas is the mesh's own texture coordinates on `size` × `size` texels. A texel's point is where its centre lies
    on the mesh; where a face touches a texel beside its centre, the nearest place on the face. Normals are the mesh's
    attribute "normal" between corners, else those of its faces. Each point takes `samples` rays in proportion to the
    cosine, of at most `max_distance` metres, from `bias` metres above it (None: what single precision rounds away). The
    texels within `gutter` of a face's repeat the nearest of those, so that filters find no seam.

    The subject is in its own way, or else all of `among`, which has to hold it as it stands there. The same `seed`
    gives the same answer for any number of threads. Raises `GeometryError` for a mesh without texture coordinates, for
    coordinates that are not within 0 to 1 and for overlapping faces (`unwrap` makes others); `RenderError` for
    anything but a mesh, for numbers without meaning, and for sizes that would take more than 4 GiB.
    """
    item = subject if isinstance(subject, Item) else Item(_mesh(subject))
    mesh = _mesh(item.shape)
    if item.displacement is not None:
        raise RenderError("bake_occlusion: the item is displaced in pictures alone; isophote.displace makes its mesh")
    _check_numbers(size, samples, gutter, bias)
    reach, number = checked_reach(max_distance), checked_seed(seed)
    if among is not None and not isinstance(among, Item | Scene):
        among = Item(among)
    around = item if among is None else among
    try:
        atlas = atlas_of(mesh, int(size))
    except GeometryError as error:
        raise GeometryError(f"bake_occlusion: {error}") from None
    rays = _Rays(int(samples), reach, bias, max(reach_of(item), reach_of(around)), number)
    with reporter(progress) as report:
        values = _values(atlas, item.transform.matrix, lowered(around, threads), rays, report, threads)
    return BakedOcclusion(_spread(atlas.covered, values, int(gutter)), atlas.covered)


@attrs.frozen
class _Rays:
    """How rays are cast: `far` is the largest coordinate about."""

    samples: int
    reach: float
    bias: float | None
    far: float
    seed: int


def _mesh(shape: object) -> Mesh:
    if not isinstance(shape, Mesh):
        raise RenderError(
            f"bake_occlusion: only a Mesh has an atlas, not a {type(shape).__name__}; isophote.to_mesh makes a mesh "
            "of a field, and isophote.unwrap its atlas"
        )
    return shape


def _check_numbers(size: object, samples: object, gutter: object, bias: object) -> None:
    for name, value, least, most in (
        ("size", size, 1, 65_536),
        ("samples", samples, 1, _MOST_SAMPLES),
        ("gutter", gutter, 0, 65_536),
    ):
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
            raise RenderError(f"bake_occlusion: {name} must be a whole number from {least} to {most:,}, not {value!r}")
        if name == "size" and int(value) ** 2 * _BYTES_A_TEXEL > _MOST_BYTES:
            raise RenderError(
                f"bake_occlusion: size {value} would take {int(value) ** 2 * _BYTES_A_TEXEL / 2**30:.1f} GiB, more "
                f"than {_MOST_BYTES >> 30}; use {int((_MOST_BYTES / _BYTES_A_TEXEL) ** 0.5)} at most"
            )
    if bias is not None and not (isinstance(bias, int | float | np.number) and 0 <= bias < np.inf):
        raise RenderError(f"bake_occlusion: bias must be a number of metres, 0 or above, not {bias!r}")


def _values(
    atlas: Atlas, matrix: npt.NDArray[np.float64], scene: Packed, rays: _Rays, report: Reporter, threads: int | None
) -> Floats:
    """(n,) visibility of the covered texels."""
    count = len(atlas.triangle)
    values = np.empty(count, np.float32)
    turned = np.linalg.inv(matrix[:3, :3])
    for block, first in enumerate(range(0, count, _TEXELS_AT_ONCE)):
        last = min(first + _TEXELS_AT_ONCE, count)
        points, normals = atlas.places(first, last)
        points = points @ matrix[:3, :3].T + matrix[:3, 3]
        normals = normals @ turned
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        found = np.zeros((last - first, 4))
        openings = kernels.OPENINGS.pack(
            points=np.ascontiguousarray(points, np.float32),
            normals=np.ascontiguousarray(normals, np.float32),
            bias=np.full(last - first, ROUNDING * rays.far if rays.bias is None else rays.bias, np.float32),
            samples=rays.samples,
            # Points are numbered from 0 in each block: blocks must not share their random numbers.
            seed=checked_seed(rays.seed + (block << 32)),
            warp=kernels.COSINE,
            reach=rays.reach,
            directions=np.zeros((0, 4), np.float32),
            open=found,
        )
        trace(scene, openings, last - first, rays.samples, _part(report, first / count, last / count), threads)
        values[first:last] = found[:, 0] / rays.samples
    return values


def _part(report: Reporter, begin: float, end: float) -> Reporter:
    """A report of what is done between two parts of the whole."""
    return Reporter(lambda stage, done: report(stage, begin + done * (end - begin)))


def _spread(covered: npt.NDArray[np.bool_], values: Floats, gutter: int) -> Floats:
    """(h, w): the values of the covered texels, repeated up to `gutter` texels away, and 1 beyond."""
    texels = np.ones(covered.shape, np.float32)
    texels[covered] = values
    if gutter and not covered.all():
        distance, (rows, columns) = distance_transform_edt(~covered, return_indices=True)
        near = distance <= gutter
        texels[near] = texels[rows[near], columns[near]]
    return texels
