"""What a closed, manifold, oriented mesh of triangles is, checked from its definition."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import isophote as iso

__all__ = ["area", "check_closed", "euler", "volume"]


def corners(mesh: iso.Mesh) -> npt.NDArray[np.float64]:
    return mesh.vertices[mesh.faces]


def volume(mesh: iso.Mesh) -> float:
    """By the divergence theorem; positive where faces are anticlockwise from outside."""
    p = corners(mesh)
    return float(np.einsum("ij,ij->", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6)


def area(mesh: iso.Mesh) -> float:
    p = corners(mesh)
    return float(np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2)


def euler(mesh: iso.Mesh) -> int:
    """Vertices − edges + faces of a closed mesh: two for each component, less two for each hole through it."""
    return len(mesh.vertices) - mesh.face_count // 2


def check_closed(mesh: iso.Mesh) -> None:
    """Every directed edge has one face, and its opposite one too; the faces round each vertex are one ring."""
    faces: Any = mesh.faces
    assert faces.shape[1] == 3
    count = len(mesh.vertices)
    # Where the corner i of a triangle is, the edge across runs from `start` to `end`.
    corner, start, end = (np.concatenate([np.roll(faces, -k, axis=1)[:, i] for i in range(3)]) for k in range(3))
    edges = np.concatenate([faces[:, [i, (i + 1) % 3]] for i in range(3)]).astype(np.int64)
    forward, backward = edges @ [count, 1], edges @ [1, count]
    assert len(np.unique(forward)) == len(forward), "an edge has two faces on one side"
    assert np.array_equal(np.sort(forward), np.sort(backward)), "an edge has a face on one side only"
    assert (np.bincount(faces.reshape(-1), minlength=count) > 0).all(), "a vertex has no face"
    # Going round each vertex from each of its edges: (corner, start) to (corner, end).
    key = corner.astype(np.int64) * count + start
    order = np.argsort(key)
    following = order[np.searchsorted(key[order], corner.astype(np.int64) * count + end)]
    least = np.arange(len(key))
    step = following
    for _ in range(int(np.ceil(np.log2(np.bincount(corner).max()))) + 1):
        least = np.minimum(least, least[step])
        step = step[step]
    rings = np.unique(least)
    assert len(rings) == count, "the faces round a vertex are several rings"
