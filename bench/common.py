"""What the benchmarks share: meshes, rays, timing in turns, tables."""

from __future__ import annotations

import importlib.metadata
import itertools
import os
import platform
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import isophote as iso

Array = npt.NDArray[np.float64]
Floats = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]

FREQUENCIES = {"70k": 59, "1M": 224}
"""Frequencies of the two bumpy spheres: 69,620 and 1,003,520 triangles."""


# --- meshes ---------------------------------------------------------------------------------------


def geodesic_sphere(frequency: int) -> tuple[Array, Ints]:
    """Unit icosphere: (10 f² + 2, 3) points and (20 f², 3) triangles that face outward."""
    golden = (1 + 5**0.5) / 2
    corners = np.array([np.roll((0, a, b * golden), k) for k in range(3) for a in (-1, 1) for b in (-1, 1)])
    faces = np.array([f for f in itertools.combinations(range(12), 3) if _is_face(corners[list(f)])])
    inward = np.linalg.det(corners[faces]) < 0
    faces[inward] = faces[inward][:, ::-1]

    row, column = (grid.reshape(-1) for grid in np.mgrid[0 : frequency + 1, 0 : frequency + 1])
    row, column = row[row + column <= frequency], column[row + column <= frequency]
    weights = np.stack([frequency - row - column, row, column], axis=1)
    place = np.full((frequency + 2, frequency + 2), -1)
    place[row, column] = np.arange(len(row))
    upright = np.stack([place[row, column], place[row + 1, column], place[row, column + 1]], axis=1)
    hanging = np.stack([place[row + 1, column], place[row + 1, column + 1], place[row, column + 1]], axis=1)
    pattern = np.concatenate([t[(t >= 0).all(axis=1)] for t in (upright, hanging)])

    # A point is known by its whole weights at the twelve corners, whichever face it was made from.
    codes = np.random.default_rng(0).integers(1, 2**62, 12)
    keys = np.concatenate([weights @ codes[face] for face in faces])
    _, first, number = np.unique(keys, return_index=True, return_inverse=True)
    points = np.concatenate([weights @ corners[face] for face in faces])[first]
    triangles = np.concatenate([pattern + k * len(row) for k in range(len(faces))])
    return points / np.linalg.norm(points, axis=1, keepdims=True), number[triangles].astype(np.int32)


def _is_face(corners: Array) -> bool:
    return np.allclose(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1), 2)


def bumpy_sphere(frequency: int) -> tuple[Floats, Ints]:
    """A geodesic sphere with three octaves of bumps, about 12 % deep."""
    points, triangles = geodesic_sphere(frequency)
    height = np.ones(len(points))
    for octave, waves in enumerate((5.0, 13.0, 37.0)):
        phases = np.array([0, 0, 1]) + octave * np.array([1, 2, 3])
        height += 0.06 / 2**octave * np.sin(waves * points + phases).prod(axis=1)
    return (points * height[:, None]).astype(np.float32), triangles


# --- rays -----------------------------------------------------------------------------------------


class Rays(NamedTuple):
    """(n, 3) origins and directions of unit length."""

    origins: Floats
    directions: Floats


def camera_rays(size: int) -> Rays:
    """A pinhole camera at (0, 0, 3) with 40° of view, row by row."""
    steps = ((np.arange(size) + 0.5) / size * 2 - 1) * np.tan(np.radians(20))
    x, y = (grid.reshape(-1) for grid in np.meshgrid(steps, -steps))
    return _rays(np.tile((0.0, 0.0, 3.0), (size * size, 1)), np.stack([x, y, -np.ones_like(x)], axis=1))


def bounce_rays(tracer: iso.Tracer, rays: Rays) -> Rays:
    """One cosine-distributed ray off each hit of `rays`."""
    hits = tracer.closest(*rays)
    normals = hits.normal[hits.hit]
    return _rays(hits.point[hits.hit] + 1e-4 * normals, normals + (1 - 1e-6) * _directions(len(normals), 1))


def inside_rays(count: int) -> Rays:
    """Random directions from random points of the ball of radius 0.8, which lies inside the bumpy sphere."""
    radius = 0.8 * np.random.default_rng(3).random(count) ** (1 / 3)
    return _rays(_directions(count, 2) * radius[:, None], _directions(count, 4))


def _directions(count: int, seed: int) -> Array:
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def _rays(origins: Array, directions: Array) -> Rays:
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return Rays(np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(unit, np.float32))


# --- timing ---------------------------------------------------------------------------------------


class Times(NamedTuple):
    """Seconds of each round: on the wall, and of all threads' processor time."""

    wall: Array
    cpu: Array


class Ratio(NamedTuple):
    """How many times as long `theirs` takes as `ours`: by the fastest rounds, and the median over pairs."""

    wall: float
    wall_median: float
    cpu: float
    cpu_median: float

    @classmethod
    def of(cls, ours: Times, theirs: Times) -> Ratio:
        """The ratio of two sides that took turns."""
        pairs = [(b.min() / a.min(), float(np.median(b / a))) for a, b in zip(ours, theirs, strict=True)]
        return cls(*pairs[0], *pairs[1])


def timed(side: Callable[[], object]) -> tuple[float, float]:
    """Seconds (wall, processor) of one call."""
    wall, cpu = time.perf_counter(), time.process_time()
    side()
    return time.perf_counter() - wall, time.process_time() - cpu


def in_turns(sides: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, Times]:
    """Call every side once to warm up, then all of them in turns: A B A B. What they share, they share alike."""
    for side in sides.values():
        side()
    found = np.array([[timed(side) for side in sides.values()] for _ in range(rounds)])
    return {name: Times(found[:, k, 0], found[:, k, 1]) for k, name in enumerate(sides)}


# --- telling --------------------------------------------------------------------------------------


def print_table(headings: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """A table in Markdown; numbers keep three figures or so."""
    print("| " + " | ".join(headings) + " |")
    print("|" + "---|" * len(headings))
    for row in rows:
        print("| " + " | ".join(_cell(value) for value in row) + " |")
    print(flush=True)


def _cell(value: object) -> str:
    if isinstance(value, float | np.floating):
        return f"{value:.3g}" if abs(value) < 1 else f"{value:.2f}" if abs(value) < 1000 else f"{value:,.0f}"
    return str(value)


def verdict(value: float, goal: float, *, at_most: bool = False) -> str:
    """The goal, and whether `value` meets it."""
    met = value <= goal if at_most else value >= goal
    return f"{'≤' if at_most else '≥'} {goal:g}: {'met' if met else '**missed**'}"


def print_machine(*peers: str) -> None:
    """What the numbers were made on: processor, cores, load, versions of packages."""
    names = ("isophote", "numba", "numpy", *peers)
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    load = f"; load {os.getloadavg()[0]:.1f} at the start" if hasattr(os, "getloadavg") else ""
    print(f"{_processor()}, {os.cpu_count()} cores{load}; Python {platform.python_version()}, {versions}\n", flush=True)


def _processor() -> str:
    facts = Path("/proc/cpuinfo")
    if facts.exists():
        for line in facts.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def missing(package: str) -> None:
    """End, saying how to get a peer."""
    sys.exit(f"{package} is not installed; make an environment with it: ./env .venv-bench bench")
