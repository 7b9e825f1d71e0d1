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
Flags: TypeAlias = npt.NDArray[np.bool_]

# Rounding of a value and of what it is made of, as a part of the value, of the point and of one.
_ROUNDING = 1e-12

# A box is looked at in so many parts along each axis; then those that reach farther out than a point that is inside,
# by more than a part of the size, are halved along that axis, at most so often, and along others where they are so many
# times as wide.
_PARTS = {2: 16, 3: 8}
_HALVINGS = 6
_PART = 0.005
_SLENDER = 6.0
# Boxes times operators that are looked at, which takes some twenty milliseconds.
_MOST_WORK = 400_000


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

    def farther(self, points: Floats, values: Floats, radius: Floats) -> Flags:
        """(n,) whether the values at points (n, dimension) prove, by the Lipschitz constant alone, that the form is
        positive up to `radius` (n,) around them. `intervals` proves no less, and takes ten times as long."""
        slope = self.constants[self.result]
        if not slope < np.inf:
            return np.zeros(len(points), bool)
        reach = float(np.abs(self.graph.region).max()) + 1
        spread = slope * radius + _ROUNDING * (np.abs(values) + reach) + _ROUNDING * slope * reach
        proven: Flags = values > spread
        return proven

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
    tolerance = _PART * (box[1] - box[0])
    inside = settled = np.stack([box[1], box[0]])
    for halvings in range(_HALVINGS + 1):
        low, high, inside = _reached(looker, low, high, inside)
        beyond = (low < inside[0] - tolerance) | (high > inside[1] + tolerance)
        outer = beyond.any(axis=1)
        settled = _around(settled, low[~outer], high[~outer])
        low, high, beyond = _not_empty(looker, low[outer], high[outer], beyond[outer])
        chosen = _axes(beyond, (high - low) / (box[1] - box[0]))
        budget -= int((2 ** chosen.sum(axis=1)).sum()) * len(looker.nodes)
        if len(low) == 0 or budget < 0 or halvings == _HALVINGS:
            break
        low, high = _halved(low, high, chosen)
    settled = _around(settled, low, high)
    return settled if (settled[0] <= settled[1]).all() else np.stack([box.mean(axis=0)] * 2)


def _around(box: Box, low: Floats, high: Floats) -> Box:
    """The box around a box and others."""
    return np.stack([np.vstack([low, box[:1]]).min(axis=0), np.vstack([high, box[1:]]).max(axis=0)])


def _reached(looker: Looker, low: Floats, high: Floats, inside: Box) -> tuple[Floats, Floats, Box]:
    """Boxes without those that the values at their middles prove empty; and `inside` with points that are known to be
    inside, of the middles and of those of the outermost sides."""
    middle = (low + high) / 2
    values = looker.values(middle)
    inside = _around(inside, middle[values <= 0], middle[values <= 0])
    kept = ~looker.farther(middle, values, np.linalg.norm(high - low, axis=1) / 2)
    low, high, middle = low[kept], high[kept], middle[kept]
    tried = []
    for axis in range(low.shape[1]):
        for side, outermost in ((low, low[:, axis].min(initial=np.inf)), (high, high[:, axis].max(initial=-np.inf))):
            face = middle[side[:, axis] == outermost]
            face[:, axis] = outermost
            tried.append(face)
    points = np.concatenate(tried)
    points = points[looker.values(points) <= 0]
    return low, high, _around(inside, points, points)


def _axes(beyond: Flags, width: Floats) -> Flags:
    """(n, dimension) the axes along which boxes are halved: those on which they reach too far out, and those on which
    they are much wider than on these."""
    narrow = np.where(beyond, width, np.inf).min(axis=1, keepdims=True, initial=np.inf)
    axes: Flags = beyond | (width > _SLENDER * narrow)
    return axes


def _halved(low: Floats, high: Floats, chosen: Flags) -> tuple[Floats, Floats]:
    """Boxes halved along the axes chosen for each, (n, dimension); neighbours share their sides exactly."""
    for axis in range(low.shape[1]):
        here = chosen[:, axis]
        ends, starts = high[here], low[here]
        ends[:, axis] = starts[:, axis] = (low[here, axis] + high[here, axis]) / 2
        low, high = np.concatenate([low[~here], low[here], starts]), np.concatenate([high[~here], ends, high[here]])
        chosen = np.concatenate([chosen[~here], chosen[here], chosen[here]])
    return low, high


def _split(low: Floats, high: Floats, parts: int) -> tuple[Floats, Floats]:
    """Each box in `parts` along each axis; neighbours share their sides exactly."""
    dimension = low.shape[1]
    steps = np.stack(np.meshgrid(*[np.arange(parts)] * dimension, indexing="ij"), axis=-1).reshape(1, -1, dimension)

    def side(number: Any) -> Floats:
        part = number / parts
        sides: Floats = (low[:, None] * (1 - part) + high[:, None] * part).reshape(-1, dimension)
        return sides

    return side(steps), side(steps + 1)


def _not_empty(looker: Looker, low: Floats, high: Floats, beyond: Flags) -> tuple[Floats, Floats, Flags]:
    if len(low) == 0:
        return low, high, beyond
    least, _ = looker.intervals(low, high)
    # What is not a number proves nothing.
    kept = ~(least > 0)
    return low[kept], high[kept], beyond[kept]
