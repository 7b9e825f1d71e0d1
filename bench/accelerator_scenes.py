"""Scenes that suit different accelerators."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

import isophote as iso
from common import Array, Floats, Ints, Rays

__all__ = ["MODELS", "SCENES", "bounce_from", "view_rays"]

MODELS = Path(__file__).parents[1] / "../shared/models"

Geometry = tuple[Floats, Ints]


def _loose(corners: Array) -> Geometry:
    """Triangles that share nothing, from (m, 3, 3) corners."""
    points = np.ascontiguousarray(corners.reshape(-1, 3), np.float32)
    return points, np.arange(len(points), dtype=np.int32).reshape(-1, 3)


def _joined(parts: list[Geometry]) -> Geometry:
    starts = np.cumsum([0, *(len(points) for points, _ in parts)])
    triangles = [t + np.int32(s) for (_, t), s in zip(parts, starts, strict=False)]
    return np.concatenate([p for p, _ in parts]), np.concatenate(triangles)


def soup(count: int = 100_000) -> Geometry:
    """Small triangles spread evenly over a cube."""
    rng = np.random.default_rng(1)
    return _loose(rng.uniform(-1, 1, (count, 1, 3)) + rng.normal(0, 0.01, (count, 3, 3)))


def scan() -> Geometry:
    """The Stanford bunny, 69,451 triangles."""
    return _mesh(iso.load_mesh(MODELS / "boundary/bun_zipper.ply"))


def dragon() -> Geometry:
    """The Stanford dragon, 202,520 triangles."""
    return _mesh(iso.load_mesh(MODELS / "large/dragon_vrip_res2.ply.gz"))


def _mesh(mesh: iso.Mesh) -> Geometry:
    """The mesh in the unit cube about the origin."""
    low, high = mesh.bounds
    points = (mesh.vertices - (low + high) / 2) * (2 / (high - low).max())
    return points.astype(np.float32), iso.triangulate(mesh).triangles


def _block(low: Array, high: Array, cuts: int) -> Geometry:
    """A box whose sides are cut into squares of two triangles, `cuts` along each edge."""
    parts = []
    u, v = (grid.reshape(-1) for grid in np.mgrid[0 : cuts + 1, 0 : cuts + 1] / cuts)
    i, j = (grid.reshape(-1) for grid in np.mgrid[0:cuts, 0:cuts])
    a = i * (cuts + 1) + j
    quads = np.stack([a, a + cuts + 1, a + cuts + 2, a, a + cuts + 2, a + 1], axis=1).reshape(-1, 3)
    for axis in range(3):
        for side in (low, high):
            points = np.empty((len(u), 3))
            points[:, axis] = side[axis]
            for k, part in (((axis + 1) % 3, u), ((axis + 2) % 3, v)):
                points[:, k] = low[k] + part * (high - low)[k]
            parts.append((points, quads.astype(np.int32)))
    return _joined(parts)


def architecture(degrees: float = 30.0) -> Geometry:
    """A block of 12 × 12 houses on a floor, all turned by an angle about the vertical and a slant."""
    rng = np.random.default_rng(2)
    parts = [_block(np.array([-1.05, -0.05, -1.05]), np.array([1.05, 0.0, 1.05]), 16)]
    for i in range(12):
        for j in range(12):
            corner = np.array([-1 + i / 6 + 0.02, 0.0, -1 + j / 6 + 0.02])
            size = np.array([0.12, rng.uniform(0.1, 0.6), 0.12]) * rng.uniform(0.7, 1, 3)
            parts.append(_block(corner, corner + size, 6))
    points, triangles = _joined(parts)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_y = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    about_z = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return (points @ (about_z @ about_y).T).astype(np.float32), triangles


def teapot(cuts: int = 32) -> Geometry:
    """Newell's teapot, its 32 patches cut into squares of two triangles, `cuts` along each side."""
    numbers = [line.split(",") for line in (MODELS / "bezier/teapot").read_text().split()]
    count = int(numbers[0][0])
    patches = np.array(numbers[1 : count + 1], int) - 1
    control = np.array(numbers[count + 2 :], float)[patches].reshape(count, 4, 4, 3)
    t = np.linspace(0, 1, cuts + 1)
    basis = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], axis=1)
    points = np.einsum("ia,jb,pabk->pijk", basis, basis, control)[..., [0, 2, 1]]
    i, j = (grid.reshape(-1) for grid in np.mgrid[0:cuts, 0:cuts])
    a = i * (cuts + 1) + j
    quads = np.stack([a, a + cuts + 1, a + cuts + 2, a, a + cuts + 2, a + 1], axis=1).reshape(-1, 3)
    return _joined([(patch.reshape(-1, 3), quads.astype(np.int32)) for patch in points])


def teapot_in_stadium() -> Geometry:
    """The teapot, 65,536 triangles, in the middle of a bowl a thousand times as wide, of 20,000."""
    points, triangles = teapot()
    points = (points - points.mean(axis=0)) / np.abs(points).max() * 1e-3
    u, v = (grid.reshape(-1) for grid in np.mgrid[0:201, 0:51])
    angle, height = u / 200 * 2 * np.pi, v / 50
    radius = 0.4 + 0.6 * height
    bowl = np.stack([radius * np.cos(angle), 0.4 * height**2 - 0.01, radius * np.sin(angle)], axis=1)
    i, j = (grid.reshape(-1) for grid in np.mgrid[0:200, 0:50])
    a = i * 51 + j
    quads = np.stack([a, a + 51, a + 52, a, a + 52, a + 1], axis=1).reshape(-1, 3).astype(np.int32)
    points, triangles = _joined([(points, triangles), (bowl, quads)])
    return points.astype(np.float32), triangles


def hair(strands: int = 6_000, cuts: int = 8) -> Geometry:
    """Thin triangles, a hundred times as long as wide, along curved strands about a ball."""
    rng = np.random.default_rng(3)
    root = rng.normal(size=(strands, 3))
    root /= np.linalg.norm(root, axis=1, keepdims=True)
    bend = rng.normal(0, 0.5, (strands, 3)) - [0, 0.8, 0]
    t = np.linspace(0, 1, cuts + 1)[:, None, None]
    path = 0.5 * root + 0.5 * t * root + 0.25 * t**2 * bend
    aside = np.cross(root, rng.normal(size=(strands, 3)))
    aside *= 0.0006 / np.linalg.norm(aside, axis=1, keepdims=True)
    left, right = path - aside, path + aside
    first = np.stack([left[:-1], right[:-1], left[1:]], axis=2)
    second = np.stack([right[:-1], right[1:], left[1:]], axis=2)
    return _loose(np.concatenate([first, second]).reshape(-1, 3, 3))


def needles(count: int = 20_000) -> Geometry:
    """Triangles five hundred times as long as wide, every way through a cube: each comes by many others."""
    rng = np.random.default_rng(5)
    along = rng.normal(size=(count, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    middle = rng.uniform(-1, 1, (count, 3))
    aside = 0.002 * np.cross(along, rng.normal(size=(count, 3)))
    return _loose(np.stack([middle - along / 2, middle + along / 2, middle - along / 2 + aside], axis=1))


def room() -> Geometry:
    """Six bunnies on the floor of a room whose walls are two triangles each."""
    points, triangles = scan()
    places = [np.array([x, -0.9, z]) for x in (-2, 2) for z in (-2, 0, 2)]
    walls = _block(np.array([-3.0, -1.0, -3.0]), np.array([3.0, 2.5, 3.0]), 1)
    points, triangles = _joined([*((points * 0.1 + place, triangles) for place in places), walls])
    return points.astype(np.float32), triangles


SCENES: dict[str, Callable[[], Geometry]] = {
    "soup": soup,
    "scan": scan,
    "houses": architecture,
    "stadium": teapot_in_stadium,
    "hair": hair,
    "dragon": dragon,
    "needles": needles,
    "room": room,
}


def view_rays(name: str, size: int) -> Rays:
    """A pinhole camera that sees the scene, row by row; in the stadium, from the stands toward the teapot."""
    if name == "stadium":
        eye, target, fov = np.array([0.004, 0.003, 0.005]), np.zeros(3), 50.0
    else:
        eye, target, fov = np.array([1.6, 1.2, 2.4]), np.zeros(3), 45.0
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross([0, 1, 0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    steps = ((np.arange(size) + 0.5) / size * 2 - 1) * np.tan(np.radians(fov / 2))
    x, y = (grid.reshape(-1, 1) for grid in np.meshgrid(steps, -steps))
    directions = x * right + y * up - back
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return Rays(np.tile(eye, (size * size, 1)).astype(np.float32), directions.astype(np.float32))


def bounce_from(tracer: iso.Tracer, rays: Rays, seed: int = 1) -> Rays:
    """One cosine-distributed ray off each hit of `rays`, on the side that they came from."""
    hits = tracer.closest(*rays)
    normals = hits.normal[hits.hit].astype(float)
    toward = (normals * rays.directions[hits.hit]).sum(axis=1, keepdims=True) > 0
    normals = np.where(toward, -normals, normals)
    d = np.random.default_rng(seed).normal(size=normals.shape)
    directions = normals + (1 - 1e-6) * d / np.linalg.norm(d, axis=1, keepdims=True)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    distance = hits.distance[hits.hit][:, None]
    origins = hits.point[hits.hit] + 1e-4 * distance * normals
    return Rays(origins.astype(np.float32), directions.astype(np.float32))
