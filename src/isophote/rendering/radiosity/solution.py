"""What radiosity found: light on patches, a mesh that shows it from anywhere, and how it settled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.io.files import StrPath
from isophote.io.save import save
from isophote.rendering.image import Image
from isophote.rendering.method import Array, Size, checked_size
from isophote.rendering.radiosity.backdrop import sky_radiance
from isophote.rendering.radiosity.hierarchy import Settled
from isophote.rendering.radiosity.surface import Surface, surface_of
from isophote.rendering.radiosity.uniform import UniformSettled
from isophote.rendering.tracer import Tracer
from isophote.scene.camera import AnyCamera, Camera
from isophote.scene.light import Environment, Light, Sky
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["RadiositySolution"]

Points: TypeAlias = npt.NDArray[np.float64]

_ROWS_AT_ONCE = 64


@attrs.frozen(eq=False, repr=False)
class RadiositySolution:
    """The balance of light B = E + ρ H on n patches.

    `corners` (n, 4, 3), the last of a triangle NaN; `areas` (n,) in m²; `albedo`, and in W/m² `irradiance` H and
    `radiosity` B (n, 3); `item` (n,) the number of each patch's item or light. `residuals`: by how much each bounce
    changed the radiosity of any patch, in parts of the most that any reflects, or where it was gathered, of the most at
    all; where light was shot, a step is half of what was left, and the residual what part of all light still is.
    `form_factor_sums` (n,): Σ F of each patch, 1 where it sees surfaces to all sides, NaN where it was not needed.
    `links`: between how many pairs light was exchanged. `mesh` holds the radiance B / π as the linear attribute
    "colour" of its vertices, smooth within planes and smooth meshes.
    """

    corners: Points
    areas: Points
    albedo: Points
    irradiance: Points
    radiosity: Points
    item: npt.NDArray[np.int64]
    residuals: tuple[float, ...]
    form_factor_sums: Points
    links: int
    mesh: Mesh
    _settled: Settled | UniformSettled = attrs.field(repr=False)
    _surface: Surface = attrs.field(repr=False)
    _lights: tuple[Light, ...] = attrs.field(repr=False)

    @property
    def bounce_count(self) -> int:
        """How many bounces of light were added up."""
        return len(self.residuals)

    def bounce(self, number: int) -> Mesh:
        """`mesh` as it is after so many bounces: with 0 only what shines, with 1 direct light, and so on."""
        whole = isinstance(number, int | np.integer) and not isinstance(number, bool)
        if not whole or not 0 <= number <= self.bounce_count:
            raise RenderError(f"bounce: there are bounces 0 to {self.bounce_count}, but not {number!r}")
        return _mesh(self._settled, self._surface, number)

    def image(
        self, camera: AnyCamera, size: Size = (640, 480), *, samples: int = 16, bounce: int | None = None
    ) -> Image:
        """The picture that a camera takes of the solution: `samples` rays a pixel, rounded to a square, on a grid.

        With `bounce` as it is after so many bounces. Behind all patches the sky is seen. The channel "patch" tells
        patches apart.
        """
        if not isinstance(camera, AnyCamera):
            raise RenderError(f"image: camera must be a Camera or an OrthographicCamera, not {camera!r}")
        mesh = self.mesh if bounce is None else self.bounce(bounce)
        return picture_of(mesh, self._surface, self._settled, camera, checked_size(size), samples, self._lights)

    def save(self, path: StrPath) -> None:
        """Write `mesh`, as GLB or PLY (which keep colours), or any other format of meshes."""
        save(self.mesh, path)

    def __repr__(self) -> str:
        residual = self.residuals[-1] if self.residuals else 0.0
        return f"<RadiositySolution: {len(self.areas):,} patches, {self.links:,} links, residual {residual:.1e}>"


def solution_of(settled: Settled | UniformSettled, lights: Sequence[Light] = ()) -> RadiositySolution:
    """What a tree in balance says, of whose `lights` the skies are seen behind it."""
    tree, leaves = settled.tree, settled.tree.leaves
    surface = surface_of(tree)
    corners = tree.corners[leaves].copy()
    corners[tree.sides[leaves] == 3, 3] = np.nan
    return RadiositySolution(
        corners=corners,
        areas=tree.areas[leaves],
        albedo=tree.albedo[leaves],
        irradiance=settled.irradiance,
        radiosity=settled.light[leaves],
        item=tree.faces.item[tree.face[leaves]],
        residuals=settled.residuals,
        form_factor_sums=settled.form_factor_sums,
        links=settled.links,
        mesh=_mesh(settled, surface, len(settled.bounces) - 1),
        settled=settled,
        surface=surface,
        lights=tuple(lights),
    )


def _mesh(settled: Settled | UniformSettled, surface: Surface, number: int) -> Mesh:
    """Radiance at vertices after so many bounces: that of leaves at these places, blended where leaves meet."""
    radiosity = settled.radiosity_at(number, surface.leaf, surface.place)
    colour = np.maximum(surface.averaged(radiosity), 0.0) / np.pi
    return Mesh(surface.vertices, surface.triangles, attributes={"colour": Attribute(colour.astype(np.float32))})


def picture_of(
    mesh: Mesh,
    surface: Surface,
    settled: Settled | UniformSettled,
    camera: AnyCamera,
    size: Size,
    samples: int,
    lights: Sequence[Light],
) -> Image:
    """Rays through a grid of places in each pixel, met by the mesh, coloured by its vertices, or by skies behind it."""
    if isinstance(samples, bool) or not isinstance(samples, int | np.integer) or not 1 <= samples <= 1024:
        raise RenderError(f"Radiosity: samples must be a whole number from 1 to 1024, not {samples!r}")
    width, height = size
    tracer = Tracer(mesh)
    skies = [light for light in lights if isinstance(light, Sky | Environment)]
    grid = max(1, round(float(samples) ** 0.5))
    colours = np.asarray(mesh.colours.values, np.float64) if mesh.colours is not None else np.zeros((0, 3))
    colour = np.zeros((height, width, 3))
    for first in range(0, height, _ROWS_AT_ONCE):
        rows = np.arange(first, min(first + _ROWS_AT_ONCE, height))
        for k in range(grid * grid):
            shift = (k % grid + 0.5) / grid, (k // grid + 0.5) / grid
            origins, directions = _rays(camera, size, rows, shift)
            hits = tracer.closest(origins, directions, coherent=True)
            met = np.flatnonzero(hits.hit)
            corners = colours[mesh.faces[hits.primitive[met]]]
            u, v = hits.uv[met].astype(np.float64).T[..., None]
            blended = corners[:, 0] * (1 - u - v) + corners[:, 1] * u + corners[:, 2] * v
            flat = colour[rows].reshape(-1, 3)
            flat[met] += blended
            if skies:
                beyond = np.flatnonzero(~hits.hit)
                flat[beyond] += sky_radiance(skies, directions[beyond])
            colour[rows] = flat.reshape(len(rows), width, 3)
    channels: dict[str, Array] = {"colour": (colour / grid**2).astype(np.float32)}
    return Image({**channels, **_features(tracer, settled, surface, camera, size)})


def _rays(
    camera: AnyCamera, size: Size, rows: npt.NDArray[np.int64], shift: tuple[float, float]
) -> tuple[Points, Points]:
    """Origins and directions through a place of every pixel of some rows, one row for each ray."""
    film = camera.linear_map(size)
    x, y = np.meshgrid(np.arange(size[0]) + shift[0], rows + shift[1])
    x, y = x.reshape(-1, 1), y.reshape(-1, 1)
    return film.o + x * film.ox + y * film.oy, film.d + x * film.dx + y * film.dy


def _features(
    tracer: Tracer, settled: Settled | UniformSettled, surface: Surface, camera: AnyCamera, size: Size
) -> dict[str, Array]:
    """Channels of what is seen at the centres of pixels."""
    width, height = size
    origins, directions = _rays(camera, size, np.arange(height), (0.5, 0.5))
    hits = tracer.closest(origins, directions, coherent=True)
    tree = settled.tree
    leaf = surface.leaf_of[np.maximum(hits.primitive, 0)]
    met = hits.hit[:, None]
    length = np.linalg.norm(directions, axis=1)
    channels: dict[str, Array] = {
        "depth": hits.distance.reshape(height, width),
        "distance": (hits.distance * length).astype(np.float32).reshape(height, width),
        "normal": np.where(met, tree.normals[leaf], 0).astype(np.float32).reshape(height, width, 3),
        "albedo": np.where(met, tree.albedo[leaf], 0).astype(np.float32).reshape(height, width, 3),
        "item": np.where(hits.hit, tree.faces.item[tree.face[leaf]], -1).astype(np.int32).reshape(height, width),
        "primitive": np.where(hits.hit, tree.faces.primitive[tree.face[leaf]], -1)
        .astype(np.int32)
        .reshape(height, width),
        "patch": np.where(hits.hit, leaf, -1).astype(np.int32).reshape(height, width),
    }
    if not isinstance(camera, Camera):
        channels["distance"] = channels["depth"]
    return channels
