"""Exact primitives of a scene into their table, with a tree over the boxes of those that have an end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.kernels.base.entry import Entry
from isophote.kernels.base.table import Packed
from isophote.kernels.primitive import ball, block, flat, outlined, quadratic, ring, ring_lanes, tapered, tube
from isophote.kernels.primitive.layout import PRIMITIVES
from isophote.kernels.primitive.surface import primitive_surface
from isophote.kernels.primitive.trace import test_primitive, trace_primitive
from isophote.kernels.primitive.trace_lanes import trace_primitive_lanes
from isophote.lower.boxes import ACCELERATOR, counting_boxes, over_boxes
from isophote.lower.packing import repacked
from isophote.lower.primitive_table import PrimitivePart
from isophote.shapes.primitive.extent import balls_around, boxes_around
from isophote.shapes.primitive.primitive import Primitive

__all__ = ["KINDS", "Kind", "counting_primitives", "lower_primitives", "moved_primitives", "own_numbers"]

Floats: TypeAlias = npt.NDArray[np.float64]

# So many primitives are asked one by one: a tree would take longer.
_FEW = 3
# Extents beyond this leave no room for arithmetic in single precision.
_LARGEST = 1e15
# Rounding on the way to a primitive's own space and back, in parts of what is added up on it.
_ROUNDING = 64 * 2.0**-53
# Boxes and balls grow by this part of their size and place, more than their rounding to single precision.
_SLACK = 2.0**-22
# What packed primitives hold beside their table.
_BOXES = "boxes of primitives"


def _as_they_are(values: Floats) -> Floats:
    return values if len(values) else np.zeros(1)


class Kind(NamedTuple):
    """A kind of primitive: its entries (kernels/primitive/layout.py), and its values as the entries want them."""

    meet: Entry
    describe: Entry
    meet_lanes: Entry | None = None
    numbers: Callable[[Floats], Floats] = _as_they_are


def _half_planes(values: Floats) -> Floats:
    """Of a convex polygon's corners, counterclockwise: (a, b, c) of a x + b y ≤ c for every edge that has a length."""
    corners = values.reshape(-1, 2)
    edges = np.roll(corners, -1, axis=0) - corners
    real = (edges != 0).any(axis=1)
    corners, edges = corners[real], edges[real]
    out = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]
    rows = np.column_stack([out, (out * corners).sum(axis=1)])
    return np.concatenate([[float(len(rows))], rows.reshape(-1)])


def _edges(values: Floats) -> Floats:
    """Of a polygon's edges: those that are not level, which no level ray crosses."""
    rows = values.reshape(-1, 4)
    rows = rows[rows[:, 1] != rows[:, 3]]
    return np.concatenate([[float(len(rows))], rows.reshape(-1)])


KINDS: dict[str, Kind] = {
    "ball": Kind(ball.meet_ball, ball.describe_ball, ball.meet_balls),
    "plane": Kind(flat.meet_plane, flat.describe_plane, flat.meet_planes),
    "disk": Kind(flat.meet_disk, flat.describe_disk, flat.meet_disks),
    "block": Kind(block.meet_block, block.describe_block, block.meet_blocks),
    "pipe": Kind(tube.meet_pipe, tube.describe_pipe, tube.meet_pipes),
    "tube": Kind(tube.meet_tube, tube.describe_tube, tube.meet_tubes),
    "cone": Kind(tapered.meet_cone, tapered.describe_cone, tapered.meet_cones),
    "ring": Kind(ring.meet_ring, ring.describe_ring, ring_lanes.meet_rings),
    "quadric": Kind(quadratic.meet_quadric, quadratic.describe_quadric),
    "convex": Kind(outlined.meet_convex, outlined.describe_polygon, numbers=_half_planes),
    "polygon": Kind(outlined.meet_polygon, outlined.describe_polygon, numbers=_edges),
}


def own_numbers(primitive: Primitive) -> Floats:
    """The numbers that a primitive's entries are given."""
    return KINDS[primitive.kind].numbers(primitive.values)


def lower_primitives(
    parts: Sequence[PrimitivePart], surface: int, accelerator: str = "bvh", threads: int | None = None
) -> Packed:
    """The table of all primitives, with the accelerator of a name; `surface` is the row of the first one's item among
    the surfaces.

    Raises `SceneError` where one leaves the range of single precision.
    """
    placed = [part.primitive for part in parts]
    boxes = boxes_around(placed)
    _check(parts, boxes)
    inverses = np.linalg.inv(np.array([primitive.matrix for primitive in placed]))
    numbers = [own_numbers(primitive) for primitive in placed]
    first = np.cumsum([0, *map(len, numbers)])[:-1]
    kinds = [KINDS[primitive.kind] for primitive in placed]
    packed = PRIMITIVES.pack(
        numbers=np.column_stack([surface + np.arange(len(parts)), first]).astype(np.int32),
        entries=np.array([_addresses(kind) for kind in kinds], np.int64),
        reach=_reaches(placed, boxes, inverses),
        values=np.concatenate(numbers),
        to_object=np.ascontiguousarray(inverses[:, :3].reshape(-1, 12)),
        to_world=np.array([primitive.matrix[:3].reshape(-1) for primitive in placed]),
        **_over(boxes, accelerator, threads),
        trace=trace_primitive.address,
        trace_lanes=trace_primitive_lanes.address,
        surface=primitive_surface.address,
    )
    return packed.holding({_BOXES: boxes, ACCELERATOR: accelerator})


def moved_primitives(packed: Packed, moved: Mapping[int, PrimitivePart]) -> Packed:
    """Lowered primitives with the same ones placed elsewhere in these rows; all else is shared."""
    names = _BOXES, "reach", "to_object", "to_world"
    boxes, reach, to_object, to_world = (packed.arrays[name].copy() for name in names)
    rows, parts = list(moved), list(moved.values())
    placed = [part.primitive for part in parts]
    boxes[rows] = boxes_around(placed)
    _check(parts, boxes[rows])
    matrices = np.array([primitive.matrix for primitive in placed])
    inverses = np.linalg.inv(matrices)
    reach[rows] = _reaches(placed, boxes[rows], inverses)
    to_object[rows], to_world[rows] = inverses[:, :3].reshape(-1, 12), matrices[:, :3].reshape(-1, 12)
    over = _over(boxes, packed.arrays[ACCELERATOR])
    return repacked(PRIMITIVES, packed, reach=reach, to_object=to_object, to_world=to_world, **over)


def _addresses(kind: Kind) -> tuple[int, int, int]:
    return kind.meet.address, kind.describe.address, 0 if kind.meet_lanes is None else kind.meet_lanes.address


def _check(parts: Sequence[PrimitivePart], boxes: Floats) -> None:
    finite = np.isfinite(boxes).all(axis=(1, 2))
    with np.errstate(invalid="ignore"):
        sizes = (boxes[:, 1] - boxes[:, 0]).max(axis=1)
    reach = np.abs(np.where(np.isfinite(boxes), boxes, 0.0)).max(axis=(1, 2))
    wrong = np.isnan(boxes).any(axis=(1, 2)) | (reach > _LARGEST) | (finite & ~(sizes > 1 / _LARGEST))
    if wrong.any():
        bad = int(np.argmax(wrong))
        raise SceneError(
            f"items[{parts[bad].public}]: its region {boxes[bad].tolist()} leaves no room for single precision; "
            "scale the scene"
        )


def _over(boxes: Floats, accelerator: str, threads: int | None = None) -> dict[str, Any]:
    """The fields of PRIMITIVES that say which ones stand alone, and those of the accelerator over the others' boxes."""
    finite = np.isfinite(boxes).all(axis=(1, 2))
    numbers = np.flatnonzero(finite).astype(np.int32)
    if len(numbers) <= _FEW:
        finite, numbers = np.zeros_like(finite), numbers[:0]
    own = boxes[finite]
    slack = _SLACK * np.abs(own).max(axis=(1, 2))[:, None]
    over = over_boxes(accelerator, np.stack([own[:, 0] - slack, own[:, 1] + slack], axis=1), test_primitive, threads)
    if len(over["top_items"]):
        # The tree's leaves name primitives themselves.
        over["top_items"], numbers = numbers[over["top_items"]], np.arange(len(boxes), dtype=np.int32)
    return {"alone": np.flatnonzero(~finite).astype(np.int32), "boxed": numbers, **over}


def counting_primitives(primitives: Packed) -> Packed:
    """Primitives whose rays count what they visit."""
    return counting_boxes(PRIMITIVES, primitives, test_primitive)


def _reaches(placed: Sequence[Primitive], boxes: Floats, inverses: Floats) -> npt.NDArray[np.float32]:
    """Rows of `Primitives.reach`, of primitives in boxes whose matrices have these inverses."""
    middles, radii = balls_around(placed, boxes)
    matrices = np.array([primitive.matrix[:3] for primitive in placed])
    there, back = np.abs(matrices), np.abs(inverses[:, :3])
    # Of endless ones, what is near their own middle; a hit's own place is counted where it is known.
    far = np.abs(np.where(np.isfinite(boxes), boxes, matrices[:, None, :, 3])).max(axis=1)
    own = np.einsum("nij,nj->ni", back[:, :, :3], far) + back[:, :, 3]
    returned = np.einsum("nij,nj->ni", there[:, :, :3], own) + there[:, :, 3]
    stretches = np.linalg.norm(back[:, :, :3], 2, axis=(1, 2))
    grown = radii * (1 + _SLACK) + _SLACK * np.abs(middles).max(axis=1)
    return np.column_stack([middles, grown, _ROUNDING * returned.max(axis=1), stretches]).astype(np.float32)
