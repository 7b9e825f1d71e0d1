"""A material by itself, asked for directions."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.kernels.brdf import probe
from isophote.kernels.brdf.contract import WORDS
from isophote.lower.materials import MaterialTable
from isophote.scene.material import Emitter
from isophote.scene.material_base import Material

__all__ = ["Probe", "Scattered"]

Floats: TypeAlias = npt.NDArray[np.float32]


class Scattered(NamedTuple):
    """Directions (n, 3), f |cosθ| or f |cosθ| / density (n, 3), and densities (n,), 0 for single directions."""

    into: Floats
    value: Floats
    density: Floats


class Probe:
    """A material's reflectance, without a scene: in the local frame, whose z is the normal and x the tangent.

    Directions are (n, 3) or (3,), unit vectors that leave the surface. An `out` below the surface looks from inside,
    which only glass tells apart. `uv` is where textures are looked up. Of what shines the body is asked; raises
    `SceneError` where there is none.
    """

    def __init__(self, material: Material, uv: tuple[float, float] = (0.5, 0.5)) -> None:
        table = MaterialTable(all_linked=True)
        table.number(_reflecting(material))
        # The words of the tables point at the arrays that these hold.
        self._materials, self._textures = table.build()
        self._place = np.float32(uv[0]), np.float32(uv[1])
        self._scratch = np.zeros(WORDS, np.float32)

    @property
    def branches(self) -> int:
        """The number of single directions that light is sent to."""
        return int(self._materials.arrays["branches"][0])

    @property
    def scatters(self) -> bool:
        """Whether light is scattered to all directions, too."""
        return bool(self._materials.arrays["scatters"][0])

    def evaluate(self, out: npt.ArrayLike, into: npt.ArrayLike) -> Scattered:
        """f |cosθ| and the density of sampling for each pair of directions, single ones left out."""
        outs, intos = _pair(out, into)
        return self._call(probe.evaluate_many, outs, intos)

    def sample(self, out: npt.ArrayLike, points: npt.ArrayLike) -> Scattered:
        """Directions by `points` (n, 3): two coordinates in the unit disk, and a number from 0, below 1."""
        outs, given = _pair(out, points)
        return self._call(probe.sample_many, outs, np.zeros_like(outs), given)

    def branch(self, out: npt.ArrayLike, k: int) -> Scattered:
        """The k-th single direction that light from each `out` is sent to, and the share that goes there."""
        if not 0 <= k < self.branches:
            raise IndexError(f"the material has {self.branches} single directions, and none of number {k}")
        outs, intos = _pair(out, np.zeros(3))
        return self._call(probe.branch_many, outs, intos, np.int64(k))

    def _call(self, kernel: Any, outs: Floats, intos: Floats, *more: Any) -> Scattered:
        found = Scattered(intos, np.zeros_like(outs), np.zeros(len(outs), np.float32))
        kernel(self._materials.words, self._textures.words, *self._place, outs, *more, *found, self._scratch)
        return found


def _reflecting(material: Material) -> Material:
    if not isinstance(material, Emitter):
        return material
    if material.body is None:
        raise SceneError("an Emitter without a body reflects no light; give it one, such as body=iso.Matte(0.8)")
    return material.body


def _pair(a: npt.ArrayLike, b: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Two lists of directions of one length, as new arrays."""
    first, second = np.broadcast_arrays(
        np.atleast_2d(np.asarray(a, np.float32)), np.atleast_2d(np.asarray(b, np.float32))
    )
    if first.ndim != 2 or first.shape[1] != 3:
        raise ValueError(f"directions must be (n, 3) or (3,), not {np.shape(a)} and {np.shape(b)}")
    return np.array(first, order="C"), np.array(second, order="C")
