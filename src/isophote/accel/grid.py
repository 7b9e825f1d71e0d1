"""Uniform grids of triangles, and grids within their cells, built on all cores: kernels/accel/grid_layout.py."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Accelerator, Built, blocks_of, padded_slots
from isophote.accel.crew import crew, ranges
from isophote.accel.grid_lists import Geometry, Lists, boxes_of_lists, order_all, share_lists
from isophote.kernels.accel.grid_build import (
    NARROWEST,
    choose_root,
    choose_subgrids,
    place_triangles,
    slack_for,
    triangle_sums,
)
from isophote.kernels.accel.grid_empty import measure_empty
from isophote.kernels.accel.grid_entry import any_in_grid, closest_in_grid, things_in_grid
from isophote.kernels.accel.grid_layout import (
    GRID,
    MOST_LEVELS,
    NEAR,
    NEAR_ORIGINS,
    NOTHING,
    ROUNDING,
)
from isophote.kernels.base.table import Packed

__all__ = ["GRID_OF_GRIDS"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]
Doubles: TypeAlias = npt.NDArray[np.float64]
Longs: TypeAlias = npt.NDArray[np.int64]

# Work is cut into slabs of a grid with about so many references. Fixed: it must not depend on the number of threads.
_SLAB = 1 << 15
_MOST_SLABS = 8
# Flat boxes are made so many slacks thick.
_THINNEST = 4.0
# Slack for origins farther than they need count as near is at most this part of a cell: 1 / _FINE.
_FINE = 32.0


class _Level(NamedTuple):
    """Grids of one level: frames and shapes (kernels/accel/grid_layout.py), cells numbered within the level, and in
    which order `references` are theirs: the first of each, and the end."""

    frames: Doubles
    shapes: Longs
    starts: Longs
    references: IntArray


class _Filled(NamedTuple):
    """References in the order of a level's cells, and where each cell's begin, and the end."""

    references: IntArray
    starts: Longs


def _build(positions: FloatArray, triangles: IntArray, threads: int | None) -> Built:
    count = len(triangles)
    corners = positions[triangles.reshape(-1)]
    bounds = np.stack([corners.min(axis=0, initial=np.inf), corners.max(axis=0, initial=-np.inf)]).astype(np.float32)
    if count == 0:
        return Built(_nothing(), np.empty(0, np.float32), bounds)
    boxes = bool((triangles[:, 1] == triangles[:, 2]).all())
    with crew(threads, count) as run:
        geometry = Geometry(positions.reshape(-1), triangles.reshape(-1), boxes, run)
        level = _root(geometry, count, bounds.astype(np.float64))
        levels, filled, chosen = [], [], []
        while True:
            levels.append(level)
            filled.append(_fill(geometry, level))
            chosen.append(_choose(geometry, level, filled[-1], last=len(levels) == MOST_LEVELS))
            if not (chosen[-1].shapes[:, 0] > 0).any():
                break
            level = _next_level(filled[-1], chosen[-1], float(levels[0].frames[0, NEAR]))
        tables, slots = _table(geometry, levels, filled, chosen)
    return Built(tables, blocks_of(positions, triangles, slots, threads), bounds)


def _nothing() -> Packed:
    """A grid of one empty cell."""
    shape, none = np.ones((1, 3), np.int64), np.zeros(0, np.float32)
    frames = _frames(np.array([[0.0, 0, 0, 1, 1, 1]]), shape, np.ones(1), 0.0)
    cells, lists = np.full(1, NOTHING, np.int32), np.zeros((0, 3), np.int32)
    return GRID.pack(frames=frames, shapes=np.array([[1, 1, 1, 0]]), cells=cells, lists=lists, rows=none, reach=0.0)


def _frames(boxes: Doubles, shapes: Longs, reaches: Doubles, farthest: float) -> Doubles:
    """Frames of grids that are to hold boxes (g, 6) with so many cells on x, y, z (g, 3). Origins are near as far away
    as slack stays a small part of the cells, up to `farthest`."""
    extents = boxes[:, 3:] - boxes[:, :3]
    thinnest = np.where(shapes > 1, extents / shapes, np.inf).min(axis=1)
    own = NEAR_ORIGINS * 0.5 * extents.max(axis=1)
    near = np.maximum(own, np.minimum(farthest, thinnest / (_FINE * ROUNDING) - reaches))[:, None]
    slack = ROUNDING * (near + reaches[:, None])
    lower = boxes[:, :3] - np.maximum(0.5 * (_THINNEST * slack - extents), 0.0)
    wide = (np.maximum(extents, _THINNEST * slack) + 4 * slack) / shapes
    return np.concatenate([lower - 2 * slack, wide, slack, near, reaches[:, None], 1 / wide], axis=1)


def _root(geometry: Geometry, count: int, bounds: Doubles) -> _Level:
    """The outermost grid, with all triangles."""
    middle, extents = bounds.mean(axis=0), bounds[1] - bounds[0]
    # One point still has coordinates, and those their rounding.
    largest = max(float(extents.max()), 1e-6 * float(np.abs(bounds).max()), 1e-300)
    slack = slack_for(largest, largest / 2)
    extents = np.maximum(extents, _THINNEST * slack)
    extents[np.argmax(extents)] = max(largest, float(extents.max()))
    pieces = list(ranges(0, count))
    sums = np.empty((len(pieces), 6))
    arrays = geometry.positions, geometry.triangles
    geometry.run(triangle_sums, [(*arrays, *piece, sums[i]) for i, piece in enumerate(pieces)])
    shape = np.empty(3, np.int64)
    choose_root(count, geometry.item_cost, sums.sum(axis=0), extents, shape)
    shape = np.maximum(np.minimum(shape, (extents / (NARROWEST * slack)).astype(np.int64)), 1)
    box = np.concatenate([middle - extents / 2, middle + extents / 2])[None]
    frames = _frames(box, shape[None], np.array([largest / 2]), 0.0)
    return _Level(frames, np.append(shape, 0)[None], np.array([0, count]), np.arange(count, dtype=np.int32))


def _fill(geometry: Geometry, level: _Level) -> _Filled:
    """The references of each cell of a level, in order: counted first, then written."""
    jobs, spans = _jobs(level)
    cells = int(level.shapes[-1, 3] + level.shapes[-1, :3].prod())
    counts = np.zeros(cells, np.int64)
    none = np.empty(0, np.int32)
    given = geometry.positions, geometry.triangles, level.references, level.frames, level.shapes, jobs
    geometry.run(place_triangles, [(*given, *span, counts, none) for span in spans])
    starts = np.concatenate([np.zeros(1, np.int64), np.cumsum(counts)])
    filled = np.empty(int(starts[-1]), np.int32)
    cursors = starts[:-1].copy()
    geometry.run(place_triangles, [(*given, *span, cursors, filled) for span in spans])
    return _Filled(filled, starts)


def _jobs(level: _Level) -> tuple[Longs, list[tuple[int, int]]]:
    """Jobs of place_triangles, and ranges of them that are worth a thread's while. Jobs have cells of their own."""
    counts = np.diff(level.starts)
    slabs = np.minimum(np.clip(counts // _SLAB, 1, _MOST_SLABS), level.shapes[:, 2])
    grid = np.repeat(np.arange(len(counts)), slabs)
    number = np.arange(len(grid)) - np.repeat(np.cumsum(slabs) - slabs, slabs)
    depth = level.shapes[grid, 2]
    low, high = depth * number // slabs[grid], depth * (number + 1) // slabs[grid]
    jobs = np.stack([grid, low, high, level.starts[grid], level.starts[grid + 1]], axis=1)
    group = np.cumsum(counts[grid]) // _SLAB
    ends = np.append(np.flatnonzero(np.diff(group)) + 1, len(jobs))
    return jobs, list(zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True))


class _Chosen(NamedTuple):
    """For each cell of a level, the cells on x, y, z of the grid that it should be (cells, 3), 0 where it stays a list;
    the box of what it holds (cells, 6), and how far corners of its triangles lie from that one's middle (cells,)."""

    shapes: Longs
    boxes: Doubles
    reaches: Doubles


def _choose(geometry: Geometry, level: _Level, filled: _Filled, *, last: bool) -> _Chosen:
    """Which cells of a level become grids; none of the last level."""
    cells = len(filled.starts) - 1
    chosen = _Chosen(np.zeros((cells, 3), np.int64), np.zeros((cells, 6)), np.zeros(cells))
    if not last:
        corners = geometry.positions, geometry.triangles, geometry.item_cost
        given = *corners, filled.references, filled.starts, level.frames, level.shapes
        jobs = []
        for begin, end in ranges(0, cells):
            grid = int(np.searchsorted(level.shapes[:, 3], begin, side="right")) - 1
            jobs.append((*given, grid, begin, end, *chosen))
        geometry.run(choose_subgrids, jobs)
    return chosen


def _next_level(filled: _Filled, chosen: _Chosen, farthest: float) -> _Level:
    """The grids that cells of a level become."""
    cells = np.flatnonzero(chosen.shapes[:, 0])
    inner = chosen.shapes[cells]
    frames = _frames(chosen.boxes[cells], inner, chosen.reaches[cells], farthest)
    sizes = inner.prod(axis=1)
    shapes = np.concatenate([inner, (np.cumsum(sizes) - sizes)[:, None]], axis=1)
    counts = filled.starts[cells + 1] - filled.starts[cells]
    starts = np.concatenate([np.zeros(1, np.int64), np.cumsum(counts)])
    within = np.arange(starts[-1]) - np.repeat(starts[:-1], counts)
    references = filled.references[np.repeat(filled.starts[cells], counts) + within]
    return _Level(frames, shapes, starts, references)


def _table(
    geometry: Geometry, levels: list[_Level], filled: list[_Filled], chosen: list[_Chosen]
) -> tuple[Packed, IntArray]:
    """The table of all levels, and the triangles in the slots of the lists' blocks."""
    codes, shapes, kept, counts = [], [], [], []
    grids, cells, numbers = 1, 0, 0
    for level, content, choice in zip(levels, filled, chosen, strict=True):
        own = np.diff(content.starts)
        inner = choice.shapes[:, 0] > 0
        listed = (own > 0) & ~inner
        code = np.full(len(own), NOTHING, np.int32)
        code[inner] = 2 * (grids + np.arange(inner.sum())) + 1
        code[listed] = 2 * (numbers + np.arange(listed.sum()))
        codes.append(code)
        shapes.append(level.shapes + np.array([0, 0, 0, cells]))
        kept.append(content.references[np.repeat(listed, own)])
        counts.append(own[listed])
        grids, cells, numbers = grids + int(inner.sum()), cells + len(own), numbers + int(listed.sum())
    all_frames, all_shapes = np.concatenate([level.frames for level in levels]), np.concatenate(shapes)
    all_cells = np.concatenate(codes)
    lists = Lists(np.concatenate(kept), np.concatenate(counts).astype(np.int32))
    rows, first_rows = order_all(geometry, lists, boxes_of_lists(all_frames, all_shapes, all_cells))
    all_cells, lists, first_rows = share_lists(all_cells, lists, first_rows)
    geometry.run(measure_empty, [(all_cells, all_shapes, *piece) for piece in _pieces(all_shapes)])
    starts, slots = padded_slots(lists.sizes, lists.references)
    tables = GRID.pack(
        frames=all_frames,
        shapes=all_shapes,
        cells=all_cells,
        lists=np.stack([starts, lists.sizes, first_rows], axis=1),
        rows=rows,
        reach=float(np.abs(geometry.positions).max()),
    )
    return tables, slots


def _pieces(shapes: Longs) -> list[tuple[int, int]]:
    """Ranges of grids with enough cells to be worth a thread's while."""
    group = np.cumsum(shapes[:, :3].prod(axis=1)) // _SLAB
    ends = np.append(np.flatnonzero(np.diff(group)) + 1, len(shapes))
    return list(zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True))


GRID_OF_GRIDS = Accelerator("grid", _build, closest_in_grid, any_in_grid, things_in_grid)
