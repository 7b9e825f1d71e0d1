"""Fields without a shape of their own, which others are displaced by."""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np

from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.field import Field
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.functions import sin
from isophote.shapes.field.numbers import Vector, lowest, positive_vector

__all__ = ["Waves", "waves"]


@attrs.frozen(repr=False)
class Waves(Form):
    """sin(2π x / a) sin(2π y / b) sin(2π z / c), from −1 to 1: what a surface may be displaced by.

    Its slope is at most 2π over the least wavelength: the squares of the derivatives' factors, Σ cos² · sin² · sin²
    over the axes, sum to 1 at most.
    """

    wavelength: Vector = positive_vector(3)

    exactness = Exactness.BOUND

    def expression(self, p: Point) -> Value:
        turns = [sin(c * (2 * math.pi / p.number(w))) for c, w in zip(p.coordinates, self.wavelength, strict=True)]
        return p.bounded(turns[0] * turns[1] * turns[2], 2 * math.pi / min(map(lowest, self.wavelength)))

    @property
    def bounds(self) -> Box:
        return np.array([[-np.inf] * 3, [np.inf] * 3])

    def spelled(self) -> str:
        same = len(set(map(repr, self.wavelength))) == 1
        return f"waves({number_spelled(self.wavelength[0] if same else self.wavelength)})"


def waves(wavelength: Any) -> Field:
    """sin(2π x / a) sin(2π y / b) sin(2π z / c), from −1 to 1, for `wavelength` (a, b, c), or one for all.

    For `displace`: `part.displace(iso.waves(0.3), 0.02)` has bumps of ±0.02.
    """
    return Field(Waves(wavelength))
