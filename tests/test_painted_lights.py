"""Lights whose radiance a texture varies, beside the same light made of parts of one colour each."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from scenes import plane

CELLS = np.array([[(8.0, 1.0, 0.0), (0.0, 0.0, 6.0)], [(0.5, 5.0, 0.5), (3.0, 3.0, 3.0)]], np.float32)
PICTURE = iso.ImageTexture(CELLS, wrap="clamp", filter="nearest")
UV = [(0, 0), (0, 1), (1, 1), (1, 0)]
# The lamp faces down: its corners go round clockwise as seen from above.
LAMP = iso.Mesh([(-1, 1.2, -1), (1, 1.2, -1), (1, 1.2, 1), (-1, 1.2, 1)], [(0, 1, 2, 3)], attributes={"uv": UV})
CAMERA = iso.Camera((0, 0.8, 5), (0, 0.3, 0), fov_degrees=40)


def uv_at(x: float, z: float) -> tuple[float, float]:
    return (z + 1) / 2, (x + 1) / 2


def parts() -> list[iso.Item]:
    """The lamp as four squares of one colour each."""
    found = []
    for x in (-1.0, 0.0):
        for z in (-1.0, 0.0):
            u, v = uv_at(x + 0.5, z + 0.5)
            colour = CELLS[int((1 - v) * 2), int(u * 2)]
            corners = [(x, 1.2, z), (x + 1, 1.2, z), (x + 1, 1.2, z + 1), (x, 1.2, z + 1)]
            found.append(iso.Item(iso.Mesh(corners, [(0, 1, 2, 3)]), iso.Emitter(tuple(map(float, colour)))))
    return found


def shining(factor: float = 1.0) -> dict[str, iso.Material]:
    picture = iso.ImageTexture(CELLS / np.float32(factor), wrap="clamp", filter="nearest")
    return {
        "emitter": iso.Emitter(factor, texture=picture),
        "principled": iso.Principled(0.0, roughness=1.0, emission=(factor,) * 3, emission_texture=picture),
    }


def drawn(lamp: list[iso.Item], floor: iso.Material, method: object) -> np.ndarray:
    scene = iso.Scene([iso.Item(plane(6), floor), *lamp], [], CAMERA)
    image = iso.render(scene, method, size=(12, 12), seed=3, progress=False)
    return image.channels["colour"].astype(np.float64)


@pytest.mark.parametrize("kind", ["emitter", "principled"])
@pytest.mark.parametrize(
    "floor", [iso.Matte(0.7), iso.Plastic(0.4, roughness=0.2), iso.Mirror()], ids=["matte", "plastic", "mirror"]
)
def test_light_of_all_colours_arrives_as_from_its_parts(kind: str, floor: iso.Material) -> None:
    method = iso.PathTrace(samples=1024, max_depth=2)
    wanted, found = drawn(parts(), floor, method), drawn([iso.Item(LAMP, shining(2.0)[kind])], floor, method)
    # Glints and the lamp itself apart, pictures agree to a few parts in a hundred; on the mean they agree better.
    np.testing.assert_allclose(found.mean(axis=(0, 1)), wanted.mean(axis=(0, 1)), rtol=0.02)
    near = np.abs(found - wanted) <= 0.06 * wanted + 0.02
    assert near.mean() > 0.93


def test_ray_tracing_aims_at_painted_lights() -> None:
    method = iso.RayTrace(samples=16, light_samples=64)
    wanted = drawn(parts(), iso.Matte(0.7), method)
    found = drawn([iso.Item(LAMP, shining()["emitter"])], iso.Matte(0.7), method)
    np.testing.assert_allclose(found.mean(axis=(0, 1)), wanted.mean(axis=(0, 1)), rtol=0.02)
    assert (np.abs(found - wanted) <= 0.06 * wanted + 0.02).mean() > 0.93


def test_primitives_with_textures_shine_by_chance() -> None:
    """An even texture on a ball is light as without one."""
    even = iso.ImageTexture(np.full((1, 1, 3), 0.5, np.float32))
    plain, painted = iso.Emitter(4.0), iso.Emitter(8.0, texture=even)
    ball = iso.Item(iso.sphere(0.5), plain).translate((0, 1, 0))
    method = iso.PathTrace(samples=1024, max_depth=2)
    wanted = drawn([ball], iso.Matte(0.7), method)
    found = drawn([iso.Item(ball.shape, painted, ball.transform)], iso.Matte(0.7), method)
    np.testing.assert_allclose(found.mean(axis=(0, 1)), wanted.mean(axis=(0, 1)), rtol=0.03)
