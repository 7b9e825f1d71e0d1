"""Fields: rays against formulas, meshes against volumes, areas and the field itself."""

from __future__ import annotations

import math
from functools import cache, partial
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.topology import topology
from isophote.analysis.mass import mass_properties
from isophote.checks.check import Check, Effort, Measured
from isophote.convert.contour import to_mesh
from isophote.rendering.tracer import Tracer
from isophote.shapes.field.field import Field
from isophote.shapes.field.rounds import cylinder, torus
from isophote.shapes.field.solids import box, sphere
from isophote.shapes.mesh import Mesh

__all__ = ["CHECKS"]

Floats: TypeAlias = npt.NDArray[np.float64]

_TRACED = "fields: largest difference between where rays are marched to and the formula"
_VOLUMES = "fields: volumes of meshes of solids, in parts of the formula"
_TRUE = "fields: largest distance between meshes of a tolerance and the field, in parts of the tolerance"
_CLOSED = "fields: Euler characteristic of meshes"

_RAYS, _CELL, _TOLERANCE = 10_000, 0.05, 0.004
_BALL, _RING, _BLOCK = sphere(1), torus(0.8, 0.3), box((1.0, 0.6, 0.8))
_DRILLED = sphere(1) - cylinder(0.4) - cylinder(0.4).along("x")

_SOLIDS: dict[str, tuple[Field, float]] = {
    "ball": (_BALL, 4 / 3 * math.pi),
    "ring": (_RING, 2 * math.pi**2 * 0.8 * 0.3**2),
    "block": (_BLOCK, 1.0 * 0.6 * 0.8),
    # A ball less a hole along its middle: (1 − r²)^{3/2} of it is left.
    "ball with a hole": (sphere(1) - cylinder(0.4), 4 / 3 * math.pi * (1 - 0.4**2) ** 1.5),
}
# A hole lowers it by two; the second of two that cross adds three openings to the body.
_EULER: dict[str, tuple[Field, int]] = {"ball": (_BALL, 2), "ring": (_RING, 0), "ball with two holes": (_DRILLED, -4)}


@cache
def _mesh(field: Field, factor: int) -> Mesh:
    return to_mesh(field, _CELL / factor ** (1 / 4), progress=False)


def _aimed(effort: Effort) -> tuple[Floats, Floats]:
    """Rays from all around towards the middle, as single precision has them."""
    generator = effort.generator()
    origins = generator.normal(size=(effort.samples(_RAYS), 3))
    origins *= 3 / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = generator.uniform(-0.7, 0.7, origins.shape) - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return origins.astype(np.float32).astype(np.float64), directions.astype(np.float32).astype(np.float64)


def _marched_ball(effort: Effort) -> Measured:
    """Against t = −b − √(b² − c)."""
    origins, directions = _aimed(effort)
    # Something that rays do not meet first, since a bare ball is met by its formula.
    found = Tracer(_BALL | sphere(0.1), threads=effort.threads).closest(origins, directions).distance
    b, c = (origins * directions).sum(axis=1), (origins**2).sum(axis=1) - 1
    left = b * b - c
    # Not along the surface, where a hair's breadth of the ball is a long way of the ray.
    met = left > 0.1
    gap = np.abs(found[met] + b[met] + np.sqrt(left[met]))
    return Measured(float(gap.max()), 0, 1e-4, at_most=True)


def _marched_ring(effort: Effort) -> Measured:
    """Against the quartic's root; both meet the ring, or neither."""
    origins, directions = _aimed(effort)
    hit = [Tracer(s, threads=effort.threads).closest(origins, directions) for s in (_RING, _RING | sphere(0.1))]
    exact, found = (h.distance for h in hit)
    # Where the other ball is in the way, or the surface is looked along, they may differ.
    slope = np.abs((hit[0].normal * directions).sum(axis=1))
    before = Tracer(sphere(0.1), threads=effort.threads).closest(origins, directions).distance
    clear = np.isfinite(exact) & (exact < before) & (slope > 0.1)
    return Measured(float(np.abs(found[clear] - exact[clear]).max()), 0, 1e-4, at_most=True)


def _volume(name: str, effort: Effort) -> Measured:
    field, exact = _SOLIDS[name]
    return Measured(mass_properties(_mesh(field, effort.factor)).volume / exact, 1, 0.003)


def _off_surface(name: str, effort: Effort) -> Measured:
    """At corners and in the middles of faces."""
    field, tolerance = _SOLIDS[name][0], _TOLERANCE / math.sqrt(effort.factor)
    mesh = to_mesh(field, tolerance=tolerance, progress=False)
    points = np.concatenate([mesh.vertices, mesh.vertices[np.asarray(mesh.faces)].mean(axis=1)])
    return Measured(float(np.abs(field(points)).max()) / tolerance, 1, 0, at_most=True)


def _euler(name: str, effort: Effort) -> Measured:
    field, exact = _EULER[name]
    return Measured(topology(_mesh(field, effort.factor)).euler, exact, 0)


CHECKS = [
    Check(_TRACED, "ball", _marched_ball),
    Check(_TRACED, "ring", _marched_ring),
    *(Check(_VOLUMES, name, partial(_volume, name)) for name in _SOLIDS),
    *(Check(_TRUE, name, partial(_off_surface, name)) for name in _SOLIDS),
    *(Check(_CLOSED, name, partial(_euler, name)) for name in _EULER),
]
