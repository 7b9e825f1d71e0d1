"""A field on a grid to vertices and triangles: bricks handed out to threads, and put together in their order."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from isophote.convert.contour_grid import Grid, corner_text
from isophote.convert.contour_join import LEAST_HEIGHT, Chunk, Longs, Spread, Triangles, join
from isophote.convert.contour_scratch import new_output, new_work, pack_contour
from isophote.errors import GeometryError
from isophote.kernels.base.table import Packed
from isophote.kernels.measure import contour_brick, contour_regions
from isophote.kernels.measure.contour_tables import BRICK
from isophote.machine import processors
from isophote.progress import Reporter
from isophote.shapes.field.evaluate import packed_data
from isophote.shapes.field.field import Field
from isophote.shapes.field.tape import tape_of

__all__ = ["MEMORY", "Options", "Triangles", "contoured"]


# Bytes that a mesh may take while it is made, unless the caller says otherwise.
MEMORY = 4e9

# Bytes for each brick that the surface crosses: the mesh of some 1,500 cells, its parts before they are joined, and the
# index of the brick's cells.
_A_BRICK = 400_000
# Bricks that a thread is given at once, and components of a brick that there is room for at first.
_CHUNK = 8
_ROOM = 1 << 14


_T = TypeVar("_T")


class _Field(NamedTuple):
    """A tape's rows, and the tables that they read."""

    rows: npt.NDArray[np.int32]
    data: Packed


class Options(NamedTuple):
    """How a field is contoured: vertices on sharp edges or in the middle, bytes allowed, threads (None: all)."""

    sharp: bool
    memory: float
    threads: int | None


def contoured(shape: Field, grid: Grid, reach: float, options: Options, report: Reporter) -> Triangles:
    """The surface of a field on a grid; cells are merged within the distance `reach`, or not at all if that is 0."""
    top = grid.low + grid.cell * np.array(grid.cells)
    tape = tape_of(shape.form, np.stack([grid.low, top]))
    field = _Field(tape.rows, packed_data(tape))
    cells = reach / grid.cell if options.sharp and reach > 0 else -1.0
    contour = pack_contour(tape.rows, grid.axes, cells, options.sharp)
    with _crew(options.threads) as spread:
        free: list[Packed] = []
        bricks = _find_bricks(contour, grid, field, free, spread)
        _check_memory(grid, len(bricks), options.memory)
        chunks = _contour(_Worker(contour, grid, bricks, field, free), bricks, spread, report)
        return join(chunks, bricks, grid, max(cells, LEAST_HEIGHT), spread, report)


def _check_memory(grid: Grid, bricks: int, memory: float) -> None:
    needed = bricks * _A_BRICK + 4.0 * np.prod(grid.bricks)
    if needed > memory:
        raise GeometryError(
            f"a mesh with cell {grid.cell:.3g} needs about {needed / 1e9:.2g} GB of memory, and {memory / 1e9:.2g} GB "
            f"are allowed; cell {grid.cell * float(np.sqrt(needed / memory)) * 1.1:.2g} fits, or a larger memory="
        )


@contextmanager
def _crew(threads: int | None) -> Iterator[Spread]:
    """A function that calls another for each tuple of arguments and gives the results in their order."""
    if threads is None:
        threads = processors()
    if threads == 1:
        yield lambda function, jobs: (function(*job) for job in jobs)
        return
    with ThreadPoolExecutor(threads) as pool:
        yield lambda function, jobs: pool.map(lambda job: function(*job), jobs)


def _find_bricks(contour: Packed, grid: Grid, field: _Field, free: list[Packed], spread: Spread) -> Longs:
    """The numbers of the bricks that the surface may cross, in order; scratch that is `free` again."""
    groups = int(np.prod([-(-n // contour_regions.GROUP) for n in grid.cells]))

    def find(first: int, last: int) -> Longs:
        found = np.empty(64 * (last - first), np.int64)
        work = _last(free) or new_work(*field, _ROOM)
        count = contour_regions.find_bricks(contour.words, work.words, first, last, found)
        free.append(work)
        return found[:count]

    parts = list(spread(find, ((first, min(first + 64, groups)) for first in range(0, groups, 64))))
    return np.sort(np.concatenate(parts))


def _last(free: list[_T]) -> _T | None:
    """The last of what is free, taken off the list; None if there is nothing, which another thread may see to."""
    try:
        return free.pop()
    except IndexError:
        return None


class _Room(NamedTuple):
    """The scratch of a thread, for bricks of `size` components, and what it puts out, `done` bricks as yet."""

    work: Packed
    output: Packed
    done: int
    size: int


class _Worker:
    """Contours chunks of bricks, with the scratch of its thread, which grows where a brick needs more."""

    def __init__(self, contour: Packed, grid: Grid, bricks: Longs, field: _Field, scratch: list[Packed]) -> None:
        self._contour, self._grid, self._bricks, self._field = contour, grid, bricks, field
        self._scratch = scratch
        self._free: list[_Room] = []

    def __call__(self, first: int, last: int) -> list[Chunk]:
        room = _last(self._free) or self._new(_ROOM)
        chunks = []
        while first < last:
            status, done = contour_brick.contour_bricks(
                self._contour.words, room.work.words, room.output.words, self._bricks, first, last, room.done
            )
            if done > room.done:
                chunks.append(Chunk(room.output.arrays, room.done, done))
                first += done - room.done
            if status == contour_brick.NO_ROOM and done > 0:
                room = room._replace(output=self._new_output(room.size), done=0)
            elif status == contour_brick.NO_ROOM:
                # The brick needs more than there is.
                room = self._new(2 * room.size)
            elif status == contour_brick.DONE:
                room = room._replace(done=done)
            else:
                self._refuse(status, int(self._bricks[first]))
        self._free.append(room)
        return chunks

    def _new(self, size: int) -> _Room:
        work = _last(self._scratch) if size == _ROOM else None
        work = work or new_work(*self._field, size)
        return _Room(work, self._new_output(size), 0, size)

    def _new_output(self, size: int) -> Packed:
        return new_output(4 * size, 16 * size, len(self._bricks))

    def _refuse(self, status: int, brick: int) -> None:
        grid = self._grid
        across, along, _ = grid.bricks
        place = np.array([brick % across, brick // across % along, brick // (across * along)])
        low = grid.low + grid.cell * BRICK * place
        where = f"between {corner_text(low)} and {corner_text(low + grid.cell * BRICK)}"
        if status == contour_brick.NOT_A_NUMBER:
            raise GeometryError(f"the field is not a number (NaN) at a point {where}; mend its function there")
        raise GeometryError(f"the field reaches beyond its bounds {where}; give larger bounds=")


def _contour(worker: _Worker, bricks: Longs, spread: Spread, report: Reporter) -> list[Chunk]:
    spans = ((first, min(first + _CHUNK, len(bricks))) for first in range(0, len(bricks), _CHUNK))
    chunks: list[Chunk] = []
    done = 0
    for parts in spread(worker, spans):
        chunks += parts
        done += sum(part.last - part.first for part in parts)
        report("contouring", done / len(bricks))
    return chunks
