"""Textures from functions of the user's, and from fields."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.fields import as_optional_number, instance_of, one_of, optional, positive
from isophote.scene.procedural import Procedural, Stops, stops
from isophote.shapes.field.field import Field
from isophote.shapes.field.form import Form
from isophote.shapes.field.function_part import FunctionPart
from isophote.shapes.field.tape import numpy_values

__all__ = ["FieldTexture", "Formula"]

Floats: TypeAlias = npt.NDArray[np.float64]

# Places at which a function is tried, and how near its expression must come to it there.
_TRIED, _SAME = 200, 1e-9


@attrs.frozen(repr=False)
class FieldTexture(Procedural):
    """The colour of a ramp at the value of a field: distances as colours, isolines.

    `stops` are those of `Ramp`; their positions are values of the field, metres for a distance. With a `period` they
    lie from 0 to 1 in each period of the value: bands, or lines where a colour is narrow. The mean over what a pixel
    sees is taken over sixteen places. The field stands in the texture's space, and is nothing that is drawn.
    """

    field: Field = attrs.field(validator=instance_of("a Field in space", Field))
    stops: Stops = attrs.field(default=("black", "white"), converter=stops)
    period: float | None = attrs.field(default=None, converter=as_optional_number, validator=optional(positive))
    between: str = attrs.field(default="linear", validator=one_of("linear", "smooth", "constant"))

    @property
    def forms(self) -> tuple[Form, ...]:
        """The form of the value."""
        return (self.field.form,)


def _tried(function: Callable[[Any], Any]) -> int:
    """How many columns a function gives; refused where they cannot be written as expressions."""
    if not callable(function):
        raise SceneError(f"Formula: function must be a function of places (n, 3), but is {function!r}")
    places = np.random.default_rng(0).uniform(-4, 4, (_TRIED, 3))
    try:
        with np.errstate(all="ignore"):
            given = np.asarray(function(places.copy()))
    except Exception as error:
        raise SceneError(f"Formula: the function failed on places {places.shape}: {error}") from error
    if given.shape not in ((_TRIED,), (_TRIED, 3)) or given.dtype.kind not in "biuf":
        raise SceneError(
            f"Formula: the function must give a number or a colour for each place, ({_TRIED},) or ({_TRIED}, 3) for "
            f"{places.shape}, but it gave {given.dtype} {given.shape}"
        )
    columns = given.reshape(_TRIED, -1).astype(np.float64)
    if not _is_written(function, places, columns):
        raise SceneError(
            "Formula: the function cannot be written as an expression; it may use arithmetic, NumPy's functions of "
            "elements, norm, where, clip, stack and reductions along the columns"
        )
    return columns.shape[1]


def _is_written(function: Callable[[Any], Any], places: Floats, columns: Floats) -> bool:
    """Whether a function has expressions, with the same values as itself."""
    try:
        written = [numpy_values(FunctionPart(function, k), places) for k in range(columns.shape[1])]
    except Exception:  # noqa: BLE001
        # Whatever a function does with what only looks like an array.
        return False
    known = np.isfinite(columns)
    close = np.abs(np.stack(written, axis=1) - columns) <= _SAME * (1 + np.abs(columns))
    return bool(close[known].all())


@attrs.frozen(repr=False)
class Formula(Procedural):
    """What a NumPy function of the place says: `Formula(lambda p: np.sin(9 * p[:, 0]) * np.sin(9 * p[:, 2]))`.

    It takes places (n, 3), in metres, or (u, v, 0) with `space="uv"`, and gives numbers (n,), which become colours by
    `stops` and `period` as in `FieldTexture`, or linear colours (n, 3), of which what is negative counts as 0. It is
    written as an expression once, as functions of fields are; nothing is compiled for it. The mean over what a pixel
    sees is taken over sixteen places.

    Raises `SceneError` where the function fails, gives other shapes, or uses what has no expression.
    """

    function: Callable[[Any], Any] = attrs.field()
    stops: Stops = attrs.field(default=("black", "white"), converter=stops)
    period: float | None = attrs.field(default=None, converter=as_optional_number, validator=optional(positive))
    between: str = attrs.field(default="linear", validator=one_of("linear", "smooth", "constant"))
    channels: int = attrs.field(init=False, eq=False)

    @channels.default
    def _count(self) -> int:
        return _tried(self.function)

    @property
    def forms(self) -> tuple[Form, ...]:
        """The forms of the value, or of red, green and blue."""
        return tuple(FunctionPart(self.function, k) for k in range(self.channels))
