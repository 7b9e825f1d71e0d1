"""Materials that tests of reflectance walk over, and integrals over directions."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

import isophote as iso
from isophote.lower.probe import Probe

__all__ = ["ALL", "GLASSES", "MATTE_OR_GLOSSY", "SINGLE", "WHITE", "direction", "disk_points", "probe", "sphere_grid"]

Floats = npt.NDArray[np.float64]

_WHITE_INDEX = (1e-4, 1e3)

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

# Those that give back all light, whatever their parameters.
WHITE: dict[str, iso.Material] = {
    "matte": iso.Matte(1.0),
    "Oren-Nayar": iso.OrenNayar(1.0, 1.0),
    "metal": iso.Metal(_WHITE_INDEX, 0.5),
    "rough metal": iso.Metal(_WHITE_INDEX, 1.0),
    "plastic": iso.Plastic(1.0, 0.4),
    "smooth plastic": iso.Plastic(1.0, 0.0),
    "principled dielectric": iso.Principled(1.0, 0.0, 0.5),
    "principled metal": iso.Principled(1.0, 1.0, 0.7),
    "principled half metal": iso.Principled(1.0, 0.4, 0.3),
    "mix": iso.Mix(iso.Matte(1.0), iso.Metal(_WHITE_INDEX, 0.6), 0.4),
}


@cache
def probe(material: iso.Material) -> Probe:
    """The probe of a material, made once."""
    return Probe(material)


def direction(theta: float, phi: float = 0.0) -> Floats:
    """The unit vector at these angles from z and from x."""
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def sphere_grid(rows: int, columns: int) -> tuple[Floats, Floats]:
    """(rows · columns, 3) directions over the whole sphere, and the solid angle (rows · columns,) that each stands for.

    Rows go from z = −1 up in even steps of the angle to the z axis.
    """
    edges = np.linspace(np.pi, 0, rows + 1)
    theta = (edges[1:] + edges[:-1]) / 2
    phi = 2 * np.pi * (np.arange(columns) + 0.5) / columns
    theta, phi = (a.reshape(-1) for a in np.meshgrid(theta, phi, indexing="ij"))
    angles = np.repeat(np.diff(np.cos(edges)), columns) * 2 * np.pi / columns
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], 1), angles


def disk_points(count: int, seed: int = 1) -> Floats:
    """(count, 3): points of the unit disk, and a number from 0 to 1 each; jittered, so that means are tight."""
    side = int(np.sqrt(count))
    rng = np.random.default_rng(seed)
    cells = np.stack(np.meshgrid(np.arange(side), np.arange(side)), 2).reshape(-1, 2)
    u, v = ((cells + rng.random(cells.shape)) / side).T
    pick = (rng.permutation(side * side) + rng.random(side * side)) / (side * side)
    r = np.sqrt(u)
    return np.stack([r * np.cos(2 * np.pi * v), r * np.sin(2 * np.pi * v), np.minimum(pick, 1 - 2.0**-24)], 1)
