"""Footprints of pixels: what textures are told of it, beside differences between neighbouring pixels."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

import footprint_textures as shows
import isophote as iso
from isophote.kernels.base.entry import Entry
from isophote.kernels.texture import image
from scenes import icosphere

Floats = npt.NDArray[np.float64]

SIZE = 48
PICTURE = iso.ImageTexture(np.full((1, 1, 3), 255, np.uint8), filter="nearest")
SKY = iso.Sky((1.0, 1.0, 1.0))
SQUARE = iso.Mesh(
    [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)],
    [(0, 1, 2, 3)],
    attributes={"uv": [(0, 0), (3, 0), (3, 2), (0, 2)]},
)
TEXTURED = iso.Matte(PICTURE)


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> Callable[[iso.Scene, Entry, object], Floats]:
    """Draws scenes whose picture textures show what an entry answers."""

    def draw(scene: iso.Scene, entry: Entry, method: object = None) -> Floats:
        monkeypatch.setattr(image, "nearest", entry)
        # A scene that no other is equal to, so that no tables are used again.
        fresh = iso.Scene([iso.Item(i.shape, i.material, i.transform) for i in scene.items], scene.lights, scene.camera)
        pictures = iso.render(fresh, method or iso.PathTrace(samples=1), size=(SIZE, SIZE)).channels
        return pictures["albedo" if method is None else "colour"].astype(np.float64)

    return draw


def differences(places: Floats, columns: int) -> Floats:
    """Σ over the two half-axes of a pixel of squared changes, by central differences; NaN at the border."""
    found = np.full((*places.shape[:2], columns), np.nan)
    dx = (places[1:-1, 2:, :columns] - places[1:-1, :-2, :columns]) / 4
    dy = (places[2:, 1:-1, :columns] - places[:-2, 1:-1, :columns]) / 4
    found[1:-1, 1:-1] = dx**2 + dy**2
    return found


def agree(axes: Floats, wanted: Floats, seen: npt.NDArray[np.bool_], tolerance: float) -> None:
    """Whether most pixels' ellipses have the wanted extents."""
    inner = seen & np.isfinite(wanted).all(axis=2)
    assert inner.sum() > 200
    ratio = np.sqrt((axes[..., : wanted.shape[2]][inner] + 1e-12) / (wanted[inner] + 1e-12))
    assert np.quantile(np.abs(np.log(ratio)), 0.9) < tolerance
    assert abs(np.median(np.log(ratio))) < tolerance / 2


VIEWS = {
    "perspective": iso.Camera((0.4, 0.7, 2.2), (0, 0, 0), fov_degrees=40),
    "parallel": iso.OrthographicCamera((0.4, 1.4, 2.2), (0, 0, 0), height=1.6),
}
SHAPES = {
    "triangles": SQUARE,
    "sphere": iso.sphere(0.6),
    "cylinder": iso.cylinder(0.4, 1.2),
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("shape", SHAPES)
def test_coordinates_change_as_from_pixel_to_pixel(shown, view: str, shape: str) -> None:
    scene = iso.Scene(
        [iso.Item(SHAPES[shape], TEXTURED, iso.Transform.identity().scale((1.2, 0.8, 1.0)))], [SKY], VIEWS[view]
    )
    uv, axes = shown(scene, shows.show_uv), shown(scene, shows.show_uv_axes)
    # Not across the edge of a part, nor where coordinates start again.
    seen = np.zeros(uv.shape[:2], bool)
    seen[1:-1, 1:-1] = True
    for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        moved = np.roll(uv, step, axis=(0, 1))
        seen &= (np.abs(moved - uv)[..., :2].max(axis=2) < 0.3) & (moved[..., 2] == 1)
    agree(axes, differences(uv, 2), seen & (uv[..., 2] == 1), 0.25)


@pytest.mark.parametrize("shape", [SQUARE, iso.sphere(0.6), iso.sphere(0.6).twist(0.1)], ids=["mesh", "ball", "field"])
def test_places_of_the_shapes_own_space_change_as_from_pixel_to_pixel(shown, shape) -> None:
    turned = iso.Transform.identity().scale(0.5).rotate((0, 1, 0), 0.5).translate((0.1, 0, 0))
    scene = iso.Scene([iso.Item(shape, TEXTURED, turned)], [SKY], iso.Camera((0.2, 0.5, 1), (0, 0, 0), fov_degrees=50))
    place, axes = shown(scene, shows.show_own), shown(scene, shows.show_own_axes)
    wanted = differences(place, 3)
    seen = (axes.max(axis=2) > 0) & np.isfinite(wanted).all(axis=2)
    # Not across the outline.
    for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        seen &= np.roll(axes.max(axis=2) > 0, step, axis=(0, 1))
    total = np.sqrt(axes.sum(axis=2)[seen] / wanted.sum(axis=2)[seen])
    assert seen.sum() > 200
    assert np.quantile(np.abs(np.log(total)), 0.9) < 0.25


MIRRORS = {
    "flat": iso.Item(iso.box((1.2, 1.2, 0.1)), iso.Mirror()),
    "ball": iso.Item(iso.sphere(0.6), iso.Mirror()),
    "smooth mesh": iso.Item(icosphere(4, 0.6, smooth=True), iso.Mirror()),
    "field": iso.Item(iso.sphere(0.6).twist(0.01), iso.Mirror()),
    "glass ball": iso.Item(iso.sphere(0.6), iso.Glass()),
}


@pytest.mark.parametrize("mirror", ["flat", "ball", "smooth mesh", "field", "glass ball"])
def test_cones_turn_at_smooth_surfaces_as_rays_do(shown, mirror: str) -> None:
    """What is seen in mirrors and through glass: areas of footprints beside those of neighbouring rays."""
    behind = -4.0 if mirror == "glass ball" else 4.0
    wall = iso.Item(
        SQUARE, TEXTURED, iso.Transform.identity().rotate((1, 0, 0), np.pi / 2).scale(12).translate((0, 0, behind))
    )
    camera = iso.Camera((0.3, 0.2, 2.5), (0, 0, 0), fov_degrees=22)
    scene = iso.Scene([wall, MIRRORS[mirror]], [SKY], camera)
    # Nothing of what glass reflects, nor of what is reflected within it.
    method = iso.RayTrace(samples=1, depth=3 if mirror == "glass ball" else 2, min_weight=0.3, pattern="regular")
    uv, axes = shown(scene, shows.show_uv, method), shown(scene, shows.show_uv_axes, method)
    share = np.where((uv == 1).all(axis=2), 0, uv[..., 2])
    seen = share > 0.3
    uv, axes = uv / np.maximum(share, 0.1)[..., None], axes / np.maximum(share, 0.1)[..., None]
    for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        moved = np.roll(uv, step, axis=(0, 1))
        seen &= (np.abs(moved - uv)[..., :2].max(axis=2) < 0.2) & (np.roll(share, step, axis=(0, 1)) > 0.3)
    dx, dy = np.full((2, *uv.shape[:2], 2), np.nan)
    dx[1:-1, 1:-1] = (uv[1:-1, 2:, :2] - uv[1:-1, :-2, :2]) / 4
    dy[1:-1, 1:-1] = (uv[2:, 1:-1, :2] - uv[:-2, 1:-1, :2]) / 4
    wanted = np.abs(dx[..., 0] * dy[..., 1] - dx[..., 1] * dy[..., 0])
    found = np.sqrt(np.maximum(axes[..., 0] * axes[..., 1] - axes[..., 2] ** 2, 0))
    seen &= np.isfinite(wanted)
    assert seen.sum() > 150
    ratio = 0.5 * np.log(found[seen] / wanted[seen])
    assert abs(np.median(ratio)) < 0.1
    assert np.quantile(np.abs(ratio), 0.8) < 0.3
