"""What tests of ray tracing share: pictures by `RayTrace`, logs of pixels, boxes between two corners."""

from __future__ import annotations

import numpy as np

import isophote as iso
from isophote.rendering.method import Job
from isophote.rendering.ray_log import PixelLog, log_pixel

__all__ = ["block", "colour", "log", "ray_trace", "seen_along"]


def ray_trace(items, lights=(), camera=None, *, size=(16, 16), seed=1, threads=2, method=None, **settings) -> iso.Image:
    """The picture of items and lights by `RayTrace(**settings)`, or by another method."""
    camera = camera or iso.Camera((0, 0, 4), (0, 0, 0), fov_degrees=40)
    scene = iso.Scene(items, lights=lights, camera=camera)
    method = iso.RayTrace(**settings) if method is None else method
    return iso.render(scene, method, size=size, seed=seed, threads=threads, progress=False)


def colour(image: iso.Image) -> np.ndarray:
    """(h, w, 3) in double precision."""
    return image.channels["colour"].astype(np.float64)


def log(items, lights=(), camera=None, *, pixel=(0, 0), size=(1, 1), seed=1, **settings) -> PixelLog:
    """The log of a pixel's rays; of the only pixel unless others are named."""
    camera = camera or iso.Camera((0, 0, 4), (0, 0, 0), fov_degrees=40)
    scene = iso.Scene(items, lights=lights, camera=camera)
    return log_pixel(Job(scene, size, seed, 1, lambda stage, fraction: None), iso.RayTrace(**settings), pixel)


def block(low, high) -> iso.Mesh:
    """A box of quads between two corners."""
    low, high = np.array(low, float), np.array(high, float)
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * (high - low) + low
    return iso.Mesh(corners, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


def seen_along(origin, direction, height=1e-3) -> iso.OrthographicCamera:
    """A camera whose rays start at `origin`, all but a hair's breadth, and go along `direction`."""
    origin, direction = np.array(origin, float), np.array(direction, float)
    up = (0, 1, 0) if abs(direction[1]) < 0.9 * np.linalg.norm(direction) else (1, 0, 0)
    return iso.OrthographicCamera(origin, origin + direction, up, height=height)
