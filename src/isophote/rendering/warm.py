"""First use on a machine: kernels are compiled once, on two processors, with a bar."""

from __future__ import annotations

import gc
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
from numba.core import event

from isophote import kernels
from isophote.kernels.base.cache import is_compiled
from isophote.kernels.base.table import Table
from isophote.kernels.trace import tables, wave
from isophote.lower.lamps import many_lamps
from isophote.lower.light_tree import may_have_light_tree
from isophote.lower.materials import is_linked
from isophote.lower.primitive_table import primitive_of
from isophote.progress import Reporter
from isophote.rendering.warm_accelerators import accelerator_parts, parts_of_accelerators
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material_base import textures_of
from isophote.scene.scene import Scene
from isophote.shapes.mesh import Mesh

__all__ = ["STAGE", "compile_parts", "compiled", "warm_parts", "warm_up"]

STAGE = "compiling kernels (first use on this machine)"

# Functions that one picture compiles; only the bar depends on it.
_FUNCTIONS = 100
_OTHER_PROCESS = "import sys; from isophote.rendering.warm import compile_parts; compile_parts(sys.argv[1:])"

_Words: TypeAlias = np.ndarray[tuple[int], np.dtype[np.int64]]


@contextmanager
def _without_collecting() -> Iterator[None]:
    """Pause the collection of cyclic garbage, which takes a sixth of compiling and finds next to nothing."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def _words(table: Table) -> _Words:
    return np.zeros(3 * table.size, np.int64)


def _path_tracer() -> None:
    from isophote.kernels.trace import path, wave_entries

    # A tile without pixels needs no tables.
    words = (_words(table) for table in (tables.SCENE, tables.PLAN, tables.FILM))
    path.path_trace_tile(*words, wave.new_wave(1).words, _words(wave_entries.ENTRIES), 0, 0, 0, 0)


def _ray_tracer() -> None:
    from isophote.kernels.trace import ray_log, ray_trace, ray_tree

    before = (_words(table) for table in (tables.SCENE, tables.PLAN, tables.FILM))
    after = (_words(table) for table in (ray_tree.TREE, ray_log.LOG))
    ray_trace.ray_trace_tile(*before, wave.new_wave(1).words, *after, 0, 0, 0, 0)


def _occlusion() -> None:
    from isophote.kernels.trace import occlusion_picture

    words = (_words(table) for table in (tables.SCENE, tables.PLAN, occlusion_picture.SKY, tables.FILM))
    occlusion_picture.occlusion_tile(*words, wave.new_wave(1).words, 0, 0, 0, 0)


def _sphere_tracer() -> None:
    from isophote.kernels.trace import sphere_tables, sphere_trace

    words = (_words(table) for table in (tables.SCENE, sphere_tables.MARCH, sphere_tables.SPHERE_PICTURE))
    sphere_trace.sphere_trace_tile(*words, 0, 0, 0, 0)


def _waves() -> None:
    from isophote.kernels.trace import wave_entries

    wave_entries.compile_entries()


def _light_samples() -> None:
    from isophote.kernels.trace import light_samples

    light_samples.draw_jobs.compile()
    light_samples.sample_lights.compile()


def _first_hits() -> None:
    from isophote.kernels.trace import first_hit

    first_hit.first_hits(_words(tables.SCENE), _words(first_hit.FEATURES), 0, 0, 0)


def _trees() -> None:
    from isophote.accel.tree import build_triangles

    build_triangles(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32), threads=1)


def _fields() -> None:
    from isophote.accel.field_tree import warm_field_trees
    from isophote.kernels.accel import field_surface, field_trace
    from isophote.kernels.forms.tape_entries import pack_interpreters

    pack_interpreters()
    field_trace.trace_field.compile()
    field_surface.field_surface.compile()
    warm_field_trees()


def _primitives() -> None:
    from isophote.kernels.primitive import surface, trace, trace_lanes

    # Kinds are compiled as they are met: a fraction of a second each.
    trace.trace_primitive.compile()
    trace_lanes.trace_primitive_lanes.compile()
    surface.primitive_surface.compile()


def _materials() -> None:
    from isophote.kernels.trace import prepare

    # Kinds as of primitives.
    prepare.prepare.compile()


def _light_tree() -> None:
    from isophote.kernels.light import emitter, light_tree_entry
    from isophote.lower.light_tree import plant

    light_tree_entry.ask_light_tree.compile()
    plant(np.full(2, emitter.POINT, np.int32), np.zeros((2, 18)))


def _counts() -> None:
    from isophote.kernels.trace import count

    counts = np.zeros((3, 0), np.int32)
    count.count_pixels(_words(tables.SCENE), wave.new_wave(1).words, counts, 0, 0, 0)


def _textures() -> None:
    from isophote.kernels.trace import footprint, textured

    footprint.curvature_at.compile()
    textured.colour_at.compile()


def _pictures() -> None:
    from isophote.kernels.texture import filtered
    from isophote.kernels.texture.contract import IN_FLOATS, SRGB
    from isophote.lower.pictures import pyramid

    pyramid(np.zeros((2, 4), np.float32), 2, 1, IN_FLOATS)
    pyramid(np.zeros((2, 4), np.uint8), 2, 1, SRGB)
    filtered.elliptical.compile()


def _air() -> None:
    from isophote.kernels.trace import air_rays

    air_rays.scatter.compile()
    air_rays.dim_shadows.compile()


class _Part(NamedTuple):
    """What is compiled together: file and name of the kernel that comes last, what compiles it, and about how long that
    takes beside others."""

    file: str
    kernel: str
    compile: Callable[[], None]
    seconds: int = 3


# Compiling loads much, so each part does it for itself.
_PARTS = {
    "path": _Part("trace/path.py", "path_trace_tile", _path_tracer, 9),
    "ray": _Part("trace/ray_trace.py", "ray_trace_tile", _ray_tracer, 10),
    "occlusion": _Part("trace/occlusion_picture.py", "occlusion_tile", _occlusion, 14),
    "sphere": _Part("trace/sphere_trace.py", "sphere_trace_tile", _sphere_tracer, 10),
    "light samples": _Part("trace/light_samples.py", "sample_lights", _light_samples, 3),
    "waves": _Part("trace/wave_entries.py", "blocked_of_wave", _waves, 12),
    "first hits": _Part("trace/first_hit.py", "first_hits", _first_hits, 4),
    "trees": _Part("accel/build_wide.py", "fill_blocks", _trees, 3),
    "fields": _Part("accel/field_build.py", "split_regions", _fields, 10),
    "primitives": _Part("primitive/surface.py", "primitive_surface", _primitives, 2),
    "air": _Part("trace/air_rays.py", "dim_shadows", _air, 4),
    "materials": _Part("trace/prepare.py", "prepare", _materials, 2),
    "textures": _Part("trace/textured.py", "colour_at", _textures, 2),
    "pictures": _Part("texture/filtered.py", "elliptical", _pictures, 2),
    "light tree": _Part("light/light_tree_build.py", "collapse_light_tree", _light_tree, 3),
    "visits": _Part("trace/count.py", "count_pixels", _counts, 2),
    **{name: _Part(*part) for name, part in accelerator_parts()},
}
# What tiles call by address.
_CALLED = {"path": ("waves",), "ray": ("waves", "light samples")}
_KERNELS = Path(kernels.__file__ or "").parent
_there: set[str] = set()


def compiled(parts: Sequence[str] = ("path", "waves", "first hits")) -> bool:
    """Whether these parts lie in the cache; what a picture of meshes takes if none are named."""
    for name in parts:
        # Looking through the cache's folder takes milliseconds; what was there once in a process, is loaded.
        if name not in _there and not is_compiled(_KERNELS / _PARTS[name].file, _PARTS[name].kernel):
            return False
        _there.add(name)
    return True


@_without_collecting()
def compile_parts(parts: Sequence[str]) -> None:
    """Compile these parts, or load them from the cache."""
    for name in parts:
        _PARTS[name].compile()


def _part_of(shape: object, method: str) -> str:
    """What a shape takes besides the method."""
    if isinstance(shape, Mesh):
        return "trees"
    if method == "sphere" and not hasattr(type(shape), "primitive"):
        return "fields"
    return "fields" if primitive_of(shape) is None else "primitives"


def _instances(scene: Scene) -> list[str]:
    """A word for each item whose mesh other items have as well."""
    uses = Counter(id(item.shape) for item in scene.items if isinstance(item.shape, Mesh))
    return ["instances"] * sum(count for count in uses.values() if count > 1)


def warm_up(report: Reporter, scene: Scene, method: str, accelerator: str = "bvh") -> None:
    """Compile what a method ("path", "ray", "occlusion", "sphere" or "visits") needs for a scene, with the accelerator
    of a name, and is not in the cache yet."""
    rest = [] if method == "sphere" else ["first hits"]
    kinds = [_part_of(item.shape, method) for item in scene.items]
    if method != "sphere" and many_lamps(scene):
        kinds.append("primitives")
    counting = method == "visits"
    rest += [*sorted(set(kinds)), *parts_of_accelerators(accelerator, [*kinds, *_instances(scene)], counting=counting)]
    # Sphere tracing knows matte surfaces alone, and visits none.
    if method not in ("sphere", "visits") and any(is_linked(item.material) for item in scene.items):
        rest.append("materials")
    textures = [texture for item in scene.items for texture in textures_of(item.material)]
    if textures:
        rest.append("textures")
    if any(isinstance(texture, ImageTexture) and texture.filter == "ewa" for texture in textures):
        rest.append("pictures")
    if method == "path" and may_have_light_tree(scene):
        rest.append("light tree")
    if method == "path" and scene.medium is not None:
        rest.append("air")
    warm_parts(report, [method, *rest])


def _halves(parts: Iterable[str]) -> tuple[list[str], list[str]]:
    """Parts for two processes that take about as long, the longest first."""
    here: list[str] = []
    rest: list[str] = []
    ahead = 0
    for name in sorted(parts, key=lambda name: -_PARTS[name].seconds):
        seconds = _PARTS[name].seconds
        (here if ahead <= 0 else rest).append(name)
        ahead += seconds if ahead <= 0 else -seconds
    return here, rest


def warm_parts(report: Reporter, parts: Sequence[str]) -> None:
    """Compile these parts, and what they call by address, where they are not in the cache yet: half of them here, half
    in a second process; both write to the same cache."""
    called = [other for name in parts for other in _CALLED.get(name, ())]
    needed = list(dict.fromkeys([*parts, *called]))
    if compiled(needed):
        return
    here, rest = _halves(needed)
    with _counted(report):
        other = None
        if sys.executable and rest:
            command = [sys.executable, "-c", _OTHER_PROCESS, *rest]
            other = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            compile_parts(here)
        finally:
            if other is not None:
                other.wait()
        # From the cache now, or here if the other process could not.
        compile_parts(rest)


class _Counter(event.Listener):
    """Turns Numba's compilation events into a fraction."""

    def __init__(self, report: Reporter) -> None:
        self._report = report
        self._count = 0

    def on_start(self, event: object) -> None:
        self._report(STAGE, min(self._count / _FUNCTIONS, 0.99))

    def on_end(self, event: object) -> None:
        self._count += 1


@contextmanager
def _counted(report: Reporter) -> Iterator[None]:
    report(STAGE, 0.0)
    with event.install_listener("numba:compile", _Counter(report)):
        yield
    report(STAGE, 1.0)
