"""Ambient occlusion at points and at the vertices of a mesh."""

from __future__ import annotations

import functools
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.curvature.normals import vertex_normals
from isophote.convert.triangulate import triangulate
from isophote.errors import RenderError
from isophote.kernels.accel.bundle_rays import BUNDLE_SCRATCH
from isophote.kernels.base.table import Packed
from isophote.kernels.trace import occlusion as kernels
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.lower.scene import lower_scene
from isophote.progress import ProgressLike, Reporter, reporter
from isophote.rendering.method import checked_seed
from isophote.rendering.occlusion.directions import hemicube
from isophote.rendering.occlusion.order import near_each_other
from isophote.rendering.pool import Pool, checked_threads
from isophote.scene.camera import Camera
from isophote.scene.scene import Item, Scene, Shape
from isophote.shapes.field.field import Field
from isophote.shapes.mesh import Mesh

__all__ = ["ROUNDING", "Occlusion", "ambient_occlusion", "checked_reach", "lowered", "reach_of", "trace"]

Points: TypeAlias = npt.NDArray[np.float64]

_WARPS = {"cosine": kernels.COSINE, "uniform": kernels.UNIFORM}
_WAYS = ("rays", "hemicube", "field")
_MOST_SAMPLES = 2**20
_TAPS = 5
_WAVE = 1040
_RAYS_A_JOB = 65_536
# Room for the rounding of places in single precision, in parts of the largest coordinate.
ROUNDING = 64 * 2.0**-24


@attrs.frozen(eq=False)
class Occlusion:
    """How open the sky is above n points.

    `visibility` (n,) float32 is the part of the light of an even sky that arrives, V = 1/π ∫ v cosθ dω: 1 where nothing
    is in the way, 0 where everything is blocked. `bent_normal` (n, 3) float32 is the mean direction of that light, of
    length 1; zeros where nothing arrives.
    """

    visibility: npt.NDArray[np.float32]
    bent_normal: npt.NDArray[np.float32]

    @property
    def occlusion(self) -> npt.NDArray[np.float32]:
        """(n,): the part that is blocked, 1 − visibility."""
        return np.float32(1) - self.visibility


def ambient_occlusion(
    subject: Shape | Item | Scene,
    points: npt.ArrayLike | None = None,
    normals: npt.ArrayLike | None = None,
    *,
    samples: int = 64,
    max_distance: float | None = None,
    by: str = "rays",
    weights: str = "cosine",
    bias: float | None = None,
    seed: int = 0,
    progress: ProgressLike = None,
    threads: int | None = None,
) -> Occlusion:
    """How much of an even sky is seen from points on surfaces, V = 1/π ∫ v(ω) cosθ dω over the hemisphere of a normal.

    `points` and `normals` (n, 3) default to the vertices of `subject`, a mesh, and their normals (weighed by angle);
    normals may have any length but 0. All of `subject` is in the way, both sides of its surfaces, as far as
    `max_distance` metres (None: however far).

    `by="rays"` counts `samples` random rays a point; `weights="cosine"` picks them in proportion to the cosine,
    "uniform" evenly over the hemisphere, which measures ∫ v dω / 2π instead. `by="hemicube"` looks at the scene from
    each point onto the five faces of a half cube, `samples` pixels wide, and adds up what the pixels of the background
    count for. `by="field"` asks a field five times along the normal, up to `max_distance` above the point, and takes
    what is missing there of the height for blocked, 1 − Σ 2⁻ⁱ max(hᵢ − v(p + hᵢ n), 0) / hᵢ / Σ 2⁻ⁱ with hᵢ = i h / 5:
    a guess, but a quick and smooth one, as `SphereTrace` has it.

    Rays start `bias` metres above their points; by default at what single precision rounds away.

    The same `seed` gives the same answer for any number of threads. Raises `RenderError` for numbers without meaning.
    Source: Zhukov, Iones, Kronin, "An Ambient Light Illumination Model", 1998.
    """
    if by == "field":
        return _in_field(subject, points, normals, max_distance)
    scene = lowered(subject, threads)
    where = _points_of(subject, points, normals, bias)
    directions, count, warp = _directions(by, weights, samples)
    reach, number = checked_reach(max_distance), checked_seed(seed)
    order = near_each_other(where.points)
    sums = np.zeros((len(order), 4))
    openings = kernels.OPENINGS.pack(
        points=where.points[order],
        normals=where.normals[order],
        bias=where.bias[order],
        samples=count,
        seed=number,
        warp=warp,
        reach=reach,
        directions=directions,
        open=sums,
    )
    with reporter(progress) as report:
        trace(scene, openings, len(order), count, report, threads)
    found = np.empty_like(sums)
    found[order] = sums
    return _summed(found, 1.0 if warp == kernels.GIVEN else float(count))


def _in_field(
    subject: object, points: npt.ArrayLike | None, normals: npt.ArrayLike | None, reach: float | None
) -> Occlusion:
    if not isinstance(subject, Field) or points is None or normals is None or reach is None:
        raise RenderError(
            'ambient_occlusion: by="field" needs a Field (not an item or a scene), points, normals, and max_distance, '
            "the height up to which the field is asked"
        )
    where = _points_of(subject, points, normals, 0.0)
    checked_reach(reach)
    blocked, total = np.zeros(len(where.points)), 0.0
    for tap in range(1, _TAPS + 1):
        height = reach * tap / _TAPS
        values = subject(where.points + height * where.normals)
        blocked += 0.5**tap * np.clip((height - values) / height, 0.0, 1.0)
        total += 0.5**tap
    return Occlusion((1.0 - blocked / total).astype(np.float32), where.normals)


@attrs.frozen(eq=False)
class _Where:
    """Points in single precision, unit normals, and how far above the points rays start."""

    points: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    bias: npt.NDArray[np.float32]


def lowered(subject: Shape | Item | Scene, threads: int | None) -> Packed:
    """The tables of what stands in the way; lights are not part of it."""
    scene = subject if isinstance(subject, Scene) else Scene([subject if isinstance(subject, Item) else Item(subject)])
    # The tables need some camera; rays do not.
    return lower_scene(Scene(scene.items, camera=Camera((0, 0, 1), (0, 0, 0))), (1, 1), checked_threads(threads))


def trace(
    scene: Packed, openings: Packed, points: int, samples: int, report: Reporter, threads: int | None = None
) -> None:
    """Run the kernel over all points, on all threads. Raises `KeyboardInterrupt` where the user interrupts."""
    pool = Pool(threads)
    words = max(BUNDLE_SCRATCH, scratch_words(scene.arrays["fields"]))
    waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]
    step = max(1, _RAYS_A_JOB // samples)
    jobs = range(0, points, step)

    def work(first: int, thread: int) -> None:
        last = min(first + step, points)
        kernels.find_openings(scene.words, openings.words, waves[thread].words, first, last)

    pool.run(work, jobs, lambda done: report("ambient occlusion", done / max(1, len(jobs))))
    if pool.interrupted:
        raise KeyboardInterrupt


def _summed(found: Points, whole: float) -> Occlusion:
    size = np.linalg.norm(found[:, 1:], axis=1, keepdims=True)
    bent = np.divide(found[:, 1:], size, out=np.zeros_like(found[:, 1:]), where=size > 0)
    return Occlusion((found[:, 0] / whole).astype(np.float32), bent.astype(np.float32))


def _directions(by: str, weights: str, samples: int) -> tuple[npt.NDArray[np.float32], int, int]:
    """(directions, rays a point, how they are found)."""
    if by not in _WAYS:
        raise RenderError(f"ambient_occlusion: by must be one of {', '.join(map(repr, _WAYS))}, not {by!r}")
    if weights not in _WARPS:
        raise RenderError(f"ambient_occlusion: weights must be one of {', '.join(map(repr, _WARPS))}, not {weights!r}")
    if isinstance(samples, bool) or not isinstance(samples, int | np.integer) or not 1 <= samples <= _MOST_SAMPLES:
        raise RenderError(
            f"ambient_occlusion: samples must be a whole number from 1 to {_MOST_SAMPLES:,}, not {samples!r}"
        )
    if by == "rays":
        return np.zeros((0, 4), np.float32), int(samples), _WARPS[weights]
    if weights != "cosine":
        raise RenderError('ambient_occlusion: the pixels of a half cube are weighed by the cosine; weights="cosine"')
    if samples % 2 or samples > 1024:
        raise RenderError(f"ambient_occlusion: a half cube has an even number of pixels up to 1024, not {samples}")
    directions = _hemicube(int(samples))
    return directions, len(directions), kernels.GIVEN


_hemicube = functools.lru_cache(maxsize=2)(hemicube)


def checked_reach(max_distance: float | None) -> float:
    """`max_distance` as a number, infinite for None. Raises `RenderError`."""
    if max_distance is None:
        return np.inf
    if isinstance(max_distance, bool) or not isinstance(max_distance, int | float | np.number) or not max_distance > 0:
        raise RenderError(f"max_distance must be a number of metres above 0, or None, not {max_distance!r}")
    return float(max_distance)


def _points_of(
    subject: object, points: npt.ArrayLike | None, normals: npt.ArrayLike | None, bias: float | None
) -> _Where:
    if (points is None) != (normals is None):
        raise RenderError("ambient_occlusion: give points and normals together, or neither for a mesh's vertices")
    if bias is not None and not (isinstance(bias, int | float | np.number) and 0 <= bias < np.inf):
        raise RenderError(f"ambient_occlusion: bias must be a number of metres, 0 or above, not {bias!r}")
    if points is None or normals is None:
        return _vertices_of(subject, bias)
    p, n = _triples("points", points), _triples("normals", normals)
    if len(p) != len(n):
        raise RenderError(f"ambient_occlusion: {len(p)} points, but {len(n)} normals")
    length = np.linalg.norm(n, axis=1)
    if (length == 0).any():
        raise RenderError(f"ambient_occlusion: normals[{int(np.argmin(length))}] is zero")
    far = np.maximum(np.abs(p).max(axis=1, initial=0.0), reach_of(subject))
    lift = np.full(len(p), bias) if bias is not None else ROUNDING * far
    return _Where(_single(p), _single(n / length[:, None]), _single(lift))


def reach_of(subject: object) -> float:
    """Largest finite coordinate of what stands in the way."""
    items = subject.items if isinstance(subject, Scene) else (subject,)
    corners = np.concatenate([np.asarray(item.bounds, np.float64) for item in items])  # type: ignore[attr-defined]
    return float(np.abs(corners[np.isfinite(corners)]).max(initial=0.0))


def _vertices_of(subject: object, bias: float | None) -> _Where:
    """A mesh's vertices, lifted by the rounding of the triangles around each."""
    item = subject if isinstance(subject, Item) else None
    shape = item.shape if item else subject
    if not isinstance(shape, Mesh):
        raise RenderError(
            f"ambient_occlusion: give points and normals; only a Mesh has vertices, not a {type(subject).__name__}"
        )
    placed, normals = np.asarray(shape.vertices), vertex_normals(shape)
    if item is not None:
        matrix = item.transform.matrix
        placed = placed @ matrix[:3, :3].T + matrix[:3, 3]
        normals = normals @ np.linalg.inv(matrix[:3, :3])
    upright = _unit(normals)
    if bias is not None:
        return _Where(_single(placed), upright, _single(np.full(len(placed), bias)))
    size = _largest_of(np.abs(placed.T))
    triangles = triangulate(shape).triangles
    reach = size.copy()
    np.maximum.at(reach, triangles.reshape(-1), np.repeat(_largest_of(size[triangles.T]), 3))
    return _Where(_single(placed), upright, _single(ROUNDING * reach))


def _unit(normals: Points) -> npt.NDArray[np.float32]:
    """Of length 1; a vertex without a normal looks up, since nothing says where else."""
    x, y, z = normals.T
    length = np.sqrt(x * x + y * y + z * z)
    none = length == 0
    length[none] = 1
    unit = _single(normals / length[:, None])
    unit[none] = 0, 1, 0
    return unit


def _largest_of(three: Points) -> Points:
    """(n,) of (3, n); a reduction along rows of three would take five times as long."""
    largest: Points = np.maximum(np.maximum(three[0], three[1]), three[2])
    return largest


def _single(values: Points) -> npt.NDArray[np.float32]:
    return np.ascontiguousarray(values, np.float32)


def _triples(name: str, values: npt.ArrayLike) -> Points:
    array = np.atleast_2d(np.asarray(values, np.float64))
    if array.ndim != 2 or array.shape[1] != 3 or not np.isfinite(array).all():
        raise RenderError(f"ambient_occlusion: {name} must be finite numbers of shape (n, 3)")
    return array
