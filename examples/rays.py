"""Rays over arrays: how thick is a bowl, and how much of the sky does its floor see?

`Tracer` builds the tree once and answers for as many rays as an array holds: the first hit of each, or whether
anything is in the way. Run it, and it prints its answers; it also defines the bowl as a `shape`.

    python examples/rays.py
    isophote render examples/rays.py -o bowl.png
"""

import numpy as np

import isophote as iso

OUTER, INNER = 1.0, 0.9


def bowl(rows=64, columns=128):
    """Half a hollow sphere, open at the top and closed at the rim."""
    polar = np.linspace(np.pi / 2, np.pi, rows)[:, None]
    around = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
    unit = np.stack(
        np.broadcast_arrays(np.sin(polar) * np.sin(around), np.cos(polar), np.sin(polar) * np.cos(around)), axis=-1
    )
    points = np.concatenate([(OUTER * unit).reshape(-1, 3), (INNER * unit).reshape(-1, 3)])
    here = np.arange(rows * columns).reshape(rows, columns)
    there = np.roll(here, -1, axis=1)
    outside = np.stack([here[:-1], here[1:], there[1:], there[:-1]], axis=-1).reshape(-1, 4)
    inside = outside[:, ::-1] + rows * columns
    rim = np.stack([here[0], there[0], there[0] + rows * columns, here[0] + rows * columns], axis=-1)
    return iso.Mesh(points, np.concatenate([outside, inside, rim]))


def thickness(tracer, count, rng):
    """(count,) metres of bowl along rays from below toward the middle of the sphere: exit minus entry."""
    directions = rng.normal(size=(count, 3))
    directions[:, 1] = -np.abs(directions[:, 1]) - 0.2
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    entry = tracer.closest(3 * directions, -directions).distance
    exits = 3 - tracer.closest(np.zeros(3), directions).distance
    return exits - entry


def visible_sky(tracer, count, rng):
    """Part of the upper half of directions, weighed by the cosine, that the bottom of the bowl sees."""
    radius, angle = np.sqrt(rng.random(count)), 2 * np.pi * rng.random(count)
    x, z = radius * np.sin(angle), radius * np.cos(angle)
    directions = np.stack([x, np.sqrt(1 - radius**2), z], axis=1)
    return 1 - tracer.occluded((0, -INNER + 1e-3, 0), directions).mean()


shape = bowl()

if __name__ == "__main__":
    random = np.random.default_rng(1)
    ready = iso.Tracer(shape)
    found = thickness(ready, 100_000, random)
    print(f"thickness {found.mean():.4f} m, from {found.min():.4f} to {found.max():.4f}; built as {OUTER - INNER:.4f}")
    print(f"visible sky {visible_sky(ready, 1_000_000, random):.3f}; by the formula 0.500")
