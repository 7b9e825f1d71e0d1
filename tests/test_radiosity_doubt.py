"""What radiosity sees of light that links are not sure of, what it tells while it works, and what it refuses early."""

from __future__ import annotations

import re

import numpy as np
import pytest

import isophote as iso
from isophote.errors import RenderError
from scenes import box


def quad(*corners: tuple[float, float, float]) -> iso.Mesh:
    return iso.Mesh(corners, [(0, 1, 2, 3)])


def rectangle(half: float, height: float) -> iso.Mesh:
    """A square about the origin."""
    return quad((-half, height, half), (half, height, half), (half, height, -half), (-half, height, -half))


def half_shaded(ground: np.ndarray, places: int, lights: int) -> np.ndarray:
    """Mean irradiance of rectangles (n, 4, 3) on the ground from a lamp, |x|, |z| < 0.5 at y = 1, of radiance 1, where
    a sheet hides what is seen through x < 0, y = 0.5."""
    steps, grid = (np.arange(places) + 0.5) / places, (np.arange(lights) + 0.5) / lights
    s, t = (axis.reshape(-1, 1) for axis in np.meshgrid(steps, steps))
    along, across = (axis.reshape(-1) for axis in np.meshgrid(grid, grid))
    low, high = ground.min(axis=1), ground.max(axis=1)
    found = np.zeros(len(ground))
    for k in range(len(ground)):
        x, z = low[k, 0] + s * (high - low)[k, 0], low[k, 2] + t * (high - low)[k, 2]
        # From x the lamp is seen beyond −x.
        width = np.clip(0.5 + x, 0, 1)
        square = (0.5 - width * along - x) ** 2 + (across - 0.5 - z) ** 2 + 1
        found[k] = (width / square**2).mean()
    return found


def test_half_shadows_are_those_of_brute_force() -> None:
    sheet = quad((-6, 0.5, 6), (0, 0.5, 6), (0, 0.5, -6), (-6, 0.5, -6))
    lamp = iso.RectLight(size=(1, 1), radiance=(1, 1, 1)).at((0, 1, 0))
    scene = iso.Scene([iso.Item(rectangle(1.0, 0.0), iso.Matte(0.5)), iso.Item(sheet, iso.Emitter(0.0))], lights=[lamp])
    found = iso.radiosity(scene, iso.Radiosity(patch=0.1, error=0.005), progress=False)
    lit = (found.item == 0) & (found.irradiance[:, 0] > 0)
    exact = half_shaded(found.corners[lit], 16, 16)
    errors = np.abs(found.irradiance[lit, 0] / exact - 1)[exact > 0.05 * exact.max()]
    assert len(errors) > 100
    assert np.percentile(errors, 90) < 0.005
    assert errors.max() < 0.03


def test_patches_that_a_box_stands_on_have_the_light_of_what_is_left() -> None:
    # All around shines alike: where the box hides half, half arrives, next to it as well.
    walls = iso.Item(box(8.0, inward=True), iso.Emitter(1.0))
    ground = iso.Item(rectangle(1.0, 0.0), iso.Matte(0.5))
    dark = iso.Item(box(0.7), iso.Emitter(0.0)).translate((0.11, 0.35, 0.07))
    scene = iso.Scene([walls, ground, dark])
    found = iso.radiosity(scene, iso.Radiosity(patch=0.1, error=0.005), progress=False)
    up = (found.item == 1) & (found.form_factor_sums > 0)
    corners, arriving = found.corners[up], found.irradiance[up, 0]
    low, high = corners.min(axis=1)[:, [0, 2]], corners.max(axis=1)[:, [0, 2]]
    left, right = np.array([-0.24, -0.28]), np.array([0.46, 0.42])
    covered = np.clip(np.minimum(high, right) - np.maximum(low, left), 0, None).prod(axis=1)
    part = covered / (high - low).prod(axis=1)
    middle = (low + high) / 2
    # In the middle of a side of the box, partly under it.
    cut = (part > 0.2) & (part < 0.7) & (np.abs(middle - (0.11, 0.07)).min(axis=1) < 0.15)
    assert cut.sum() >= 6
    # A bit more than half: its sides end.
    assert (arriving[cut] > 0.5 * np.pi).all()
    assert (arriving[cut] < 0.62 * np.pi).all()


def test_too_many_links_are_refused_before_they_are_made() -> None:
    walls = [
        quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)),
        quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)),
        quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)),
    ]
    lamp = iso.RectLight(size=(0.5, 0.5), radiance=15).at((0, 1.98, 0))
    scene = iso.Scene([iso.Item(wall, iso.Matte(0.7)) for wall in walls], lights=[lamp])
    with pytest.raises(RenderError, match=r"links are needed.* MB; give larger patches") as refused:
        iso.radiosity(scene, iso.Radiosity(patch=0.004, error=1e-6), progress=False)
    asked = re.search(r"first ([\d,]+) pairs", str(refused.value))
    assert asked is not None
    assert int(asked.group(1).replace(",", "")) < 1_000_000


def test_progress_is_told_by_stages_that_do_not_multiply() -> None:
    told: list[tuple[str, float]] = []
    scene = iso.Scene(
        [iso.Item(rectangle(1.0, 0.0), iso.Matte(0.5)), iso.Item(box(0.3), iso.Matte(0.5)).translate((0, 0.3, 0))],
        lights=[iso.RectLight(size=(0.5, 0.5), radiance=15).at((0, 1.98, 0))],
    )
    iso.radiosity(scene, iso.Radiosity(patch=0.05), progress=lambda stage, part: told.append((stage, part)))
    assert len({stage for stage, _ in told}) <= 4
    linking = [part for stage, part in told if stage == "linking patches"]
    assert len(linking) > 3
    assert all(0 <= part <= 1 for part in linking)
