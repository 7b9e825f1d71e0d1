"""Where instances of objects stand: their matrices, the tree over their boxes, and the same moved elsewhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.tree import build_boxes
from isophote.kernels.accel.geometry import GEOMETRY
from isophote.kernels.accel.surface import SURFACES
from isophote.kernels.base.table import Packed, Table

__all__ = ["IDENTITY", "PLACES", "Place", "moved_instances", "place_instances", "repacked", "tree_over"]

Matrix: TypeAlias = npt.NDArray[np.float64]
FloatArray: TypeAlias = npt.NDArray[np.float32]

IDENTITY = np.eye(4)

PLACES = "places"
"""What a Packed geometry holds beside its fields: the `Place` of each instance."""

_BOXES = "boxes of instances"
_ROUNDING = 32 * 2.0**-24


class Place(NamedTuple):
    """An instance: the box of its object in its own space, what takes that to the world, and the item's number for the
    user, or −1 for what is no single item."""

    box: Matrix
    matrix: Matrix
    public: int


def repacked(table: Table, packed: Packed, **changes: Any) -> Packed:
    """A packed table with other values in some of its fields; what it holds beside its fields is held on."""
    fields = {name: packed.arrays[name] for name in table.fields} | changes
    return table.pack(**fields).holding(packed.arrays | changes)


def tree_over(boxes: FloatArray, threads: int | None = None) -> dict[str, npt.NDArray[Any]]:
    """`top_nodes` and `top_items`: the tree over boxes (n, 2, 3); empty where there are none."""
    if len(boxes) == 0:
        return {"top_nodes": np.zeros(0, np.float32), "top_items": np.zeros(0, np.int32)}
    top = build_boxes(boxes[:, 0], boxes[:, 1], threads)
    return {"top_nodes": top.nodes, "top_items": top.blocks.astype(np.int32, copy=False)}


class _Arrays(NamedTuple):
    to_object: FloatArray
    to_world: FloatArray
    identity: npt.NDArray[np.uint8]
    boxes: FloatArray
    slack: FloatArray

    def put(self, k: int, place: Place) -> None:
        self.to_world[k] = place.matrix[:3].reshape(-1)
        self.to_object[k] = np.linalg.inv(place.matrix)[:3].reshape(-1)
        self.identity[k] = (place.matrix == IDENTITY).all()
        self.boxes[k], self.slack[k] = _placed_box(place.box, place.matrix, bool(self.identity[k]))

    def fields(self) -> dict[str, npt.NDArray[Any]]:
        """What the geometry has of them; a single instance that stands where its object does needs no tree."""
        alone = len(self.boxes) == 1 and self.identity[0] != 0
        return {
            "to_object": self.to_object,
            "to_world": self.to_world,
            "identity": self.identity,
            **tree_over(self.boxes[:0] if alone else self.boxes),
        }


def place_instances(
    objects: Mapping[str, Any], places: Sequence[Place]
) -> tuple[Packed, FloatArray, npt.NDArray[np.float32]]:
    """The geometry of instances of `objects`, which are the fields of GEOMETRY that say nothing of places; the rounding
    that each one's transform brings; and the world's bounds."""
    count = len(places)
    arrays = _Arrays(
        np.zeros((count, 12), np.float32),
        np.zeros((count, 12), np.float32),
        np.zeros(count, np.uint8),
        np.zeros((count, 2, 3), np.float32),
        np.zeros(count, np.float32),
    )
    for k, place in enumerate(places):
        arrays.put(k, place)
    packed = GEOMETRY.pack(**objects, **arrays.fields())
    held = {PLACES: tuple(places), _BOXES: arrays.boxes}
    bounds = np.stack([arrays.boxes[:, 0].min(axis=0), arrays.boxes[:, 1].max(axis=0)])
    return packed.holding(held), arrays.slack, bounds


def moved_instances(geometry: Packed, surfaces: Packed, matrices: Mapping[int, Matrix]) -> tuple[Packed, Packed]:
    """A geometry and its surfaces with other `matrices` for the items of these numbers for the user; all else is
    shared."""
    places = geometry.arrays[PLACES]
    old = geometry.arrays
    arrays = _Arrays(
        old["to_object"].copy(),
        old["to_world"].copy(),
        old["identity"].copy(),
        old[_BOXES].copy(),
        surfaces.arrays["slack"].copy(),
    )
    for k, place in enumerate(places):
        if place.public in matrices:
            arrays.put(k, place._replace(matrix=matrices[place.public]))
    return repacked(GEOMETRY, geometry, **arrays.fields()), repacked(SURFACES, surfaces, slack=arrays.slack)


def _placed_box(box: Matrix, matrix: Matrix, identity: bool) -> tuple[Matrix, float]:
    """An instance's box in the world, widened by its rounding, and that rounding."""
    if identity:
        return box, 0.0
    corners = np.array([[box[i, 0], box[j, 1], box[k, 2], 1.0] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    placed = corners @ matrix[:3].T
    local = float(np.abs(box).max())
    there, back = np.abs(matrix[:3]), np.abs(np.linalg.inv(matrix)[:3])
    stretch = float(there[:, :3].sum(axis=1).max())
    far = np.abs(placed).max(axis=0)
    # Rays come back to the object with rounding of their own, which the transform then stretches.
    returned = float((there[:, :3] @ (back[:, :3] @ far + back[:, 3])).max())
    slack = _ROUNDING * (stretch * local + float(there[:, 3].max()) + float(far.max()) + returned)
    return np.stack([placed.min(axis=0) - slack, placed.max(axis=0) + slack]), slack
