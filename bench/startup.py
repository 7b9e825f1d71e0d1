"""How long a user waits: the first picture on a machine, the same command again, and `import isophote`.

    python bench/startup.py [--rounds 5] [--first-rounds 3] [--size 256] [--samples 64]

Every run is a fresh process. First pictures get an empty cache of kernels each, so they compile; the ones after them
use that of the last. "Besides rendering" is the whole command without the seconds that it reports for rendering
(building the tree, paths, channels): starting Python, loading packages and kernels, reading and writing.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from common import print_machine, print_table, verdict

EXAMPLE = Path(__file__).parents[1] / "examples" / "cornell_box.py"
GOAL_FIRST, GOAL_AGAIN, GOAL_BESIDES, GOAL_IMPORT = 20.0, 2.0, 1.0, 0.3
_IMPORT = "import time; t = time.perf_counter(); import isophote; print(time.perf_counter() - t)"
_IMPORT_ALL = (
    "import time; t = time.perf_counter(); import isophote; isophote.render, isophote.PathTrace, isophote.load_scene; "
    "print(time.perf_counter() - t)"
)


class Run(NamedTuple):
    """A process: what it printed, and its seconds on the wall and of processor time."""

    output: str
    wall: float
    cpu: float


def run(arguments: Sequence[str], cache: Path | None = None) -> Run:
    """Run Python with `arguments` in a fresh process, its kernels cached in `cache`."""
    environment = os.environ if cache is None else {**os.environ, "ISOPHOTE_CACHE_DIR": str(cache)}
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, text=True)
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(f"{' '.join(done.args)} failed:\n{done.stderr}")
    return Run(done.stdout, wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def pictures(folder: Path, size: int, samples: int, first_rounds: int, rounds: int) -> tuple[list[Run], list[Run]]:
    """Runs of the same command: each of the first ones with an empty cache, the others with the last of these (with the
    user's where there were none)."""
    command = ["-m", "isophote", "render", str(EXAMPLE), "-o", str(folder / "picture.png"), "--json"]
    command += ["--size", f"{size}x{size}", "--samples", str(samples)]
    caches = [folder / f"cache{k}" for k in range(first_rounds)]
    first = [run(command, cache) for cache in caches]
    return first, [run(command, caches[-1] if caches else None) for _ in range(rounds)]


def row(name: str, values: Sequence[float], goal: float | None, cpu: Sequence[float] | None = None) -> list[object]:
    """A line of the table; the goal is judged by the median."""
    middle = float(np.median(values))
    used = "" if cpu is None else float(np.median(cpu))
    return [name, len(values), min(values), middle, used, "" if goal is None else verdict(middle, goal, at_most=True)]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--first-rounds", type=int, default=3)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--samples", type=int, default=64)
    options = parser.parse_args(arguments)
    print_machine()
    with tempfile.TemporaryDirectory() as folder:
        first, again = pictures(Path(folder), options.size, options.samples, options.first_rounds, options.rounds)
    bare = [run(["-c", "pass"]) for _ in range(options.rounds)]
    light, heavy = ([float(run(["-c", code]).output) for _ in range(options.rounds)] for code in (_IMPORT, _IMPORT_ALL))
    besides = [r.wall - json.loads(r.output)["rendering_seconds"] for r in again]
    rows = []
    if first:
        rows = [row("first picture, kernels compiled", [r.wall for r in first], GOAL_FIRST, [r.cpu for r in first])]
    rows += [
        row("the same command again", [r.wall for r in again], GOAL_AGAIN, [r.cpu for r in again]),
        row("of that, besides rendering", besides, GOAL_BESIDES),
        row("`import isophote`", light, GOAL_IMPORT),
        row("the same with render, PathTrace and load_scene", heavy, None),
        row("Python alone, starting and ending", [r.wall for r in bare], None, [r.cpu for r in bare]),
    ]
    print_table(("what", "runs", "wall s, min", "wall s, median", "CPU s, median", "goal, s"), rows)


if __name__ == "__main__":
    main()
