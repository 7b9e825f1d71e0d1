"""A moving scene into tables of several moments, which share all that stands still.

A scene is lowered as it stands when its shutter opens, with what moves as instances of its own. All moments get the
same trees, tapes, vertices and textures with new matrices and a new tree over the boxes of what stands in the scene.
Lights are gathered anew where something that shines moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.texture.contract import TEXTURES
from isophote.kernels.trace.tables import SCENE
from isophote.lower.displaced import displaced
from isophote.lower.field_table import endless
from isophote.lower.latest import LatestScene
from isophote.lower.materials import emission_of
from isophote.lower.own_space import own_spaces
from isophote.lower.packing import repacked
from isophote.lower.placement import moved_instances
from isophote.lower.primitive_table import PrimitivePart, primitive_of
from isophote.lower.scene import Parts, camera_rows, lights_of, lower_scene, parts_of, tables_of
from isophote.scene.motion import Motion
from isophote.scene.scene import Bounds, Scene, camera_at, placed_boxes
from isophote.scene.ways import Ways
from isophote.shapes.primitive.primitive import Primitive

__all__ = ["lower_moments"]

Matrix: TypeAlias = npt.NDArray[np.float64]
Longs: TypeAlias = npt.NDArray[np.int64]

# Times at which boxes of what moves are taken.
_PROBES = 17


class _Rows(NamedTuple):
    """Items by their numbers, and their rows in a table."""

    numbers: Longs
    rows: Longs

    @classmethod
    def among(cls, public: Sequence[int], moving: frozenset[int]) -> _Rows:
        """Of the items of these numbers those that move."""
        pairs = [(number, row) for row, number in enumerate(public) if number in moving]
        numbers, rows = np.array(pairs, np.int64).reshape(-1, 2).T
        return cls(numbers, rows)


class _First(NamedTuple):
    """A scene lowered as it stands when its shutter opens: its parts and tables, the radius of what is finite in it,
    the numbers of what moves, and of the fields and primitives among it, with their rows; the primitives unplaced."""

    parts: Parts
    tables: dict[str, Packed]
    reach: float
    moving: Longs
    fields: _Rows
    primitives: _Rows
    unplaced: list[Primitive]

    @classmethod
    def of(cls, scene: Scene, moving: frozenset[int], threads: int | None, accelerator: str) -> _First:
        """Of a scene, with room for what moves."""
        opening = scene.still(scene.shutter[0])
        parts = parts_of(opening, moving=moving)
        numbers = np.array(sorted(moving), np.int64)
        tables, reach = tables_of(opening, parts, threads, accelerator, _swept(scene, numbers))
        primitives = _Rows.among([part.public for part in parts.primitives], moving)
        shapes = [primitive_of(opening.items[number].shape) for number in primitives.numbers]
        unplaced = [shape for shape in shapes if shape is not None]
        return cls(
            parts,
            tables,
            reach,
            numbers,
            _Rows.among([part.public for part in parts.fields], moving),
            primitives,
            unplaced,
        )

    def moved(self, matrices: Matrix) -> dict[str, Packed]:
        """The tables of the scene, with the same lights, as its items stand by `matrices` (items, 4, 4)."""
        geometry, surfaces = moved_instances(self.tables["geometry"], self.tables["surfaces"], matrices, self.moving)
        tables = self.tables | {"geometry": geometry, "surfaces": surfaces}
        textures = self.tables["textures"]
        if len(textures.arrays["to_own"]):
            tables["textures"] = repacked(TEXTURES, textures, to_own=own_spaces(matrices, surfaces))
        if len(self.fields.rows):
            # Loaded where it is needed, as in lower/scene.py.
            from isophote.lower.fields import moved_fields

            numbers, rows = self.fields
            tables["fields"] = moved_fields(self.tables["fields"], rows, matrices[numbers])
        if self.unplaced:
            tables["primitives"] = self._moved_primitives(matrices)
        return tables

    def _moved_primitives(self, matrices: Matrix) -> Packed:
        from isophote.lower.primitives import moved_primitives

        numbers, rows = self.primitives
        placed = matrices[numbers] @ np.array([primitive.matrix for primitive in self.unplaced])
        moved: dict[int, PrimitivePart] = {}
        for row, primitive, matrix in zip(rows.tolist(), self.unplaced, placed, strict=True):
            moved[row] = self.parts.primitives[row]._replace(primitive=primitive._replace(matrix=matrix))
        return moved_primitives(self.tables["primitives"], moved)

    def moved_with_lights(self, still: Scene, threads: int | None, accelerator: str) -> dict[str, Packed]:
        """As `moved`, with what shines where it stands."""
        parts = parts_of(still, moving=frozenset(self.moving.tolist()))
        if _same_lights(parts, self.parts):
            matrices = np.array([item.transform.matrix for item in still.items])
            return self.moved(matrices) | {"lights": lights_of(still, parts, self.reach)}
        # A lamp that is stretched out of round has another place among the lights, of which all surfaces know.
        tables, _ = tables_of(still, parts, threads, accelerator)
        return tables


# The scene lowered last with its shutter open, for another view of it or other times.
_latest: LatestScene[_First] = LatestScene()


def lower_moments(
    scene: Scene, size: tuple[int, int], times: Sequence[float], threads: int | None = None, accelerator: str = "bvh"
) -> list[Packed]:
    """The tables of `scene` at each of `times`, in seconds, while its shutter is open, as `lower_scene` makes them of
    one. What times they are, changes nothing but where things stand."""
    scene = displaced(scene, size)
    motions = {k: item.transform for k, item in enumerate(scene.items) if isinstance(item.transform, Motion)}
    moving = frozenset(number for number, motion in motions.items() if motion.moves(*scene.shutter))
    if not moving:
        # The camera alone moves; the scene as it stands is lowered once for all of its places.
        tables = lower_scene(scene.still(scene.shutter[0]), size, threads, accelerator).arrays
        kept = {name: tables[name] for name in SCENE.fields}
        return [SCENE.pack(**kept | {"camera": camera_rows(camera_at(scene, time), size)}) for time in times]
    way = accelerator, scene.medium, scene.shutter
    first = _latest.find(scene, way)
    if first is None:
        first = _First.of(scene, moving, threads, accelerator)
        _latest.keep(scene, way, first, one_view=endless(first.parts.fields))
    shines = any(max(emission_of(scene.items[number].material)[0]) > 0 for number in moving)
    ways = Ways([item.transform for item in scene.items])
    moments = []
    for time in times:
        found = (
            first.moved_with_lights(scene.still(time), threads, accelerator) if shines else first.moved(ways.at(time))
        )
        moments.append(SCENE.pack(**found, camera=camera_rows(camera_at(scene, time), size)))
    return moments


def _swept(scene: Scene, moving: Longs) -> list[Bounds]:
    """Boxes of what moves, at times all over those of the shutter."""
    ways = Ways([scene.items[number].transform for number in moving])
    boxes = np.array([scene.items[number].shape.bounds for number in moving], np.float64)
    times = np.linspace(*scene.shutter, _PROBES).tolist()
    placed = np.stack([placed_boxes(boxes, ways.at(time)) for time in times])
    return list(np.stack([placed[:, :, 0].min(axis=0), placed[:, :, 1].max(axis=0)], axis=1))


def _same_lights(a: Parts, b: Parts) -> bool:
    """Whether surfaces are the lights of the same numbers."""
    if [part.light for part in a.primitives] != [part.light for part in b.primitives]:
        return False
    pairs = [(one.lights, other.lights) for one, other in zip(a.meshes, b.meshes, strict=True)]
    return all(
        one is other or (one is not None and other is not None and np.array_equal(one, other)) for one, other in pairs
    )
