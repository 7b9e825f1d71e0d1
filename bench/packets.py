"""A camera's coherent rays in packets, a million triangles, one thread: `Tracer` against Mitsuba's Embree packets.

    python bench/packets.py [--rounds 9] [--frequency 224] [--size 1024]

Ours is `Tracer.closest` and `Tracer.occluded` with `coherent=True`, as a user calls them, on NumPy arrays; Mitsuba's is
`ray_intersect_preliminary` (distance, triangle, uv) and `ray_test` with `coherent=True` on rays that lie in Dr.Jit
arrays, each evaluated. Single rays of ours are told beside them.

Mitsuba's llvm_ad_rgb needs LLVM (on Debian: `apt-get install libllvm19` and
DRJIT_LIBLLVM_PATH=/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1); without it there is nothing to compare with, since
scalar_rgb takes one call of Python for each ray.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any

import numpy as np

import isophote as iso
from common import Ratio, Rays, bumpy_sphere, camera_rays, in_turns, print_machine, print_table, verdict
from peers import load_mitsuba, mitsuba_mesh

GOAL = 1.0


def mitsuba_queries(mitsuba: ModuleType, scene: Any, rays: Rays) -> tuple[Callable[[], Any], Callable[[], Any]]:
    """Mitsuba's queries (closest, any) over `rays` on one thread: distances, and whether anything is met."""
    import drjit

    origins, directions = (np.ascontiguousarray(rows.T) for rows in rays)
    loaded = mitsuba.Ray3f(mitsuba.Point3f(origins), mitsuba.Vector3f(directions))
    drjit.eval(loaded)
    drjit.set_thread_count(1)

    def closest() -> Any:
        found = scene.ray_intersect_preliminary(loaded, coherent=True)
        drjit.eval(found.t, found.prim_index, found.prim_uv)
        drjit.sync_thread()
        return found.t

    def occluded() -> Any:
        blocked = scene.ray_test(loaded, coherent=True)
        drjit.eval(blocked)
        drjit.sync_thread()
        return blocked

    return closest, occluded


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--frequency", type=int, default=224, help="20 f² triangles")
    parser.add_argument("--size", type=int, default=1024, help="rays are size × size")
    options = parser.parse_args(arguments)
    mitsuba, vectorised = load_mitsuba()
    if not vectorised:
        sys.exit("Mitsuba without LLVM has no packets to compare with")
    print_machine("mitsuba")
    positions, triangles = bumpy_sphere(options.frequency)
    rays, tracer = camera_rays(options.size), iso.Tracer(iso.Mesh(positions, triangles), threads=1)
    scene = mitsuba.load_dict({"type": "scene", "mesh": mitsuba_mesh(mitsuba, positions, triangles)})
    closest, occluded = mitsuba_queries(mitsuba, scene, rays)
    found = in_turns(
        {
            "closest": lambda: tracer.closest(*rays, coherent=True),
            "closest single": lambda: tracer.closest(*rays),
            "closest Mitsuba": closest,
            "any": lambda: tracer.occluded(*rays, coherent=True),
            "any single": lambda: tracer.occluded(*rays),
            "any Mitsuba": occluded,
        },
        options.rounds,
    )
    rows, millions = [], len(rays.origins) / 1e6
    for query in ("closest", "any"):
        ours, single, theirs = (found[f"{query}{side}"] for side in ("", " single", " Mitsuba"))
        ratio = Ratio.of(ours, theirs)
        speeds = [[millions / times[k].min() for times in (ours, single, theirs)] for k in (0, 1)]
        rows.append([query, *speeds[1], "CPU", ratio.cpu, ratio.cpu_median, verdict(ratio.cpu, GOAL)])
        rows.append([query, *speeds[0], "wall", ratio.wall, ratio.wall_median, ""])
    print_table(("query", "ours, packets", "ours, single", "Mitsuba", "Mray/s by", "ratio", "median", "goal"), rows)

    packets, alone, reach = tracer.closest(*rays, coherent=True), tracer.closest(*rays), np.array(closest())
    theirs_hit = np.isfinite(reach)
    both = packets.hit & theirs_hit
    gap = packets.distance[both] - reach[both]
    print(
        f"{len(reach):,} rays. Packets and single rays of ours name another triangle for "
        f"{(packets.primitive != alone.primitive).sum()}. Hits: ours {packets.hit.sum():,}, Mitsuba's "
        f"{theirs_hit.sum():,}; one side alone meets something for {(packets.hit != theirs_hit).sum()}. Mitsuba goes "
        f"through what ours meets (farther by 1e-3 or more) for {(gap < -1e-3).sum()}, ours for {(gap > 1e-3).sum()}."
    )


if __name__ == "__main__":
    main()
