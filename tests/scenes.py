"""Meshes and scenes that tests of rendering share."""

from __future__ import annotations

import numpy as np

import isophote as iso
from isophote.checks.scenes import box

__all__ = ["WHITE_SKY", "box", "icosphere", "mean", "plane", "render"]

WHITE_SKY = iso.Sky("white", 1.0)


def plane(size: float = 2.0) -> iso.Mesh:
    """A quad in y = 0 that faces up."""
    s = size / 2
    return iso.Mesh([(-s, 0, -s), (-s, 0, s), (s, 0, s), (s, 0, -s)], [(0, 1, 2, 3)])


def icosphere(levels: int, radius: float = 1.0, smooth: bool = False) -> iso.Mesh:
    """20 · 4^levels triangles; with `smooth`, normals of the true sphere."""
    g = (1 + 5**0.5) / 2
    points = np.array([(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0)], float)
    points = np.concatenate([points, np.roll(points, 1, axis=1), np.roll(points, 2, axis=1)])
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    near = np.isclose(distances, 2)
    triples = [
        (i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[i, k]
    ]
    faces = np.array([t if np.linalg.det(points[list(t)]) > 0 else t[::-1] for t in triples])
    points /= np.linalg.norm(points[0])
    for _ in range(levels):
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        unique, place = np.unique(edges, axis=0, return_inverse=True)
        middle = points[unique].sum(axis=1)
        ab, bc, ca = place.reshape(3, -1) + len(points)
        points = np.concatenate([points, middle / np.linalg.norm(middle, axis=1)[:, None]])
        a, b, c = faces.T
        faces = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return iso.Mesh(points * radius, faces, attributes={"normal": points} if smooth else None)


def render(items: object, lights: object = (), camera: object = None, *, size=(16, 16), seed=1, threads=2, **method):
    """The picture of items and lights by `PathTrace(**method)`."""
    camera = camera or iso.Camera((0, 0, 4), (0, 0, 0), fov_degrees=40)
    scene = iso.Scene(items, lights=lights, camera=camera)
    return iso.render(scene, iso.PathTrace(**method), size=size, seed=seed, progress=False, threads=threads)


def mean(image: iso.Image) -> np.ndarray:
    """(3,): mean colour of all pixels."""
    return image.channels["colour"].astype(np.float64).mean(axis=(0, 1))
