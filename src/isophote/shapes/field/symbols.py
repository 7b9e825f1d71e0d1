"""Arrays that are not there: what a user's NumPy function does to them is written into a graph.

`Columns` stands for an array (n, k) or (n,) whose columns are values of a graph. Arithmetic, NumPy's functions of
elements, reductions along the columns, `np.where`, `np.stack` and the like give new ones; all else raises
`NotSymbolicError`, and the function is then taken as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from isophote.shapes.field import functions as f
from isophote.shapes.field.expression import Number, Value

__all__ = ["Columns", "Condition", "NotSymbolicError"]

_Choice: TypeAlias = Callable[[Number, Number], Number]


class NotSymbolicError(TypeError):
    """Something that has no expression was asked of columns."""


def _plain(a: Number) -> float | None:
    """A number, where it is one."""
    return a.constant if isinstance(a, Value) else float(a)


def _lifted(function: Callable[..., Any], plain: Callable[..., Any]) -> Callable[..., Number]:
    """A function of values that takes numbers too: of numbers alone it is `plain`."""

    def apply(*arguments: Number) -> Number:
        if any(isinstance(a, Value) for a in arguments):
            value: Number = function(*arguments)
            return value
        return float(plain(*arguments))

    return apply


def _power(a: Number, b: Number) -> Number:
    exponent = _plain(b)
    if exponent is None or not isinstance(a, Value):
        raise NotSymbolicError("powers with an exponent that changes")
    if exponent == 0.5:
        return f.sqrt(a)
    if not exponent.is_integer() or abs(exponent) > 64:
        raise NotSymbolicError("powers that are not whole")
    count, square = abs(int(exponent)), a
    result: Value | None = None
    while count:
        if count & 1:
            result = square if result is None else result * square
        square, count = square * square, count >> 1
    if result is None:
        return 1.0
    powered: Number = 1 / result if exponent < 0 else result
    return powered


def _remainder(a: Any, b: Any) -> Number:
    rest: Number = a - _floor(a / b) * b
    return rest


_floor = _lifted(f.floor, np.floor)
_absolute = _lifted(abs, abs)
_sqrt = _lifted(f.sqrt, np.sqrt)
_sin, _cos = _lifted(f.sin, np.sin), _lifted(f.cos, np.cos)
_minimum, _maximum = _lifted(f.minimum, min), _lifted(f.maximum, max)
_hypot = _lifted(lambda a, b: _length([a, b]), np.hypot)


def _length(parts: Sequence[Number]) -> Number:
    """Length of a vector of any number of parts."""
    values = [p for p in parts if _plain(p) != 0]
    if not values:
        return 0.0
    if len(values) in (2, 3) and all(isinstance(v, Value) for v in values):
        return f.length(*values)  # type: ignore[arg-type]
    if len(values) == 1:
        return _absolute(values[0])
    squares: Number = 0.0
    for v in values:
        squares = squares + v * v
    root: Number = _sqrt(squares)
    return root


_ELEMENTWISE: dict[str, Callable[..., Number]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "negative": lambda a: -a,
    "positive": lambda a: a,
    "absolute": _absolute,
    "fabs": _absolute,
    "square": lambda a: a * a,
    "reciprocal": lambda a: 1 / a,
    "power": _power,
    "float_power": _power,
    "sqrt": _sqrt,
    "sin": _sin,
    "cos": _cos,
    "tan": lambda a: _sin(a) / _cos(a),
    "arcsin": _lifted(f.arcsin, np.arcsin),
    "arccos": _lifted(f.arccos, np.arccos),
    "arctan": _lifted(lambda a: f.arctan2(a, 1.0), np.arctan),
    "arctan2": _lifted(f.arctan2, np.arctan2),
    "hypot": _hypot,
    "exp": _lifted(f.exp, np.exp),
    "log": _lifted(f.log, np.log),
    "floor": _floor,
    "ceil": lambda a: -_floor(-a),
    "rint": _lifted(f.rint, np.rint),
    "remainder": _remainder,
    "floor_divide": lambda a, b: _floor(a / b),
    "minimum": _minimum,
    "fmin": _minimum,
    "maximum": _maximum,
    "fmax": _maximum,
    "sign": lambda a: f.select(a, -1.0, f.select(-a, 1.0, 0.0)),
    "clip": lambda a, low, high: _minimum(_maximum(a, low), high),
}


class Condition(NDArrayOperatorsMixin):
    """A truth value for each point: what `np.where` takes. `choose(a, b)` is a where it is true, else b."""

    def __init__(self, choose: _Choice) -> None:
        self.choose = choose

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Condition:
        if method != "__call__" or options or not all(isinstance(i, Condition) for i in inputs):
            raise NotSymbolicError(ufunc.__name__)
        first, *others = (i.choose for i in inputs)
        if ufunc.__name__ in ("logical_and", "bitwise_and"):
            return Condition(lambda a, b: first(others[0](a, b), b))
        if ufunc.__name__ in ("logical_or", "bitwise_or"):
            return Condition(lambda a, b: first(a, others[0](a, b)))
        if ufunc.__name__ in ("logical_not", "invert"):
            return Condition(lambda a, b: first(b, a))
        raise NotSymbolicError(ufunc.__name__)

    def __array_function__(self, function: Any, types: Any, args: Any, options: Any) -> Any:
        if function is not np.where or options or len(args) != 3:
            raise NotSymbolicError(function.__name__)
        a, b = args[1:]
        owner = next((each for each in (a, b) if isinstance(each, Columns)), None)
        flat = owner is None or owner.is_flat
        pairs = _broadcast([Columns.of(a), Columns.of(b)])
        return Columns([self.choose(x, y) for x, y in pairs], flat)

    def __bool__(self) -> bool:
        raise NotSymbolicError("the truth of an array")

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise NotSymbolicError("an array of truth values")


_COMPARISONS: dict[str, Callable[[Any, Any], Condition]] = {
    "less": lambda a, b: Condition(lambda x, y: f.select(a - b, x, y)),
    "greater": lambda a, b: Condition(lambda x, y: f.select(b - a, x, y)),
    "less_equal": lambda a, b: Condition(lambda x, y: f.select(b - a, y, x)),
    "greater_equal": lambda a, b: Condition(lambda x, y: f.select(a - b, y, x)),
}


def _broadcast(operands: Sequence[Columns]) -> list[tuple[Number, ...]]:
    """The columns of all operands side by side; one column goes with any number of them."""
    count = max(len(o.parts) for o in operands)
    if any(len(o.parts) not in (1, count) for o in operands):
        raise NotSymbolicError("columns of several numbers")
    return [tuple(o.parts[k if len(o.parts) > 1 else 0] for o in operands) for k in range(count)]


class Columns(NDArrayOperatorsMixin):
    """An array of points or of numbers for each: (n, k), or (n,) where `is_flat`. See the module."""

    def __init__(self, parts: Sequence[Number], is_flat: bool) -> None:
        self.parts = tuple(parts)
        self.is_flat = is_flat

    @classmethod
    def of(cls, given: Any) -> Columns:
        """Columns, or numbers that are the same for all points: one, or one for each column."""
        if isinstance(given, Columns):
            return given
        array = np.asarray(given)
        if array.dtype.kind not in "biuf" or array.ndim > 2 or (array.ndim == 2 and len(array) != 1):
            raise NotSymbolicError("arrays of other shapes")
        return cls([float(v) for v in array.reshape(-1)], array.ndim == 0)

    @property
    def T(self) -> tuple[Columns, ...]:  # noqa: N802
        """The columns, one by one."""
        if self.is_flat:
            raise NotSymbolicError("a transposed vector")
        return tuple(Columns([part], True) for part in self.parts)

    def __getitem__(self, key: Any) -> Columns:
        whole = slice(None)
        if self.is_flat:
            if key in ((whole, None), (Ellipsis, None)):
                return Columns(self.parts, False)
            raise NotSymbolicError("an index of points")
        if not isinstance(key, tuple) or len(key) != 2 or (key[0] is not Ellipsis and key[0] != whole):
            raise NotSymbolicError("an index of points")
        chosen = np.arange(len(self.parts))[key[1]]
        return Columns([self.parts[k] for k in np.atleast_1d(chosen)], chosen.ndim == 0)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        name = ufunc.__name__
        if method == "reduce" and not options.get("initial") and options.get("where", True) is True:
            return self._reduced(name, options.get("axis", 0), bool(options.get("keepdims")))
        # `a += b` asks for the sum to be put into a; it becomes what the name a stands for.
        if method != "__call__" or set(options) > {"out"}:
            raise NotSymbolicError(f"{name} with options")
        if name == "matmul":
            return self._times(*inputs)
        operands = [Columns.of(i) for i in inputs]
        flat = all(o.is_flat or not isinstance(i, Columns) for o, i in zip(operands, inputs, strict=True))
        if flat and any(len(o.parts) > 1 for o in operands):
            raise NotSymbolicError("a vector with one number for each point")
        if any(o.is_flat and isinstance(i, Columns) for o, i in zip(operands, inputs, strict=True)) and not flat:
            raise NotSymbolicError("(n,) with (n, k)")
        rows = _broadcast(operands)
        if name in _COMPARISONS:
            if len(rows) > 1 or not flat:
                raise NotSymbolicError("truth values of several columns")
            return _COMPARISONS[name](*rows[0])
        if name not in _ELEMENTWISE:
            raise NotSymbolicError(name)
        return Columns([_ELEMENTWISE[name](*row) for row in rows], flat)

    def __array_function__(self, function: Any, types: Any, args: Any, options: Any) -> Any:
        rule = _FUNCTIONS.get(function.__name__)
        if rule is None:
            raise NotSymbolicError(function.__name__)
        return rule(*args, **options)

    def _reduced(self, name: str, axis: Any, keepdims: bool = False) -> Columns:
        if self.is_flat or axis not in (1, -1, (1,), (-1,)) or name not in ("add", "multiply", "minimum", "maximum"):
            raise NotSymbolicError(f"{name} over all points")
        total = self.parts[0]
        for part in self.parts[1:]:
            total = _ELEMENTWISE[name](total, part)
        return Columns([total], not keepdims)

    def _times(self, left: Any, right: Any) -> Columns:
        """A matrix product with numbers on the right."""
        matrix = np.asarray(right) if isinstance(left, Columns) and not isinstance(right, Columns) else None
        if matrix is None or left.is_flat or matrix.ndim not in (1, 2) or len(matrix) != len(left.parts):
            raise NotSymbolicError("matrix products")
        sums = [sum(p * float(m) for p, m in zip(left.parts, row, strict=True)) for row in np.atleast_2d(matrix.T)]
        return Columns(sums, matrix.ndim == 1)

    def sum(self, axis: Any = None, keepdims: bool = False) -> Columns:
        """The sum along the columns."""
        return self._reduced("add", axis, keepdims)

    def prod(self, axis: Any = None, keepdims: bool = False) -> Columns:
        """The product along the columns."""
        return self._reduced("multiply", axis, keepdims)

    def min(self, axis: Any = None, keepdims: bool = False) -> Columns:
        """The least along the columns."""
        return self._reduced("minimum", axis, keepdims)

    def max(self, axis: Any = None, keepdims: bool = False) -> Columns:
        """The largest along the columns."""
        return self._reduced("maximum", axis, keepdims)

    def dot(self, other: Any) -> Columns:
        """The matrix product with numbers."""
        return self._times(self, other)

    def clip(self, low: Any, high: Any) -> Columns:
        """Brought between two numbers."""
        return _clip(self, low, high)

    def copy(self) -> Columns:
        """Itself, for nothing changes it."""
        return self

    def astype(self, kind: Any, *_: Any, **__: Any) -> Columns:
        """Itself, in double precision alone."""
        if np.dtype(kind) != np.float64:
            raise NotSymbolicError("other precision")
        return self

    def __bool__(self) -> bool:
        raise NotSymbolicError("the truth of an array")

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise NotSymbolicError("an array of numbers")

    __hash__ = None  # type: ignore[assignment]


def _clip(a: Columns, low: Any, high: Any) -> Columns:
    bottom: Any = a if low is None else np.maximum(a, low)
    result: Columns = bottom if high is None else np.minimum(bottom, high)
    return result


def _norm(a: Columns, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Columns:
    if a.is_flat or axis not in (1, -1) or ord not in (None, 2, np.inf, 1):
        raise NotSymbolicError("norm over all points")
    if ord in (np.inf, 1):
        sizes: Columns = abs(a)
        return sizes._reduced("maximum" if ord == np.inf else "add", axis, keepdims)
    return Columns([_length(a.parts)], not keepdims)


def _stack(arrays: Any, axis: int = 0) -> Columns:
    if axis not in (1, -1) or not all(isinstance(a, Columns) and a.is_flat for a in arrays):
        raise NotSymbolicError("stack along the points")
    return Columns([a.parts[0] for a in arrays], False)


def _concatenated(arrays: Any, axis: int = 0) -> Columns:
    if axis not in (1, -1) or not all(isinstance(a, Columns) and not a.is_flat for a in arrays):
        raise NotSymbolicError("concatenate along the points")
    return Columns([part for a in arrays for part in a.parts], False)


def _where(condition: Any, a: Any, b: Any) -> Columns:
    if not isinstance(condition, Condition):
        raise NotSymbolicError("where with given truth values")
    result: Columns = condition.__array_function__(np.where, (), (condition, a, b), {})
    return result


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "norm": _norm,
    "stack": _stack,
    "column_stack": lambda arrays: _stack(arrays, 1),
    "concatenate": _concatenated,
    "hstack": lambda arrays: _concatenated(arrays, 1),
    "where": _where,
    "clip": _clip,
    "sum": Columns.sum,
    "prod": Columns.prod,
    "min": Columns.min,
    "amin": Columns.min,
    "max": Columns.max,
    "amax": Columns.max,
    "dot": lambda a, b: a._times(a, b),
    "round": lambda a: np.rint(a),
    "transpose": lambda a: a.T,
}
