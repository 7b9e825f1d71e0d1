"""Tables of the last scene are used again, and only for the same scene."""

from __future__ import annotations

import gc

import attrs

import isophote as iso
from isophote.lower import scene as lower
from isophote.lower.latest import LatestScene

TRIANGLE = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
FRONT, SIDE = iso.Camera((0, 0, 3), (0, 0, 0)), iso.Camera((1, 0, 3), (0, 0, 0))


def test_another_view_needs_no_new_tree() -> None:
    scene = iso.Scene([iso.Item(TRIANGLE)], lights=[iso.Sky()], camera=FRONT)
    first, second = lower.lower_scene(scene, (4, 4)), lower.lower_scene(scene.with_(camera=SIDE), (8, 8))
    assert first.arrays["geometry"] is second.arrays["geometry"]
    assert (first.arrays["camera"] != second.arrays["camera"]).any()


def test_other_items_or_lights_are_lowered_anew() -> None:
    scene = iso.Scene([iso.Item(TRIANGLE)], lights=[iso.Sky()], camera=FRONT)
    first = lower.lower_scene(scene, (4, 4)).arrays
    for other in (
        scene.with_(items=[iso.Item(TRIANGLE).translate((1, 0, 0))]),
        scene.with_(items=[*scene.items, iso.Item(TRIANGLE)]),
        scene.with_(lights=[iso.Sky("red")]),
    ):
        again = lower.lower_scene(other, (4, 4)).arrays
        assert again["geometry"] is not first["geometry"]
        assert again["lights"] is not first["lights"]


def test_tables_are_let_go_with_their_items() -> None:
    latest = LatestScene()
    scene = iso.Scene([iso.Item(TRIANGLE)])
    latest.keep(scene, "bvh", {})
    assert latest.find(scene, "bvh") == {}
    same_looking = iso.Scene([iso.Item(TRIANGLE)])
    assert latest.find(same_looking, "bvh") is None
    del scene
    gc.collect()
    assert latest._latest._kept is None


def test_pictures_keep_their_levels_under_other_lights() -> None:
    picture = iso.ImageTexture([[0, 100], [200, 50]])
    scene = iso.Scene([iso.Item(TRIANGLE, iso.Matte(picture))], lights=[iso.Sky()], camera=FRONT)

    def texels(scene: iso.Scene) -> object:
        return lower.lower_scene(scene, (4, 4)).arrays["textures"].arrays["bytes"]

    first = texels(scene)
    assert texels(scene.with_(lights=[iso.Sky("red")])) is first
    sharp = iso.Matte(attrs.evolve(picture, filter="nearest"))
    assert texels(scene.with_(items=[iso.Item(TRIANGLE, sharp)])) is not first
    other = iso.Matte(iso.ImageTexture([[0, 100], [200, 50]]))
    assert texels(scene.with_(items=[iso.Item(TRIANGLE, other)])) is not first
