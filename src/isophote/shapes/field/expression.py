"""Expressions of a point: what a field is, operator by operator.

A `Graph` holds the operators of one expression, each once however often it occurs, in an order in which arguments
come first. Shapes write themselves into it with the arithmetic of `Value`:

    def expression(self, p: Point) -> Value:
        return p.bounded(length(p.x, p.y, p.z) - p.number(self.radius), 1.0)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias, cast

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field.operators import OPERATORS, Interval

__all__ = ["Graph", "Node", "Number", "Parameter", "Point", "Value"]

Box: TypeAlias = npt.NDArray[np.float64]


class Node(NamedTuple):
    """One operator of a graph: its name, the nodes of its arguments, its constant (a number, or a table of data)."""

    name: str
    arguments: tuple[int, ...]
    constant: Any


class Parameter(float):
    """A number with a name, which a web page gives a slider: `sphere(Parameter("radius", 1.0, 0.5, 2.0))`.

    It is the number `value` everywhere else; `low` and `high` are the ends of the slider.
    """

    name: str
    low: float
    high: float

    def __new__(cls, name: str, value: float, low: float, high: float) -> Parameter:
        if not isinstance(name, str) or not name:
            raise GeometryError(f"Parameter: name must be a word that a page can show, but is {name!r}")
        try:
            value, low, high = float(value), float(low), float(high)
        except (TypeError, ValueError):
            raise GeometryError(
                f"Parameter {name!r}: value, low and high must be numbers, but are {value!r}, {low!r}, {high!r}"
            ) from None
        if not (math.isfinite(value) and math.isfinite(low) and math.isfinite(high) and low <= value <= high):
            raise GeometryError(
                f"Parameter {name!r}: low ≤ value ≤ high must hold, all finite, but they are {low}, {value}, {high}"
            )
        parameter = super().__new__(cls, value)
        parameter.name, parameter.low, parameter.high = name, low, high
        return parameter

    def __repr__(self) -> str:
        return f"Parameter({self.name!r}, {float(self)!r}, {self.low!r}, {self.high!r})"

    def __getnewargs__(self) -> tuple[Any, ...]:
        return self.name, float(self), self.low, self.high


Number: TypeAlias = "float | Value"

# Names of the inputs, in their order.
_INPUTS = ("x", "y", "z")


@attrs.define(eq=False)
class Graph:
    """Operators of an expression of the point (x, y, z), which lies in the box `region`, (2, 3).

    With `symbolic`, parameters stay as nodes, to become uniforms of a shader; otherwise they are their numbers.
    """

    region: Box = attrs.field(factory=lambda: np.array([[-np.inf] * 3, [np.inf] * 3]))
    symbolic: bool = False
    nodes: list[Node] = attrs.field(init=False)
    # What is known of values beyond what the operators' rules tell: bounds on their Lipschitz constants.
    claims: dict[int, float] = attrs.field(init=False, factory=dict)
    # Values that move no faster than the fastest of some others.
    likenesses: dict[int, tuple[int, ...]] = attrs.field(init=False, factory=dict)
    _known: dict[tuple[Any, ...], int] = attrs.field(init=False, factory=dict)
    _intervals: dict[int, Interval] = attrs.field(init=False, factory=dict)

    def __attrs_post_init__(self) -> None:
        self.nodes = [Node("INPUT", (), name) for name in _INPUTS]

    @property
    def point(self) -> Point:
        """The point that the expression is of."""
        return Point(Value(self, 0), Value(self, 1), Value(self, 2), 1.0)

    def number(self, number: float) -> Value:
        """A constant; a parameter, in a symbolic graph."""
        if self.symbolic and isinstance(number, Parameter):
            return Value(self, self._node("PARAMETER", (), number, key=number.name))
        return Value(self, self._node("CONSTANT", (), float(number)))

    def apply(self, name: str, *arguments: Number, constant: Any = 0.0) -> Value:
        """The value of an operator of values and numbers."""
        values = [a if isinstance(a, Value) else self.number(a) for a in arguments]
        if all(v.constant is not None for v in values) and isinstance(constant, int | float):
            return self.number(float(OPERATORS[name].value(*(v.constant for v in values), constant)))
        ids = tuple(v.id for v in values)
        if OPERATORS[name].commutes:
            ids = tuple(sorted(ids))
        return Value(self, self._node(name, ids, constant))

    def _node(self, name: str, arguments: tuple[int, ...], constant: Any, key: Any = None) -> int:
        # Tables of data are told apart by what they are, numbers by their value and sign.
        number = isinstance(constant, float)
        mark = key if key is not None else (constant, math.copysign(1, constant)) if number else id(constant)
        entry = (name, arguments, mark)
        found = self._known.get(entry)
        if found is None:
            found = self._known[entry] = len(self.nodes)
            self.nodes.append(Node(name, arguments, constant))
        return found

    def interval(self, node: int) -> Interval:
        """An interval that holds a value wherever the point lies in the region."""
        if node >= len(self._intervals):
            with np.errstate(all="ignore"):
                for each in range(len(self._intervals), node + 1):
                    self._intervals[each] = self._interval(each)
        return self._intervals[node]

    def _interval(self, node: int) -> Interval:
        name, arguments, constant = self.nodes[node]
        if name == "INPUT":
            return self.region[0, node], self.region[1, node]
        if name == "PARAMETER":
            return np.asarray(constant.low), np.asarray(constant.high)
        low, high = (float(end) for end in OPERATORS[name].interval(*(self._intervals[a] for a in arguments), constant))
        # Infinities of both signs may meet; then nothing is known.
        low = -math.inf if math.isnan(low) else math.nextafter(low, -math.inf)
        high = math.inf if math.isnan(high) else math.nextafter(high, math.inf)
        # Scalars of NumPy behave as arrays do, at a third of the cost.
        return cast("Interval", (np.float64(low), np.float64(high)))

    def lipschitz(self) -> list[float]:
        """A Lipschitz constant of every value over the region; infinite where none is known."""
        constants: list[float] = []
        self.interval(len(self.nodes) - 1)
        with np.errstate(all="ignore"):
            for number in range(len(self.nodes)):
                constants.append(self._lipschitz(number, constants))
        return constants

    def _lipschitz(self, number: int, constants: list[float]) -> float:
        name, arguments, constant = self.nodes[number]
        if name in ("INPUT", "PARAMETER"):
            known = 1.0 if name == "INPUT" else 0.0
        elif name == "CONSTANT":
            known = 0.0
        else:
            intervals = [self._intervals[a] for a in arguments]
            known = float(OPERATORS[name].lipschitz([constants[a] for a in arguments], intervals, constant))
            known = math.inf if math.isnan(known) else known
        if number in self.likenesses:
            known = min(known, max(constants[other] for other in self.likenesses[number]))
        return min(known, self.claims.get(number, math.inf))

    def one_of(self, value: Value, *arms: Value) -> Value:
        """`value`, which is continuous and everywhere one of `arms` (or differs from it by a constant).

        So it has no larger Lipschitz constant than they have.
        """
        if all(arm.id < value.id for arm in arms):
            self.likenesses[value.id] = tuple(arm.id for arm in arms)
        return value

    def used(self, result: int) -> list[int]:
        """The nodes that `result` depends on, arguments first."""
        live = {result}
        for node in range(result, -1, -1):
            if node in live:
                live.update(self.nodes[node].arguments)
        return sorted(live)


@attrs.frozen(eq=False)
class Value:
    """A node of a graph, with arithmetic."""

    graph: Graph
    id: int

    @property
    def constant(self) -> float | None:
        """The number that this value always is, or None."""
        node = self.graph.nodes[self.id]
        return float(node.constant) if node.name == "CONSTANT" else None

    def __add__(self, other: Number) -> Value:
        b = self._lift(other)
        if b.constant is None and self.constant is not None:
            return b + self
        if b.constant is None:
            return self.graph.apply("ADD", self, b)
        return self if b.constant == 0 else self.graph.apply("ADD_CONSTANT", self, constant=b.constant)

    __radd__ = __add__

    def __sub__(self, other: Number) -> Value:
        b = self._lift(other)
        if b.constant is not None:
            return self + -b.constant
        if self.constant is None:
            return self.graph.apply("SUBTRACT", self, b)
        return -b if self.constant == 0 else self.graph.apply("CONSTANT_MINUS", b, constant=self.constant)

    def __rsub__(self, other: Number) -> Value:
        return self._lift(other) - self

    def __mul__(self, other: Number) -> Value:
        b = self._lift(other)
        if b.constant is None and self.constant is not None:
            return b * self
        if b.constant is None:
            return self.graph.apply("SQUARE", self) if b.id == self.id else self.graph.apply("MULTIPLY", self, b)
        if b.constant in (0, 1, -1):
            return {0: b, 1: self, -1: -self}[int(b.constant)]
        return self.graph.apply("MULTIPLY_CONSTANT", self, constant=b.constant)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> Value:
        b = self._lift(other)
        if b.constant is not None and b.constant != 0:
            return self * (1 / b.constant)
        if self.constant is not None and b.constant is None:
            return self.graph.apply("CONSTANT_OVER", b, constant=self.constant)
        return self.graph.apply("DIVIDE", self, b)

    def __rtruediv__(self, other: Number) -> Value:
        return self._lift(other) / self

    def _lift(self, other: Number) -> Value:
        return other if isinstance(other, Value) else self.graph.number(other)

    def __neg__(self) -> Value:
        node = self.graph.nodes[self.id]
        if node.name == "NEGATE":
            return Value(self.graph, node.arguments[0])
        return self.graph.apply("NEGATE", self)

    def __abs__(self) -> Value:
        return self.graph.apply("ABSOLUTE", self)


class Point(NamedTuple):
    """The point that a shape is asked about, in the shape's own space.

    `stretch` is a Lipschitz constant of the map from the world's point to this one. In the plane, `z` is not used.
    """

    x: Value
    y: Value
    z: Value
    stretch: float

    @property
    def coordinates(self) -> list[Value]:
        """x, y and z."""
        return [self.x, self.y, self.z]

    @property
    def graph(self) -> Graph:
        """The graph that the point's coordinates live in."""
        return self.x.graph

    def number(self, number: float) -> Value:
        """A number of the shape's; lengths and angles go through here, so that they can be parameters."""
        return self.graph.number(number)

    def bounded(self, value: Value, constant: float) -> Value:
        """`value`, of which the shape knows a Lipschitz constant in its own space."""
        claims = self.graph.claims
        claims[value.id] = min(claims.get(value.id, math.inf), constant * self.stretch)
        return value

    def moved(self, x: Number, y: Number, z: Number, stretch: float = 1.0) -> Point:
        """Another point, made from this one by a map with the Lipschitz constant `stretch`."""
        a, b, c = (v if isinstance(v, Value) else self.number(v) for v in (x, y, z))
        for coordinate in (a, b, c):
            self.bounded(coordinate, stretch)
        return Point(a, b, c, self.stretch * stretch)

    def intervals(self) -> Sequence[Interval]:
        """Intervals of the coordinates over the graph's region."""
        return [self.graph.interval(v.id) for v in (self.x, self.y, self.z)]
