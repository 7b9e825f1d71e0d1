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
# Bricks that a thread is given at once.
_BRICKS = 16
# Arrays of a chunk that have a row for each cell, each edge, and each component.
_CELLS = ("codes", "cases", "firsts")
_EDGES = ("edges", "rings", "crossings", "normals")
_COMPONENTS = ("parents", "roots", "levels", "places")


class Triangles(NamedTuple):
    """`vertices` (n, 3) float64, and `triangles` (m, 3) int32, anticlockwise from outside."""

    vertices: npt.NDArray[np.float64]
    triangles: Ints


class Chunk(NamedTuple):
    """What some bricks put out; see OUTPUT of kernels/measure/contour_tables.py."""

    arrays: dict[str, npt.NDArray[Any]]
    ends: Ints


def taken(output: Packed, bricks: int) -> Chunk:
    """What so many bricks have put out, which nobody else may write to again."""
    ends = output.arrays["ends"][:bricks]
    cells, edges, components, _ = ends[-1].tolist()
    lengths = dict.fromkeys(_CELLS, cells) | dict.fromkeys(_EDGES, edges) | dict.fromkeys(_COMPONENTS, components)
    return Chunk({name: output.arrays[name][:length] for name, length in lengths.items()}, ends)


def join(
    chunks: list[Chunk], bricks: Longs, grid: Grid, least_height: float, spread: Spread, report: Reporter
) -> Triangles:
    """Vertices and faces of all bricks."""
    if not chunks:
        return Triangles(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    arrays = _one_after_another(chunks, spread)
    starts, edge_starts, nodes = (_starts(np.concatenate([_counts(chunk, k) for chunk in chunks])) for k in range(3))
    slots = np.full(int(np.prod(grid.bricks)), -1, np.int32)
    slots[bricks] = np.arange(len(bricks))
    count = len(arrays["parents"])
    fixed = {
        "bricks": bricks,
        "slots": slots,
        "starts": starts,
        "edge_starts": edge_starts,
        "nodes": nodes,
        "across": grid.bricks[0],
        "along": grid.bricks[1],
        "words": CASES,
        "split": np.zeros(count, np.uint8),
        "to_split": np.zeros(count, np.uint8),
        "least_height": least_height,
        "present": np.zeros((len(bricks), BRICK**3 // 32), np.int32),
        "ranks": np.empty((len(bricks), BRICK**3 // 32), np.int32),
    }
    tables = contour_faces.FACES.pack(**arrays, **fixed)
    jobs = ((tables.words, a, min(a + _BRICKS, len(bricks))) for a in range(0, len(bricks), _BRICKS))
    list(spread(contour_faces.index_bricks, jobs))
    if any(chunk.ends[:, 3].any() for chunk in chunks):
        tables = _mended(tables)
    triangles = np.concatenate(_faces(tables, grid, spread, report))
    places = tables.arrays["places"]
    numbers, vertices = np.zeros(len(places), np.int32), np.empty_like(places)
    count = contour_faces.put_together(places, grid.cell, grid.low, triangles, numbers, vertices)
    return Triangles(vertices[:count].copy(), triangles)


def _counts(chunk: Chunk, column: int) -> Ints:
    """How many cells, edges or components each brick of a chunk has."""
    return np.diff(chunk.ends[:, column], prepend=0)


def _starts(counts: npt.NDArray[Any]) -> Longs:
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])


def _one_after_another(chunks: list[Chunk], spread: Spread) -> dict[str, npt.NDArray[Any]]:
    """The chunks' arrays put together."""

    def put_together(name: str) -> npt.NDArray[Any]:
        return np.concatenate([chunk.arrays[name] for chunk in chunks])

    names = (*_COMPONENTS, *_EDGES, *_CELLS)
    return dict(zip(names, spread(put_together, ((name,) for name in names)), strict=True))


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
    extra = int(counts.sum())
    bricks = np.searchsorted(arrays["starts"], cells, "right") - 1
    arrays["cases"][cells] = cases
    arrays["firsts"][cells] = len(arrays["parents"]) + _starts(counts)[:-1] - arrays["nodes"][bricks]
    arrays["words"] = table
    for name, fill in (("parents", -1), ("levels", 0), ("split", 0), ("to_split", 0), ("roots", 0), ("places", 0)):
        added = np.full((extra, *arrays[name].shape[1:]), fill, arrays[name].dtype)
        arrays[name] = np.concatenate([arrays[name], added])
    tables = contour_faces.FACES.pack(**arrays)
    contour_faults.place_components(tables.words, cells, bricks, _first_edges(arrays["cases"]))
    return tables


def _first_edges(cases: Ints) -> Longs:
    """The number of the first edge of each cell."""
    x, y, z = ((cases ^ cases >> (1 << axis)) & 1 for axis in range(3))
    return _starts(x + y + z)


def _faces(tables: Packed, grid: Grid, spread: Spread, report: Reporter) -> list[Ints]:
    """The triangles of each brick's edges, by numbers of components."""
    arrays = tables.arrays
    edges = np.diff(arrays["edge_starts"])
    found: list[Ints] = [np.empty((0, 3), np.int32)] * len(edges)

    def write(bricks: Longs) -> None:
        out, ends = np.empty((2 * int(edges[bricks].sum()), 3), np.int32), np.empty(len(bricks), np.int64)
        contour_faces.write_faces(tables.words, bricks, out, ends)
        first = 0
        for brick, end in zip(bricks.tolist(), ends.tolist(), strict=True):
            found[brick], first = out[first:end], end

    todo = np.arange(len(edges))
    while len(todo):
        list(spread(write, ((todo[a : a + _BRICKS],) for a in range(0, len(todo), _BRICKS))))
        report("joining", 0.5)
        split = np.flatnonzero(arrays["to_split"])
        arrays["split"][split] = 1
        arrays["to_split"][split] = 0
        contour_faces.find_vertices(tables.words, _bricks_of(arrays, split))
        todo = _touched(arrays, split, grid)
    report("joining", 1.0)
    return found


def _bricks_of(arrays: dict[str, Any], components: Longs) -> Longs:
    """The bricks that components lie in, each once."""
    return np.unique(np.searchsorted(arrays["nodes"], components, "right") - 1)


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
