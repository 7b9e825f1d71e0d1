"""Two threads against one, for `Tracer` and for `PathTrace`.

    python bench/threads.py [--rounds 5] [--frequency 224] [--size 1024] [--samples 64]

The speed-up on the wall is what counts, but other work on the machine spoils it: the last column tells what it would be
on idle cores if only processor time mattered, 2 · CPU(1) / CPU(2).
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence

import numpy as np

import isophote as iso
from common import bumpy_sphere, camera_rays, in_turns, inside_rays, print_machine, print_table, verdict
from scenes import cornell_box, isophote_scene

GOAL = 1.9
HEADINGS = (
    "work", "1 thread, wall s", "2 threads, wall s", "speed-up", "median", "1 thread, CPU s", "2 threads, CPU s",
    "speed-up by CPU", "goal",
)  # fmt: skip


def works(frequency: int, size: int, samples: int) -> dict[str, Callable[[int], Callable[[], object]]]:
    """What is measured: for a number of threads, the function to call."""
    mesh = iso.Mesh(*bumpy_sphere(frequency))
    tracers = {count: iso.Tracer(mesh, threads=count) for count in (1, 2)}
    camera, inside = camera_rays(size), inside_rays(size**2)
    scene, method = isophote_scene(cornell_box()), iso.PathTrace(samples=samples)
    return {
        "Tracer.closest, camera rays": lambda n: lambda: tracers[n].closest(*camera),
        "Tracer.closest, camera rays, coherent": lambda n: lambda: tracers[n].closest(*camera, coherent=True),
        "Tracer.closest, rays from inside": lambda n: lambda: tracers[n].closest(*inside),
        "Tracer.occluded, rays from inside": lambda n: lambda: tracers[n].occluded(*inside),
        "PathTrace, Cornell box": lambda n: lambda: iso.render(scene, method, size=(size // 4, size // 4), threads=n),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frequency", type=int, default=224, help="20 f² triangles")
    parser.add_argument("--size", type=int, default=1024, help="rays are size × size, the picture is a quarter as wide")
    parser.add_argument("--samples", type=int, default=64)
    options = parser.parse_args(arguments)
    print_machine()
    rows = []
    for name, work in works(options.frequency, options.size, options.samples).items():
        found = in_turns({"one": work(1), "two": work(2)}, options.rounds)
        one, two = found["one"], found["two"]
        speed_up = one.wall.min() / two.wall.min()
        rows.append(
            [name, one.wall.min(), two.wall.min(), speed_up, np.median(one.wall / two.wall), one.cpu.min(),
             two.cpu.min(), 2 * one.cpu.min() / two.cpu.min(), verdict(speed_up, GOAL)]
        )  # fmt: skip
    print_table(HEADINGS, rows)


if __name__ == "__main__":
    main()
