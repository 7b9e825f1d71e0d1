"""Small scenes that checks share, and the mean colours of their pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.checks.check import Effort
from isophote.rendering.image import Image
from isophote.rendering.method import Method
from isophote.rendering.render import render
from isophote.scene.camera import AnyCamera
from isophote.scene.light import Light
from isophote.scene.scene import Item, Scene
from isophote.shapes.mesh import Mesh

__all__ = ["box", "greys", "picture", "quad", "sphere_mesh"]

Greys: TypeAlias = npt.NDArray[np.float64]


def quad(*corners: tuple[float, float, float]) -> Mesh:
    """One polygon that faces where its corners run counter-clockwise."""
    return Mesh(corners, [tuple(range(len(corners)))])


def box(size: float = 1.0, inward: bool = False) -> Mesh:
    """A cube of quads around the origin."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size / 2
    faces = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    return Mesh(corners, faces[:, ::-1] if inward else faces)


def sphere_mesh(rings: int, bump: float = 0.0) -> Mesh:
    """A closed mesh of the unit sphere, of 4 rings (rings − 1) triangles, in waves of height `bump`."""
    polar, around = np.pi * np.arange(1, rings)[:, None] / rings, np.pi * np.arange(2 * rings)[None, :] / rings
    x, y, z = np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar) + 0 * around
    points = np.concatenate([np.stack([x, y, z], 2).reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    points *= 1 + bump * np.sin(9 * points[:, :1]) * np.sin(11 * points[:, 1:2]) * np.sin(7 * points[:, 2:])
    row, column = np.mgrid[0 : rings - 2, 0 : 2 * rings]
    here, right = row * 2 * rings + column, row * 2 * rings + (column + 1) % (2 * rings)
    below, across = here + 2 * rings, right + 2 * rings
    first, last = np.arange(2 * rings), (rings - 2) * 2 * rings + np.arange(2 * rings)
    parts = [
        np.stack([here, below, across], 2).reshape(-1, 3),
        np.stack([here, across, right], 2).reshape(-1, 3),
        np.stack([np.full_like(first, len(points) - 2), first, np.roll(first, -1)], 1),
        np.stack([np.full_like(last, len(points) - 1), np.roll(last, -1), last], 1),
    ]
    return Mesh(points, np.concatenate(parts))


def picture(
    items: Sequence[Item],
    lights: Sequence[Light],
    camera: AnyCamera,
    method: Method,
    effort: Effort,
    size: tuple[int, int] = (16, 16),
) -> Image:
    """The picture, without a bar."""
    scene = Scene(items, lights, camera)
    return render(scene, method, size=size, seed=effort.seed, threads=effort.threads, progress=False)


def greys(image: Image) -> Greys:
    """(h, w): means of the three colours."""
    found: Greys = image.channels["colour"].astype(np.float64).mean(axis=2)
    return found
