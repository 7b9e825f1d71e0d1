"""Form factors of polygons: closed forms, closure and reciprocity."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.checks.check import Check, Effort, Measured
from isophote.rendering.radiosity.contours import form_factor

__all__ = ["CHECKS", "parallel_rectangles", "perpendicular_rectangles"]

_TOPIC = "form factors"

_FLOOR = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], np.float64)
_CEILING = np.add(_FLOOR[::-1], (0, 0, 1))
_WALL = np.array([(0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)], np.float64)


def parallel_rectangles(x: float, y: float) -> float:
    """Between equal rectangles of edges x and y at distance 1 (Howell's catalogue of configuration factors, C-11)."""
    p, q = 1 + x * x, 1 + y * y
    log = np.log(np.sqrt(p * q / (1 + x * x + y * y)))
    along = x * np.sqrt(q) * np.arctan(x / np.sqrt(q)) - x * np.arctan(x)
    across = y * np.sqrt(p) * np.arctan(y / np.sqrt(p)) - y * np.arctan(y)
    return float(2 / (np.pi * x * y) * (log + along + across))


def perpendicular_rectangles(h: float, w: float) -> float:
    """From a floor of depth w to a wall of height h at a shared edge of length 1 (Howell's catalogue, C-14)."""
    both = h * h + w * w
    log = (
        np.log((1 + w * w) * (1 + h * h) / (1 + both))
        + w * w * np.log(w * w * (1 + both) / ((1 + w * w) * both))
        + h * h * np.log(h * h * (1 + both) / ((1 + h * h) * both))
    )
    turn = w * np.arctan(1 / w) + h * np.arctan(1 / h) - np.sqrt(both) * np.arctan(1 / np.sqrt(both))
    return float((turn + log / 4) / (np.pi * w))


def _area(polygon: npt.NDArray[np.float64]) -> float:
    fan = polygon[1:] - polygon[0]
    return float(np.linalg.norm(np.cross(fan[:-1], fan[1:]).sum(axis=0)) / 2)


def _parallel(effort: Effort) -> Measured:
    return Measured(form_factor(_FLOOR, _CEILING), parallel_rectangles(1, 1), 1e-9)


def _perpendicular(effort: Effort) -> Measured:
    return Measured(form_factor(_FLOOR, _WALL), perpendicular_rectangles(1, 1), 1e-9)


def _long_parallel(effort: Effort) -> Measured:
    scale = np.array([0.3, 5.0, 1.0])
    return Measured(form_factor(_FLOOR * scale, _CEILING * scale), parallel_rectangles(0.3, 5.0), 1e-8)


def _low_wall(effort: Effort) -> Measured:
    found = form_factor(_FLOOR, _WALL * (1.0, 1.0, 0.01))
    return Measured(found, perpendicular_rectangles(0.01, 1), 1e-8)


def _cube(effort: Effort) -> Measured:
    return Measured(form_factor(_FLOOR, _CEILING) + 4 * form_factor(_FLOOR, _WALL), 1, 1e-9)


def _tetrahedra(effort: Effort) -> list[npt.NDArray[np.float64]]:
    """Faces, inward, of a random tetrahedron that is not too flat."""
    generator = effort.generator()
    while True:
        corners = generator.normal(size=(4, 3))
        volume = float(np.linalg.det(corners[1:] - corners[0]))
        if abs(volume) > 0.5:
            break
    order = [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)]
    return [corners[list(face)][:: 1 if volume > 0 else -1] for face in order]


def _closure(effort: Effort) -> Measured:
    first, *others = _tetrahedra(effort)
    return Measured(sum(form_factor(first, other) for other in others), 1, 1e-7)


def _reciprocity(effort: Effort) -> Measured:
    faces = _tetrahedra(effort)
    pairs = [(a, b) for a in range(4) for b in range(a)]
    gaps = [
        _area(faces[a]) * form_factor(faces[a], faces[b]) - _area(faces[b]) * form_factor(faces[b], faces[a])
        for a, b in pairs
    ]
    return Measured(float(np.abs(gaps).max()), 0, 1e-8, at_most=True)


CHECKS = [
    Check(_TOPIC, "unit squares, parallel", _parallel),
    Check(_TOPIC, "unit squares, at right angles", _perpendicular),
    Check(_TOPIC, "rectangles 0.3 × 5, parallel", _long_parallel),
    Check(_TOPIC, "floor to a wall of height 0.01", _low_wall),
    Check(_TOPIC, "cube: sum of a face's", _cube),
    Check(_TOPIC, "random tetrahedron: sum of a face's", _closure),
    Check(_TOPIC, "random tetrahedron: largest |A F − A' F'|", _reciprocity),
]
