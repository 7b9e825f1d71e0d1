"""A field to a mesh, beside fogleman/sdf (which samples a grid and runs marching cubes over it).

    SDF_FOLDER=/path/to/sdf python bench/fields_mesh.py [--rounds 9]

fogleman/sdf is on no package index: clone https://github.com/fogleman/sdf and name the folder; it needs scikit-image
and SciPy. Both take the ball in a box less three poles, in cubes of the edge that sdf takes for 2²² samples.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import isophote as iso
from common import Times, in_turns, print_machine, print_table, verdict

_SAMPLES = 1 << 22
_GOAL_TIMES, _GOAL_SECONDS, _GRID = 30, 1.0, 256


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=9)
    rounds = parser.parse_args(arguments).rounds
    print_machine("scikit-image")
    peer, step = peer_part(load_sdf())
    part = own_part()
    fine = 1.5 / (_GRID - 2)
    sides: dict[str, tuple[str, Callable[[], Any]]] = {
        "merged": ("dual contouring, flat cells merged", lambda: iso.to_mesh(part, cell=step)),
        "all": ("dual contouring, all cells", lambda: iso.to_mesh(part, cell=step, tolerance=0)),
        "nets": ("surface nets", lambda: iso.to_mesh(part, cell=step, method="surface-nets")),
        "alone": ("dual contouring, flat cells merged, one thread", lambda: iso.to_mesh(part, cell=step, threads=1)),
        "fine": (f"dual contouring, grid {_GRID}³", lambda: iso.to_mesh(part, cell=fine)),
        "sdf": ("fogleman/sdf", lambda: peer.generate(samples=_SAMPLES, verbose=False)),
    }
    times = in_turns({name: run for name, (_, run) in sides.items()}, rounds)
    theirs = len(peer.generate(samples=_SAMPLES, verbose=False)) // 3
    told(times, sides, theirs)


def told(times: dict[str, Times], sides: dict[str, tuple[str, Callable[[], Any]]], theirs: int) -> None:
    least = {name: float(np.min(time.wall)) for name, time in times.items()}
    rows = []
    for name, (text, run) in sides.items():
        faces = theirs if name == "sdf" else run().face_count
        middle = float(np.median(times[name].wall)) * 1e3
        rows.append((text, least[name] * 1e3, middle, f"{faces:,}", least["sdf"] / least[name], closed(name, run)))
    print_table(("", "ms, least", "ms, median", "triangles", "times sdf's speed", "closed"), rows)
    speed, own = least["sdf"] / least["merged"], sides["merged"][1]().face_count
    print(f"times its speed {verdict(speed, _GOAL_TIMES)}; triangles {verdict(own, theirs, at_most=True)}")
    print(f"grid {_GRID}³, seconds {verdict(least['fine'], _GOAL_SECONDS, at_most=True)}")


def closed(name: str, run: Callable[[], Any]) -> str:
    if name == "sdf":
        return "points not joined"
    topology = iso.analysis.topology(run())
    return "yes" if topology.closed and topology.manifold and topology.oriented else "**no**"


def own_part() -> Any:
    pole = iso.cylinder(0.5)
    return (iso.sphere(1) & iso.box(1.5)) - pole - pole.along("x") - pole.along("z")


def load_sdf() -> Any:
    folder = os.environ.get("SDF_FOLDER", "")
    if not (Path(folder) / "sdf" / "core.py").is_file():
        sys.exit(str(__doc__))
    sys.path.insert(0, folder)
    import sdf

    return sdf


def peer_part(sdf: Any) -> tuple[Any, float]:
    """The part, and the edge of the cubes that it is sampled in."""
    pole = sdf.cylinder(0.5)
    part = (sdf.sphere(1) & sdf.box(1.5)) - (pole.orient(sdf.X) | pole.orient(sdf.Y) | pole.orient(sdf.Z))
    low, high = (np.array(corner) for corner in sdf.core._estimate_bounds(part))
    return part, float((np.prod(high - low) / _SAMPLES) ** (1 / 3))


if __name__ == "__main__":
    main()
