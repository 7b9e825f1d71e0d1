"""Materials as trees of nodes: the entries that are called for them, and their parameters."""

from __future__ import annotations

from functools import singledispatch
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.kernels.base.entry import Entry
from isophote.kernels.brdf import conductor
from isophote.scene.colour import Colour
from isophote.scene.material_base import Material
from isophote.scene.metal import Metal
from isophote.scene.texture import Texture

__all__ = ["Node", "Slot", "node_of"]

Floats: TypeAlias = npt.NDArray[np.float32]


@attrs.frozen
class Slot:
    """A parameter: its value, the texture that multiplies it, and the channel of that which counts, or −1 for all."""

    value: Colour
    texture: Texture | None = None
    channel: int = -1

    @classmethod
    def of(cls, parameter: Any) -> Slot:
        """The slot of a colour, a number or a texture."""
        if isinstance(parameter, Texture):
            return cls((1.0, 1.0, 1.0), parameter)
        if isinstance(parameter, tuple):
            return cls(parameter)
        return cls((float(parameter),) * 3)


@attrs.frozen(eq=False)
class Node:
    """A node of a material: its entries (evaluate, sample, branch), slots, numbers in `data`, what it mixes or coats,
    how many single directions it sends light to, whether it scatters to all others, and whether the tangent matters."""

    entries: tuple[Entry, Entry, Entry | None]
    slots: tuple[Slot, ...]
    data: Floats | None = None
    children: tuple[Node, ...] = ()
    branches: int = 0
    scatters: bool = True
    anisotropic: bool = False


@singledispatch
def node_of(material: Material) -> Node:
    """The node of a material."""
    raise TypeError(f"no node for a {type(material).__name__}")


def _is_smooth(roughness: Any) -> bool:
    return all(part == 0 for part in roughness if not isinstance(part, Texture)) and not any(
        isinstance(part, Texture) for part in roughness
    )


@node_of.register
def _(material: Metal) -> Node:
    slots = tuple(Slot.of(value) for value in (*material.index, material.colour, *material.roughness))
    if _is_smooth(material.roughness):
        smooth = (conductor.evaluate_nothing, conductor.sample_smooth, conductor.branch_smooth)
        return Node(smooth, slots, branches=1, scatters=False)
    along, across = material.roughness
    rough = (conductor.evaluate_conductor, conductor.sample_conductor, None)
    return Node(rough, slots, anisotropic=along != across)
