"""Where instances of objects stand: their matrices, the accelerator over their boxes, and the same moved elsewhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.accel.geometry import GEOMETRY
from isophote.kernels.accel.surface import SURFACES
from isophote.kernels.base.table import Packed
from isophote.lower.boxes import ACCELERATOR, over_instances
from isophote.lower.packing import repacked

__all__ = ["IDENTITY", "Place", "moved_instances", "place_instances"]

Matrix: TypeAlias = npt.NDArray[np.float64]
FloatArray: TypeAlias = npt.NDArray[np.float32]
Longs: TypeAlias = npt.NDArray[np.int64]

IDENTITY = np.eye(4)

# What a packed geometry holds beside its fields: boxes of instances in their own space and in the world, and the
# numbers of their items.
_OWN, _BOXES, _PUBLIC = "own boxes of instances", "boxes of instances", "items of instances"
_ROUNDING = 32 * 2.0**-24


class Place(NamedTuple):
    """An instance: the box of its object in its own space, what takes that to the world, and the item's number for the
    user, or −1 for what is no single item."""

    box: Matrix
    matrix: Matrix
    public: int


class _Arrays(NamedTuple):
    to_object: FloatArray
    to_world: FloatArray
    identity: npt.NDArray[np.uint8]
    boxes: FloatArray
    slack: FloatArray

    def put(self, rows: npt.NDArray[np.int64], own: Matrix, matrices: Matrix) -> None:
        """Instances of these rows with boxes (n, 2, 3) of their own stand by `matrices` (n, 4, 4)."""
        inverses = np.linalg.inv(matrices)
        self.to_world[rows] = matrices[:, :3].reshape(-1, 12)
        self.to_object[rows] = inverses[:, :3].reshape(-1, 12)
        identity = (matrices == IDENTITY).all(axis=(1, 2))
        self.identity[rows], self.boxes[rows], self.slack[rows] = identity, own, 0.0
        moved = ~identity
        self.boxes[rows[moved]], self.slack[rows[moved]] = _placed(own[moved], matrices[moved], inverses[moved])

    def fields(self, accelerator: str) -> dict[str, Any]:
        """What the geometry has of them, with the accelerator of a name over them; a single instance that stands where
        its object does needs none."""
        alone = len(self.boxes) == 1 and self.identity[0] != 0
        return {
            "to_object": self.to_object,
            "to_world": self.to_world,
            "identity": self.identity,
            **over_instances(accelerator, self.boxes[:0] if alone else self.boxes),
        }


def place_instances(
    objects: Mapping[str, Any], places: Sequence[Place], accelerator: str
) -> tuple[Packed, FloatArray, npt.NDArray[np.float32]]:
    """The geometry of instances of `objects`, which are the fields of GEOMETRY that say nothing of places, and the
    accelerator of a name over them; the rounding that each one's transform brings; and the world's bounds."""
    count = len(places)
    arrays = _Arrays(
        np.zeros((count, 12), np.float32),
        np.zeros((count, 12), np.float32),
        np.zeros(count, np.uint8),
        np.zeros((count, 2, 3), np.float32),
        np.zeros(count, np.float32),
    )
    own = np.array([place.box for place in places])
    arrays.put(np.arange(count), own, np.array([place.matrix for place in places]))
    packed = GEOMETRY.pack(**objects, **arrays.fields(accelerator))
    public = np.array([place.public for place in places])
    held = {_OWN: own, _BOXES: arrays.boxes, _PUBLIC: public, ACCELERATOR: accelerator}
    bounds = np.stack([arrays.boxes[:, 0].min(axis=0), arrays.boxes[:, 1].max(axis=0)])
    return packed.holding(held), arrays.slack, bounds


def moved_instances(geometry: Packed, surfaces: Packed, matrices: Matrix, moving: Longs) -> tuple[Packed, Packed]:
    """A geometry and its surfaces with those of `matrices` (items, 4, 4) for the items of these numbers for the user;
    all else is shared."""
    old = geometry.arrays
    rows = np.flatnonzero(np.isin(old[_PUBLIC], moving))
    if len(rows) == 0:
        return geometry, surfaces
    arrays = _Arrays(
        old["to_object"].copy(),
        old["to_world"].copy(),
        old["identity"].copy(),
        old[_BOXES].copy(),
        surfaces.arrays["slack"].copy(),
    )
    arrays.put(rows, old[_OWN][rows], matrices[old[_PUBLIC][rows]])
    fields = arrays.fields(old[ACCELERATOR])
    return repacked(GEOMETRY, geometry, **fields), repacked(SURFACES, surfaces, slack=arrays.slack)


def _placed(own: Matrix, matrices: Matrix, inverses: npt.NDArray[Any]) -> tuple[Matrix, Matrix]:
    """Instances' boxes in the world (n, 2, 3), widened by their rounding, and that rounding (n,)."""
    corners = np.stack([own[:, (k >> 2, k >> 1 & 1, k & 1), (0, 1, 2)] for k in range(8)], axis=1)
    placed = corners @ matrices[:, :3, :3].swapaxes(1, 2) + matrices[:, None, :3, 3]
    local = np.abs(own).max(axis=(1, 2))
    there, back = np.abs(matrices[:, :3]), np.abs(inverses[:, :3])
    stretch = there[:, :, :3].sum(axis=2).max(axis=1)
    far = np.abs(placed).max(axis=1)
    # Rays come back to the object with rounding of their own, which the transform then stretches.
    own_far = (back[:, :, :3] @ far[:, :, None])[:, :, 0] + back[:, :, 3]
    returned = (there[:, :, :3] @ own_far[:, :, None])[:, :, 0].max(axis=1)
    slack = _ROUNDING * (stretch * local + there[:, :, 3].max(axis=1) + far.max(axis=1) + returned)
    room = slack[:, None]
    return np.stack([placed.min(axis=1) - room, placed.max(axis=1) + room], axis=1), slack
