"""Intervals of a form over many boxes at once, by NumPy; and tight boxes around forms, found by them."""

from __future__ import annotations

from functools import cached_property
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.shapes.field.expression import Graph
from isophote.shapes.field.form import Box, Form
from isophote.shapes.field.operators import OPERATORS
from isophote.shapes.field.tape import written

__all__ = ["Looker", "numpy_intervals", "tight_bounds"]

Floats: TypeAlias = npt.NDArray[np.float64]

# Rounding of a value and of what it is made of, as a part of the value, of the point and of one.
_ROUNDING = 1e-12

# A box is looked at in so many parts along each axis; then those that reach farther out than a point that is inside,
# by more than a part of the size, are halved along each axis, at most so often.
_PARTS = {2: 16, 3: 8}
_HALVINGS = 6
_PART = 0.005
# Boxes times operators that are looked at, which takes some fifty milliseconds.
_MOST_WORK = 1_200_000


@attrs.frozen(slots=False)
class Looker:
    """A form's expression over a region, which is looked at box by box within it."""

    graph: Graph
    nodes: list[int]
    result: int

    @cached_property
    def constants(self) -> list[float]:
        """Lipschitz constants of all nodes over the region."""
        return self.graph.lipschitz()

    @classmethod
    def of(cls, form: Form, region: Box) -> Looker:
        """Make ready to look at a form within a region."""
        graph, result = written(form, region)
        nodes = [node for node in graph.used(result) if graph.nodes[node].name != "INPUT"]
        return cls(graph, nodes, result)

    def values(self, points: Floats) -> Floats:
        """(n,) values at points (n, dimension)."""
        values: dict[int, Any] = dict(enumerate(points.T))
        with np.errstate(all="ignore"):
            for node in self.nodes:
                name, arguments, constant = self.graph.nodes[node]
                values[node] = OPERATORS[name].value(*(values[a] for a in arguments), constant)
        return np.broadcast_to(values[self.result], (len(points),))

    def intervals(self, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """(n,) least and greatest values, or beyond, over boxes with corners `low` and `high`, (n, dimension).

        Operator by operator, the interval rule, and value(middle) ± Lipschitz constant · radius, whichever is tighter.
        """
        radius = np.linalg.norm(high - low, axis=1) / 2
        flat = [np.zeros(len(low))] * (3 - low.shape[1])
        values: dict[int, Any] = dict(enumerate([*((low + high) / 2).T, *flat]))
        intervals: dict[int, Any] = dict(enumerate([*zip(low.T, high.T, strict=True), *((f, f) for f in flat)]))
        reach = float(np.abs(self.graph.region).max()) + 1
        with np.errstate(all="ignore"):
            for node in self.nodes:
                name, arguments, constant = self.graph.nodes[node]
                rule, slope = OPERATORS[name], self.constants[node]
                value = values[node] = rule.value(*(values[a] for a in arguments), constant)
                least, most = rule.interval(*(intervals[a] for a in arguments), constant)
                slack = _ROUNDING * (np.abs(value) + reach)
                if slope < np.inf:
                    spread = slope * radius + slack + _ROUNDING * slope * reach
                    intervals[node] = np.fmax(least - slack, value - spread), np.fmin(most + slack, value + spread)
                else:
                    intervals[node] = least - slack, most + slack
        least, most = (np.broadcast_to(end, (len(low),)) for end in intervals[self.result])
        return least, most


def numpy_intervals(form: Form, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """(n,) least and greatest values of a form, or beyond, over boxes with corners `low` and `high`, (n, dimension)."""
    return Looker.of(form, np.stack([low.min(axis=0), high.max(axis=0)])).intervals(low, high)


def tight_bounds(form: Form) -> Box:
    """The form's bounds, made smaller by what intervals prove to be empty; a box of no size where all of it is."""
    box = form.bounds
    if form.is_tight or not np.isfinite(box).all() or (box[0] >= box[1]).any():
        return box
    looker = Looker.of(form, box)
    low, high = _split(box[None, 0], box[None, 1], _PARTS[form.dimension])
    budget = _MOST_WORK - len(looker.nodes) * len(low)
    if budget < 0:
        return box
    low, high = _not_empty(looker, low, high)
    tolerance = _PART * (box[1] - box[0])
    inside = np.stack([box[1], box[0]])
    for _ in range(_HALVINGS):
        inside = _reached(looker, low, high, inside)
        outer = ((low < inside[0] - tolerance) | (high > inside[1] + tolerance)).any(axis=1)
        budget -= int(outer.sum()) * 2**form.dimension * len(looker.nodes)
        if not outer.any() or budget < 0:
            break
        parts = _not_empty(looker, *_split(low[outer], high[outer], 2))
        low, high = (np.concatenate([kept[~outer], part]) for kept, part in zip((low, high), parts, strict=True))
    return np.stack([low.min(axis=0), high.max(axis=0)]) if len(low) else np.stack([box.mean(axis=0)] * 2)


def _reached(looker: Looker, low: Floats, high: Floats, inside: Box) -> Box:
    """The box of points that are known to be inside, with those at the middles of the boxes and of their sides."""
    middle = (low + high) / 2
    tried = [middle]
    for axis in range(low.shape[1]):
        for side, outermost in ((low, low[:, axis].min(initial=np.inf)), (high, high[:, axis].max(initial=-np.inf))):
            at = side[:, axis] == outermost
            face = middle[at].copy()
            face[:, axis] = outermost
            tried.append(face)
    points = np.concatenate(tried)
    points = points[looker.values(points) <= 0]
    return np.stack([np.vstack([points, inside[:1]]).min(axis=0), np.vstack([points, inside[1:]]).max(axis=0)])


def _split(low: Floats, high: Floats, parts: int) -> tuple[Floats, Floats]:
    """Each box in `parts` along each axis; neighbours share their sides exactly."""
    dimension = low.shape[1]
    steps = np.stack(np.meshgrid(*[np.arange(parts)] * dimension, indexing="ij"), axis=-1).reshape(1, -1, dimension)

    def side(number: Any) -> Floats:
        part = number / parts
        sides: Floats = (low[:, None] * (1 - part) + high[:, None] * part).reshape(-1, dimension)
        return sides

    return side(steps), side(steps + 1)


def _not_empty(looker: Looker, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    if len(low) == 0:
        return low, high
    least, _ = looker.intervals(low, high)
    # What is not a number proves nothing.
    kept = ~(least > 0)
    return low[kept], high[kept]
