"""Rays that try accelerators, and what brute force says about them."""

from __future__ import annotations

import numpy as np

import isophote as iso

__all__ = ["check_against_brute_force", "distant_rays", "rays_at"]

Rays = tuple[np.ndarray, np.ndarray]


def rays_at(mesh: iso.Mesh, count: int, seed: int = 1) -> Rays:
    """Rays from around the mesh and from within it, of many lengths; some along axes, some from vertices, some both."""
    rng = np.random.default_rng(seed)
    low, high = mesh.bounds.astype(np.float64)
    size = np.maximum(high - low, 1e-3 * (high - low).max())
    origins = low + size * rng.uniform(-0.5, 1.5, (count, 3))
    directions = low + size * rng.uniform(0, 1, (count, 3)) - origins
    along = rng.random(count) < 0.2
    directions[along] *= rng.random((along.sum(), 3)) < 0.4
    directions[(directions == 0).all(axis=1)] = (0, 0, -1)
    at_vertices = rng.random(count) < 0.1
    origins[at_vertices] = mesh.vertices[rng.integers(0, len(mesh.vertices), at_vertices.sum())]
    directions *= 10 ** rng.uniform(-3, 3, (count, 1))
    # Near the end of single precision some are not finite, or are too short.
    with np.errstate(over="ignore"):
        rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
    usable = np.isfinite(rays).all(axis=1) & (np.abs(rays[:, 3:]).max(axis=1) > 1e-8)
    return rays[usable, :3], rays[usable, 3:]


def distant_rays(mesh: iso.Mesh, count: int, seed: int = 2) -> Rays:
    """Rays toward the mesh from up to ten thousand times its size away, where single precision is coarse."""
    rng = np.random.default_rng(seed)
    origins, directions = rays_at(mesh, count, seed)
    middle = mesh.bounds.mean(axis=0)
    far = middle + (origins - middle) * 10 ** rng.uniform(1, 4, (count, 1))
    return far, (middle - far) * 1e-2 + 0.01 * directions


def check_against_brute_force(mesh: iso.Mesh, rays: Rays, names: tuple[str, ...]) -> iso.Hits:
    """Every accelerator finds the same distances, bit for bit, and the same triangles but where several are as near.
    Returns the true hits."""
    truth = iso.Tracer(mesh, accelerator="brute").closest(*rays)
    for name in names:
        tracer = iso.Tracer(mesh, accelerator=name)
        found = tracer.closest(*rays)
        assert found.distance.tobytes() == truth.distance.tobytes(), name
        assert np.array_equal(tracer.occluded(*rays), truth.hit), name
        # A triangle that is told is met where it is told, so another one is as near.
        assert np.array_equal(found.primitive < 0, truth.primitive < 0), name
    return truth
