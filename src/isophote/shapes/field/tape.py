"""An expression as a tape: rows of numbers that one compiled interpreter runs, whatever the shape.

Row k writes slot INPUTS + k; the point lies in slots 0, 1, 2; the last row writes the field's value. The words of a
row are told in kernels/forms/opcodes.py.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.forms import opcodes
from isophote.shapes.field.expression import Graph
from isophote.shapes.field.form import Box, Form
from isophote.shapes.field.operators import OPERATORS
from isophote.shapes.field.rounding import roundings

__all__ = ["Tape", "numpy_values", "tape_of", "written"]

Floats: TypeAlias = npt.NDArray[np.float64]


class Tape(NamedTuple):
    """`rows` (n, ROW) int32, and the tables of data that rows name by number."""

    rows: npt.NDArray[np.int32]
    data: tuple[Any, ...]


def written(form: Form, region: Box | None = None, *, symbolic: bool = False) -> tuple[Graph, int]:
    """The graph of a form's expression over a region, (2, 3), and the node of its value."""
    graph = Graph(symbolic=symbolic) if region is None else Graph(np.asarray(region, np.float64), symbolic)
    return graph, form.expression(graph.point).id


def tape_of(form: Form, region: Box | None = None) -> Tape:
    """The tape of a form; with a `region`, its rows carry Lipschitz constants that hold there."""
    graph, result = written(form, region)
    constants = graph.lipschitz() if region is not None else None
    rounding = None if constants is None else roundings(graph, constants)
    live = [node for node in graph.used(result) if graph.nodes[node].name != "INPUT"]
    slots = {0: 0, 1: 1, 2: 2} | {node: opcodes.INPUTS + k for k, node in enumerate(live)}
    rows = np.zeros((len(live), opcodes.ROW), np.int32)
    floats = rows.view(np.float32)
    data: dict[int, tuple[int, Any]] = {}
    for k, node in enumerate(live):
        name, arguments, constant = graph.nodes[node]
        rows[k, opcodes.OP] = OPERATORS[name].code
        rows[k, opcodes.OUT] = opcodes.INPUTS + k
        for word, argument in zip((opcodes.A, opcodes.B, opcodes.C), arguments, strict=False):
            rows[k, word] = slots[argument]
        if isinstance(constant, float | int):
            floats[k, opcodes.IMM] = constant
        else:
            rows[k, opcodes.IMM] = data.setdefault(id(constant), (len(data), constant))[0]
        floats[k, opcodes.LIPSCHITZ] = np.inf if constants is None else _above(constants[node])
        floats[k, opcodes.ROUNDING] = 0.0 if rounding is None else _above(rounding[node])
    if slots[result] != opcodes.INPUTS + len(live) - 1:
        rows = np.concatenate([rows, _copy_row(slots[result], len(live), 1.0)])
    return Tape(np.ascontiguousarray(rows), tuple(constant for _, constant in data.values()))


def _above(constant: float) -> np.float32:
    """The next float32 that is not below."""
    single = np.float32(constant)
    return single if float(single) >= constant else np.nextafter(single, np.float32(np.inf))


def _copy_row(slot: int, row: int, constant: float) -> npt.NDArray[np.int32]:
    """A row that copies: the value of a field is always what its last row writes."""
    copy = np.zeros((1, opcodes.ROW), np.int32)
    copy[0, opcodes.OP], copy[0, opcodes.OUT], copy[0, opcodes.A] = opcodes.COPY, opcodes.INPUTS + row, slot
    copy.view(np.float32)[0, opcodes.LIPSCHITZ] = constant
    return copy


def numpy_values(form: Form, points: npt.ArrayLike) -> Floats:
    """(n,) float64 values at points (n, 3), by NumPy alone: the oracle of every other evaluator."""
    graph, result = written(form)
    columns = np.asarray(points, np.float64).T
    values: dict[int, Any] = dict(enumerate(columns))
    with np.errstate(all="ignore"):
        for node in graph.used(result):
            name, arguments, constant = graph.nodes[node]
            if name != "INPUT":
                values[node] = OPERATORS[name].value(*(values[a] for a in arguments), constant)
    return np.broadcast_to(values[result], columns.shape[1:]).astype(np.float64)
