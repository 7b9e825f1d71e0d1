"""Why a ray-traced pixel has its colour: its trees of rays, with all that each ray gathered."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace import ray_log as columns
from isophote.rendering.exposure import Moment, expose
from isophote.rendering.method import Job
from isophote.rendering.pixel_filter import as_pixel_filter, filter_table
from isophote.rendering.pool import Tile
from isophote.rendering.ray_tiles import RayTiles, new_log
from isophote.rendering.ray_trace import RayTrace
from isophote.scene.light import RectLight
from isophote.scene.scene import Scene
from isophote.shapes.mesh import Mesh

__all__ = ["LightTerm", "LoggedRay", "PixelLog", "log_pixel"]

Triple: TypeAlias = tuple[float, float, float]
Array: TypeAlias = npt.NDArray[np.float64]

_KINDS = {
    int(columns.CAMERA): "camera",
    int(columns.REFLECTED): "reflected",
    int(columns.REFRACTED): "refracted",
    int(columns.PASSED): "passed",
}
_ENDS = {int(columns.ENDED_BY_DEPTH): "depth", int(columns.ENDED_BY_WEIGHT): "weight"}
_MET = {int(columns.NOTHING): "nothing", int(columns.LAMP): "light", int(columns.SURFACE): "surface"}
_FIRST_RAYS, _FIRST_LIGHTS = 1024, 4096


@attrs.frozen
class LightTerm:
    """One shadow ray: what a light adds to a ray's colour.

    `light` is the light's number, counted on from the items', and `trial` the number of the ray among those to this
    light. `arriving` is the irradiance of a surface that faces it, or the radiance of a light with a size; `value` is
    f cosθ and `factor` 1 / (n · density) where there are n rays to a light with a size, else 1. `seen`: whether nothing
    is in the way.
    """

    light: int
    trial: int
    direction: Triple
    distance: float
    arriving: Triple
    value: Triple
    factor: float
    seen: bool

    @property
    def colour(self) -> Triple:
        """arriving · value · factor, or black where the light is not seen."""
        if not self.seen:
            return 0.0, 0.0, 0.0
        r, g, b = (a * v * self.factor for a, v in zip(self.arriving, self.value, strict=True))
        return r, g, b


@attrs.frozen
class LoggedRay:
    """A ray of a pixel: where it went, what it met, and its colour.

    `kind` is "camera", "reflected", "refracted" or "passed" (straight on, through what does not bend it); `parent` is
    the number of the ray that it branched from, or -1, and `weight` its share in that ray's colour, or, of a camera
    ray, in the pixel's. `ended` says why a ray was not traced: "depth", "weight", or None for those that were.

    `met` is "surface", "light" or "nothing", `item` that item's or light's number, `primitive` the face's and
    `barycentric` the weights of its triangle's corners (None on what has no triangles). `tint` is what the medium on
    the way left of the light, `emitted` what came from the surface, light or sky itself, `ambient` what the surface
    scatters of a constant sky. Then colour = tint · (emitted + ambient + Σ colour of `lights` + Σ weight · colour of
    its branches).
    """

    sample: int
    kind: str
    parent: int
    level: int
    weight: Triple
    origin: Triple
    direction: Triple
    ended: str | None
    met: str
    distance: float
    item: int
    primitive: int
    barycentric: Triple | None
    place: Triple
    normal: Triple
    shading: Triple
    uv: tuple[float, float]
    tint: Triple
    emitted: Triple
    ambient: Triple
    lights: tuple[LightTerm, ...]
    colour: Triple


@attrs.frozen
class PixelLog:
    """The rays of a pixel, parents before their branches, and its colour: Σ weight · colour over the camera rays."""

    pixel: tuple[int, int]
    colour: Triple
    rays: tuple[LoggedRay, ...]


def log_pixel(job: Job, method: RayTrace, pixel: tuple[int, int]) -> PixelLog:
    """Trace the rays of `pixel` (column, row) as a picture of `job` by `method` would, and log them.

    With a limit of time or noise the pixel gets as many samples as it has without. Raises `RenderError` for pixels
    outside the picture.
    """
    x, y = pixel
    width, height = job.size
    if not (0 <= x < width and 0 <= y < height):
        raise RenderError(f"pixel must be (column, row) within {width} × {height}, not {pixel!r}")
    method = attrs.evolve(method, seconds=None, noise=None)
    moments, _ = expose(job, method.accelerator)
    log, tiles = _traced(moments, job, method, (x, y), _FIRST_RAYS, _FIRST_LIGHTS)
    rays, lights = (int(count) for count in log.arrays["counts"])
    if rays > _FIRST_RAYS or lights > _FIRST_LIGHTS:
        log, tiles = _traced(moments, job, method, (x, y), rays, lights)
    r, g, b = tiles.film.mean()[y, x].tolist()
    shares = _shares(log, rays, method, width * height)
    return PixelLog((x, y), (r, g, b), _records(log, rays, lights, shares, _in_triangles(job.scene)))


def _in_triangles(scene: Scene) -> frozenset[int]:
    """Numbers of the items and lights that are made of triangles."""
    shapes = [item.shape for item in scene.items] + list(scene.lights)
    return frozenset(number for number, shape in enumerate(shapes) if isinstance(shape, Mesh | RectLight))


def _traced(
    moments: Sequence[Moment],
    job: Job,
    method: RayTrace,
    pixel: tuple[int, int],
    rays: int,
    lights: int,
) -> tuple[Packed, RayTiles]:
    """A log with so many rows, and the film of the pixel alone."""
    x, y = pixel
    log = new_log(rays, lights)
    tiles = RayTiles(method, moments, job, 1, log)
    tiles.film.target[y, x] = method.limits.planned
    tiles.trace(Tile(x, x + 1, y, y + 1), 0)
    return log, tiles


def _shares(log: Packed, rays: int, method: RayTrace, pixels: int) -> Array:
    """(rays,): what share camera rays have in the pixel, as the film has it; 1 for others."""
    numbers = log.arrays["ray_numbers"][:rays]
    camera = numbers[:, columns.KIND] == columns.CAMERA
    below = camera & (numbers[:, columns.FILM_PLACE] >= pixels)
    above = camera & ~below
    excess = filter_table(as_pixel_filter(method.filter)).excess
    if not below.any() or not above.any():
        return np.where(camera, 1 / max(1, camera.sum()), 1.0)
    over, under = (1 + excess) / above.sum(), -excess / below.sum()
    return np.where(camera, np.where(below, under, over), 1.0)


def _records(log: Packed, rays: int, lights: int, shares: Array, cut: frozenset[int]) -> tuple[LoggedRay, ...]:
    values, numbers = log.arrays["rays"][:rays].astype(np.float64), log.arrays["ray_numbers"][:rays]
    terms: list[list[LightTerm]] = [[] for _ in range(rays)]
    for row, number in zip(log.arrays["lights"][:lights], log.arrays["light_numbers"][:lights], strict=True):
        terms[number[columns.RAY]].append(_term(row.astype(np.float64), number))
    colours = _colours(values, numbers, terms)
    made = zip(values, numbers, terms, colours, shares, strict=True)
    return tuple(_ray(cut, *one) for one in made)


def _triple(row: Array, column: int | np.signedinteger[Any]) -> Triple:
    x, y, z = row[column : column + 3].tolist()
    return x, y, z


def _term(row: Array, number: npt.NDArray[np.int64]) -> LightTerm:
    return LightTerm(
        int(number[columns.LIGHT]),
        int(number[columns.TRIAL]),
        _triple(row, columns.TOWARDS),
        float(row[columns.REACH]),
        _triple(row, columns.ARRIVING),
        _triple(row, columns.VALUE),
        float(row[columns.FACTOR]),
        bool(number[columns.SEEN]),
    )


def _colours(values: Array, numbers: npt.NDArray[np.int64], terms: list[list[LightTerm]]) -> Array:
    """(rays, 3), from the last rays to the first, since branches come after their parents."""
    colours = np.zeros((len(values), 3))
    for row in range(len(values) - 1, -1, -1):
        value, number = values[row], numbers[row]
        gathered = value[columns.EMITTED :][:3] + value[columns.AMBIENT :][:3]
        gathered = gathered + sum((np.array(term.colour) for term in terms[row]), np.zeros(3)) + colours[row]
        colours[row] = value[columns.TINT :][:3] * gathered if number[columns.ENDED] == columns.TRACED else 0.0
        parent = number[columns.PARENT]
        if parent >= 0:
            colours[parent] += value[columns.WEIGHT :][:3] * colours[row]
    return colours


def _ray(
    cut: frozenset[int],
    value: Array,
    number: npt.NDArray[np.int64],
    terms: list[LightTerm],
    colour: Array,
    share: float,
) -> LoggedRay:
    w1, w2 = value[columns.CORNERS :][:2].tolist()
    u, v = value[columns.UV :][:2].tolist()
    return LoggedRay(
        sample=int(number[columns.SAMPLE]),
        kind=_KINDS[int(number[columns.KIND])],
        parent=int(number[columns.PARENT]),
        level=int(number[columns.LEVEL]),
        weight=_triple(value * share, columns.WEIGHT),
        origin=_triple(value, columns.ORIGIN),
        direction=_triple(value, columns.DIRECTION),
        ended=_ENDS.get(int(number[columns.ENDED])),
        met=_MET[int(number[columns.MET])],
        distance=float(value[columns.DISTANCE]),
        item=int(number[columns.ITEM]),
        primitive=int(number[columns.PRIMITIVE]),
        barycentric=(1 - w1 - w2, w1, w2) if int(number[columns.ITEM]) in cut else None,
        place=_triple(value, columns.PLACE),
        normal=_triple(value, columns.NORMAL),
        shading=_triple(value, columns.SHADING),
        uv=(u, v),
        tint=_triple(value, columns.TINT),
        emitted=_triple(value, columns.EMITTED),
        ambient=_triple(value, columns.AMBIENT),
        lights=tuple(terms),
        colour=_triple(colour, 0),
    )
