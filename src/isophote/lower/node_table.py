"""Materials that are called by address into tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.kernels.brdf.contract import MOST_SLOTS, NODE_WORDS
from isophote.kernels.trace.turned_normal import BUMP
from isophote.lower.node import SPAN, Cut, Node, Slot
from isophote.scene.texture import Texture

__all__ = ["NodeTable"]

Floats: TypeAlias = npt.NDArray[np.float32]


class NodeTable:
    """The nodes of all materials, their slots and their data, one after another."""

    def __init__(self, texture: Callable[[Texture], int]) -> None:
        self._texture = texture
        self._nodes: list[list[int]] = []
        self._slots: list[Slot] = []
        self._data: list[Floats] = [np.zeros(0, np.float32)]
        self._places: dict[int, int] = {}
        self._size = 0

    def add_all(self, roots: Sequence[Node | None], cuts: Sequence[Cut | None]) -> dict[str, Any]:
        """Fields of the table, for materials in their order; None where one is compiled into the tiles, and where one
        is whole."""
        spans = [(0,) * SPAN if root is None else self._material(root) for root in roots]
        opacities = [-1 if cut is None else self._add_slots(cut.slots) for cut in cuts]
        codes = [(-1 if s.texture is None else self._texture(s.texture), s.channel) for s in self._slots]
        return {
            "prepare": _prepare() if any(roots) else 0,
            "spans": np.array(spans, np.int32).reshape(-1, SPAN),
            "nodes": np.array(self._nodes, np.int64).reshape(-1, NODE_WORDS),
            "slot_values": np.array([s.value for s in self._slots], np.float32).reshape(-1, 3),
            "slot_codes": np.array(codes, np.int32).reshape(-1, 2),
            "data": np.concatenate(self._data),
            "cuts": np.array(opacities, np.int32),
            **_hole_entries(any(cuts)),
            "bump": _bump() if any(slot.channel == BUMP for slot in self._slots) else 0,
        }

    def _add_slots(self, slots: Sequence[Slot]) -> int:
        """Number of the first."""
        self._slots += slots
        return len(self._slots) - len(slots)

    def _material(self, root: Node) -> tuple[int, ...]:
        first = len(self._slots)
        number = self._add(root, first)
        count = len(self._slots) - first
        if count > MOST_SLOTS:
            raise SceneError(f"a material mixes or coats too much: {count} parameters, of {MOST_SLOTS} at most")
        # The root's own slots come last.
        turned = count - len(root.slots) + 1 if root.turned else 0
        return number, first, count, int(root.anisotropic), root.openness, turned

    def _add(self, node: Node, first: int) -> int:
        # What is inside comes first, so that its slots are where they are without what is around it.
        children = [*(self._add(child, first) for child in node.children), 0, 0][:2]
        own = len(self._slots) - first
        self._slots += node.slots
        addresses = [0 if entry is None else entry.address for entry in node.entries]
        self._nodes.append([*addresses, own, self._place(node.data), *children, node.branches])
        return len(self._nodes) - 1

    def _place(self, data: Floats | None) -> int:
        """Where data begin; those of several nodes are there once."""
        if data is None:
            return 0
        if id(data) not in self._places:
            self._places[id(data)] = self._size
            # Kept here, so that no other array gets its identity.
            self._data.append(data)
            self._size += len(data)
        return self._places[id(data)]


def _prepare() -> int:
    # Loaded where there is something to prepare.
    from isophote.kernels.trace.prepare import prepare

    return prepare.address


def _bump() -> int:
    # As in _prepare.
    from isophote.kernels.trace.bump import bump_at

    return bump_at.address


def _hole_entries(wanted: bool) -> dict[str, int]:
    if not wanted:
        return {"opacity": 0, "pass_holes": 0, "shade_holes": 0}
    # As in _prepare.
    from isophote.kernels.trace.hole_rays import opacity_at, pass_holes, shade_holes

    return {"opacity": opacity_at.address, "pass_holes": pass_holes.address, "shade_holes": shade_holes.address}
