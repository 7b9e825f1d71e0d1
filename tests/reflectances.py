"""Materials that tests of reflectance walk over, several of a kind."""

from __future__ import annotations

import isophote as iso

__all__ = ["ALL", "GLASSES", "MATTE_OR_GLOSSY", "SINGLE"]

# Materials that scatter to all directions, with parameters that a grid of directions can follow.
MATTE_OR_GLOSSY: dict[str, iso.Material] = {
    "matte": iso.Matte((0.9, 0.5, 0.1)),
    "Oren-Nayar": iso.OrenNayar((0.9, 0.5, 0.1), 0.8),
    "Phong": iso.Phong((0.7, 0.5, 0.1), (0.3, 0.4, 0.9), 25),
    "Blinn": iso.Blinn((0.7, 0.5, 0.1), (0.3, 0.4, 0.9), 60),
    "Blinn, broad": iso.Blinn(0.5, 1.0, 0.5),
    "Ashikhmin-Shirley": iso.AshikhminShirley((0.7, 0.5, 0.1), (0.1, 0.4, 0.9), (200, 12)),
    "Ward": iso.Ward((0.7, 0.5, 0.1), (0.1, 0.4, 0.9), (0.35, 0.7)),
    "metal": iso.Metal("gold", 0.5),
    "metal, one bounce": iso.Metal("copper", 0.5, single_bounce=True),
    "brushed metal": iso.Metal("gold", (0.4, 0.8)),
    "plastic": iso.Plastic((0.9, 0.5, 0.1), 0.5),
    "principled dielectric": iso.Principled((0.9, 0.5, 0.1), 0.0, 0.5),
    "principled metal": iso.Principled((0.9, 0.5, 0.1), 1.0, 0.6),
    "principled half metal": iso.Principled((0.9, 0.5, 0.1), 0.5, 0.6),
    "coated": iso.Coated(iso.Matte((0.9, 0.5, 0.1)), 0.5),
    "coated brushed metal": iso.Coated(iso.Metal("copper", (0.4, 0.7)), 0.6, ior=1.8),
    "mix": iso.Mix(iso.Metal("gold", 0.5), iso.OrenNayar("navy"), 0.3),
    "mix of mixes": iso.Mix(iso.Mix(iso.Matte(0.2), iso.Phong(), 0.6), iso.Coated(iso.Plastic("red", 0.5), 0.4), 0.5),
}
GLASSES: dict[str, iso.Material] = {
    "rough glass": iso.Glass(1.5, (0.9, 1.0, 0.8), roughness=0.6),
    "brushed glass": iso.Glass(1.33, roughness=(0.5, 0.8)),
    "rough bubble": iso.Glass(0.7, roughness=0.6),
}
# Those that also, or only, send light to single directions.
SINGLE: dict[str, iso.Material] = {
    "mirror": iso.Mirror((0.9, 0.8, 0.7)),
    "smooth metal": iso.Metal("silver", 0),
    "glass": iso.Glass(1.5, (0.9, 1.0, 0.8)),
    "smooth plastic": iso.Plastic((0.9, 0.5, 0.1), 0),
    "lacquered metal": iso.Coated(iso.Metal("gold", 0.5)),
    "lacquered mirror": iso.Coated(iso.Mirror(0.9)),
    "mix with mirror": iso.Mix(iso.Mirror(0.9), iso.Matte("red"), 0.25),
    "mix of glass and mirror": iso.Mix(iso.Glass(1.4), iso.Mirror(0.5), 0.7),
}
ALL = MATTE_OR_GLOSSY | GLASSES | SINGLE
