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
from isophote.kernels.measure import contour_faces, contour_faults, contour_parts
from isophote.kernels.measure.contour_cases import CASES, COUNT_SHIFT, case_word, twice_crossed_faces
from isophote.kernels.measure.contour_tables import BRICK, MOMENTS, PLANE
from isophote.kernels.measure.contour_vertices import VERTICES
from isophote.kernels.measure.qef import QEF_WORDS
from isophote.progress import Reporter

__all__ = ["LEAST_HEIGHT", "Chunk", "Longs", "Spread", "Triangles", "join"]

Ints: TypeAlias = npt.NDArray[np.int32]
Longs: TypeAlias = npt.NDArray[np.int64]
Spread: TypeAlias = Callable[[Callable[..., Any], Iterable[tuple[Any, ...]]], Iterator[Any]]

# Triangles less than this high, in cells, may be turned over.
LEAST_HEIGHT = 0.02
# Bricks that a thread is given at once.
_BRICKS = 16
# Arrays of a chunk that have a row for each cell, each edge, and each component.
_CELLS = ("codes", "cases", "firsts", "first_edges")
_EDGES = ("edges", "rings", "crossings")
_COMPONENTS = ("parents", "roots", "levels", "places")


class Triangles(NamedTuple):
    """`vertices` (n, 3) float64, and `triangles` (m, 3) int32, anticlockwise from outside."""

    vertices: npt.NDArray[np.float64]
    triangles: Ints


class Chunk(NamedTuple):
    """What bricks have put out: those that are `first` ≤ b < `last` there. See kernels/measure/contour_tables.py."""

    output: dict[str, npt.NDArray[Any]]
    first: int
    last: int

    @property
    def ends(self) -> Ints:
        """Where each brick's cells, edges and components end in the output, and where the first brick's begin."""
        ends = self.output["ends"][max(self.first - 1, 0) : self.last, :3]
        return ends if self.first else np.concatenate([np.zeros((1, 3), np.int32), ends])


def join(
    chunks: list[Chunk], bricks: Longs, grid: Grid, least_height: float, spread: Spread, report: Reporter
) -> Triangles:
    """Vertices and faces of all bricks."""
    if not chunks:
        return Triangles(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    ends = [chunk.ends for chunk in chunks]
    arrays = _one_after_another(chunks, ends, spread)
    counts = np.concatenate([np.diff(end, axis=0) for end in ends])
    starts, edge_starts, nodes = (_starts(counts[:, k]) for k in range(3))
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
        "changed": np.zeros(count, np.uint8),
        "least_height": least_height,
        "present": np.zeros((len(bricks), BRICK**3 // 32), np.int32),
        "ranks": np.empty((len(bricks), BRICK**3 // 32), np.int32),
    }
    tables = contour_faces.FACES.pack(**arrays, **fixed)
    jobs = ((tables.words, a, min(a + _BRICKS, len(bricks))) for a in range(0, len(bricks), _BRICKS))
    list(spread(contour_faces.index_bricks, jobs))
    if any(chunk.output["ends"][chunk.first : chunk.last, 3].any() for chunk in chunks):
        tables = _mended(tables)
    triangles = np.concatenate(_faces(tables, grid, spread, report))
    places = tables.arrays["places"]
    numbers = np.zeros(len(places), np.int32)
    vertices = np.empty((contour_faces.number_vertices(triangles, numbers), 3))
    contour_faces.place_vertices(places, grid.cell, grid.low, numbers, vertices)
    return Triangles(vertices, triangles)


def _starts(counts: npt.NDArray[Any]) -> Longs:
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(counts, dtype=np.int64)])


def _one_after_another(chunks: list[Chunk], ends: list[Ints], spread: Spread) -> dict[str, npt.NDArray[Any]]:
    """The chunks' arrays put together."""
    spans = [list(zip(end[0].tolist(), end[-1].tolist(), strict=True)) for end in ends]

    def put_together(name: str, kind: int) -> npt.NDArray[Any]:
        pairs = zip(chunks, spans, strict=True)
        return np.concatenate([chunk.output[name][slice(*span[kind])] for chunk, span in pairs])

    jobs = [(name, kind) for kind, names in enumerate((_CELLS, _EDGES, _COMPONENTS)) for name in names]
    return dict(zip((name for name, _ in jobs), spread(put_together, jobs), strict=True))


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
    for name in ("parents", "levels", "split", "to_split", "changed", "roots", "places"):
        added = np.full((extra, *arrays[name].shape[1:]), -1 if name == "parents" else 0, arrays[name].dtype)
        arrays[name] = np.concatenate([arrays[name], added])
    tables = contour_faces.FACES.pack(**arrays)
    contour_faults.place_components(tables.words, cells, bricks)
    return tables


def _faces(tables: Packed, grid: Grid, spread: Spread, report: Reporter) -> list[Ints]:
    """The triangles of each brick's edges, by numbers of components."""
    arrays = tables.arrays
    most = 2 * np.diff(arrays["edge_starts"])
    found: list[tuple[Ints, Ints]] = [_part(_room(0), 0, 0)] * len(most)

    def write(bricks: Longs) -> None:
        out, ends = _room(int(most[bricks].sum())), np.empty(len(bricks), np.int64)
        contour_faces.write_faces(tables.words, bricks, out.words, ends)
        first = 0
        for brick, end in zip(bricks.tolist(), ends.tolist(), strict=True):
            found[brick], first = _part(out, first, end), end

    def mend(bricks: Longs) -> None:
        out, first = _room(int(most[bricks].sum())), 0
        for brick in bricks.tolist():
            end = contour_faces.mend_faces(tables.words, brick, *found[brick], out.words, first)
            found[brick], first = _part(out, first, end), end

    list(spread(write, _portions(np.arange(len(most)))))
    report("joining", 0.5)
    parts = _parts()
    while len(split := _newly_split(arrays)):
        bricks = np.unique(np.searchsorted(arrays["nodes"], split, "right") - 1)
        arrays["changed"][:] = 0
        contour_faces.find_vertices(tables.words, bricks)
        contour_parts.place_parts(tables.words, bricks, parts.words)
        list(spread(mend, _portions(_touched(arrays, split, grid))))
        report("joining", 0.5)
    report("joining", 1.0)
    return [vertices for vertices, _ in found]


def _portions(bricks: Longs) -> Iterator[tuple[Longs]]:
    return ((bricks[a : a + _BRICKS],) for a in range(0, len(bricks), _BRICKS))


def _room(triangles: int) -> Packed:
    """Room for triangles."""
    vertices, edges = np.empty((triangles, 3), np.int32), np.empty(triangles, np.int32)
    return contour_faces.TRIANGLES.pack(vertices=vertices, edges=edges)


def _part(faces: Packed, first: int, end: int) -> tuple[Ints, Ints]:
    return faces.arrays["vertices"][first:end], faces.arrays["edges"][first:end]


def _parts() -> Packed:
    """Scratch for the vertices of what is split."""
    return contour_parts.PARTS.pack(
        components=np.zeros(VERTICES, np.int32),
        codes=np.zeros(VERTICES, np.int32),
        moments=np.zeros((VERTICES, MOMENTS)),
        places=np.zeros((VERTICES, 3)),
        plane=np.zeros((1, PLANE)),
        qefs=np.zeros(QEF_WORDS, np.float32),
    )


def _newly_split(arrays: dict[str, Any]) -> Longs:
    """The components that shall be split, which are marked as such."""
    # The search is many times as fast for truth values as for numbers.
    split = np.flatnonzero(arrays["to_split"].view(np.bool_))
    arrays["split"][split] = 1
    arrays["to_split"][split] = 0
    return split


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
