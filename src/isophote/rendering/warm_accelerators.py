"""What accelerators compile at first use: their builders, and entries for triangles and for things with boxes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import partial

import numpy as np

__all__ = ["accelerator_parts", "parts_of_accelerators"]

# Name → file of the entries, and how their names end.
_ENTRIES = {
    "bih": ("bih_entry.py", "in_bih"),
    "brute": ("brute_entry.py", "of_all"),
    "bsp": ("bsp_entry.py", "in_bsp"),
    "bvh": ("tree_entry.py", "in_tree"),
    "grid": ("grid_entry.py", "in_grid"),
    "kdtree": ("kd_entry.py", "in_kd"),
}
_TESTS = {"primitives": "tests of primitives", "fields": "tests of fields", "instances": "tests of instances"}
# So many of a kind are asked one by one, whatever the accelerator.
_ALONE = {"primitives": 3, "fields": 1, "instances": 1}


def _triangles(name: str) -> None:
    from isophote.accel.accelerator import accelerator_of, build_accelerator

    build_accelerator(name, np.eye(3), np.array([[0, 1, 2]], np.int32), threads=1)
    kind = accelerator_of(name)
    kind.closest.compile()
    kind.any.compile()


def _things(name: str) -> None:
    from isophote.accel.accelerator import accelerator_of, build_things

    build_things(name, np.zeros((1, 3)), np.ones((1, 3)), threads=1)
    accelerator_of(name).things.compile()


def _tests_of_primitives() -> None:
    from isophote.kernels.primitive import trace

    trace.test_primitive.compile()


def _tests_of_fields() -> None:
    from isophote.kernels.accel import field_trace

    field_trace.test_field.compile()


def _tests_of_instances() -> None:
    from isophote.kernels.accel import instance_entry

    instance_entry.closest_in_instance.compile()
    instance_entry.any_in_instance.compile()


def accelerator_parts() -> Iterator[tuple[str, tuple[str, str, Callable[[], None]]]]:
    """Parts of rendering/warm.py by their names: file and name of the kernel that comes last, and what compiles it."""
    for name, (file, end) in _ENTRIES.items():
        yield name, (f"accel/{file}", f"any_{end}", partial(_triangles, name))
        yield f"{name} things", (f"accel/{file}", f"things_{end}", partial(_things, name))
    yield _TESTS["primitives"], ("primitive/trace.py", "test_primitive", _tests_of_primitives)
    yield _TESTS["fields"], ("accel/field_trace.py", "test_field", _tests_of_fields)
    yield _TESTS["instances"], ("accel/instance_entry.py", "any_in_instance", _tests_of_instances)


def parts_of_accelerators(accelerator: str, kinds: Iterable[str], *, counting: bool = False) -> list[str]:
    """Names of what an accelerator takes for items of these kinds ("trees", "primitives" or "fields"; and "instances",
    once more, for meshes that several items have), beside what all scenes take; with `counting`, as it is where rays
    count what they visit."""
    if accelerator == "bvh" and not counting:
        return []
    found = Counter(kinds)
    tests = [test for kind, test in _TESTS.items() if found[kind] > _ALONE[kind]]
    parts = [accelerator] if found["trees"] else []
    return [*parts, *([f"{accelerator} things"] if tests else []), *tests]
