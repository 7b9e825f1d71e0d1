"""A moving scene into tables of several moments, which share all that stands still.

A scene is lowered as it stands when its shutter opens, with what moves as instances of its own. All moments get the
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
from isophote.lower.displaced import displaced
from isophote.lower.field_table import endless
from isophote.lower.latest import Latest
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

# Times at which boxes of what moves are taken.
_PROBES = 17


class _First(NamedTuple):
    """A scene lowered as it stands when its shutter opens: its parts and tables, the radius of what is finite in it,
    the numbers of what moves; rows of the fields among that by their items' numbers, and of the primitives, with these
    unplaced."""

    parts: Parts
    tables: dict[str, Packed]
    reach: float
    moving: frozenset[int]
    fields: dict[int, int]
    primitives: dict[int, tuple[int, Primitive]]

    @classmethod
    def of(cls, scene: Scene, moving: frozenset[int], threads: int | None, accelerator: str) -> _First:
        """Of a scene, with room for what moves."""
        opening = scene.still(scene.shutter[0])
        parts = parts_of(opening, moving=moving)
        tables, reach = tables_of(opening, parts, threads, accelerator, _swept(scene, moving))
        fields = {part.public: row for row, part in enumerate(parts.fields) if part.public in moving}
        rows = {part.public: row for row, part in enumerate(parts.primitives) if part.public in moving}
        shapes = {number: primitive_of(opening.items[number].shape) for number in rows}
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


# The scene lowered last with its shutter open, for another view of it or other times.
_latest: Latest[_First] = Latest()


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
        return [SCENE.pack(**kept | {"camera": camera_rows(scene.still(time), size)}) for time in times]
    way = accelerator, scene.medium, scene.shutter
    first = _latest.find(scene, way)
    if first is None:
        first = _First.of(scene, moving, threads, accelerator)
        _latest.keep(scene, way, first, one_view=endless(first.parts.fields))
    shines = any(max(emission_of(scene.items[number].material)[0]) > 0 for number in moving)
    moments = []
    for time in times:
        still = scene.still(time)
        found = first.moved_with_lights(still, threads, accelerator) if shines else first.moved(still)
        moments.append(SCENE.pack(**found, camera=camera_rows(still, size)))
    return moments


def _swept(scene: Scene, moving: frozenset[int]) -> list[Bounds]:
    """Boxes of what moves, at times all over those of the shutter."""
    boxes = []
    for number in moving:
        item = scene.items[number]
        box = np.asarray(item.shape.bounds, np.float64)
        stands = (item.still(time) for time in np.linspace(*scene.shutter, _PROBES).tolist())
        boxes += [placed_box(box, one.transform.matrix) for one in stands]
    return boxes


def _same_lights(a: Parts, b: Parts) -> bool:
    """Whether surfaces are the lights of the same numbers."""
    if [part.light for part in a.primitives] != [part.light for part in b.primitives]:
        return False
    pairs = [(one.lights, other.lights) for one, other in zip(a.meshes, b.meshes, strict=True)]
    return all(
        one is other or (one is not None and other is not None and np.array_equal(one, other)) for one, other in pairs
    )
