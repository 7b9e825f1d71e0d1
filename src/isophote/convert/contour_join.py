"""Bricks of a contour put together: their cells and components numbered, faces written between them.

Faults are mended on the way. Where two cells would give an edge of the mesh four faces, the curves on the face between
them are joined the other way. Where merging folded a triangle over, what was merged there is split again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.convert.contour_grid import Grid
from isophote.kernels.base.table import Packed
from isophote.kernels.measure import contour_faces, contour_faults
from isophote.kernels.measure.contour_cases import CASES, COUNT_SHIFT, case_word, twice_crossed_faces
from isophote.kernels.measure.contour_tables import BRICK
from isophote.progress import Reporter

__all__ = ["LEAST_HEIGHT", "Chunk", "Longs", "Spread", "Triangles", "join", "taken"]

Ints: TypeAlias = npt.NDArray[np.int32]
Longs: TypeAlias = npt.NDArray[np.int64]
Spread: TypeAlias = Callable[[Callable[..., Any], Iterable[tuple[Any, ...]]], Iterator[Any]]

# Triangles less than this high, in cells, may be turned over.
LEAST_HEIGHT = 0.02
# Bricks, and components, that a thread is given at once.
_BRICKS, _COMPONENTS = 16, 1 << 15


class Triangles(NamedTuple):
    """`vertices` (n, 3) float64, and `triangles` (m, 3) int32, anticlockwise from outside."""

    vertices: npt.NDArray[np.float64]
    triangles: Ints


class Chunk(NamedTuple):
    """What some bricks put out; see OUTPUT of kernels/measure/contour_tables.py."""

    codes: Ints
    cases: Ints
    firsts: Ints
    crossings: npt.NDArray[np.float32]
    normals: Ints
    parents: Ints
    levels: npt.NDArray[np.uint8]
    places: npt.NDArray[np.float64]
    ends: Ints


def taken(output: Packed, bricks: int) -> Chunk:
    """Copies of what so many bricks have put out."""
    arrays = output.arrays
    cells, components, _ = arrays["ends"][bricks - 1].tolist()
    lengths = {"crossings": 3 * cells, "normals": 3 * cells, "ends": bricks}
    lengths |= dict.fromkeys(("parents", "levels", "places"), components)
    return Chunk(*(arrays[name][: lengths.get(name, cells)].copy() for name in Chunk._fields))


def join(
    chunks: list[Chunk], bricks: Longs, grid: Grid, least_height: float, spread: Spread, report: Reporter
) -> Triangles:
    """Vertices and faces of all bricks."""
    if not chunks:
        return Triangles(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    arrays = _numbered(chunks)
    ends = [chunk.ends for chunk in chunks]
    starts = _starts(np.concatenate([np.diff(end[:, 0], prepend=0) for end in ends]))
    nodes = _starts(np.concatenate([np.diff(end[:, 1], prepend=0) for end in ends]))
    edges = np.concatenate([end[:, 2] for end in ends])
    slots = np.full(int(np.prod(grid.bricks)), -1, np.int32)
    slots[bricks] = np.arange(len(bricks))
    count = len(arrays["parents"])
    fixed = {
        "bricks": bricks,
        "slots": slots,
        "starts": starts,
        "nodes": nodes,
        "across": grid.bricks[0],
        "along": grid.bricks[1],
        "words": CASES,
        "split": np.zeros(count, np.uint8),
        "to_split": np.zeros(count, np.uint8),
        "vertices": np.zeros(count, np.int32),
        "least_height": least_height,
        "present": np.zeros((len(bricks), BRICK**3 // 32), np.int32),
        "ranks": np.zeros((len(bricks), BRICK**3 // 32), np.int32),
    }
    tables = contour_faces.FACES.pack(**arrays, **fixed)
    _spread_out(spread, contour_faces.index_bricks, tables, len(bricks), _BRICKS)
    tables = _mended(tables)
    triangles = np.concatenate(_faces(tables, edges, grid, spread, report))
    places = tables.arrays["places"]
    numbers, vertices = np.zeros(len(places), np.int32), np.empty_like(places)
    count = contour_faces.put_together(places, grid.cell, grid.low, triangles, numbers, vertices)
    return Triangles(vertices[:count].copy(), triangles)


def _starts(counts: npt.NDArray[Any]) -> Longs:
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])


def _numbered(chunks: list[Chunk]) -> dict[str, npt.NDArray[Any]]:
    """The chunks' arrays one after another, with components numbered through."""
    before = _starts(np.array([len(chunk.parents) for chunk in chunks]))
    names = ("codes", "cases", "crossings", "normals", "levels", "places")
    arrays = {name: np.concatenate([getattr(chunk, name) for chunk in chunks]) for name in names}
    pairs = list(zip(chunks, before.astype(np.int32), strict=False))
    arrays["firsts"] = np.concatenate([chunk.firsts + first for chunk, first in pairs])
    parents = [np.where(chunk.parents >= 0, chunk.parents + first, -1) for chunk, first in pairs]
    arrays["parents"] = np.concatenate(parents).astype(np.int32, copy=False)
    return arrays


def _spread_out(spread: Spread, kernel: Callable[..., Any], tables: Packed, count: int, grain: int) -> None:
    list(spread(kernel, ((tables.words, a, min(a + grain, count)) for a in range(0, count, grain))))


@cache
def _twice(signs: int, joined: int) -> int:
    return twice_crossed_faces(signs, joined)


@cache
def _all_twice() -> Ints:
    return np.array([_twice(signs, 0) for signs in range(256)], np.int32)


def _mended(tables: Packed) -> Packed:
    """The tables with curves on faces joined the other way where both cells' components cross a face twice."""
    arrays = tables.arrays
    cells = np.flatnonzero(_all_twice()[arrays["cases"]])
    pairs = np.empty((3 * len(cells), 3), np.int64)
    bricks = np.searchsorted(arrays["starts"], cells, "right") - 1
    pairs = pairs[: contour_faults.find_faults(tables.words, cells, bricks, _all_twice(), pairs)]
    joined: dict[int, int] = {}
    for cell, other, axis in pairs.tolist():
        signs, others = int(arrays["cases"][cell]), int(arrays["cases"][other])
        face, back = 2 * axis + 1, 2 * axis
        # Joining the curves of one face may have parted those of another.
        if _twice(signs, joined.get(cell, 0)) >> face & _twice(others, joined.get(other, 0)) >> back & 1:
            joined[cell] = joined.get(cell, 0) | 1 << face
            joined[other] = joined.get(other, 0) | 1 << back
    return _rejoined(tables, joined) if joined else tables


def _rejoined(tables: Packed, joined: dict[int, int]) -> Packed:
    """The tables with new components for cells whose faces are joined; numbers from 256 on name their cases."""
    arrays = dict(tables.arrays)
    cells = np.array(sorted(joined), np.int64)
    signs = arrays["cases"][cells].tolist()
    kinds = sorted({(sign, joined[cell]) for sign, cell in zip(signs, cells.tolist(), strict=True)})
    words = [case_word(*kind) for kind in kinds]
    # A case's low eight bits are its signs.
    table = np.zeros(256 * (1 + len(kinds)), np.int32)
    table[:256] = CASES
    numbers = {kind: 256 * (1 + n) + kind[0] for n, kind in enumerate(kinds)}
    for kind, word in zip(kinds, words, strict=True):
        table[numbers[kind]] = word
    cases = [numbers[sign, joined[cell]] for sign, cell in zip(signs, cells.tolist(), strict=True)]
    counts = table[cases] >> COUNT_SHIFT & 7
    first, extra = len(arrays["parents"]), int(counts.sum())
    arrays["cases"][cells] = cases
    arrays["firsts"][cells] = first + _starts(counts)[:-1]
    arrays["words"] = table
    for name, fill in (("parents", -1), ("levels", 0), ("split", 0), ("to_split", 0), ("vertices", 0), ("places", 0)):
        added = np.full((extra, *arrays[name].shape[1:]), fill, arrays[name].dtype)
        arrays[name] = np.concatenate([arrays[name], added])
    tables = contour_faces.FACES.pack(**arrays)
    bricks = np.searchsorted(arrays["starts"], cells, "right") - 1
    contour_faults.place_components(tables.words, cells, bricks)
    return tables


def _faces(tables: Packed, edges: Ints, grid: Grid, spread: Spread, report: Reporter) -> list[Ints]:
    """The triangles of each brick's edges, by numbers of components."""
    bricks, arrays = len(edges), tables.arrays
    found: list[Ints] = [np.empty((0, 3), np.int32)] * bricks

    def write(numbers: list[int]) -> None:
        for brick in numbers:
            out = np.empty((2 * int(edges[brick]), 3), np.int32)
            found[brick] = out[: contour_faces.write_faces(tables.words, brick, out)]

    todo = np.arange(bricks)
    while len(todo):
        _spread_out(spread, contour_faces.find_vertices, tables, len(arrays["parents"]), _COMPONENTS)
        list(spread(write, ((todo[a : a + _BRICKS].tolist(),) for a in range(0, len(todo), _BRICKS))))
        report("joining", 0.5)
        split = np.flatnonzero(arrays["to_split"])
        arrays["split"][split] = 1
        arrays["to_split"][split] = 0
        todo = _touched(arrays, split, grid)
    report("joining", 1.0)
    return found


def _touched(arrays: dict[str, Any], components: Longs, grid: Grid) -> Longs:
    """Bricks that have faces at components: those that they lie in, and the next ones where their cells reach there."""
    numbers = arrays["bricks"][np.searchsorted(arrays["nodes"], components, "right") - 1]
    across, along, _ = grid.bricks
    place = np.stack([numbers % across, numbers // across % along, numbers // (across * along)], axis=1)
    # Vertices lie in their cells or a cell beside them.
    reach = 2 + (1 << arrays["levels"][components].astype(np.int64))[:, None]
    beyond = arrays["places"][components] + reach >= (place + 1) * BRICK
    touched = [place]
    for step in range(1, 8):
        way = np.array([step & 1, step >> 1 & 1, step >> 2])
        there = place[(beyond | (way == 0)).all(axis=1)] + way
        touched.append(there[(there < grid.bricks).all(axis=1)])
    x, y, z = np.concatenate(touched).T
    slots = np.unique(arrays["slots"][(z * along + y) * across + x]).astype(np.int64)
    return slots[slots >= 0]
