"""Sampling reflectance: millions of samples a second on one core, of GGX in a loop and of every material by its entry.

    python bench/brdf.py [--rounds 7] [--count 65536]

Directions come from all over the hemisphere, sample points from all over the square. GGX by its visible normals
(anisotropic, α = 0.3 and 0.1) stands in a loop over arrays, which the compiler makes eight wide: the normals alone, and
with the reflected direction, the weight and the density. Entries are what rendering calls, one sample at a time by
address, with parameters at hand: direction, weight and density (`sample`), or value and density (`evaluate`). Times are
of the processor, so that other work on the machine counts little; the best and the median round are told. Beside them
is Mitsuba's roughconductor, where its llvm_ad_rgb runs: a wavefront of the same samples on one thread, its compiled
kernel in the cache.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np
from numba import njit

import isophote as iso
from common import Floats, print_machine, print_table, verdict
from isophote.kernels.base.vec import dot, vec3
from isophote.kernels.brdf.microfacet import density_of_normals, masking, visible_normal
from isophote.lower.probe import Probe

GOAL = 30.0
MATERIALS = {
    "Matte": iso.Matte(0.5),
    "OrenNayar": iso.OrenNayar(0.5),
    "Phong": iso.Phong(0.5),
    "Blinn": iso.Blinn(0.5),
    "AshikhminShirley": iso.AshikhminShirley(0.5),
    "Ward": iso.Ward(0.5),
    "Metal, one bounce": iso.Metal("gold", (0.55, 0.32), single_bounce=True),
    "Metal": iso.Metal("gold", (0.55, 0.32)),
    "Glass, rough": iso.Glass(1.5, roughness=0.4),
    "Glass, smooth": iso.Glass(1.5),
    "Plastic": iso.Plastic(0.5),
    "Principled": iso.Principled(0.5),
    "Coated metal": iso.Coated(iso.Metal("gold")),
    "Mix": iso.Mix(iso.Metal("gold"), iso.Matte(0.5)),
    "Measured": None,
}
_ALONG, _ACROSS = np.float32(0.3), np.float32(0.1)
_ZERO, _QUARTER, _TWO = np.float32(0), np.float32(0.25), np.float32(2)
_loop = njit(error_model="numpy", fastmath={"contract", "nsz"})


class Rate(NamedTuple):
    """Millions a second: the best round and the median."""

    best: float
    middle: float


@_loop
def visible_normals(out, points, found):
    """Normals (3, n) for directions and points of the disk (3, n), (2, n)."""
    for i in range(out.shape[1]):
        h = visible_normal(vec3(out[0, i], out[1, i], out[2, i]), _ALONG, _ACROSS, points[0, i], points[1, i])
        found[0, i], found[1, i], found[2, i] = h.x, h.y, h.z


@_loop
def ggx_samples(out, points, found):
    """Reflected directions, G1 of these (the weight of a perfect mirror's facets), and densities, as (5, n)."""
    for i in range(out.shape[1]):
        o = vec3(out[0, i], out[1, i], out[2, i])
        h = visible_normal(o, _ALONG, _ACROSS, points[0, i], points[1, i])
        into = h * (_TWO * dot(o, h)) - o
        found[0, i], found[1, i], found[2, i] = into.x, into.y, into.z
        found[3, i] = masking(into, _ALONG, _ACROSS) if into.z > _ZERO else _ZERO
        density = density_of_normals(h, _ALONG, _ACROSS)
        found[4, i] = masking(o, _ALONG, _ACROSS) * density * _QUARTER / o.z


def directions(count: int, seed: int) -> Floats:
    """(count, 3) over the hemisphere."""
    v = np.random.default_rng(seed).normal(size=(count, 3))
    v[:, 2] = np.abs(v[:, 2]) + 1e-3
    return (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)


def points(count: int) -> Floats:
    """(count, 3): of the unit disk, and from 0 to 1."""
    u, v, pick = np.random.default_rng(3).random((3, count))
    return np.stack([np.sqrt(u) * np.cos(2 * np.pi * v), np.sqrt(u) * np.sin(2 * np.pi * v), pick], 1).astype(
        np.float32
    )


def rate(side: Callable[[], object], count: int, rounds: int, clock: Callable[[], float] = time.thread_time) -> Rate:
    """How many millions a second `side` makes, that makes `count` a call."""
    side()
    seconds: list[float] = []
    for _ in range(rounds):
        began, calls = clock(), 0
        while clock() - began < 0.05:
            side()
            calls += 1
        seconds.append((clock() - began) / (calls * count))
    return Rate(1e-6 / min(seconds), 1e-6 / float(np.median(seconds)))


def loops(count: int, rounds: int) -> dict[str, Rate]:
    """GGX in loops over arrays."""
    out, given = np.ascontiguousarray(directions(count, 1).T), np.ascontiguousarray(points(count).T[:2])
    found = np.zeros((5, count), np.float32)
    return {
        "visible normals": rate(lambda: visible_normals(out, given, found[:3]), count, rounds),
        "direction, weight, density": rate(lambda: ggx_samples(out, given, found), count, rounds),
    }


def entries(name: str, count: int, rounds: int) -> tuple[Rate, Rate]:
    """(sample, evaluate) of a material."""
    material = MATERIALS[name] or iso.measure_brdf(iso.Plastic(0.5))
    probe, out, into, given = Probe(material), directions(count, 1), directions(count, 2), points(count)
    return rate(lambda: probe.sample(out, given), count, rounds), rate(lambda: probe.evaluate(out, into), count, rounds)


def peer(count: int, rounds: int) -> Rate | None:
    """Mitsuba's roughconductor: direction, weight and density, on one thread; None where it does not run."""
    if find_spec("mitsuba") is None:
        return None
    import mitsuba as mi

    try:
        mi.set_variant("llvm_ad_rgb")
        import drjit as dr

        dr.set_thread_count(1)
        np.array(mi.Float(1) + 1)
    except (ImportError, RuntimeError) as error:
        print(f"Mitsuba's llvm_ad_rgb does not run ({error}).\n")
        return None
    metal: dict[str, Any] = {"type": "roughconductor", "distribution": "ggx", "material": "none"}
    bsdf = mi.load_dict(metal | {"alpha_u": float(_ALONG), "alpha_v": float(_ACROSS)})
    count = max(count, 2**20)
    out, square = directions(count, 1), np.random.default_rng(3).random((2, count)).astype(np.float32)
    surface = dr.zeros(mi.SurfaceInteraction3f, count)
    surface.wi = mi.Vector3f(*(mi.Float(np.ascontiguousarray(axis)) for axis in out.T))
    sample = mi.Point2f(mi.Float(square[0]), mi.Float(square[1]))
    dr.eval(surface, sample)

    def side() -> None:
        found, weight = bsdf.sample(mi.BSDFContext(), surface, mi.Float(0.5), sample)
        dr.eval(found.wo, found.pdf, weight)
        dr.sync_thread()

    # Its work is done by a thread of its own.
    return rate(side, count, rounds, time.process_time)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--count", type=int, default=2**16, help="samples a call")
    given = parser.parse_args()
    print_machine(*(["mitsuba"] if find_spec("mitsuba") else []))
    theirs = peer(given.count, given.rounds)
    rows: list[list[object]] = []
    for name, found in loops(min(given.count, 2**14), given.rounds).items():
        ratio = "" if theirs is None or name == "visible normals" else f"{found.middle / theirs.middle:.1f}"
        rows.append([name, found.best, found.middle, ratio, verdict(found.middle, GOAL)])
    if theirs is not None:
        rows.append(["Mitsuba's roughconductor", theirs.best, theirs.middle, "1", ""])
    print_table(["GGX, M samples/s a core", "best", "median", "× Mitsuba", "goal"], rows)
    table: list[list[object]] = []
    for name in MATERIALS:
        sampled, evaluated = entries(name, given.count, given.rounds)
        table.append([name, sampled.best, sampled.middle, evaluated.best, evaluated.middle])
    print_table(["entry, M/s a core", "sample, best", "median", "evaluate, best", "median"], table)


if __name__ == "__main__":
    main()
