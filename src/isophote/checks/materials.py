"""The materials that are checked: every kind, with parameters that a grid of directions can follow."""

from __future__ import annotations

from functools import cache

from isophote.lower.probe import Probe
from isophote.rendering.reflectance_table import measure_brdf
from isophote.scene.compound import Coated, Mix, Plastic
from isophote.scene.cutout import Cutout
from isophote.scene.gloss import AshikhminShirley, Blinn, OrenNayar, Phong, Ward
from isophote.scene.material import Glass, Matte, Mirror, Principled
from isophote.scene.material_base import Material
from isophote.scene.metal import Metal
from isophote.scene.noise import PerlinNoise
from isophote.scene.patterns import Checker
from isophote.scene.relief import Bump, NormalMap
from isophote.scene.thin_glass import ThinGlass

__all__ = ["MATERIALS", "WHITE", "WHITE_INDEX", "WHITE_PLACES", "material_of", "probe_of"]

# n and k of a metal that reflects everything.
WHITE_INDEX = (1e-4, 1e3)

_ORANGE = (0.9, 0.5, 0.1)

MATERIALS: dict[str, Material | None] = {
    "Matte": Matte(_ORANGE),
    "OrenNayar": OrenNayar(_ORANGE, 0.8),
    "Phong": Phong((0.7, 0.5, 0.1), (0.3, 0.4, 0.9), 25),
    "Blinn": Blinn((0.7, 0.5, 0.1), (0.3, 0.4, 0.9), 60),
    "AshikhminShirley": AshikhminShirley((0.7, 0.5, 0.1), (0.1, 0.4, 0.9), (200, 12)),
    "Ward": Ward((0.7, 0.5, 0.1), (0.1, 0.4, 0.9), (0.35, 0.7)),
    "Mirror": Mirror((0.9, 0.8, 0.7)),
    "Metal, smooth": Metal("silver", 0),
    "Metal, rough": Metal("gold", 0.5),
    "Metal, brushed": Metal("gold", (0.4, 0.8)),
    "Glass, smooth": Glass(1.5, (0.9, 1.0, 0.8)),
    "Glass, rough": Glass(1.5, (0.9, 1.0, 0.8), roughness=0.6),
    "ThinGlass": ThinGlass(1.5, (0.9, 1.0, 0.8), 0.01, (5, 20, 50)),
    "Plastic, smooth": Plastic(_ORANGE, 0),
    "Plastic, rough": Plastic(_ORANGE, 0.5),
    "Coated": Coated(Metal("copper", (0.4, 0.7)), 0.6, ior=1.8),
    "Mix": Mix(Metal("gold", 0.5), OrenNayar("navy"), 0.3),
    "Principled": Principled(_ORANGE, 0.5, 0.6),
    # Made when it is asked for: half a second.
    "Measured": None,
}

# Those that give back all light.
WHITE: dict[str, Material] = {
    "Matte": Matte(1.0),
    "OrenNayar": OrenNayar(1.0, 1.0),
    "Mirror": Mirror(1.0),
    "Metal, rough": Metal(WHITE_INDEX, 0.5),
    "Metal, very rough": Metal(WHITE_INDEX, 1.0),
    "Glass, smooth": Glass(1.5),
    "ThinGlass": ThinGlass(1.5),
    "Plastic, smooth": Plastic(1.0, 0.0),
    "Plastic, rough": Plastic(1.0, 0.4),
    "Mix": Mix(Matte(1.0), Metal(WHITE_INDEX, 0.6), 0.4),
    "Principled, dielectric": Principled(1.0, 0.0, 0.5),
    "Principled, half metal": Principled(1.0, 0.4, 0.3),
    "Principled, metal": Principled(1.0, 1.0, 0.7),
}

# Those that differ from place to place on a body, so that only pictures tell; they give back all light, too.
WHITE_PLACES: dict[str, Material] = {
    "Cutout": Cutout(Matte(1.0), 0.6),
    "NormalMap": NormalMap(Matte(1.0), Checker((0.8, 0.5, 0.9), (0.4, 0.7, 0.95), size=0.3)),
    "Bump": Bump(Matte(1.0), PerlinNoise(size=0.3), 0.05),
}


@cache
def material_of(name: str) -> Material:
    """The material of this name in MATERIALS."""
    return MATERIALS[name] or measure_brdf(Blinn((0.7, 0.5, 0.1), (0.3, 0.4, 0.9), 60))


@cache
def probe_of(material: Material) -> Probe:
    """The probe of a material, made once."""
    return Probe(material)
