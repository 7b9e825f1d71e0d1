"""Fields in scenes into tapes, trees of regions and the tree over their boxes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.field_tree import FieldTree, build_field_tree
from isophote.errors import SceneError
from isophote.kernels.accel.field_layout import BALL, CHILDREN, FIELDS, FIRST_TAPE, NODE, STRETCH
from isophote.kernels.accel.field_surface import field_surface
from isophote.kernels.accel.field_trace import test_field, trace_field
from isophote.kernels.base.table import Packed
from isophote.kernels.forms.tape_entries import pack_interpreters
from isophote.lower.boxes import ACCELERATOR, counting_boxes, over_boxes
from isophote.lower.field_table import FieldPart, endless
from isophote.lower.packing import repacked
from isophote.scene.scene import placed_box, placed_boxes
from isophote.shapes.field.evaluate import packed_data
from isophote.shapes.field.tape import tape_of

__all__ = ["HORIZON", "counting_fields", "lower_fields", "moved_fields"]

Matrix: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int32]

HORIZON = 1024.0
"""How far endless fields reach, in sizes of what is finite in the scene together with the camera."""

# The region of a field goes so far beyond its bounds, in parts of its longest edge: rays must enter it outside.
_BEYOND = 2.0**-8
# Steps that positions can tell apart, in parts of the largest coordinate.
_LEAST_STEP = 2.0**-22
# Extents beyond this leave no room for arithmetic in single precision.
_LARGEST = 1e15
# What the packed fields hold beside their table: what rays are clipped to, in each one's own space, and their boxes.
_CLIPS, _BOXES = "clips", "boxes of fields"


class _Lowered(NamedTuple):
    """One field: its tree, its tables of data, its cube, what rays are clipped to, its box in the world, and the size
    of details."""

    tree: FieldTree
    data: Packed
    low: npt.NDArray[np.float32]
    side: float
    clip: Matrix
    box: Matrix
    detail: float


def lower_fields(
    parts: Sequence[FieldPart], surface: int, around: Matrix, threads: int | None = None, accelerator: str = "bvh"
) -> Packed:
    """The table of all fields; `surface` is the row of the first one's item among the surfaces. Beside its arrays
    stands "horizon", (2, 3): the box in the world within which endless fields are whole, or None where there are none.

    `around`, (2, 3), holds what is finite in the scene and the camera: endless fields end HORIZON of its sizes away.
    Raises `SceneError` where a field leaves the range of single precision.
    """
    lowered: dict[int, _Lowered] = {}
    found: list[_Lowered] = []
    for part in parts:
        # Items of one field share its tree, unless it is cut where the scene ends.
        shared = bool(np.isfinite(part.field.bounds).all())
        key = id(part.field) if shared else -1 - len(found)
        if key not in lowered:
            lowered[key] = _lower(part, around, threads)
        one = lowered[key]
        found.append(one._replace(box=placed_box(one.clip, part.matrix)))
    packed = _packed(parts, found, surface, accelerator)
    return packed.holding({"horizon": _horizon(around) if endless(parts) else None})


def _lower(part: FieldPart, around: Matrix, threads: int | None) -> _Lowered:
    box = _finite_box(part, around)
    edge = float((box[1] - box[0]).max())
    if not (np.isfinite(box).all() and edge > 0 and np.abs(box).max() < _LARGEST):
        raise SceneError(f"a field's region {box.tolist()} leaves no room for single precision; scale the scene")
    clip = np.stack([box[0] - _BEYOND * edge, box[1] + _BEYOND * edge])
    side = edge * (1 + 4 * _BEYOND)
    low = ((clip[0] + clip[1]) / 2 - side / 2).astype(np.float32)
    region = np.stack([low, low + side]) + np.array([[-_BEYOND], [_BEYOND]]) * edge
    tape = tape_of(part.field.form, region)
    data = packed_data(tape)
    tree = build_field_tree(tape.rows, data.words, low, side, threads)
    detail = float((box[1] - box[0]).min())
    if not np.isfinite(part.field.bounds).all():
        detail = min(detail, _extent(around))
    return _Lowered(tree, data, low, side, clip, clip, detail)


def _extent(around: Matrix) -> float:
    """The longest edge of what is finite."""
    return max(float((around[1] - around[0]).max()), 1e-3)


def _horizon(around: Matrix) -> Matrix:
    """The box in the world that endless fields reach to."""
    reach = HORIZON * _extent(around)
    horizon: Matrix = around + np.array([[-reach], [reach]])
    return horizon


def _finite_box(part: FieldPart, around: Matrix) -> Matrix:
    """Bounds of a field in its own space, cut at the horizon."""
    bounds = np.asarray(part.field.bounds, np.float64)
    if np.isfinite(bounds).all():
        return bounds
    inverse = np.linalg.inv(part.matrix).astype(np.float64)
    horizon = placed_box(_horizon(around), inverse)
    return np.stack([np.maximum(bounds[0], horizon[0]), np.minimum(bounds[1], horizon[1])])


def _packed(parts: Sequence[FieldPart], found: Sequence[_Lowered], surface: int, accelerator: str) -> Packed:
    """All fields in one table; fields that share a tree have it once."""
    rows, tapes, nodes = [np.zeros(0, np.int32)], [np.zeros((0, 2), np.int32)], [np.zeros(0, np.int32)]
    finer = [np.zeros(0, np.int64)]
    numbers, cubes = np.zeros((len(parts), 5), np.int32), np.zeros((len(parts), 17), np.float32)
    starts: dict[int, tuple[int, int]] = {}
    row, tape, node, longest = 0, 0, 0, 0
    for k, one in enumerate(found):
        tree = one.tree
        if id(tree) not in starts:
            starts[id(tree)] = node, tape
            rows.append(tree.rows.reshape(-1))
            tapes.append(tree.tapes + np.array([row, 0], np.int32))
            nodes.append(_moved(tree.nodes, node, tape))
            finer.append(tree.finer)
            row, tape, node = row + len(tree.rows), tape + len(tree.tapes), node + len(tree.nodes) // NODE
            longest = max(longest, int(tree.tapes[:, 1].max()))
        first_node, first_tape = starts[id(tree)]
        root = first_node + tree.root if tree.root > 0 else tree.root - first_tape
        numbers[k] = root, tree.levels, first_tape, surface + k, first_node
        reach = max(float(np.abs(one.low).max()), float(np.abs(one.low + one.side).max()))
        cubes[k, :BALL] = *one.low, one.side, *one.clip[0], *one.clip[1], 0.0, _LEAST_STEP * reach, one.detail
    placed = np.array([one.box for one in found]).reshape(-1, 2, 3)
    matrices = np.array([part.matrix for part in parts], np.float64).reshape(-1, 4, 4)
    _put(cubes, matrices, placed)
    boxes = placed.astype(np.float32)
    data = _data(found)
    packed = FIELDS.pack(
        rows=np.concatenate(rows),
        tapes=np.concatenate(tapes),
        nodes=np.concatenate(nodes),
        finer=np.concatenate(finer),
        numbers=numbers,
        cubes=cubes,
        to_object=np.ascontiguousarray(np.linalg.inv(matrices)[:, :3].reshape(-1, 12)),
        to_world=np.ascontiguousarray(matrices[:, :3].reshape(-1, 12)),
        data=data,
        **_over(boxes, accelerator),
        trace=trace_field.address,
        surface=field_surface.address,
        longest=longest,
        interpreters=pack_interpreters(),
    )
    # The words of `data` point at tables that must live as long.
    held = {"tables": tuple(one.data for one in found), _CLIPS: np.array([one.clip for one in found]), _BOXES: boxes}
    return packed.holding(held | {ACCELERATOR: accelerator})


def _over(boxes: npt.NDArray[np.float32], accelerator: str) -> dict[str, Any]:
    """The accelerator over the boxes of several fields; a single one needs none."""
    return over_boxes(accelerator, boxes if len(boxes) > 1 else boxes[:0], test_field)


def counting_fields(fields: Packed) -> Packed:
    """Fields whose rays count what they visit."""
    return counting_boxes(FIELDS, fields, test_field)


def _put(cubes: npt.NDArray[np.float32], matrices: Matrix, boxes: Matrix) -> npt.NDArray[np.float32]:
    """Rows of `cubes` with what they say of where fields stand: by matrices, in boxes in the world."""
    cubes[:, STRETCH] = np.abs(matrices[:, :3, :3]).sum(axis=2).max(axis=1)
    middles = (boxes[:, 0] + boxes[:, 1]) / 2
    cubes[:, BALL : BALL + 3] = middles
    cubes[:, BALL + 3] = np.linalg.norm(boxes[:, 1] - middles, axis=1) * (1 + 1e-6)
    return cubes


def moved_fields(packed: Packed, rows: npt.NDArray[np.int64], matrices: Matrix) -> Packed:
    """Lowered fields of which those of these rows stand by `matrices` (n, 4, 4); all else is shared. Endless ones end
    where they did in their own space."""
    names = "cubes", "to_object", "to_world", _BOXES
    cubes, to_object, to_world, boxes = (packed.arrays[name].copy() for name in names)
    placed = placed_boxes(packed.arrays[_CLIPS][rows], matrices)
    cubes[rows] = _put(cubes[rows], matrices, placed)
    to_object[rows], to_world[rows] = np.linalg.inv(matrices)[:, :3].reshape(-1, 12), matrices[:, :3].reshape(-1, 12)
    boxes[rows] = placed
    over = _over(boxes, packed.arrays[ACCELERATOR])
    return repacked(FIELDS, packed, cubes=cubes, to_object=to_object, to_world=to_world, **over)


def _moved(nodes: Ints, node: int, tape: int) -> Ints:
    """A tree's nodes behind others, so that its numbers go on from theirs."""
    moved = nodes.reshape(-1, NODE).copy()
    codes = moved[:, :CHILDREN]
    codes[codes > 0] += node
    codes[codes <= FIRST_TAPE] -= tape
    moved[:, CHILDREN:] += tape
    return moved.reshape(-1)


def _data(found: Sequence[_Lowered]) -> npt.NDArray[np.int64]:
    width = max((len(one.data.words) for one in found), default=1)
    words = np.zeros((len(found), width), np.int64)
    for row, one in zip(words, found, strict=True):
        row[: len(one.data.words)] = one.data.words
    return words
