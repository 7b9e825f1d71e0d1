"""`repair`: a mesh made closed and manifold, and a report of all that was done to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.connectivity.stars import pick_sound_faces
from isophote.analysis.mending.clean import drop_degenerate, drop_duplicates, drop_unused
from isophote.analysis.mending.edit import Edit, Longs
from isophote.analysis.mending.holes import fill_holes
from isophote.analysis.mending.split import split_vertices
from isophote.analysis.mending.weld import weld as weld_vertices
from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh

__all__ = ["RepairReport", "repair"]

_Step: TypeAlias = Callable[[Mesh], tuple[Edit, Longs]]


@attrs.frozen(eq=False, kw_only=True)
class RepairReport:
    """What `repair` did; vertices and faces by their numbers in the mesh that it was given.

    welded: (k, 2), each merged vertex and the one that it went into. degenerate_faces: those that named a vertex
    twice; what was left of larger ones was kept. duplicate_faces: dropped, since an earlier face has the same
    vertices. split_vertices: those whose fans got a vertex each. filled: the loops that were closed, by their
    vertices; open: the loops and chains that are left. unused_vertices: left out.

    vertex_source: for each vertex of the new mesh the old one, -1 for a new one. face_source: for each face of the new
    mesh the old one, -1 for a new one.
    """

    welded: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    degenerate_faces: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    duplicate_faces: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    split_vertices: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    filled: tuple[npt.NDArray[np.int64], ...] = attrs.field(repr=False)
    open: tuple[npt.NDArray[np.int64], ...] = attrs.field(repr=False)
    unused_vertices: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    vertex_source: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)
    face_source: npt.NDArray[np.int64] = attrs.field(repr=False, converter=read_only)

    @property
    def counts(self) -> dict[str, int]:
        """How often each thing was done, by its name in words."""
        return {
            "vertices welded": len(self.welded),
            "degenerate faces dropped or cut": len(self.degenerate_faces),
            "duplicate faces dropped": len(self.duplicate_faces),
            "vertices split": len(self.split_vertices),
            "holes filled": len(self.filled),
            "faces added": int((self.face_source < 0).sum()),
            "holes left": len(self.open),
            "unused vertices left out": len(self.unused_vertices),
        }

    @property
    def changed(self) -> bool:
        """Whether anything was done."""
        return any(count for name, count in self.counts.items() if name != "holes left")

    def __str__(self) -> str:
        told = [f"{count:,} {name}" for name, count in self.counts.items() if count]
        return "; ".join(told) or "nothing to repair"


class _Bench:
    """The mesh at work, and where its vertices and faces come from."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self.vertex = np.arange(len(mesh.vertices))
        self.face = np.arange(mesh.face_count)

    def apply(self, edit: Edit) -> None:
        self.mesh = edit.made_from(self.mesh)
        self.vertex = np.where(edit.vertex >= 0, self.vertex[edit.vertex], -1)
        self.face = np.where(edit.face >= 0, self.face[edit.face], -1)

    def vertices(self, wanted: bool, step: _Step) -> Longs:
        """Do a step; the vertices that it tells of, by their first numbers."""
        return self._done(wanted, step, self.vertex)

    def faces(self, wanted: bool, step: _Step) -> Longs:
        """Do a step; the faces that it tells of, by their first numbers."""
        return self._done(wanted, step, self.face)

    def _done(self, wanted: bool, step: _Step, numbers: Longs) -> Longs:
        if not wanted:
            return np.empty(0, np.int64)
        edit, found = step(self.mesh)
        self.apply(edit)
        return numbers[found]


def repair(
    mesh: Mesh,
    *,
    weld: float | None = 0.0,
    degenerate: bool = True,
    duplicates: bool = True,
    split: bool = True,
    holes: bool | int = True,
    unused: bool = True,
) -> tuple[Mesh, RepairReport]:
    """The mesh repaired, and a report of what that took. Steps, in this order, each of which can be left out:

    weld: merge vertices within this distance, 0 for those at one place (None: no). degenerate: drop faces that name a
    vertex twice; of larger ones keep the rings that are left. duplicates: keep one of faces with the same vertices in
    the same cycle, either way round. split: give each fan of faces at a vertex a vertex of its own, which makes the
    mesh manifold. holes: close boundary loops with triangles, all or those of at most so many edges. unused: leave out
    vertices without a face.

    Surviving faces keep their attributes and labels; attributes at vertices that were welded and differ become
    attributes at corners. New faces have no labels and no attributes at corners (-1); a new vertex in the middle of a
    hole gets the mean of its rim. Faces are not turned; see `orient`. Parts that overlap stay so; see `boolean`.

    Raises `GeometryError` for options without meaning, and where no face is left.
    """
    pick_sound_faces(mesh)
    most = _most_edges(holes)
    bench = _Bench(mesh)
    welded = np.empty((0, 2), np.int64)
    if weld is not None:
        edit, welded = weld_vertices(mesh, weld)
        bench.apply(edit)
    degenerate_faces = bench.faces(degenerate, drop_degenerate)
    duplicate_faces = bench.faces(duplicates, drop_duplicates)
    split_ones = bench.vertices(split, split_vertices)
    edit, filling = fill_holes(bench.mesh, most)
    filled, left = (tuple(bench.vertex[loop] for loop in loops) for loops in filling)
    bench.apply(edit)
    unused_ones = bench.vertices(unused, drop_unused)
    return bench.mesh, RepairReport(
        welded=welded,
        degenerate_faces=degenerate_faces,
        duplicate_faces=duplicate_faces,
        split_vertices=split_ones,
        filled=filled,
        open=left,
        unused_vertices=unused_ones,
        vertex_source=bench.vertex,
        face_source=bench.face,
    )


def _most_edges(holes: bool | int) -> int | None:
    """The longest loop to fill; None for all, 0 for none."""
    if holes is True:
        return None
    if isinstance(holes, int | np.integer) and holes >= 0:
        return int(holes)
    raise GeometryError(f"holes must be True, False or the most edges of a hole to fill, but is {holes!r}")
