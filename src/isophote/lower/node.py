"""What a material that is called by address is made of; light to load, unlike what makes it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.scene.colour import Colour
from isophote.scene.texture import Texture

if TYPE_CHECKING:
    from isophote.kernels.base.entry import Entry

__all__ = ["SPAN", "Cut", "Node", "Slot", "no_nodes"]

Floats: TypeAlias = npt.NDArray[np.float32]

# Columns of `Materials.spans`.
SPAN = 6


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
    how many single directions it sends light to, whether it scatters to all others, whether the tangent matters,
    the first of the two slots whose sum is what ambient light is multiplied by, or 0 where all of it arrives, and
    whether it scatters through the surface, too. The first slot of one that is `turned` is the normal that is seen."""

    entries: tuple[Entry, Entry, Entry | None]
    slots: tuple[Slot, ...]
    data: Floats | None = None
    children: tuple[Node, ...] = ()
    branches: int = 0
    scatters: bool = True
    anisotropic: bool = False
    openness: int = 0
    through: bool = False
    turned: bool = False


@attrs.frozen
class Cut:
    """How opaque a surface is, and from which opacity on it is there, all of it, or −1 where light is shared."""

    opacity: Slot
    cutoff: float = -1.0

    @property
    def slots(self) -> tuple[Slot, Slot]:
        """As kernels/trace/hole_rays.py has them."""
        return self.opacity, Slot.of(self.cutoff)


def no_nodes(materials: int) -> dict[str, Any]:
    """Fields of the table of so many materials that are all compiled into the tiles, and whole."""
    return {
        "prepare": 0,
        "spans": np.zeros((materials, SPAN), np.int32),
        "nodes": np.zeros((0, 1), np.int64),
        "slot_values": np.zeros((0, 3), np.float32),
        "slot_codes": np.zeros((0, 2), np.int32),
        "data": np.zeros(0, np.float32),
        "cuts": np.full(materials, -1, np.int32),
        "opacity": 0,
        "pass_holes": 0,
        "shade_holes": 0,
        "bump": 0,
    }
