"""What materials refuse, and say."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import isophote as iso
from isophote.scene.material_base import textures_of
from isophote.scene.nearest import nearest_principled
from reflectances import ALL

NAN = math.nan


@pytest.mark.parametrize(
    ("words", "make"),
    [
        ("Matte: colour is the reflected part", lambda: iso.Matte(1.2)),
        ("Matte: colour is the reflected part", lambda: iso.Matte((0.5, 0.5, 1.0001))),
        ("colour must be finite", lambda: iso.Matte((0.5, NAN, 0.5))),
        ("Mirror: colour", lambda: iso.Mirror(2)),
        ("Glass: colour", lambda: iso.Glass(1.5, 2)),
        ("Glass: roughness must be a number from 0 to 1", lambda: iso.Glass(roughness=-0.1)),
        ("two of them", lambda: iso.Glass(roughness=(0.1, 2))),
        ("Glass: ior", lambda: iso.Glass(NAN)),
        ("Principled: colour", lambda: iso.Principled(1.5)),
        ("OrenNayar: roughness", lambda: iso.OrenNayar(0.5, 2)),
        ("OrenNayar: roughness", lambda: iso.OrenNayar(0.5, NAN)),
        ("OrenNayar: roughness", lambda: iso.OrenNayar(0.5, "rough")),
        ("Phong: specular", lambda: iso.Phong(0.5, 1.5)),
        ("Phong: exponent", lambda: iso.Phong(exponent=-1)),
        ("Blinn: exponent", lambda: iso.Blinn(exponent=math.inf)),
        ("AshikhminShirley: exponents", lambda: iso.AshikhminShirley(exponents=(10, NAN))),
        ("Ward: roughness must be above 0", lambda: iso.Ward(roughness=0)),
        ("Ward: roughness must be above 0", lambda: iso.Ward(roughness=(0.2, 0))),
        ("Metal: 'unobtainium' is not known; use aluminium", lambda: iso.Metal("unobtainium")),
        ("Metal: index must be a name or a pair", lambda: iso.Metal(1.5)),
        ("n must be above 0", lambda: iso.Metal((0, 3))),
        ("colour must be finite", lambda: iso.Metal((1, NAN))),
        ("Metal: roughness", lambda: iso.Metal("gold", 1.01)),
        ("Plastic: ior", lambda: iso.Plastic(ior=1.0)),
        ("Plastic: ior", lambda: iso.Plastic(ior=NAN)),
        ("Plastic: roughness", lambda: iso.Plastic("red", None)),
        ("Coated: base must be a material", lambda: iso.Coated("gold")),
        ("Mix: second must be a material", lambda: iso.Mix(iso.Matte(), 0.5)),
        ("Mix: amount", lambda: iso.Mix(iso.Matte(), iso.Mirror(), 1.5)),
        ("Mix: first shines", lambda: iso.Mix(iso.Emitter(3), iso.Mirror())),
        ("Coated: base shines", lambda: iso.Coated(iso.Principled(emission=1))),
        ("Emitter: body must be a material", lambda: iso.Emitter(1, body="red")),
        ("Emitter: body must be a material that does not shine", lambda: iso.Emitter(1, body=iso.Emitter(1))),
        ("Emitter: body shines", lambda: iso.Emitter(1, body=iso.Principled(emission=1))),
    ],
)
def test_values_without_meaning_are_refused(words: str, make: Callable[[], object]) -> None:
    with pytest.raises(iso.SceneError) as caught:
        make()
    assert words in str(caught.value)


def test_mixes_have_bounds() -> None:
    deep: iso.Material = iso.Matte()
    for _ in range(40):
        deep = iso.Mix(deep, iso.Phong())
    box = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    scene = iso.Scene([iso.Item(box, deep)], [iso.Sky()], iso.Camera((0, 0, 3), (0, 0, 0)))
    with pytest.raises(iso.SceneError, match="mixes or coats too much"):
        iso.render(scene, iso.PathTrace(samples=1), size=(2, 2), progress=False)


@pytest.mark.parametrize("name", ALL)
def test_materials_are_values(name: str) -> None:
    material = ALL[name]
    assert isinstance(material, iso.Material)
    assert eval(repr(material), vars(iso) | {name: getattr(iso, name) for name in iso.__all__}) == material
    assert hash(material) == hash(type(material)(**_fields(material)))
    nearest = nearest_principled(material)
    assert isinstance(nearest, iso.Principled)
    assert nearest_principled(nearest) is nearest


def _fields(material: iso.Material) -> dict[str, object]:
    return {name: getattr(material, name) for name in type(material).__slots__ if name != "__weakref__"}


def test_textures_beyond_one_are_taken_as_they_are() -> None:
    bright = iso.ImageTexture(np.full((1, 1, 3), 3.0, np.float32))
    assert iso.Matte(bright).colour is bright


def test_the_nearest_of_what_gltf_cannot_say() -> None:
    gold = nearest_principled(iso.Coated(iso.Metal("gold", 0.5), 0.2))
    assert (gold.metallic, gold.roughness) == (1.0, 0.2)
    assert gold.colour[0] > 2 * gold.colour[2]
    texture = iso.ImageTexture(np.full((1, 1, 3), 100, np.uint8))
    assert nearest_principled(iso.Mix(iso.Matte(texture), iso.Mirror(), 0.3)).colour_texture is texture
    shining = nearest_principled(iso.Emitter((3, 2, 1), True, iso.Plastic("red", 0.4)))
    assert (shining.emission, shining.two_sided, shining.roughness) == ((3, 2, 1), True, 0.4)
    grey = nearest_principled(iso.Measured(np.full((90, 90, 180, 3), 0.5 / np.pi)))
    assert grey.colour == pytest.approx((0.5, 0.5, 0.5), rel=1e-5)


def test_textures_inside_materials_are_counted() -> None:
    a, b = (iso.ImageTexture(np.full((1, 1, 3), value, np.uint8)) for value in (1, 2))
    material = iso.Emitter(1, body=iso.Mix(iso.Coated(iso.Matte(a)), iso.Metal("gold", (0.2, b)), a))
    assert {id(texture) for texture in textures_of(material)} == {id(a), id(b)}
