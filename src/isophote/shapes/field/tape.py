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

__all__ = ["Tape", "numpy_values", "sharing_slots", "tape_of", "written"]

Floats: TypeAlias = npt.NDArray[np.float64]


class Tape(NamedTuple):
    """`rows` (n, ROW) int32, and the tables of data that rows name by number."""

    rows: npt.NDArray[np.int32]
    data: tuple[Any, ...]


def written(form: Form, region: Box | None = None, *, symbolic: bool = False) -> tuple[Graph, int]:
    """The graph of a form's expression over a region, (2, dimension), and the node of its value."""
    if region is None:
        graph = Graph(symbolic=symbolic)
    else:
        box = np.zeros((2, 3))
        box[:, : np.shape(region)[1]] = region
        graph = Graph(box, symbolic)
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


def sharing_slots(rows: npt.NDArray[np.int32]) -> tuple[npt.NDArray[np.int32], int]:
    """Rows that write to slots which are not needed any more, so that all stay near the processor; how many slots.

    For interpreters of points only: a tape can be shortened only where each row has a slot of its own.
    """
    words = [opcodes.A, opcodes.B, opcodes.C]
    last = np.zeros(opcodes.INPUTS + len(rows), np.int64)
    for word in words:
        np.maximum.at(last, rows[:, word], np.arange(len(rows)))
    shared = rows.copy()
    places = list(range(opcodes.INPUTS)) + [0] * len(rows)
    free: list[int] = []
    count = opcodes.INPUTS
    for number, (a, b, c) in enumerate(rows[:, words].tolist()):
        shared[number, words] = places[a], places[b], places[c]
        free += {places[s] for s in (a, b, c) if s >= opcodes.INPUTS and last[s] == number}
        if not free:
            free, count = [count], count + 1
        places[opcodes.INPUTS + number] = shared[number, opcodes.OUT] = free.pop()
    return shared, count


def numpy_values(form: Form, points: npt.ArrayLike) -> Floats:
    """(n,) float64 values at points (n, dimension), by NumPy alone: the oracle of every other evaluator."""
    graph, result = written(form)
    array = np.asarray(points, np.float64)
    return np.broadcast_to(node_values(graph, result, array)[result], len(array)).astype(np.float64)


def numpy_gradients(form: Form, points: npt.ArrayLike) -> tuple[Floats, Floats]:
    """(n,) float64 values at points (n, dimension), and (n, dimension) derivatives, forwards, operator by operator."""
    graph, result = written(form)
    array = np.asarray(points, np.float64)
    values = node_values(graph, result, array)
    slopes: dict[int, Any] = {axis: np.eye(3)[axis][:, None] for axis in range(3)}
    with np.errstate(all="ignore"):
        for node in graph.used(result):
            name, arguments, constant = graph.nodes[node]
            if name != "INPUT":
                partials = OPERATORS[name].partials(*(values[a] for a in arguments), values[node], constant)
                slopes[node] = sum((d * slopes[a] for d, a in zip(partials, arguments, strict=True)), np.zeros((3, 1)))
    gradients = np.broadcast_to(slopes[result], (3, len(array)))[: array.shape[1]].T
    return np.broadcast_to(values[result], len(array)).astype(np.float64), gradients.astype(np.float64)


def node_values(graph: Graph, result: int, points: Floats) -> dict[int, Any]:
    """The values of all nodes that `result` depends on."""
    values: dict[int, Any] = dict(enumerate(points.T))
    with np.errstate(all="ignore"):
        for node in graph.used(result):
            name, arguments, constant = graph.nodes[node]
            if name != "INPUT":
                values[node] = OPERATORS[name].value(*(values[a] for a in arguments), constant)
    return values
