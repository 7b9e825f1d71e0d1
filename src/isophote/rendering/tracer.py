"""Rays over arrays: the queries behind every picture, for everyone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace.count import count_rays
from isophote.kernels.trace.primitive_rays import closest_primitive_rays, occluded_primitive_rays
from isophote.kernels.trace.rays import QUERY, closest_rays, describe_hits, occluded_rays
from isophote.kernels.trace.wave import new_wave
from isophote.lower.counting import counting
from isophote.lower.field_table import scratch_words
from isophote.lower.scene import lower_scene
from isophote.rendering.method import checked_accelerator
from isophote.rendering.pool import Pool, checked_threads
from isophote.scene.camera import Camera
from isophote.scene.scene import Item, Scene, Shape

__all__ = ["Counts", "Hits", "Tracer"]

Floats: TypeAlias = npt.NDArray[np.float32]
Ints: TypeAlias = npt.NDArray[np.int32]
_RayArrays: TypeAlias = tuple[Floats, Floats, Floats]
_Words: TypeAlias = npt.NDArray[np.int64]

_WRONG = {
    1: "origins must be finite in single precision, but number {number} is not",
    2: "directions must be finite in single precision, but number {number} is not",
    3: "directions must not be zero or shorter than 1e-8, but number {number} is",
    4: "max_distance must not be NaN, but number {number} is",
}
_RAYS_A_JOB = 16_384
_WAVE = 272
# The columns of QUERY that are not asked for.
_NOTHING: dict[str, npt.NDArray[Any]] = {
    "distance": np.zeros(0, np.float32),
    "uv": np.zeros((0, 2), np.float32),
    "item": np.zeros(0, np.int32),
    "primitive": np.zeros(0, np.int32),
    "slot": np.zeros(0, np.int32),
    "instance": np.zeros(0, np.int32),
    "blocked": np.zeros(0, np.uint8),
}


@attrs.frozen(eq=False)
class Hits:
    """What n rays meet first.

    `distance` (n,) float32 in lengths of the direction, inf where nothing is met; `item` and `primitive` (n,) int32:
    numbers of the item in the scene and of the face in its mesh (of a primitive: the part of its surface), -1 for none;
    `uv` (n, 2): weights of the second and third corner of the triangle that was hit, or texture coordinates of a
    primitive. `uv`, `point` and `normal` are worked out when they are asked for.
    """

    distance: Floats
    item: Ints
    primitive: Ints
    _uv: Floats = attrs.field(repr=False)
    _rays: tuple[Floats, Floats] = attrs.field(repr=False)
    _query: Packed = attrs.field(repr=False)
    _scene: Packed = attrs.field(repr=False)

    @property
    def point(self) -> npt.NDArray[np.float64]:
        """(n, 3): where the rays meet something, NaN where they do not."""
        reach = np.where(self.hit, self.distance, np.nan).astype(np.float64)
        points: npt.NDArray[np.float64] = self._rays[0].astype(np.float64) + self._rays[1] * reach[:, None]
        return points

    @property
    def normal(self) -> Floats:
        """(n, 3): unit normals, outward (of triangles the geometric ones); zeros where nothing is met."""
        normals = np.zeros((len(self.item), 3), np.float32)
        scratch = np.zeros(scratch_words(self._scene.arrays["fields"]), np.float32)
        describe_hits(self._scene.words, self._query.words, scratch, normals)
        return normals

    @property
    def uv(self) -> Floats:
        """(n, 2): weights of corners, or texture coordinates; zeros on fields and where nothing is met."""
        if len(self._scene.arrays["primitives"].arrays["numbers"]):
            # They come with the normals.
            _ = self.normal
        return self._uv

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """(n,): whether anything is met."""
        return self.item >= 0


class Counts(NamedTuple):
    """What n rays visit up to their first hit, (n,) int32 each.

    `nodes`: nodes, cells or planes of the accelerator, leaves among them; `primitives`: triangles, exact primitives and
    fields that a ray is tested against, as often as it is; `depth`: the deepest level that it reaches, 0 for the
    root's. Where a scene has instances, those of the accelerator over these are nodes too, and nodes and triangles are
    summed over those whose boxes the ray enters.
    """

    nodes: Ints
    primitives: Ints
    depth: Ints


class _Queries(NamedTuple):
    """The kernels that answer: they fill a QUERY."""

    closest: Callable[..., tuple[int, int]]
    occluded: Callable[..., tuple[int, int]]


_OF_ANYTHING = _Queries(closest_rays, occluded_rays)
_OF_PRIMITIVES = _Queries(closest_primitive_rays, occluded_primitive_rays)


class Tracer:
    """A scene made ready for rays; `subject` is a shape, an item or a scene. The accelerator is built once.

    Rays run in single precision. Lights that are no items are not met. Endless fields end far away: a thousand sizes of
    what is finite beside them.
    """

    def __init__(self, subject: Shape | Item | Scene, *, accelerator: str = "bvh", threads: int | None = None) -> None:
        scene = (
            subject if isinstance(subject, Scene) else Scene([subject if isinstance(subject, Item) else Item(subject)])
        )
        self._threads = checked_threads(threads)
        # The tables need some camera; rays do not.
        view = Scene(scene.still().items, camera=Camera((0, 0, 1), (0, 0, 0)))
        self._scene = lower_scene(view, (1, 1), threads, checked_accelerator(accelerator))
        tables = {name: self._scene.arrays[name].arrays for name in ("geometry", "fields", "primitives")}
        others = len(tables["geometry"]["blocks"]) + len(tables["fields"]["numbers"])
        only_primitives = not others and len(tables["primitives"]["numbers"]) > 0
        self._queries = _OF_PRIMITIVES if only_primitives else _OF_ANYTHING

    def closest(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        max_distance: npt.ArrayLike = np.inf,
        *,
        coherent: bool = False,
    ) -> Hits:
        """The first hit of each ray at 0 < distance < `max_distance`.

        `origins` and `directions` (n, 3), or one row for all; directions may have any length from 1e-8 up. `coherent`
        tells that neighbours in the arrays go much the same way, as a camera's rays do: sixteen are then traced
        together. Raises `RenderError` for other shapes, NaN, infinite, zero or shorter directions, and
        origins so far away that endless fields are not followed there.
        """
        rays = self._checked(_rays(origins, directions, max_distance))
        count = len(rays[0])
        distance, uv = np.empty(count, np.float32), np.empty((count, 2), np.float32)
        item, primitive, slot, instance = (np.empty(count, np.int32) for _ in range(4))
        found = {"distance": distance, "uv": uv, "item": item, "primitive": primitive, "slot": slot}
        query = self._run(self._queries.closest, rays, coherent, **_NOTHING | found | {"instance": instance})
        return Hits(distance, item, primitive, uv, rays[:2], query, self._scene)

    def occluded(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        max_distance: npt.ArrayLike = np.inf,
        *,
        coherent: bool = False,
    ) -> npt.NDArray[np.bool_]:
        """(n,): whether each ray meets anything at 0 < distance < `max_distance`; arguments as for `closest`."""
        rays = self._checked(_rays(origins, directions, max_distance))
        blocked = np.zeros(len(rays[0]), np.uint8)
        self._run(self._queries.occluded, rays, coherent, **_NOTHING | {"blocked": blocked})
        return blocked.view(np.bool_)

    def count(self, origins: npt.ArrayLike, directions: npt.ArrayLike, max_distance: npt.ArrayLike = np.inf) -> Counts:
        """What each ray visits up to its first hit; arguments as for `closest`. Other queries count nothing and
        lose no time by it."""
        rays = self._checked(_rays(origins, directions, max_distance))
        counts = np.zeros((3, len(rays[0])), np.int32)
        scene = counting(self._scene)

        def kernel(scene_words: _Words, query: _Words, wave: _Words, first: int, last: int, _: bool) -> tuple[int, int]:
            fault: tuple[int, int] = count_rays(scene.words, query, wave, counts, first, last)
            return fault

        self._run(kernel, rays, False, **_NOTHING)
        return Counts(*counts)

    def _checked(self, rays: _RayArrays) -> _RayArrays:
        """Rays that start where endless fields are whole. Raises `RenderError` for others."""
        horizon = self._scene.arrays["fields"].arrays.get("horizon")
        if horizon is not None:
            outside = ((rays[0] < horizon[0]) | (rays[0] > horizon[1])).any(axis=1)
            if outside.any():
                number = int(np.argmax(outside))
                raise RenderError(
                    f"origins must lie in the box {horizon.tolist()}, beyond which endless shapes are not followed, "
                    f"but number {number} is {rays[0][number].tolist()}; give the shapes bounds"
                )
        return rays

    def _run(
        self,
        kernel: Callable[..., tuple[int, int]],
        rays: _RayArrays,
        coherent: bool,
        **found: npt.NDArray[Any],
    ) -> Packed:
        origins, directions, limit = rays
        count = len(origins)
        query = QUERY.pack(origins=origins, directions=directions, limit=limit, **found)
        pool = Pool(self._threads)
        words = scratch_words(self._scene.arrays["fields"])
        jobs = range(0, count, _RAYS_A_JOB)
        waves = [new_wave(_WAVE, words) for _ in range(min(pool.threads, len(jobs)))]

        def work(first: int, thread: int) -> None:
            last = min(first + _RAYS_A_JOB, count)
            kind, number = kernel(self._scene.words, query.words, waves[thread].words, first, last, coherent)
            if kind:
                raise RenderError(_WRONG[kind].format(number=number))

        pool.run(work, jobs, lambda done: None)
        if pool.interrupted:
            # Rays that were not traced have no answers, so there is nothing to give back.
            raise KeyboardInterrupt
        return query


def _rays(origins: npt.ArrayLike, directions: npt.ArrayLike, max_distance: npt.ArrayLike) -> _RayArrays:
    """Origins, directions (n, 3) and limits (n,), contiguous float32."""
    o, d = (_triples(name, values) for name, values in (("origins", origins), ("directions", directions)))
    try:
        o, d = np.broadcast_arrays(o, d)
        with np.errstate(over="ignore"):
            limit = np.broadcast_to(np.asarray(max_distance, np.float32), len(o))
    except ValueError:
        raise RenderError(
            f"origins {o.shape}, directions {d.shape} and max_distance {np.shape(max_distance)} are not of one length"
        ) from None
    return np.ascontiguousarray(o), np.ascontiguousarray(d), np.ascontiguousarray(limit)


def _triples(name: str, values: npt.ArrayLike) -> Floats:
    # What is too large for single precision becomes infinite, and is refused as such.
    try:
        with np.errstate(over="ignore"):
            array = np.atleast_2d(np.asarray(values, np.float32))
    except (TypeError, ValueError):
        raise RenderError(f"{name} must be numbers of shape (n, 3), not {values!r}") from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise RenderError(f"{name} must have shape (n, 3), but have {np.shape(values)}")
    return array
