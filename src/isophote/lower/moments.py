"""A moving scene into tables of several moments, which share all that stands still.

A scene is lowered as it stands at the first moment, with what moves as instances of its own. The other moments get the
same trees, tapes, vertices and textures with new matrices and a new tree over the boxes of what stands in the scene.
Lights are gathered anew where something that shines moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.texture.contract import TEXTURES
from isophote.kernels.trace.tables import SCENE
from isophote.lower.materials import emission_of
from isophote.lower.own_space import own_spaces
from isophote.lower.placement import moved_instances, repacked
from isophote.lower.primitive_table import PrimitivePart, primitive_of
from isophote.lower.scene import Parts, camera_rows, lights_of, lower_scene, parts_of, tables_of
from isophote.scene.motion import Motion
from isophote.scene.scene import Bounds, Scene, placed_box
from isophote.shapes.primitive.primitive import Primitive

__all__ = ["lower_moments"]

Matrix: TypeAlias = npt.NDArray[np.float64]


def lower_moments(
    scene: Scene, size: tuple[int, int], times: Sequence[float], threads: int | None = None, accelerator: str = "bvh"
) -> list[Packed]:
    """The tables of `scene` at each of `times`, in seconds, as `lower_scene` makes them of one."""
    moving = _moving_items(scene, times)
    if not moving:
        # The camera alone moves; the scene as it stands is lowered once for all of its places.
        tables = lower_scene(scene.still(times[0]), size, threads, accelerator).arrays
        kept = {name: tables[name] for name in SCENE.fields}
        return [SCENE.pack(**kept | {"camera": camera_rows(scene.still(time), size)}) for time in times]
    stands = [scene.still(time) for time in times]
    first = _First.of(stands, moving, threads, accelerator)
    shines = any(max(emission_of(scene.items[number].material)[0]) > 0 for number in moving)
    moments = []
    for still in stands:
        tables = first.moved_with_lights(still, threads, accelerator) if shines else first.moved(still)
        moments.append(SCENE.pack(**tables, camera=camera_rows(still, size)))
    return moments


def _moving_items(scene: Scene, times: Sequence[float]) -> frozenset[int]:
    """Numbers of the items that move within the times."""
    motions = {k: item.transform for k, item in enumerate(scene.items) if isinstance(item.transform, Motion)}
    return frozenset(number for number, motion in motions.items() if motion.moves(min(times), max(times)))


def _swept(stands: Sequence[Scene], moving: frozenset[int]) -> list[Bounds]:
    """Boxes of what moves at all moments."""
    shapes = {number: np.asarray(stands[0].items[number].shape.bounds, np.float64) for number in moving}
    return [placed_box(box, still.items[number].transform.matrix) for still in stands for number, box in shapes.items()]


class _First(NamedTuple):
    """A scene lowered as it stands at first: its parts and tables, the radius of what is finite in it, the numbers of
    what moves; rows of the fields among that by their items' numbers, and of the primitives, with these unplaced."""

    parts: Parts
    tables: dict[str, Packed]
    reach: float
    moving: frozenset[int]
    fields: dict[int, int]
    primitives: dict[int, tuple[int, Primitive]]

    @classmethod
    def of(cls, stands: Sequence[Scene], moving: frozenset[int], threads: int | None, accelerator: str) -> _First:
        """The first of the scenes, with room for where the others have what moves."""
        scene = stands[0]
        parts = parts_of(scene, moving=moving)
        tables, reach = tables_of(scene, parts, threads, accelerator, _swept(stands, moving))
        fields = {part.public: row for row, part in enumerate(parts.fields) if part.public in moving}
        rows = {part.public: row for row, part in enumerate(parts.primitives) if part.public in moving}
        shapes = {number: primitive_of(scene.items[number].shape) for number in rows}
        primitives = {number: (rows[number], shape) for number, shape in shapes.items() if shape is not None}
        return cls(parts, tables, reach, moving, fields, primitives)

    def moved(self, still: Scene) -> dict[str, Packed]:
        """The tables of the scene as it stands at another moment, with the same lights."""
        matrices = {number: still.items[number].transform.matrix for number in self.moving}
        geometry, surfaces = moved_instances(self.tables["geometry"], self.tables["surfaces"], matrices)
        tables = self.tables | {"geometry": geometry, "surfaces": surfaces}
        textures = self.tables["textures"]
        if len(textures.arrays["to_own"]):
            tables["textures"] = repacked(TEXTURES, textures, to_own=own_spaces(still.items, surfaces))
        if self.fields:
            # Loaded where it is needed, as in lower/scene.py.
            from isophote.lower.fields import moved_fields

            rows = {row: matrices[number] for number, row in self.fields.items()}
            tables["fields"] = moved_fields(self.tables["fields"], rows)
        if self.primitives:
            tables["primitives"] = self._moved_primitives(matrices)
        return tables

    def _moved_primitives(self, matrices: Mapping[int, Matrix]) -> Packed:
        from isophote.lower.primitives import moved_primitives

        placed: dict[int, PrimitivePart] = {}
        for number, (row, primitive) in self.primitives.items():
            placed[row] = self.parts.primitives[row]._replace(primitive=primitive.placed(matrices[number]))
        return moved_primitives(self.tables["primitives"], placed)

    def moved_with_lights(self, still: Scene, threads: int | None, accelerator: str) -> dict[str, Packed]:
        """As `moved`, with what shines where it stands."""
        parts = parts_of(still, moving=self.moving)
        if _same_lights(parts, self.parts):
            return self.moved(still) | {"lights": lights_of(still, parts, self.reach)}
        # A lamp that is stretched out of round has another place among the lights, of which all surfaces know.
        tables, _ = tables_of(still, parts, threads, accelerator)
        return tables


def _same_lights(a: Parts, b: Parts) -> bool:
    """Whether surfaces are the lights of the same numbers."""
    if [part.light for part in a.primitives] != [part.light for part in b.primitives]:
        return False
    pairs = [(one.lights, other.lights) for one, other in zip(a.meshes, b.meshes, strict=True)]
    return all(
        one is other or (one is not None and other is not None and np.array_equal(one, other)) for one, other in pairs
    )
