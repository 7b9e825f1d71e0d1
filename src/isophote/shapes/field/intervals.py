"""Intervals of a form over many boxes at once, by NumPy; and tight boxes around forms, found by them."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.shapes.field.form import Box, Form
from isophote.shapes.field.operators import OPERATORS
from isophote.shapes.field.tape import written

__all__ = ["numpy_intervals", "tight_bounds"]

Floats: TypeAlias = npt.NDArray[np.float64]

# Rounding of a value and of what it is made of, as a part of the value, of the point and of one.
_ROUNDING = 1e-12

# A box is looked at in so many parts along each axis, then in the outermost ones' halves, as often.
_PARTS = {2: 32, 3: 12}
_HALVINGS = 5
# Boxes times operators that a pass may look at.
_MOST_WORK = 4_000_000


def numpy_intervals(form: Form, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """(n,) least and greatest values of a form over boxes with corners `low` and `high`, (n, dimension), or beyond.

    Operator by operator, the interval rule, and value(middle) ± Lipschitz constant · radius, whichever is tighter.
    """
    graph, result = written(form, np.stack([low.min(axis=0), high.max(axis=0)]))
    constants = graph.lipschitz()
    middle = (low + high) / 2
    radius = np.linalg.norm(high - low, axis=1) / 2
    flat = [np.zeros(len(low))] * (3 - low.shape[1])
    values: dict[int, Any] = dict(enumerate([*middle.T, *flat]))
    intervals: dict[int, Any] = dict(enumerate([*zip(low.T, high.T, strict=True), *((f, f) for f in flat)]))
    reach = np.abs(graph.region).max()
    with np.errstate(all="ignore"):
        for node in graph.used(result):
            name, arguments, constant = graph.nodes[node]
            if name == "INPUT":
                continue
            rule = OPERATORS[name]
            value = values[node] = rule.value(*(values[a] for a in arguments), constant)
            least, most = rule.interval(*(intervals[a] for a in arguments), constant)
            spread = constants[node] * radius + _ROUNDING * (np.abs(value) + (constants[node] + 1) * (reach + 1))
            intervals[node] = (
                np.fmax(np.nextafter(least, -np.inf), value - spread),
                np.fmin(np.nextafter(most, np.inf), value + spread),
            )
    return tuple(np.broadcast_to(np.asarray(end, np.float64), (len(low),)) for end in intervals[result])  # type: ignore[return-value]


def tight_bounds(form: Form) -> Box:
    """The form's bounds, made smaller by what intervals prove to be empty; a box of no size where all of it is."""
    box = form.bounds
    if form.is_tight or not np.isfinite(box).all() or (box[0] >= box[1]).any():
        return box
    graph, result = written(form, box)
    work = len(graph.used(result))
    low, high = _split(box[None, 0], box[None, 1], _PARTS[form.dimension])
    if work * len(low) > _MOST_WORK:
        return box
    low, high = _not_empty(form, low, high)
    for _ in range(_HALVINGS):
        if len(low) == 0:
            return np.stack([box.mean(axis=0)] * 2)
        outer = ((low == low.min(axis=0)) | (high == high.max(axis=0))).any(axis=1)
        if outer.sum() * 2**form.dimension * work > _MOST_WORK:
            break
        parts = _not_empty(form, *_split(low[outer], high[outer], 2))
        low, high = (np.concatenate([kept[~outer], part]) for kept, part in zip((low, high), parts, strict=True))
    return np.stack([low.min(axis=0), high.max(axis=0)]) if len(low) else np.stack([box.mean(axis=0)] * 2)


def _split(low: Floats, high: Floats, parts: int) -> tuple[Floats, Floats]:
    """Each box in `parts` along each axis; neighbours share their sides exactly."""
    dimension = low.shape[1]
    steps = np.stack(np.meshgrid(*[np.arange(parts)] * dimension, indexing="ij"), axis=-1).reshape(1, -1, dimension)

    def side(number: Any) -> Floats:
        part = number / parts
        sides: Floats = (low[:, None] * (1 - part) + high[:, None] * part).reshape(-1, dimension)
        return sides

    return side(steps), side(steps + 1)


def _not_empty(form: Form, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    if len(low) == 0:
        return low, high
    least, _ = numpy_intervals(form, low, high)
    # What is not a number proves nothing.
    kept = ~(least > 0)
    return low[kept], high[kept]
