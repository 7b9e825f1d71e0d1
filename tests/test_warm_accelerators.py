"""First use with an accelerator: parts of the bar are what it compiles, and scenes take those of what they hold."""

from __future__ import annotations

import pytest

from isophote.accel.accelerator import ACCELERATORS, REFERENCE, accelerator_of
from isophote.rendering.warm import compile_parts, compiled
from isophote.rendering.warm_accelerators import accelerator_parts, parts_of_accelerators


@pytest.mark.parametrize("name", [*ACCELERATORS, REFERENCE])
def test_parts_are_the_entries_of_the_accelerator(name):
    parts, kind = dict(accelerator_parts()), accelerator_of(name)
    assert parts[name][1] == kind.any._function.__name__
    assert parts[f"{name} things"][1] == kind.things._function.__name__
    compile_parts([name, f"{name} things", "tests of primitives", "visits"])
    assert compiled([name, f"{name} things", "tests of primitives", "visits"])


def test_scenes_take_the_parts_of_what_they_hold():
    assert parts_of_accelerators("bvh", ["trees", "primitives", "fields", "fields"]) == []
    assert parts_of_accelerators("kdtree", ["trees", "primitives"]) == ["kdtree"]
    assert parts_of_accelerators("kdtree", ["trees", "trees", "instances", "instances"]) == [
        "kdtree", "kdtree things", "tests of instances"
    ]  # fmt: skip
    assert parts_of_accelerators("grid", ["primitives"] * 4) == ["grid things", "tests of primitives"]
    assert parts_of_accelerators("bvh", ["trees", "fields", "fields"], counting=True) == [
        "bvh", "bvh things", "tests of fields"
    ]  # fmt: skip
